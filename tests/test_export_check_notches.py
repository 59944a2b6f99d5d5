"""Notches, scratches and bumps are no walls; walls of any shape are, as voxels judge too."""

from collections.abc import Sequence

import manifold3d
import numpy as np
import pytest

import export
import trees
from export.check import check
from export.checks.triangle_tree import triangle_tree
from export.checks.widths import Widths, walls_and_gaps
from export.printable import thin_walls
from ifs.mesh import Mesh
from trees.morphology import Ball, dilation


def prism(outline: Sequence[tuple[float, float]], height: float = 10.0) -> Mesh:
    section = manifold3d.CrossSection([np.array(outline, dtype=float)])
    solid = manifold3d.Manifold.extrude(section, height).rotate((20.0, 30.0, 40.0)).to_mesh64()
    return Mesh(np.asarray(solid.vert_properties)[:, :3].copy(), np.asarray(solid.tri_verts).astype(np.int64))


def walls(mesh: Mesh, wall: float | None = None) -> Widths:
    return walls_and_gaps(triangle_tree(mesh.points_3d(), mesh.triangles()), wall=wall)[0]


@pytest.mark.parametrize("deep", [0.2, 0.5, 1.0])
def test_a_scratch_makes_a_plate_no_thinner(deep) -> None:
    plate = prism([(0, 0), (20, 0), (20, 2), (10.1, 2), (10, 2 - deep), (9.9, 2), (0, 2)])
    assert walls(plate).least == pytest.approx(2.0, rel=1e-6)
    assert check(plate, wall=1.99).thin_walls == 0
    assert walls(plate, wall=2.01).share > 1


@pytest.mark.parametrize("deep", [0.2, 0.5, 1.0, 1.4])
def test_a_groove_does(deep) -> None:
    plate = prism([(0, 0), (20, 0), (20, 2), (12, 2), (12, 2 - deep), (8, 2 - deep), (8, 2), (0, 2)])
    assert walls(plate).least == pytest.approx(2 - deep, rel=1e-6)
    assert (check(plate, wall=2.01 - deep).thin_walls or 0) > 1000


def test_a_bracket_with_a_notch_in_its_corner() -> None:
    plain = [(0, 0), (20, 0), (20, 2), (2, 2), (2, 20), (0, 20)]
    notched = [*plain[:3], (2.3, 2), (2, 1.7), (1.7, 2), (2, 2.3), *plain[4:]]
    assert walls(prism(plain)).least == pytest.approx(2.0, rel=1e-6)
    assert walls(prism(notched)).least == pytest.approx(1.7, rel=0.01)  # by a fifth at most
    assert walls(prism([*plain[:3], (2.1, 2), (2, 1.1), (1.1, 2), (2, 2.1), *plain[4:]])).least is not None


def test_a_rib_is_a_wall_when_it_is_higher_than_wide() -> None:
    for high, least in ((0.2, 5.0), (3.0, 0.5)):
        top = 5 + high
        rib = [(0, 0), (20, 0), (20, 5), (10.25, 5), (10.25, top), (9.75, top), (9.75, 5), (0, 5)]
        assert walls(prism(rib)).least == pytest.approx(least, rel=1e-6)


@pytest.mark.parametrize("angle", [5, 10, 20])
def test_plates_that_are_tilted(angle) -> None:
    rise = 20 * np.tan(np.radians(angle))
    least = walls(prism([(0, 0), (20, 0), (20, 1 + rise), (0, 1)])).least
    assert least is not None
    assert np.cos(np.radians(angle)) - 1e-3 <= least <= 1.01


def balls(radius: float) -> trees.Tree:
    centres = np.random.default_rng(0).integers(16, 48, (8, 3))
    return dilation(trees.from_points(centres, 6, trees.Cube((0.0,) * 3, 64.0)), Ball(radius))


@pytest.mark.parametrize("style", ["exact", "smooth"])
def test_balls_of_voxels_are_as_thick_as_voxels_say(style) -> None:
    """Their surfaces have steps of a cell, and poles of a single cell."""
    tree = balls(5)
    assert not thin_walls(tree, 2.5)[0]
    report = check(export.skin(tree, style), wall=2.5)
    assert (report.thin_walls or 0) <= 0.005 * report.measured  # where no ball was found in time


def test_plates_of_voxels_are_as_thin_as_voxels_say() -> None:
    cells = np.zeros((32,) * 3, dtype=bool)
    cells[4:28, 4:28, 10:16] = True
    cells[10:22, 10:22, 13:] = False
    tree = trees.from_array(cells, trees.Cube((0.0,) * 3, 32.0))
    for limit in (2.5, 4.0):
        report = check(export.skin(tree), wall=limit)
        assert bool(report.thin_walls) == bool(thin_walls(tree, limit)[0])
    assert report.walls[0].width == pytest.approx(3.0)
