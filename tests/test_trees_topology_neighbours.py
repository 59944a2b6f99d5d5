"""Neighbours and boundaries of trees, against SciPy and brute force over all pairs of leaves."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from trees import Tree, TreeError, empty, from_array, from_points, leaves, to_array, unit_cube
from trees.topology import adjacent_cells, adjacent_leaves, adjacent_nodes, boundary, directions

SIZES = {1: 8, 2: 4, 3: 3, 4: 2, 5: 1}
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


@st.composite
def arrays(draw):
    dimension = draw(st.integers(1, 5))
    bits = draw(st.integers(0, SIZES[dimension]))
    return blocky(draw(st.integers(0, 2**32)), dimension, bits)


def corners(tree: Tree, binary: bool = False) -> tuple[np.ndarray, np.ndarray]:
    found = leaves(tree, binary)
    return tuple(np.rint(side * 2**tree.bits).astype(np.int64) for side in (found.lows, found.highs))


@settings(deadline=None, max_examples=80)
@given(array=arrays(), metric=st.sampled_from(METRICS))
def test_boundary_is_what_erosion_takes_and_dilation_adds(array, metric):
    ball = ndimage.generate_binary_structure(array.ndim, 1 if metric == "d1" else array.ndim)
    tree = from_array(array)
    eroded = np.asarray(ndimage.binary_erosion(array, ball), dtype=bool)
    dilated = np.asarray(ndimage.binary_dilation(array, ball), dtype=bool)
    assert np.array_equal(to_array(boundary(tree, metric)), array & ~eroded)
    assert np.array_equal(to_array(boundary(tree, metric, "outer")), dilated & ~array)


@settings(deadline=None, max_examples=80)
@given(array=arrays(), metric=st.sampled_from(METRICS), binary=st.booleans())
def test_adjacent_leaves_are_those_whose_boxes_touch(array, metric, binary):
    tree = from_array(array)
    lows, highs = corners(tree, binary)
    overlap = np.minimum(highs[:, None], highs) - np.maximum(lows[:, None], lows)
    shared = (overlap == 0).sum(2) <= (1 if metric == "d1" else array.ndim)
    wanted = np.argwhere(np.triu((overlap >= 0).all(2) & shared, 1))
    assert np.array_equal(adjacent_leaves(tree, metric, binary), wanted)


@settings(deadline=None, max_examples=80)
@given(array=arrays(), metric=st.sampled_from(METRICS), data=st.data())
def test_adjacent_nodes_are_of_equal_or_larger_size(array, metric, data):
    tree, side = from_array(array), len(array)
    cell = np.array([data.draw(st.integers(0, side - 1)) for _ in range(array.ndim)])
    lows, highs = (np.concatenate(both) for both in zip(corners(tree), corners(~tree), strict=True))

    def leaf(at: np.ndarray) -> int:
        return int(np.flatnonzero(((lows <= at) & (at < highs)).all(1))[0])

    own = leaf(cell)
    edge = int(highs[own, 0] - lows[own, 0])
    steps = directions(array.ndim, metric)
    beside = lows[own] + steps * edge
    inside = ((beside >= 0) & (beside < side)).all(1)
    found = adjacent_nodes(tree, cell, metric)
    assert np.array_equal(found.directions, steps[inside])
    for place, level, key, colour in zip(
        beside[inside], found.levels, found.keys, found.colours, strict=True
    ):
        block = array[tuple(slice(x, x + edge) for x in place)]
        assert colour == (2 if block.any() and not block.all() else int(block.all()))
        there = leaf(place)
        start, width = (place, edge) if colour == 2 else (lows[there], highs[there, 0] - lows[there, 0])
        assert side >> level == width >= edge
        first = from_points([start.tolist()], bits=tree.bits)
        assert first.holds_cells(start[None])[0]
        assert int(key) == slow_key(start, tree.bits)


def slow_key(cell, bits: int) -> int:
    text = "".join(str(int(x) >> (bits - 1 - level) & 1) for level in range(bits) for x in cell)
    return int(text or "0", 2)


@pytest.mark.parametrize("dimension", [1, 2, 3, 4, 5, 6])
def test_degrees_of_adjacency(dimension):
    """Guye 1988, V.1, figure 13: 2 k neighbours for d1, 3^k - 1 for d-infinity; fewer at the border."""
    tree = empty(unit_cube(dimension), bits=2)
    middle, corner = np.ones(dimension, dtype=int), np.zeros(dimension, dtype=int)
    assert len(adjacent_cells(tree, middle)) == 2 * dimension
    assert len(adjacent_cells(tree, middle, "d-infinity")) == 3**dimension - 1
    assert len(adjacent_cells(tree, corner)) == dimension
    assert len(adjacent_cells(tree, corner, "d-infinity")) == 2**dimension - 1
    around = adjacent_cells(tree, middle, "d-infinity").astype(int) - 1
    assert {tuple(step) for step in around.tolist()} == {
        tuple(s) for s in directions(dimension, "d-infinity")
    }


def test_a_great_cube_beside_small_ones():
    """Half of a cube of 2^60 cells, and single cells at its side: no face is expanded into cells."""
    half = from_points([[0, 0, 0], [0, 0, 1], [0, 1, 0], [0, 1, 1]], bits=1).at(20)
    tree = half | from_points([[2**19, 7, 7], [2**19, 2**20 - 1, 0], [2**19 + 1, 3, 3]], bits=20)
    assert len(adjacent_leaves(half)) == 4
    assert len(adjacent_leaves(half, "d-infinity")) == 6
    assert len(adjacent_leaves(tree)) == 4 + 2
    wide = from_points([[0, 0]], bits=1).at(12)
    assert len(boundary(wide)) == len(boundary(wide, "d-infinity")) == 4 * (2**11 - 1)
    assert len(boundary(wide, "d1", "outer")) == 2 * 2**11
    assert len(boundary(wide, "d-infinity", "outer")) == 2 * 2**11 + 1
    with pytest.raises(TreeError, match="pieces"):
        boundary(half)


def test_doors():
    tree = from_points([[0, 0], [3, 3]], bits=2)
    with pytest.raises(TreeError, match="metric 'chess'"):
        boundary(tree, "chess")
    with pytest.raises(TreeError, match="side 'both': inner or outer"):
        boundary(tree, side="both")
    with pytest.raises(TreeError, match="coordinate 4 on axis 1: an integer from 0 to 3"):
        adjacent_nodes(tree, np.array([0, 4]))
    with pytest.raises(TreeError, match="3 coordinates for a tree of dimension 2"):
        adjacent_cells(tree, np.array([0, 1, 1]))
    assert adjacent_leaves(empty(unit_cube(3), bits=4)).shape == (0, 2)
