"""Thickening against brute force and closed forms."""

import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from export.check import check
from export.facets import Facets
from export.meshing.skin import EmptySolid, skin
from export.thicken import BAND, thicken
from ifs import Mesh
from trees import Cube, Tree, from_points, to_points

thickening = sys.modules["export.thicken"]
blocks = hnp.arrays(bool, hnp.array_shapes(min_dims=3, max_dims=3, max_side=5)).filter(np.any)


def dots(points: np.ndarray) -> Mesh:
    return Mesh(points, np.arange(len(points))[:, None])


def voxels_of(filled: np.ndarray, origin=(-1.0, 0.5, 2.0), pitch: float = 0.3) -> Tree:
    """The filled voxels as a tree of the smallest cube."""
    bits = (max(filled.shape) - 1).bit_length()
    return from_points(np.argwhere(filled), bits, Cube(tuple(origin), pitch * 2**bits))


def centres(tree: Tree) -> np.ndarray:
    return np.array(tree.origin) + (to_points(tree) + 0.5) * tree.cell_size


def every_cell(tree: Tree, margin: int) -> np.ndarray:
    """The centres of all voxels of the bounding box of a tree, wider by a margin, mm."""
    cells = to_points(tree).astype(int)
    low, high = cells.min(axis=0) - margin, cells.max(axis=0) + margin + 1
    grid = np.stack(np.meshgrid(*map(np.arange, low, high), indexing="ij"), axis=-1).reshape(-1, 3)
    return np.array(tree.origin) + (grid + 0.5) * tree.cell_size


def nearest(places: np.ndarray, points: np.ndarray) -> np.ndarray:
    """From each place to the nearest point, one by one."""
    return np.linalg.norm(places[:, None] - points[None], axis=2).min(axis=1)


@settings(max_examples=20, deadline=None)
@given(filled=blocks, steps=st.sampled_from([0, 0.4, 1, 1.5, 2, 3]))
def test_centres_within_the_distance(filled, steps) -> None:
    tree = voxels_of(filled)
    solid = thicken(tree, steps * 0.3)
    places = every_cell(tree, 5)
    near = nearest(places, centres(tree))
    assert np.array_equal(solid.tree.holds(places), near <= steps * 0.3 + 1e-9)
    assert solid.tree.count == (near <= steps * 0.3 + 1e-9).sum()
    expected = np.minimum(near - max(steps, 0.5) * 0.3, BAND * 0.3)
    np.testing.assert_allclose(solid.field(places), expected, atol=1e-9)


@settings(max_examples=20, deadline=None)
@given(filled=blocks, steps=st.sampled_from([0, 0.4, 1, 2.5]), seed=st.integers(0, 2**32 - 1))
def test_true_points_next_to_the_surface(filled, steps, seed) -> None:
    tree = voxels_of(filled)
    moved = np.random.default_rng(seed).uniform(-0.15, 0.15, (tree.count, 3))
    points = centres(tree) + moved
    solid = thicken(tree, steps * 0.3, dots(points))
    places = every_cell(tree, 5)
    true = nearest(places, points) - max(steps, 0.5) * 0.3
    original = tree.holds(places)
    clear = np.abs(true) > 1e-9
    assert np.array_equal(solid.tree.holds(places) & clear, ((true <= 0) | original) & clear)
    near = (np.abs(true) < 0.3) & ~original
    np.testing.assert_allclose(solid.field(places)[near], true[near], atol=1e-9)
    assert (solid.field(places)[original] <= 0).all()


@settings(max_examples=20, deadline=None)
@given(filled=blocks, steps=st.sampled_from([0, 0.4, 1, 1.5, 2, 3]))
def test_a_box_reaches_centres_within_its_half_side(filled, steps) -> None:
    tree = voxels_of(filled)
    solid = thicken(tree, steps * 0.3, shape="box")
    places = every_cell(tree, 5)
    near = np.abs(places[:, None] - centres(tree)[None]).max(axis=2).min(axis=1)
    assert np.array_equal(solid.tree.holds(places), near <= steps * 0.3 + 1e-9)
    expected = np.minimum(near - max(steps, 0.5) * 0.3, BAND * 0.3)
    np.testing.assert_allclose(solid.field(places), expected, atol=1e-9)


@pytest.mark.parametrize("corners", [1, 2, 3])
def test_a_box_swept_over_facets(corners) -> None:
    """One small facet in the middle of a voxel: the sum with a box, against the linear programme."""
    rng = np.random.default_rng(corners)
    tree = voxels_of(np.ones((1, 1, 1), bool), (0.0, 0.0, 0.0), 1.0)
    mesh = Mesh(rng.uniform(0.2, 0.8, size=(corners, 3)), np.arange(corners)[None])
    solid = thicken(tree, 1.3, mesh, "box")
    places = every_cell(tree, 3)
    near = np.array([nearest_box(place, mesh.vertices) for place in places])
    clear = np.abs(near - 1.3) > 1e-7
    assert np.array_equal(solid.tree.holds(places)[clear], near[clear] <= 1.3)
    np.testing.assert_allclose(solid.field(places), np.minimum(near - 1.3, BAND), atol=1e-7)


def nearest_box(place: np.ndarray, corners: np.ndarray) -> float:
    """The least r such that `|sum w_i c_i - place| <= r` on each axis, for weights w of sum 1."""
    from scipy.optimize import linprog

    count, relative = len(corners), corners - place
    above = np.column_stack([relative.T, -np.ones(3)])
    below = np.column_stack([-relative.T, -np.ones(3)])
    weights = np.append(np.ones(count), 0.0)[None]
    found = linprog([0.0] * count + [1.0], np.vstack([above, below]), np.zeros(6), weights, [1.0])
    return float(found.fun)


@pytest.mark.parametrize("corners", [2, 3])
def test_box_distances_to_facets(corners) -> None:
    rng = np.random.default_rng(corners)
    mesh = Mesh(rng.uniform(size=(corners * 6, 3)), np.arange(corners * 6).reshape(-1, corners))
    places = rng.uniform(-1, 2, size=(40, 3))
    exact = [min(nearest_box(place, mesh.vertices[face]) for face in mesh.faces) for place in places]
    np.testing.assert_allclose(Facets(mesh).distance(places, "d-infinity"), exact, atol=1e-7)


def test_boxes_do_not_show(monkeypatch) -> None:
    rng = np.random.default_rng(0)
    tree = voxels_of(rng.random((60, 5, 5)) < 0.02, (0.0, 0.0, 0.0), 1.0)
    solid = thicken(tree, 2.2)
    places = every_cell(tree, 4)
    whole = solid.field(places)
    monkeypatch.setattr(thickening, "WINDOW", 64)
    assert np.array_equal(solid.field(places), whole)


def test_a_thickened_point_is_a_ball() -> None:
    """Errors of the volume fall at least with the first power of the pitch."""
    errors = []
    for pitch in (0.2, 0.1, 0.05):
        solid = thicken(voxels_of(np.ones((1, 1, 1), bool), (0.0, 0.0, 0.0), pitch), 1.0)
        report = check(skin(solid.tree, "smooth", field=solid.field))
        assert report.ok
        assert report.genus == (0,)
        errors.append(abs(report.volume / (4 / 3 * np.pi) - 1))
    assert errors[1] < errors[0] / 2
    assert errors[2] < errors[1] / 2


def test_true_points_remove_the_staircase() -> None:
    """A slanted plate, from points on it: the surface lies in two planes, far within a pitch."""
    pitch, normal = 0.25, np.array([1.0, 2.0, 6.0]) / np.sqrt(41)
    grid = np.stack(np.meshgrid(*[np.arange(40)] * 3, indexing="ij"), axis=-1) + 0.5
    tree = voxels_of(np.abs((grid * pitch - 5.0) @ normal) < pitch / 2, (0.0, 0.0, 0.0), pitch)
    middles = centres(tree)
    points = middles - ((middles - 5.0) @ normal)[:, None] * normal
    errors = {}
    for name, true in (("points", dots(points)), ("centres", None)):
        solid = thicken(tree, 1.5, true)
        mesh = skin(solid.tree, "smooth", field=solid.field)
        middle = np.linalg.norm(mesh.vertices[:, :2] - 5.0, axis=1) < 2.5
        away = np.abs((mesh.vertices[middle] - 5.0) @ normal)
        errors[name] = np.abs(away - 1.5).max()
    assert errors["points"] < 0.1 * pitch < errors["centres"]


@pytest.mark.parametrize("corners", [2, 3])
def test_distances_to_facets_against_a_fine_sampling(corners) -> None:
    rng = np.random.default_rng(corners)
    mesh = Mesh(rng.uniform(size=(corners * 30, 3)), np.arange(corners * 30).reshape(-1, corners))
    places = rng.uniform(-1, 2, size=(50, 3))
    weights = rng.dirichlet(np.ones(corners) * 0.5, size=20_000)
    sampled = np.einsum("wc,fcd->fwd", weights, mesh.vertices[mesh.faces]).reshape(-1, 3)
    from scipy.spatial import KDTree

    upper = KDTree(sampled).query(places)[0]
    # With few, large facets the nearest eight centres need not hold the nearest facet: ask for all.
    facets = Facets(mesh)
    found = np.min([Facets(Mesh(mesh.vertices, face[None])).distance(places) for face in mesh.faces], axis=0)
    assert (found <= upper + 1e-12).all()
    assert (upper - found).max() < 0.02
    assert (facets.distance(places) >= found - 1e-12).all()


def test_refusals() -> None:
    dot = voxels_of(np.ones((1, 1, 1), dtype=bool), (0.0, 0.0, 0.0), 1.0)
    for distance in (-1.0, np.inf, np.nan):
        with pytest.raises(ValueError, match="distance"):
            thicken(dot, distance)
    with pytest.raises(EmptySolid):
        thicken(dot - dot, 1.0)
    with pytest.raises(ValueError, match=r"one of ball, box; found 'cube'"):
        thicken(dot, 1.0, shape="cube")
    with pytest.raises(ValueError, match="pitches"):
        thicken(dot, 1.0, dots(np.array([[9.0, 0.5, 0.5]])))
    with pytest.raises(ValueError, match="finite"):
        thicken(dot, 1.0, dots(np.array([[np.nan, 0.5, 0.5]])))
