"""Thickening against brute force and closed forms."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from export.check import check
from export.facets import Facets
from export.surface import surface
from export.thicken import BAND, thicken
from export.voxels import EmptySolid, Voxels
from ifs import Mesh

blocks = hnp.arrays(bool, hnp.array_shapes(min_dims=3, max_dims=3, max_side=5)).filter(np.any)


def dots(points: np.ndarray) -> Mesh:
    return Mesh(points, np.arange(len(points))[:, None])


def distances(places: np.ndarray, solid: Voxels) -> np.ndarray:
    """From every voxel centre of a grid to the nearest of some places, in mm, one by one."""
    centres = solid.origin + (np.argwhere(np.ones_like(solid.filled)) + 0.5) * solid.pitch
    gaps = np.linalg.norm(centres[:, None] - places[None], axis=2)
    return gaps.min(axis=1).reshape(solid.filled.shape)


@settings(max_examples=60, deadline=None)
@given(filled=blocks, steps=st.sampled_from([0, 0.4, 1, 1.5, 2, 3]))
def test_centres_within_the_distance(filled, steps) -> None:
    voxels = Voxels(filled, np.array([-1.0, 0.5, 2.0]), 0.3)
    solid = thicken(voxels, steps * 0.3)
    assert solid.field is not None
    near = distances(voxels.centres(), solid.voxels)
    assert np.array_equal(solid.voxels.filled, near <= steps * 0.3 + 1e-9)
    level = max(steps, 0.5) * 0.3
    expected = np.minimum(near - level, BAND * 0.3)
    np.testing.assert_allclose(solid.field, expected, atol=1e-6)
    shell = solid.voxels.filled.copy()
    shell[1:-1, 1:-1, 1:-1] = False
    assert not shell.any()


@settings(max_examples=60, deadline=None)
@given(filled=blocks, steps=st.sampled_from([0, 0.4, 1, 2.5]), seed=st.integers(0, 2**32 - 1))
def test_true_points_next_to_the_surface(filled, steps, seed) -> None:
    voxels = Voxels(filled, np.array([-1.0, 0.5, 2.0]), 0.3)
    moved = np.random.default_rng(seed).uniform(-0.15, 0.15, (voxels.count, 3))
    points = voxels.centres() + moved
    solid = thicken(voxels, steps * 0.3, dots(points))
    assert solid.field is not None
    level = max(steps, 0.5) * 0.3
    true = distances(points, solid.voxels) - level
    original = distances(voxels.centres(), solid.voxels) < 1e-9
    clear = np.abs(true) > 1e-9
    assert np.array_equal((solid.voxels.filled & clear), ((true <= 0) | original) & clear)
    near = (np.abs(true) < 0.3) & ~original
    np.testing.assert_allclose(solid.field[near], true[near], atol=1e-6)
    assert (solid.field[original] <= 0).all()


def test_slabs_do_not_show() -> None:
    rng = np.random.default_rng(0)
    voxels = Voxels(rng.random((60, 5, 5)) < 0.02, np.zeros(3), 1.0)
    points = voxels.centres() + rng.uniform(-0.5, 0.5, (voxels.count, 3))
    for true in (None, dots(points)):
        whole, parts = thicken(voxels, 2.2, true), thicken(voxels, 2.2, true, slab=1)
        assert whole.field is not None
        assert parts.field is not None
        assert np.array_equal(whole.voxels.filled, parts.voxels.filled)
        assert np.array_equal(whole.field, parts.field)


def test_a_thickened_point_is_a_ball() -> None:
    """Errors of the volume fall at least with the first power of the pitch."""
    errors = []
    for pitch in (0.2, 0.1, 0.05):
        dot = Voxels(np.ones((1, 1, 1), dtype=bool), np.zeros(3), pitch)
        report = check(surface(thicken(dot, 1.0)))
        assert report.ok
        assert report.genus == (0,)
        errors.append(abs(report.volume / (4 / 3 * np.pi) - 1))
    assert errors[1] < errors[0] / 2
    assert errors[2] < errors[1] / 2


def test_true_points_remove_the_staircase() -> None:
    """A slanted plate, from points on it: the surface lies in two planes, far within a pitch."""
    pitch, normal = 0.25, np.array([1.0, 2.0, 6.0]) / np.sqrt(41)
    grid = np.stack(np.meshgrid(*[np.arange(40)] * 3, indexing="ij"), axis=-1) + 0.5
    height = (grid * pitch - 5.0) @ normal
    voxels = Voxels(np.abs(height) < pitch / 2, np.zeros(3), pitch)
    points = voxels.centres() - height[voxels.filled][:, None] * normal
    errors = {}
    for name, true in (("points", dots(points)), ("centres", None)):
        mesh = surface(thicken(voxels, 1.5, true))
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
    dot = Voxels(np.ones((1, 1, 1), dtype=bool), np.zeros(3), 1.0)
    for distance in (-1.0, np.inf, np.nan):
        with pytest.raises(ValueError, match="distance"):
            thicken(dot, distance)
    with pytest.raises(EmptySolid):
        thicken(Voxels(np.zeros((1, 1, 1), dtype=bool), np.zeros(3), 1.0), 1.0)
    with pytest.raises(ValueError, match="pitches"):
        thicken(dot, 1.0, dots(np.array([[9.0, 0.5, 0.5]])))
    with pytest.raises(ValueError, match="finite"):
        thicken(dot, 1.0, dots(np.array([[np.nan, 0.5, 0.5]])))
