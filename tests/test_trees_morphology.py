"""Morphology against scipy.ndimage on dense arrays, and exact convex hulls against linear programmes."""

import doctest
import importlib
import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage
from scipy.optimize import linprog
from scipy.spatial import ConvexHull

from trees import (
    Cube,
    KeyTooWide,
    TooManyPieces,
    Tree,
    TreeError,
    empty,
    from_array,
    from_points,
    to_array,
    unit_cube,
)
from trees.morphology import (
    Ball,
    Box,
    Diamond,
    closing,
    convex_hull,
    dilation,
    distances,
    erosion,
    median,
    opening,
    rank,
    within,
)
from trees.morphology.filters import grown
from trees.morphology.halfspaces import half_spaces
from trees.runs import embed

SIZES = {1: 9, 2: 5, 3: 4, 4: 3}


def blocky(seed: int, dimension: int, bits: int) -> np.ndarray:
    """A random array with uniform regions of several sizes."""
    rng = np.random.default_rng(seed)
    array = np.zeros((1,) * dimension, dtype=bool)
    for _ in range(bits):
        for axis in range(dimension):
            array = array.repeat(2, axis=axis)
        array = array ^ (rng.random(array.shape) < rng.choice([0.005, 0.05, 0.3]))
    return array


@st.composite
def arrays(draw, most: int = 4):
    dimension = draw(st.integers(1, most))
    bits = draw(st.integers(0, SIZES[dimension]))
    return blocky(draw(st.integers(0, 2**32)), dimension, bits)


def elements() -> st.SearchStrategy:
    """A kind of element, and a radius."""
    return st.tuples(st.sampled_from([Ball, Diamond, Box]), st.sampled_from([0, 1, 1.5, 2, 2.9]))


def footprint(element, dimension: int) -> np.ndarray:
    """By definition, from the coordinates of all cells."""
    radius = element.radii if isinstance(element, Box) else element.radius
    assert not isinstance(radius, tuple)
    whole = int(radius)
    grids = np.meshgrid(*[np.arange(-whole, whole + 1)] * dimension, indexing="ij")
    if isinstance(element, Ball):
        return np.sum([x**2 for x in grids], axis=0) <= radius**2
    if isinstance(element, Diamond):
        return np.sum([abs(x) for x in grids], axis=0) <= radius
    return np.ones(grids[0].shape, dtype=bool)


def euclidean(array: np.ndarray) -> np.ndarray:
    """The distance from each cell to the nearest true one."""
    return np.asarray(ndimage.distance_transform_edt(~array))


@settings(deadline=None, max_examples=25)
@given(arrays(), elements())
def test_dilation_and_erosion_are_those_of_scipy(array, kind):
    element = kind[0](kind[1])
    tree, shape = from_array(array), footprint(element, array.ndim)
    for made, expected in (
        (dilation(tree, element), ndimage.binary_dilation(array, shape)),
        (erosion(tree, element), ndimage.binary_erosion(array, shape)),
        (erosion(tree, element, outside=True), ndimage.binary_erosion(array, shape, border_value=1)),
        (opening(tree, element), ndimage.binary_opening(array, shape)),
        (closing(tree, element), ndimage.binary_closing(array, shape)),
    ):
        assert np.array_equal(to_array(made), expected)
        assert made == from_array(expected)


@settings(deadline=None, max_examples=25)
@given(arrays(3), elements(), st.booleans())
def test_the_median_and_ranks_are_those_of_scipy(array, kind, outside):
    element = kind[0](kind[1])
    tree, shape = from_array(array), footprint(element, array.ndim)
    count = int(shape.sum())
    for least, made in (
        ((count + 1) // 2, median(tree, element, outside)),
        (1, rank(tree, element, 1, outside)),
        (count, rank(tree, element, count, outside)),
        (max(1, count // 3), rank(tree, element, max(1, count // 3), outside)),
    ):
        expected = ndimage.rank_filter(
            array.astype(np.uint8), count - least, footprint=shape, mode="constant", cval=int(outside)
        )
        assert np.array_equal(to_array(made), expected > 0)


@pytest.mark.parametrize(("dimension", "bits"), [(1, 10), (2, 7), (3, 7), (4, 6)])
def test_several_tiles(dimension, bits):
    rng = np.random.default_rng(dimension)
    cells = rng.integers(0, 2**bits, (40, dimension))
    array = np.zeros((2**bits,) * dimension, dtype=bool)
    array[tuple(cells.T)] = True
    radius = 3 if dimension == 4 else 9
    array |= ndimage.binary_dilation(np.roll(array, 5, 0), iterations=2)
    tree = from_array(array)
    if dimension < 4:
        near = euclidean(array)
        assert np.array_equal(to_array(dilation(tree, Ball(radius))), near <= radius)
        far = euclidean(~np.pad(array, radius))
        inner = (slice(radius, -radius),) * dimension
        assert np.array_equal(to_array(erosion(tree, Ball(2))), far[inner] > 2)
        assert np.array_equal(
            to_array(median(tree, Box(1))), ndimage.median_filter(array, 3, mode="constant")
        )
    box = ndimage.maximum_filter(array, 2 * radius + 1, mode="constant")
    assert np.array_equal(to_array(dilation(tree, Box(radius))), box)


@pytest.mark.parametrize("radius", [63, 64, 65.5, 130])
def test_elements_larger_than_tiles(radius):
    array = np.zeros((512, 512), dtype=bool)
    array[100, 300] = array[101, 511] = array[400:420, 5] = True
    tree = from_array(array)
    near = euclidean(array)
    assert np.array_equal(to_array(dilation(tree, Ball(radius))), near <= radius)
    assert np.array_equal(
        to_array(dilation(tree, Box(radius))),
        ndimage.maximum_filter(array, 2 * int(radius) + 1, mode="constant"),
    )
    line = from_points([[2**19]], 20)
    assert dilation(line, Ball(7000)).count == 14001
    assert erosion(dilation(line, Box(7000)), Ball(6999)).count == 3


def test_boxes_with_a_radius_an_axis():
    array = blocky(5, 3, 4)
    shape = np.ones((1, 5, 7), dtype=bool)
    tree = from_array(array, Cube((0.0, 0.0, 0.0), 8.0))
    expected = from_array(ndimage.binary_dilation(array, shape), tree.cube)
    assert dilation(tree, Box((0, 2, 3))) == expected
    assert dilation(tree, Box((0.4, 1.2, 1.5), mm=True)) == expected
    assert dilation(tree, Ball(1.0, mm=True)) == dilation(tree, Ball(2))
    assert dilation(tree, Ball(math.sqrt(3))) != dilation(tree, Ball(1.7321))


@pytest.mark.parametrize("dimension", [5, 6, 7, 8])
def test_many_dimensions(dimension):
    bits = {5: 5, 6: 4, 7: 3, 8: 3}[dimension]
    rng = np.random.default_rng(dimension)
    cells = rng.integers(0, 2**bits, (4, dimension))
    tree = from_points(cells, bits)
    steps = [s for s in itertools.product((-1, 0, 1), repeat=dimension) if sum(map(abs, s)) <= 2]
    moved = (cells[:, None] + np.array(steps)).reshape(-1, dimension)
    moved = moved[((moved >= 0) & (moved < 2**bits)).all(axis=1)]
    assert dilation(tree, Ball(1.5)) == from_points(moved, bits)


def test_vast_cubes():
    """A tree of 2^63 cells: only what is near black cells counts."""
    tree = from_points([[2**20] * 3, [5, 5, 5], [2**21 - 1] * 3], 21)
    ball = footprint(Ball(6), 3).sum()
    corner = footprint(Ball(6), 3)[:7, :7, :7].sum()
    clipped = footprint(Ball(6), 3)[1:, 1:, 1:].sum()
    assert dilation(tree, Ball(6)).count == ball + corner + clipped
    half = from_points([[0, 0, 0]], 1).at(7)
    assert dilation(half, Box(1)).count == (2**6 + 1) ** 3
    wide = from_points([[0, 0]], 1).at(14)
    assert erosion(wide, Ball(5)).count == (2**13 - 10) ** 2
    assert erosion(wide, Ball(5), outside=True).count == (2**13 - 5) ** 2


@settings(deadline=None, max_examples=12)
@given(arrays(3), elements())
def test_laws(array, kind):
    element = kind[0](kind[1])
    tree = from_array(array)
    wide = grown(tree, element)
    assert wide == embed(tree, wide.cube)
    assert ~dilation(tree, element) == erosion(~tree, element, outside=True)
    opened, closed = opening(tree, element), closing(tree, element, grow=True)
    assert opened - tree == empty(tree.cube, tree.bits)
    assert not (embed(tree, closed.cube) - closed)
    assert opening(opened, element) == opened
    spread = dilation(tree, element, grow=True)
    room = round((tree.origin[0] - spread.origin[0]) / tree.cell_size)
    padded = np.pad(array, [(room, 2**spread.bits - room - 2**tree.bits)] * array.ndim)
    assert np.array_equal(to_array(spread), ndimage.binary_dilation(padded, footprint(element, array.ndim)))


@settings(deadline=None, max_examples=40)
@given(arrays(), st.sampled_from([None, 0, 1, 2.5, 5]), st.integers(0, 2**32))
def test_distances_are_those_of_scipy(array, limit, seed):
    rng = np.random.default_rng(seed)
    low = rng.integers(-3, array.shape[0], array.ndim)
    high = low + rng.integers(1, 6, array.ndim)
    tree = from_array(array)
    padded = np.pad(array, 10)
    inner = tuple(slice(a + 10, b + 10) for a, b in zip(low, high, strict=True))
    cube = (slice(10, -10),) * array.ndim
    for metric, transform in (
        ("euclidean", lambda a: np.rint(euclidean(a) ** 2).astype(int)),
        ("d1", lambda a: np.asarray(ndimage.distance_transform_cdt(~a, "taxicab"))),
        ("d-infinity", lambda a: np.asarray(ndimage.distance_transform_cdt(~a, "chessboard"))),
    ):
        expected = transform(padded) if array.any() else np.full(padded.shape, -1)
        if limit is not None:
            expected = np.where(expected > (limit**2 if metric == "euclidean" else limit), -1, expected)
        clipped = tuple(slice(s.start, min(s.stop, padded.shape[0])) for s in inner)
        part = distances(tree, low.tolist(), high.tolist(), metric, limit)
        assert part.shape == tuple(high - low)
        assert np.array_equal(part[tuple(slice(0, s.stop - s.start) for s in clipped)], expected[clipped])
        assert np.array_equal(distances(tree, metric=metric, limit=limit), expected[cube])
        if limit is not None and array.any():
            level = to_array(within(tree, limit, metric))
            assert np.array_equal(level, expected[cube] >= 0)


def test_distances_far_away():
    tree = from_points([[7, 9, 2**20]], 21)
    found = distances(tree, (0, 0, 0), (2, 3, 4), limit=10)
    assert (found == -1).all()
    near = distances(tree, (0, 0, 2**20), (2, 3, 2**20 + 1), limit=12)
    assert near[..., 0].tolist() == [[130, 113, 98], [117, 100, 85]]
    line = from_points([[3]], 3)
    assert distances(line, (2**17,), (2**17 + 1,)).tolist() == [(2**17 - 3) ** 2]
    assert distances(empty(unit_cube(2), 1)).tolist() == [[-1, -1], [-1, -1]]
    with pytest.raises(TooManyPieces):
        distances(tree)


def in_hull(cell, points: np.ndarray) -> bool:
    """Whether a convex combination of the points is the cell, by a linear programme."""
    table = np.vstack([points.T, np.ones(len(points))])
    return linprog(np.zeros(len(points)), A_eq=table, b_eq=[*cell, 1.0], method="highs").status == 0


@st.composite
def point_sets(draw):
    """Points in general position, or on a flat."""
    dimension = draw(st.integers(1, 4))
    bits = {1: 5, 2: 3, 3: 2, 4: 1}[dimension]
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    points = rng.integers(0, 2**bits, (draw(st.integers(1, 9)), dimension))
    if draw(st.booleans()) and dimension > 1:
        for i, x in zip((0, dimension - 1), rng.integers(0, 2**bits, 2), strict=True):
            points[:, i] = points[:, 1 - i % 2] if rng.random() < 0.5 and dimension > 2 else x
    return points, bits


@settings(deadline=None, max_examples=25)
@given(point_sets())
def test_convex_hulls_are_those_of_linear_programmes(given_points):
    points, bits = given_points
    hull = convex_hull(from_points(points, bits))
    points = np.unique(points, axis=0)
    expected = [
        cell
        for cell in itertools.product(range(2**bits), repeat=points.shape[1])
        if (points == cell).all(axis=1).any() or in_hull(cell, points)
    ]
    assert sorted(hull) == expected
    assert convex_hull(hull) == hull


def test_convex_hulls_of_larger_sets():
    middle, n = 50, 30
    x, y, z = np.ogrid[:128, :128, :128]
    octahedron = from_array(abs(x - middle) + abs(y - middle) + abs(z - middle) <= n)
    tips = from_points(
        np.array([[middle] * 3] * 6) + n * np.vstack([np.eye(3, dtype=int), -np.eye(3, dtype=int)]), 7
    )
    assert convex_hull(tips) == octahedron == convex_hull(octahedron)
    ball = from_array((x - 60) ** 2 + (y - 65) ** 2 + (z - 63) ** 2 <= 50**2)
    assert convex_hull(ball) == ball
    rng = np.random.default_rng(3)
    for dimension, bits in ((2, 20), (3, 14), (4, 9), (5, 6)):
        points = rng.integers(0, 2**bits, (60, dimension))
        spaces = half_spaces(points, 2**bits)
        behind = points @ spaces.normals.T
        assert (behind.max(axis=0) == spaces.limits).all()
        touching = (behind == spaces.limits).any(axis=1)
        assert set(ConvexHull(points).vertices) <= set(np.flatnonzero(touching))
    square = from_points([[3 * 2**7, 2**9], [2**7, 5], [9, 2**10 - 1], [11, 7]], 10)
    hull = convex_hull(square)
    corners = np.array(sorted(square), dtype=np.int64)
    order = np.argsort(np.arctan2(*(corners - corners.mean(axis=0)).T))
    ring = corners[order]
    turn = np.roll(ring, -1, axis=0)
    area = abs((ring[:, 0] * turn[:, 1] - ring[:, 1] * turn[:, 0]).sum())
    rim = np.gcd(*abs(turn - ring).T).sum()
    assert hull.count == (area + rim + 2) // 2  # Pick's theorem
    flat = from_points([[0, 0, 0], [100, 100, 0], [0, 0, 200], [100, 100, 200]], 8)
    assert convex_hull(flat).count == 101 * 201
    assert convex_hull(from_points([[0, 0, 0], [60, 90, 210]], 8)).count == 31
    nothing = empty(unit_cube(3), 4)
    assert convex_hull(nothing) == nothing
    assert convex_hull(~nothing) == ~nothing


def test_wrong_input_is_named():
    tree = from_points([[1, 2]], 2)
    with pytest.raises(TreeError, match="radius of -1"):
        Ball(-1)
    with pytest.raises(TreeError, match="radius of nan"):
        Box((1.0, math.nan))
    with pytest.raises(TreeError, match="3 radii for a tree of dimension 2"):
        dilation(tree, Box((1, 2, 3)))
    with pytest.raises(TreeError, match="10 black cells of an element of 9"):
        rank(tree, Box(1), 10)
    with pytest.raises(TreeError, match="metric 'l2'"):
        distances(tree, metric="l2")
    with pytest.raises(TreeError, match="metric 'l2'"):
        within(tree, 1, "l2")
    with pytest.raises(TreeError, match="axis 1: a box from 2 to 2"):
        distances(tree, (0, 2), (1, 2))
    with pytest.raises(TreeError, match="limit of -1"):
        distances(tree, limit=-1)
    with pytest.raises(TooManyPieces):
        dilation(from_points([[0] * 5], 12), Ball(40))
    with pytest.raises(KeyTooWide):
        dilation(from_points([[0, 0]], 32), Ball(1), grow=True)
    assert isinstance(dilation(tree, Ball(0)), Tree)


@pytest.mark.parametrize(
    "name", ["elements", "filters", "ranks", "spread", "distances", "hull", "halfspaces"]
)
def test_examples_answer_as_shown(name):
    result = doctest.testmod(importlib.import_module(f"trees.morphology.{name}"))
    assert result.failed == 0
    assert result.attempted > 0
