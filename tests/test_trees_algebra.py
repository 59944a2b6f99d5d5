"""Trees against dense arrays: the reference is a Boolean array and plain NumPy."""

import itertools
import pickle
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from trees import (
    Cube,
    Misaligned,
    Tree,
    TreeError,
    distance,
    empty,
    from_array,
    from_morton,
    from_points,
    leaves,
    to_array,
    to_morton,
    to_points,
    unit_cube,
)
from trees.cube import common_cube, smallest_cube
from trees.runs import embed
from trees.tree import of_bricks

SIZES = {1: 9, 2: 4, 3: 3, 4: 2}


def slow_key(cell, bits: int) -> int:
    text = "".join(str(int(x) >> (bits - 1 - level) & 1) for level in range(bits) for x in cell)
    return int(text or "0", 2)


def blocky(seed: int, dimension: int, bits: int) -> np.ndarray:
    """A random array with uniform regions of several sizes."""
    rng = np.random.default_rng(seed)
    array = np.zeros((1,) * dimension, dtype=bool)
    for _ in range(bits):
        for axis in range(dimension):
            array = array.repeat(2, axis=axis)
        array = array ^ (rng.random(array.shape) < rng.choice([0.02, 0.3]))
    return array


def coarser(array: np.ndarray) -> np.ndarray:
    for axis in range(array.ndim):
        array = array.take(range(0, array.shape[axis], 2), axis) | array.take(
            range(1, array.shape[axis], 2), axis
        )
    return array


def finer(array: np.ndarray) -> np.ndarray:
    for axis in range(array.ndim):
        array = array.repeat(2, axis)
    return array


@st.composite
def two_arrays(draw):
    dimension = draw(st.integers(1, 4))
    bits = draw(st.integers(0, SIZES[dimension]))
    seeds = draw(st.tuples(st.integers(0, 2**32), st.integers(0, 2**32)))
    return tuple(blocky(seed, dimension, bits) for seed in seeds)


@settings(deadline=None, max_examples=150)
@given(two_arrays())
def test_operations_are_those_of_arrays(pair):
    a, b = pair
    one, other = from_array(a), from_array(b)
    assert np.array_equal(to_array(one), a)
    for tree, array in (
        (one | other, a | b),
        (one & other, a & b),
        (one ^ other, a ^ b),
        (one - other, a & ~b),
        (~one, ~a),
    ):
        assert np.array_equal(to_array(tree), array)
        assert tree == from_array(array)
        assert hash(tree) == hash(from_array(array))
        assert len(tree) == array.sum()
    assert distance(one, other) == pytest.approx((a ^ b).mean())
    assert bool(one) == a.any()


@settings(deadline=None, max_examples=80)
@given(two_arrays())
def test_one_set_has_one_form_however_built(pair):
    a, b = pair
    tree = from_array(a)
    bits = tree.bits
    cells = np.argwhere(a)
    shuffled = np.random.default_rng(0).permutation(np.concatenate([cells, cells]))
    keys = np.array([slow_key(cell, bits) for cell in cells], dtype=np.uint64)
    assert from_points(shuffled, bits) == tree
    assert from_morton(keys, unit_cube(a.ndim), bits) == tree
    assert (tree ^ from_array(b)) ^ from_array(b) == tree
    assert pickle.loads(pickle.dumps(tree)) == tree
    assert to_morton(tree).tolist() == sorted(keys.tolist())
    in_order = sorted(map(tuple, cells.tolist()), key=lambda cell: slow_key(cell, bits))
    assert list(tree) == in_order == list(map(tuple, to_points(tree).tolist()))


@settings(deadline=None, max_examples=60)
@given(two_arrays())
def test_precision(pair):
    a, b = pair
    tree = from_array(a)
    if tree.bits:
        assert np.array_equal(to_array(tree.at(tree.bits - 1)), coarser(a))
        small = from_array(coarser(b))
        assert np.array_equal(to_array(tree & small), a & finer(coarser(b)))
        assert small | tree == tree | small
    assert np.array_equal(to_array(tree.at(tree.bits + 1)), finer(a))
    assert tree.at(tree.bits + 1).measure == pytest.approx(tree.measure)
    assert tree.at(tree.bits + 1).at(tree.bits) == tree


@settings(deadline=None, max_examples=60)
@given(two_arrays(), st.integers(0, 2**32))
def test_laws(pair, seed):
    a, b = map(from_array, pair)
    c = from_array(blocky(seed, a.dimension, a.bits))
    nothing = empty(a.cube, a.bits)
    assert ~(a | b) == ~a & ~b
    assert a & (b | c) == (a & b) | (a & c)
    assert a ^ (b ^ c) == (a ^ b) ^ c
    assert a - b == a & ~b
    assert a | ~a == ~nothing
    assert a & ~a == nothing
    assert a | a == a & a == a
    assert a & (a | b) == a
    assert distance(a, c) <= distance(a, b) + distance(b, c) + 1e-12


@settings(deadline=None, max_examples=60)
@given(two_arrays())
def test_membership(pair):
    array, _ = pair
    tree = from_array(array, Cube((-1.0,) * array.ndim, 3.0))
    every = np.argwhere(np.ones_like(array))
    assert np.array_equal(tree.holds_cells(every), array[tuple(every.T)])
    centres = (every + 0.5) * tree.cell_size - 1
    assert np.array_equal(tree.holds(centres), array[tuple(every.T)])
    assert not tree.holds(centres + 3).any()
    assert not tree.holds_cells(every - 2**tree.bits).any()
    assert (0,) * array.ndim in tree or not array.flat[0]
    assert (-1,) * array.ndim not in tree
    assert (2**tree.bits,) * array.ndim not in tree


@settings(deadline=None, max_examples=60)
@given(two_arrays(), st.booleans())
def test_leaves_are_the_largest_blocks(pair, binary):
    array, _ = pair
    tree = from_array(array)
    found = leaves(tree, binary)
    step = 1 if binary else tree.dimension
    flat = np.zeros(2**tree.depth, dtype=bool)
    flat[[slow_key(cell, tree.bits) for cell in np.argwhere(array)]] = True
    expected = []
    for level in range(tree.depth // step + 1):
        size = 2 ** (tree.depth - level * step)
        full = flat.reshape(-1, size).all(axis=1)
        parent = (
            np.zeros_like(full) if level == 0 else flat.reshape(-1, size << step).all(axis=1).repeat(2**step)
        )
        expected += [(i * size, level) for i in np.flatnonzero(full & ~parent)]
    assert sorted(expected) == list(zip(found.keys.tolist(), found.levels.tolist(), strict=True))
    assert np.prod(found.highs - found.lows, axis=1).sum() == pytest.approx(array.mean())
    assert tree.holds((found.lows + found.highs) / 2).all()


def test_large_solids_stay_small():
    half = from_points(np.array([[0, 0, 0]]), 1).at(21)
    assert half.count == 2**60
    assert len(half.words) == 2
    whole = ~empty(unit_cube(4), 16)
    assert whole.count == 2**64
    assert whole.measure == 1
    assert (~whole).count == 0
    assert whole.at(0).at(16) == whole
    corner = from_points(np.array([[2**16 - 1] * 4]), 16)
    assert (whole - corner).count == 2**64 - 1
    assert list(corner) == [(2**16 - 1,) * 4]
    line = from_points(np.array([[2**64 - 1], [0]], dtype=np.uint64), 64)
    assert list(line) == [(0,), (2**64 - 1,)]
    assert (line.at(1)).count == 2
    rest = ~from_points([[0]], 64) - from_points([[1]], 1).at(64)
    assert list(itertools.islice(rest, 2)) == [(1,), (2,)]


@pytest.mark.parametrize("dimension", [5, 6, 7, 13, 64])
def test_many_dimensions(dimension):
    bits = 64 // dimension
    cells = np.random.default_rng(dimension).integers(0, 2**bits, (200, dimension))
    tree = from_points(cells, bits)
    assert set(tree) == set(map(tuple, cells.tolist()))
    assert tree.holds_cells(cells).all()
    assert to_morton(tree).tolist() == sorted({slow_key(cell, bits) for cell in cells})


CUBES = [
    Cube((x * size, y * size), size) for size in (0.5, 1.0, 2.0) for x in range(-3, 4) for y in range(-3, 4)
] + [Cube((-size, -size), 2 * size) for size in (0.5, 1.0, 2.0)]


def absolute(tree: Tree, cell: float) -> set[tuple[int, int]]:
    """The set as cells of this size, counted from the point 0."""
    found = set()
    ratio = Fraction(tree.cell_size) / Fraction(cell)
    assert ratio.denominator == 1
    start = [Fraction(x) / Fraction(cell) for x in tree.origin]
    for place in tree:
        low = [int(s + x * ratio) for s, x in zip(start, place, strict=True)]
        found |= {(low[0] + i, low[1] + j) for i in range(int(ratio)) for j in range(int(ratio))}
    return found


@settings(deadline=None, max_examples=150)
@given(
    st.sampled_from(CUBES),
    st.sampled_from(CUBES),
    st.integers(0, 2),
    st.integers(0, 2),
    st.integers(0, 2**32),
)
def test_cubes_that_differ(first, second, bits, more, seed):
    a = from_array(blocky(seed, 2, bits), first)
    b = from_array(blocky(seed + 1, 2, more), second)
    cell = 2.0**-4
    one, other = absolute(a, cell), absolute(b, cell)
    assert absolute(a | b, cell) == one | other
    assert absolute(a & b, cell) == one & other
    assert absolute(a ^ b, cell) == one ^ other
    assert absolute(a - b, cell) == one - other
    assert a | b == b | a
    assert distance(a, b) == pytest.approx(len(one ^ other) * cell**2)


def test_cubes_off_the_grid_of_zero():
    a = from_array(np.array([True, False]), Cube((0.1,), 0.75))
    b = from_array(np.array([True, True]), Cube((0.1 + 0.75 * 4,), 0.75 / 4))
    if Fraction(b.origin[0]) - Fraction(0.1) == 3:
        both = a | b
        assert both.origin == (0.1,)
        assert both.size == 6
        assert both.measure == pytest.approx(0.375 + 0.1875)
    left = from_array(np.array([True, True]), Cube((-2.5,), 3.0))
    right = from_array(np.array([False, True]), Cube((0.5,), 3.0))
    assert (left | right).origin == (-2.5,)
    assert left | right == right | left
    assert (left | right).measure == 4.5


def test_grids_that_do_not_meet():
    a = from_points([[0, 0]], 1)
    with pytest.raises(Misaligned, match="no power of two"):
        _ = a | from_points([[0, 0]], 1, Cube((0.0, 0.0), 3.0))
    with pytest.raises(Misaligned, match="axis 1") as caught:
        _ = a | from_points([[0, 0]], 1, Cube((0.0, 0.3), 1.0))
    assert caught.value.axis == 1
    with pytest.raises(TreeError, match="dimensions 2 and 3"):
        _ = a & from_points([[0, 0, 0]], 1)
    far = a | from_points([[0, 0]], 1, Cube((0.0, 2.0**40), 1.0))
    assert (far.bits, list(far)) == (42, [(0, 0), (0, 2**41)])
    with pytest.raises(TreeError, match="512 are possible"):
        _ = a | from_points([[0, 0]], 1, Cube((0.0, 2.0**300), 1.0))
    with pytest.raises(Misaligned):
        embed(a, Cube((0.25, 0.0), 2.0))
    with pytest.raises(TypeError):
        _ = a | {(0, 0)}  # pyright: ignore[reportOperatorIssue]


def test_smallest_cube():
    assert smallest_cube((3.0, 3.0), (4.0, 3.0)) == Cube((0.0, 0.0), 8.0)
    assert smallest_cube((-1.0,), (-0.5,)) == Cube((-1.0,), 1.0)
    assert smallest_cube((0.0,), (1.0,)) == Cube((0.0,), 2.0)
    assert smallest_cube((-1.0,), (1.0,)) == Cube((-2.0,), 4.0)
    assert common_cube(Cube((-1.0,), 1.0), Cube((0.0,), 1.0)) == Cube((-1.0,), 2.0)
    assert common_cube(Cube((-2.0,), 4.0), Cube((4.0,), 4.0)) == Cube((-8.0,), 16.0)


def test_a_tree_is_immutable_and_checked():
    tree = from_points([[1, 2]], 2)
    with pytest.raises(ValueError, match="read-only"):
        tree.words[0] = 1
    zeros, ones = np.zeros(1, np.uint64), np.full(1, 2**16, np.uint64)
    with pytest.raises(TreeError, match="beyond the 16 cells"):
        of_bricks(tree.cube, 2, zeros, ones)
    with pytest.raises(TreeError, match="repeats"):
        of_bricks(tree.cube, 4, np.arange(2, dtype=np.uint64), np.ones(2, np.uint64))
    with pytest.raises(TreeError, match="not above"):
        of_bricks(tree.cube, 4, np.array([0, 2, 1], np.uint64), np.array([1, 2, 3], np.uint64))
    with pytest.raises(TreeError, match="brick 4 of a tree of 4"):
        of_bricks(tree.cube, 4, np.array([0, 4], np.uint64), np.array([1, 2], np.uint64))
    with pytest.raises(TreeError, match="no cell"):
        assert (0.5, 1) in tree
