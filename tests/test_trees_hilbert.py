"""The Peano-Hilbert curve, against its properties and a recursive definition of the plane one."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from trees import KeyTooWide, TreeError, empty, from_array, leaves, to_points, unit_cube
from trees.hilbert import (
    cells_of_hilbert,
    hilbert_cells,
    hilbert_indices,
    hilbert_of_morton,
    hilbert_runs,
    morton_of_hilbert,
)

SIZES = [(1, 6), (2, 5), (3, 4), (4, 3), (5, 2), (6, 2), (7, 1), (3, 0)]


def random_array(seed: int, dimension: int, bits: int) -> np.ndarray:
    """A random array with uniform regions of several sizes."""
    rng = np.random.default_rng(seed)
    array = np.zeros((1,) * dimension, dtype=bool)
    for _ in range(bits):
        for axis in range(dimension):
            array = array.repeat(2, axis=axis)
        array = array ^ (rng.random(array.shape) < rng.choice([0.02, 0.3]))
    return array


arrays = st.integers(1, 4).flatmap(
    lambda k: st.builds(
        random_array, st.integers(0, 2**32), st.just(k), st.integers(0, {1: 9, 2: 4, 3: 3, 4: 2}[k])
    )
)


@pytest.mark.parametrize(("dimension", "bits"), SIZES)
def test_each_step_crosses_one_face(dimension, bits):
    cells = cells_of_hilbert(np.arange(2 ** (dimension * bits)), dimension, bits).astype(np.int64)
    assert (np.abs(np.diff(cells, axis=0)).sum(axis=1) == 1).all()
    assert len(np.unique(cells, axis=0)) == len(cells)
    assert cells[0].tolist() == [0] * dimension
    assert cells[-1].tolist() == [2**bits - 1] + [0] * (dimension - 1)
    assert np.array_equal(hilbert_indices(cells, bits), np.arange(len(cells)))


@pytest.mark.parametrize(("dimension", "bits"), [(k, bits) for k, bits in SIZES if bits])
def test_a_curve_refines_the_coarser_one(dimension, bits):
    cells = cells_of_hilbert(np.arange(2 ** (dimension * bits)), dimension, bits)
    coarse = hilbert_indices(cells >> np.uint64(1), bits - 1)
    assert np.array_equal(coarse, np.arange(len(cells)) >> dimension)


def plane_curve(bits: int) -> list[tuple[int, int]]:
    """Hilbert's curve of 1891: four copies, the first and last turned, from one corner to a neighbour."""
    if bits == 0:
        return [(0, 0)]
    part, half = plane_curve(bits - 1), 2 ** (bits - 1)
    # The copies of the transposed curve stand at both ends, the upright ones between.
    first = [(y, x) for x, y in part]
    second = [(x, y + half) for x, y in part]
    third = [(x + half, y + half) for x, y in part]
    fourth = [(2 * half - 1 - y, half - 1 - x) for x, y in part]
    return first + second + third + fourth


@pytest.mark.parametrize("bits", range(6))
def test_the_plane_curve_is_that_of_hilbert(bits):
    assert list(hilbert_cells(~empty(unit_cube(2), bits))) == plane_curve(bits)


@settings(deadline=None, max_examples=60)
@given(st.sampled_from([(1, 64), (2, 32), (2, 17), (3, 21), (4, 16), (6, 10), (64, 1), (5, 0)]), st.data())
def test_there_and_back_at_any_width(sizes, data):
    dimension, bits = sizes
    top = 2 ** (dimension * bits) - 1
    places = np.array([0, top, *data.draw(st.lists(st.integers(0, top), max_size=20))], dtype=np.uint64)
    cells = cells_of_hilbert(places, dimension, bits)
    assert np.array_equal(hilbert_indices(cells, bits), places)
    keys = morton_of_hilbert(places, dimension, bits)
    assert np.array_equal(hilbert_of_morton(keys, dimension, bits), places)
    after = places[places < top]
    here, there = (cells_of_hilbert(p, dimension, bits) for p in (after, after + np.uint64(1)))
    steps = np.where(here < there, there - here, here - there)
    assert (steps.sum(axis=1) == 1).all()


@settings(deadline=None, max_examples=60)
@given(arrays)
def test_cells_and_leaves_lie_along_the_curve(array):
    tree = from_array(array)
    bits = tree.bits
    places = hilbert_indices(to_points(tree), bits)
    cells = list(hilbert_cells(tree))
    assert cells == list(map(tuple, cells_of_hilbert(np.sort(places), tree.dimension, bits).tolist()))
    lows, highs = hilbert_runs(tree)
    covered = [
        place
        for low, high in zip(lows.tolist(), highs.tolist(), strict=True)
        for place in range(low, high + 1)
    ]
    assert covered == np.sort(places).tolist()
    assert (lows[1:] > highs[:-1] + np.uint64(1)).all()
    found, plain = leaves(tree, order="hilbert"), leaves(tree)
    assert sorted(found.keys.tolist()) == plain.keys.tolist()
    walked = iter(cells)
    for low, high in zip(found.lows, found.highs, strict=True):
        side = round((high[0] - low[0]) * 2**bits)
        block = np.array([next(walked) for _ in range(side**tree.dimension)]) / 2**bits
        assert ((block >= low) & (block < high)).all()
    assert next(walked, None) is None


def test_wrong_orders_are_refused():
    tree = ~empty(unit_cube(2), 2)
    with pytest.raises(TreeError, match="order 'peano'"):
        leaves(tree, order="peano")
    with pytest.raises(TreeError, match="for cubes"):
        leaves(tree, binary=True, order="hilbert")
    with pytest.raises(TreeError, match="place 1 is 16"):
        cells_of_hilbert(np.array([3, 16]), 2, 2)
    with pytest.raises(TreeError, match="place 0 is -1"):
        cells_of_hilbert(np.array([-1]), 2, 2)
    with pytest.raises(TreeError, match="integers, not float64"):
        cells_of_hilbert(np.array([0.5]), 2, 2)
    with pytest.raises(TreeError, match="not float64"):
        hilbert_indices(np.array([[0.5, 0.0]]), 2)
    with pytest.raises(TreeError, match="point 1: coordinate 4"):
        hilbert_indices(np.array([[0, 0], [0, 4]]), 2)
    with pytest.raises(KeyTooWide):
        cells_of_hilbert(np.array([0]), 3, 22)
