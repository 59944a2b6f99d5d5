"""Decimation: fewer triangles, the same shape, and no mesh that is not closed."""

import numpy as np
import pytest

from export.check import check
from export.meshing.decimate import decimated
from export.meshing.skin import skin
from ifs.mesh import Mesh
from trees import Cube, from_array, from_points


def ring() -> np.ndarray:
    filled = np.zeros((16, 16, 16), dtype=bool)
    filled[2:14, 2:14, 4:8] = True
    filled[5:11, 5:11] = False
    return filled


def test_flat_sides_become_few_triangles() -> None:
    tree = from_array(ring(), Cube((1.0, 2.0, 3.0), 16.0))
    mesh = skin(tree)
    few = decimated(mesh, 0.001)
    report = check(few)
    assert report.ok
    assert report.genus == (1,)
    assert report.volume == pytest.approx(tree.measure, rel=1e-6)
    assert len(few.faces) == 32  # 16 corners, genus 1: twice as many triangles


def test_what_is_not_closed_is_refused() -> None:
    mesh = skin(from_points([[1, 1, 1]], bits=2))
    with pytest.raises(ValueError, match="one triangle only"):
        decimated(Mesh(mesh.vertices, mesh.faces[1:]), 0.1)
    with pytest.raises(ValueError, match="the same way"):
        decimated(Mesh(mesh.vertices, np.concatenate([mesh.faces, mesh.faces[:1]])), 0.1)
    with pytest.raises(ValueError, match="more than 5"):
        decimated(mesh, 0.1, limit=5)
    with pytest.raises(ValueError, match="tolerance"):
        decimated(mesh, float("nan"))
