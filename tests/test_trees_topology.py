"""Components, holes and Euler characteristics of trees, against SciPy, plain NumPy and closed forms."""

import itertools
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from trees import Cube, TreeError, empty, from_array, from_points, from_predicate, leaves, to_array, unit_cube
from trees.topology import (
    betti_numbers,
    components,
    euler_characteristic,
    face_counts,
    fill_holes,
    holes,
    surface_area,
)

SIZES = {1: 9, 2: 5, 3: 4, 4: 2}
METRICS = ("d1", "d-infinity")


def blocky(seed: int, dimension: int, bits: int) -> np.ndarray:
    """A random array with uniform regions of several sizes."""
    rng = np.random.default_rng(seed)
    array = np.zeros((1,) * dimension, dtype=bool)
    for _ in range(bits):
        for axis in range(dimension):
            array = array.repeat(2, axis=axis)
        array = array ^ (rng.random(array.shape) < rng.choice([0.02, 0.3]))
    return array


def tiled(seed: int, dimension: int, bits: int) -> np.ndarray:
    """A random array that repeats: its tree has long runs of equal words that are neither full nor empty."""
    rng = np.random.default_rng(seed)
    small = min(bits, 3 if dimension < 3 else 2)
    tile = rng.random((2**small,) * dimension) < rng.choice([0.2, 0.5, 0.8])
    return np.tile(tile, (2 ** (bits - small),) * dimension)


@st.composite
def arrays(draw):
    dimension = draw(st.integers(1, 4))
    bits = draw(st.integers(0, SIZES[dimension]))
    make = draw(st.sampled_from([blocky, blocky, tiled]))
    return make(draw(st.integers(0, 2**32)), dimension, bits)


def structure(dimension: int, metric: str) -> np.ndarray:
    return ndimage.generate_binary_structure(dimension, 1 if metric == "d1" else dimension)


def labelled(array: np.ndarray, metric: str) -> tuple[np.ndarray, int]:
    labels = np.zeros(array.shape, dtype=np.int32)
    count = ndimage.label(array, structure(array.ndim, metric), output=labels)
    assert isinstance(count, int)
    return labels, count


def all_cells(array: np.ndarray) -> np.ndarray:
    return np.argwhere(np.ones_like(array))


def slid(array: np.ndarray, axes, combine) -> np.ndarray:
    for axis in axes:
        n = array.shape[axis]
        array = combine(array.take(range(n - 1), axis), array.take(range(1, n), axis))
    return array


def slow_euler(array: np.ndarray, metric: str) -> int:
    """Cells of every kind, by sliding the padded array over itself."""
    padded, k, total = np.pad(array, 1), array.ndim, 0
    for n in range(k + 1):
        for axes in itertools.combinations(range(k), n):
            if metric == "d1":
                total += (-1) ** n * int(slid(padded, axes, np.logical_and).sum())
            else:
                total += (-1) ** (k - n) * int(slid(padded, axes, np.logical_or).sum())
    return total


def ball(radius: float, bits: int, dimension: int = 3):
    def inside(lows, highs):
        near = np.clip(0.0, lows, highs)
        far = np.maximum(abs(lows), abs(highs))
        middle = ((lows + highs) ** 2).sum(1) / 4 < radius**2
        decided = np.where(highs[:, 0] - lows[:, 0] < 1.5 * 2.0 / 2**bits, middle.astype(int), 2)
        return np.where((far**2).sum(1) < radius**2, 1, np.where((near**2).sum(1) > radius**2, 0, decided))

    return from_predicate(inside, Cube((-1.0,) * dimension, 2.0), bits)


def menger(level: int) -> np.ndarray:
    solid = np.ones((1, 1, 1), dtype=bool)
    ones = np.indices((3, 3, 3)) == 1
    for _ in range(level):
        solid = np.kron(solid, ones.sum(0) < 2)
    return solid


@pytest.mark.parametrize("dense", [0, 10**9])
@settings(deadline=None, max_examples=80)
@given(array=arrays())
def test_components_are_those_of_scipy(dense, array):
    module = sys.modules[components.__module__]

    tree = from_array(array)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "DENSE", dense)
        found = [components(tree, metric) for metric in METRICS]
    for metric, mine in zip(METRICS, found, strict=True):
        labels, count = labelled(array, metric)
        own = mine.labels_of(all_cells(array)).reshape(array.shape)
        assert len(mine) == count
        assert np.array_equal(own >= 0, array)
        assert len(set(zip(own.ravel().tolist(), labels.ravel().tolist(), strict=True))) == count + (
            not array.all()
        )
        assert np.array_equal(np.bincount(own[array], minlength=count), mine.sizes)
        assert (np.diff(mine.sizes.astype(np.int64)) <= 0).all()


@settings(deadline=None, max_examples=80)
@given(array=arrays(), metric=st.sampled_from(METRICS))
def test_forest_parts_and_leaves(array, metric):
    tree = from_array(array)
    found = components(tree, metric)
    labels = found.labels_of(all_cells(array)).reshape(array.shape)
    forest = found.forest()
    assert [len(part) for part in forest] == found.sizes.tolist()
    for number in range(min(len(found), 3)):
        assert np.array_equal(to_array(forest[number]), labels == number)
        assert found.tree_of(number) == forest[number]
    assert found.tree_of(range(len(found))) == tree
    for binary in (False, True):
        corners = leaves(tree, binary)
        cells = np.rint(corners.lows * 2**tree.bits).astype(np.int64)
        assert np.array_equal(found.labels_of_leaves(binary), labels[tuple(cells.T)])
        middles = (corners.lows + corners.highs) / 2
        assert np.array_equal(found.labels_of_points(middles), found.labels_of_leaves(binary))


@settings(deadline=None, max_examples=80)
@given(array=arrays(), metric=st.sampled_from(METRICS))
def test_holes_are_what_scipy_fills(array, metric):
    tree, other = from_array(array), METRICS[metric == "d1"]
    filled = np.asarray(ndimage.binary_fill_holes(array, structure(array.ndim, other)))
    closed = holes(tree, metric)
    assert np.array_equal(to_array(fill_holes(tree, metric)), filled)
    assert len(closed) == labelled(filled & ~array, other)[1]
    own = closed.labels_of(all_cells(array)).reshape(array.shape)
    assert np.array_equal(own >= 0, filled & ~array)
    assert closed.sizes.sum() == (filled & ~array).sum()
    assert len(holes(fill_holes(tree, metric), metric)) == 0


@settings(deadline=None, max_examples=80)
@given(array=arrays())
def test_faces_and_euler_characteristic_by_sliding(array):
    tree = from_array(array)
    padded = np.pad(array, 1)
    faces = tuple(int(slid(padded, (axis,), np.logical_xor).sum()) for axis in range(array.ndim))
    assert face_counts(tree) == faces
    assert surface_area(tree) == pytest.approx(sum(faces) * tree.cell_size ** (array.ndim - 1))
    for metric in METRICS:
        assert euler_characteristic(tree, metric) == slow_euler(array, metric)


@pytest.mark.parametrize(("dimension", "bits"), [(5, 2), (6, 2), (7, 1), (8, 1)])
def test_more_axes_than_a_brick_has_levels(dimension, bits):
    array = np.random.default_rng(dimension).random((2**bits,) * dimension) < 0.4
    tree = from_array(array)
    for metric in METRICS:
        assert euler_characteristic(tree, metric) == slow_euler(array, metric)
        assert len(components(tree, metric)) == labelled(array, metric)[1]


@settings(deadline=None, max_examples=60)
@given(seed=st.integers(0, 2**32), bits=st.integers(0, 6), metric=st.sampled_from(METRICS))
def test_in_the_plane_chi_is_components_minus_holes(seed, bits, metric):
    tree = from_array(blocky(seed, 2, bits))
    assert euler_characteristic(tree, metric) == len(components(tree, metric)) - len(holes(tree, metric))


@settings(deadline=None, max_examples=60)
@given(array=arrays(), metric=st.sampled_from(METRICS))
def test_duality_of_the_two_complexes(array, metric):
    """The open cells of the complement in a larger cube: chi(X) + (-1)^k chi(complement) = (-1)^k."""
    padded = np.zeros((2 * len(array) if len(array) > 1 else 4,) * array.ndim, dtype=bool)
    quarter = len(padded) // 4
    padded[tuple(slice(quarter, quarter + len(array)) for _ in range(array.ndim))] = array
    tree, sign = from_array(padded), (-1) ** array.ndim
    closed, dual = euler_characteristic(tree, "d-infinity"), euler_characteristic(~tree, "d1")
    assert closed == sign * (1 - dual)


@pytest.mark.parametrize("level", [1, 2, 3])
def test_menger_sponge(level):
    """Open faces of the sponge, level by level: 64 corners, 144 edges, 96 squares, 20 cubes."""
    square, cube = 1, -1
    closed = 1
    for _ in range(level):
        square, closed = 16 - 24 + 8 * square, 64 - 144 + 96 * square + 20 * cube
        cube = closed - 6 * square + 12 - 8
    solid = menger(level)
    bits = (len(solid) - 1).bit_length()
    array = np.zeros((2**bits,) * 3, dtype=bool)
    array[: len(solid), : len(solid), : len(solid)] = solid
    tree = from_array(array)
    # No two cubes of the sponge meet in a mere edge, so both metrics agree.
    for metric in METRICS:
        assert euler_characteristic(tree, metric) == closed
        assert betti_numbers(tree, metric) == (1, 1 - closed, 0)
    assert closed == {1: -4, 2: -80, 3: -1408}[level]


def test_genus_of_a_surface():
    """A torus, a shell, two linked bars: the surface around each has chi = 2 - 2 genus."""
    z = np.indices((16, 16, 16)) - 7.5
    radius = np.hypot(z[0], z[1])
    torus = from_array((radius - 4.5) ** 2 + z[2] ** 2 < 4)
    shell = from_array(((z**2).sum(0) < 49) & ((z**2).sum(0) > 16))
    assert betti_numbers(torus) == betti_numbers(torus, "d-infinity") == (1, 1, 0)
    assert betti_numbers(shell) == betti_numbers(shell, "d-infinity") == (1, 0, 1)
    assert euler_characteristic(shell) == 2
    assert fill_holes(shell) == from_array((z**2).sum(0) < 49)


def test_great_depth_is_not_expanded():
    """A cube of 2^63 cells and what is left without it; a ball of 2^60 cells, counted by axes."""
    whole = ~empty(unit_cube(3), bits=21)
    assert face_counts(whole) == (2 * 4**21,) * 3
    assert surface_area(whole) == 6.0
    hollow = whole - from_points([[2**20] * 3, [5, 2**20, 3]], bits=21)
    assert betti_numbers(hollow) == (1, 0, 2)
    assert holes(hollow).sizes.tolist() == [1, 1]
    assert face_counts(hollow) == (2 * 4**21 + 4,) * 3
    assert euler_characteristic(~empty(unit_cube(1), bits=64), "d-infinity") == 1
    with pytest.raises(TreeError, match="pieces"):
        components(~empty(unit_cube(1), bits=64))
    comb = from_array(np.tile([True, False], 2**15))
    assert face_counts(comb) == (2**16,)
    assert euler_characteristic(comb) == euler_characteristic(comb, "d-infinity") == 2**15


def test_area_of_a_ball_of_cells():
    """Faces of a convex body, seen along an axis, cover its shadow twice: 2 pi r^2 an axis."""
    found = ball(0.9, bits=8)
    for faces in face_counts(found):
        assert faces * found.cell_size**2 == pytest.approx(2 * np.pi * 0.81, rel=2e-3)
    assert len(components(found)) == 1


def test_doors():
    tree = from_points([[0, 0], [3, 3]], bits=2)
    with pytest.raises(TreeError, match="metric 'd2': one of d1, d-infinity"):
        components(tree, "d2")
    with pytest.raises(TreeError, match="component 2 of 2: 0 to 1"):
        components(tree).tree_of(2)
    with pytest.raises(TreeError, match="dimension 9: at most 8"):
        euler_characteristic(empty(unit_cube(9), bits=1))
    with pytest.raises(TreeError, match="dimension 4: Betti numbers"):
        betti_numbers(empty(unit_cube(4), bits=1))
    assert len(components(empty(unit_cube(3), bits=5))) == 0
    assert components(tree).labels_of(np.array([[-1, 0], [4, 4], [0, 0]])).tolist() == [-1, -1, 0]
