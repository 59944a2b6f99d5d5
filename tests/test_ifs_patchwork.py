"""Curves and surfaces of many pieces: closed B-splines and tori against scipy, and who shares what."""

from collections import Counter

import numpy as np
import pytest
from scipy.interpolate import BSpline

import ifs


def periodic(control: np.ndarray, degree: int, t: np.ndarray) -> np.ndarray:
    """A closed uniform B-spline; t counts segments, segment i drawing on the points i, i + 1, …"""
    wrapped = np.concatenate([control, control[:degree]])
    knots = np.arange(len(wrapped) + degree + 1) - degree
    return BSpline(knots, wrapped, degree)(t)


@pytest.mark.parametrize("depth", [0, 1, 4])
def test_a_closed_curve_of_segments_is_the_periodic_spline(depth):
    shape = ifs.shape("corner-cutting")
    control = np.random.default_rng(depth).normal(size=(7, 3))
    ring = (np.arange(7)[:, None] + np.arange(3)) % 7
    complex_ = ifs.refined(ifs.patchwork(shape.topology, shape.system, control, {"edge": ring}), depth)
    mesh = ifs.draw(complex_)
    assert len(mesh.vertices) == len(mesh.faces) == 7 * 2**depth
    # Walk around the ring from the start of the first piece.
    following = dict(mesh.faces.tolist())
    walk = [int(mesh.faces[0][0])]
    while len(walk) < len(mesh.vertices):
        walk.append(following[walk[-1]])
    assert following[walk[-1]] == walk[0]
    expected = periodic(control, 2, np.arange(7 * 2**depth) / 2**depth)
    np.testing.assert_allclose(mesh.vertices[walk], expected, atol=1e-12)


def torus(rows: int, columns: int, width: int) -> np.ndarray:
    """The point numbers of the patches of a grid that is closed both ways."""
    i, j, r, c = np.ogrid[:rows, :columns, :width, :width]
    return (((i + r) % rows) * columns + (j + c) % columns).reshape(rows * columns, width * width)


@pytest.mark.parametrize(
    ("name", "width", "degree"), [("doo-sabin-patch", 3, 2), ("catmull-clark-patch", 4, 3)]
)
@pytest.mark.parametrize("depth", [0, 2])
def test_a_torus_of_patches_is_closed_and_equals_the_tensor_spline(name, width, degree, depth):
    shape = ifs.shape(name)
    rows, columns, steps = 5, 6, 2**depth
    control = np.random.default_rng(width).normal(size=(rows * columns, 3))
    patches = {"face": torus(rows, columns, width)}
    mesh = ifs.draw(ifs.refined(ifs.patchwork(shape.topology, shape.system, control, patches), depth))
    edges = Counter(
        frozenset(pair)
        for face in mesh.faces.tolist()
        for pair in zip(face, face[1:] + face[:1], strict=True)
    )
    assert set(edges.values()) == {2}
    assert len(mesh.vertices) - len(edges) + len(mesh.faces) == 0
    assert len(mesh.faces) == rows * columns * steps**2
    along = periodic(control.reshape(rows, columns, 3), degree, np.arange(rows * steps) / steps)
    expected = periodic(np.moveaxis(along, 1, 0), degree, np.arange(columns * steps) / steps).reshape(-1, 3)
    assert len(mesh.vertices) == len(expected)
    order, other = (np.lexsort(np.round(points, 9).T) for points in (mesh.vertices, expected))
    np.testing.assert_allclose(mesh.vertices[order], expected[other], atol=1e-12)


def test_pieces_are_glued_by_their_numbers_and_not_by_their_places():
    shape = ifs.shape("corner-cutting")
    same_place = np.array([[0.0, 0], [1, 2], [3, 1], [0, 0], [1, 2], [3, 1]])
    apart = {"edge": np.array([[0, 1, 2], [3, 4, 5]])}
    mesh = ifs.draw(ifs.patchwork(shape.topology, shape.system, same_place, apart))
    assert mesh.vertices.shape == (4, 2)


@pytest.mark.parametrize(
    ("patches", "words"),
    [
        ({"face": np.zeros((1, 9), dtype=int)}, "there is no cell 'face'"),
        ({"edge": np.zeros((1, 4), dtype=int)}, "has 3 control points"),
        ({"edge": np.array([[0, 1, 5]])}, "piece 0 of cell 'edge' names a control point"),
    ],
)
def test_wrong_patches_are_refused(patches, words):
    shape = ifs.shape("corner-cutting")
    with pytest.raises(ValueError, match=words):
        ifs.patchwork(shape.topology, shape.system, np.zeros((5, 2)), patches)
