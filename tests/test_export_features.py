"""Features of the smooth skin: edges and corners of flat faces are met, round surfaces left alone."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from export.check import check
from export.meshing.features import meeting_places
from export.meshing.grading import Grading
from export.meshing.skin import skin
from trees import Cube, Tree, from_array

CUBE = Cube((-1.0, -2.0, 3.0), 4.0)
MIDDLE = np.array([1.0, 0.0, 5.0])
SIDE = 16
PITCH = CUBE.size / SIDE


def tree_of(field) -> Tree:
    centres = np.indices((SIDE,) * 3).reshape(3, -1).T + 0.5
    return from_array((field(CUBE.origin + centres * PITCH) <= 0).reshape((SIDE,) * 3), CUBE)


def turned(seed: int) -> np.ndarray:
    return Rotation.from_quat(np.random.default_rng(seed).normal(size=4)).as_matrix()


def turned_cube(seed: int, half: float = 1.03):
    turn = turned(seed)

    def field(points):
        over = np.abs((points - MIDDLE) @ turn) - half
        return np.linalg.norm(np.maximum(over, 0), axis=1) + np.minimum(over.max(axis=1), 0)

    return field, lambda points: np.abs((points - MIDDLE) @ turn) - half


@pytest.mark.parametrize("seed", [1, 3])
def test_edges_and_corners_of_a_turned_cube_are_met(seed) -> None:
    field, over = turned_cube(seed)
    tree = tree_of(field)
    plain, mesh = skin(tree, "smooth", field=field), skin(tree, "smooth", field=field, features=30)
    report = check(mesh)
    assert report.ok, report.faults
    assert report.euler == check(plain, quick=True).euler
    faces_met = (np.abs(over(mesh.vertices)) < 1e-6 * PITCH).sum(axis=1)
    wrong = np.abs(field(mesh.vertices)) > 1e-6 * PITCH
    # a box may hold a vertex back from an edge that passes next to it
    assert wrong.sum() < 0.4 * (faces_met >= 2).sum()
    assert np.abs(field(mesh.vertices)).max() < 0.6 * PITCH
    assert (faces_met == 2).sum() > 12 * 2.06 / PITCH / 2
    assert (faces_met == 3).sum() >= 2
    exact = 2.06**3
    assert abs(report.volume - exact) < 0.2 * abs(check(plain, quick=True).volume - exact)


def test_a_given_gradient_takes_the_place_of_differences() -> None:
    field, over = turned_cube(1)
    turn = turned(1)

    def gradient(points):
        local = (points - MIDDLE) @ turn
        axis = np.argmax(over(points), axis=1)
        rows = np.arange(len(points))
        return np.sign(local[rows, axis])[:, None] * turn[:, axis].T

    tree = tree_of(field)
    found = skin(tree, "smooth", field=field, features=30)
    wanted = skin(tree, "smooth", field=field, features=30, gradient=gradient)
    np.testing.assert_allclose(found.vertices, wanted.vertices, atol=1e-6 * PITCH)


def test_the_rim_of_a_cylinder_is_met_to_second_order() -> None:
    turn = turned(3)

    def field(points):
        local = (points - MIDDLE) @ turn
        over = np.stack([np.hypot(local[:, 0], local[:, 1]) - 1.2, np.abs(local[:, 2]) - 1.03], axis=1)
        return np.linalg.norm(np.maximum(over, 0), axis=1) + np.minimum(over.max(axis=1), 0)

    mesh = skin(tree_of(field), "smooth", field=field, features=40)
    local = (mesh.vertices - MIDDLE) @ turn
    off = np.hypot(np.hypot(local[:, 0], local[:, 1]) - 1.2, np.abs(local[:, 2]) - 1.03)
    assert (off < 0.03 * PITCH).sum() > 2 * np.pi * 1.2 / PITCH
    report = check(mesh)
    assert report.ok, report.faults


def test_a_sheet_thickened_by_a_box_is_the_box() -> None:
    """The ends of a flat sheet, oblique to no axis: all twelve edges, all eight corners, the exact volume."""
    half = np.array([1.21, 0.83, 0.37])

    def field(points):
        return (np.abs(points - MIDDLE) - half).max(axis=1)

    mesh = skin(tree_of(field), "smooth", field=field, features=30)
    assert check(mesh).ok
    assert check(mesh, quick=True).volume == pytest.approx(8 * half.prod(), rel=1e-6)


def test_round_surfaces_have_no_features() -> None:
    def field(points):
        return np.linalg.norm(points - MIDDLE, axis=1) - 1.5

    tree = tree_of(field)
    plain = skin(tree, "smooth", field=field, grading=Grading(1))
    mesh = skin(tree, "smooth", field=field, features=40)
    assert len(plain.vertices) == len(mesh.vertices)
    # the crossings are exact ones, no longer those of a straight line between two centres
    np.testing.assert_allclose(mesh.vertices, plain.vertices, atol=0.05 * PITCH)


def test_planes_meet_where_they_are_nearest() -> None:
    rng = np.random.default_rng(0)
    corner = rng.random((50, 3)) - 0.5
    normals = np.linalg.qr(rng.normal(size=(50, 3, 3)))[0].reshape(-1, 3)
    vertex = np.repeat(np.arange(50), 3)
    points = corner[vertex] + np.cross(normals, rng.normal(size=(150, 3)))
    free = meeting_places(vertex, points, normals, np.zeros((50, 3)), np.full(50, 9.0), 0.5)
    np.testing.assert_allclose(free, corner, atol=1e-9)
    held = meeting_places(vertex, points, normals, np.zeros((50, 3)), np.full(50, 0.25), 0.5)
    # three orthogonal planes: the square of all distances is that of the distance from their corner
    np.testing.assert_allclose(held, np.clip(corner, -0.25, 0.25), atol=1e-6)


@pytest.mark.parametrize(
    ("wishes", "message"),
    [
        ({"features": 30}, "give both"),
        ({"features": 0, "field": turned_cube(0)[0]}, "between 0 and 180"),
        ({"features": 30, "field": turned_cube(0)[0], "style": "exact"}, "give both"),
        ({"gradient": lambda points: points, "field": turned_cube(0)[0]}, "gradient is for features"),
        ({"gradient": lambda points: points[:2], "field": turned_cube(0)[0], "features": 9}, "three numbers"),
    ],
)
def test_wrong_wishes_are_named(wishes, message) -> None:
    with pytest.raises(ValueError, match=message):
        skin(tree_of(turned_cube(0)[0]), **{"style": "smooth", **wishes})
