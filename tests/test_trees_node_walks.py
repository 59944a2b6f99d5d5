"""Shared trees are walked on their nodes: the answers of words, for sets that no memory holds expanded."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from trees import Cube, Tree, from_array, from_points, from_substitution, full, leaves, to_array, unit_cube
from trees.errors import TooManyPieces
from trees.geometry import branch, insert, permute, quarter_turn, reflect, scale
from trees.leaves import leaf_runs
from trees.measures import box_dimension, node_counts
from trees.morphology import Ball, Box, Diamond, dilation, erosion, rank
from trees.node_counts import block_count, entry_count
from trees.shared import Shared, check_nodes

SIZES = {1: 8, 2: 4, 3: 3, 4: 2}
RULES = {"t": ["t", "t", "t", False]}


@st.composite
def blocky(draw):
    dimension = draw(st.sampled_from(sorted(SIZES)))
    bits = draw(st.integers(0, SIZES[dimension]))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    array = np.zeros((1,) * dimension, dtype=bool)
    for _ in range(bits):
        for axis in range(dimension):
            array = array.repeat(2, axis=axis)
        array = array ^ (rng.random(array.shape) < rng.choice([0.02, 0.3]))
    return array


def shared(tree: Tree) -> Tree:
    return Tree(tree.cube, tree.bits, tree.as_shared)


def checked(tree: Tree) -> Tree:
    assert isinstance(tree.form, Shared)
    check_nodes(tree.form)
    return tree


@settings(deadline=None, max_examples=60)
@given(blocky(), st.data())
def test_walks_give_what_words_give(array, data):
    tree = from_array(array)
    nodes, k = shared(tree), tree.dimension
    assert entry_count(nodes.as_shared) == len(tree.words)
    assert list(nodes) == list(tree)
    for step in {1, k}:
        expected = leaf_runs(tree, step)
        assert all((a == b).all() for a, b in zip(leaf_runs(nodes, step), expected, strict=True))
        assert block_count(nodes.as_shared, step) == len(expected[0])
    assert node_counts(nodes) == node_counts(tree)
    axes = data.draw(st.permutations(range(k)))
    assert (to_array(checked(permute(nodes, axes))) == array.transpose(axes)).all()
    flipped = data.draw(st.sets(st.sampled_from(range(k))))
    assert (to_array(checked(reflect(nodes, sorted(flipped)))) == np.flip(array, tuple(flipped))).all()
    if k > 1:
        assert quarter_turn(nodes, 0, 1) == quarter_turn(tree, 0, 1)
    level = data.draw(st.integers(0, tree.bits))
    cell = data.draw(st.lists(st.integers(0, 2**level - 1), min_size=k, max_size=k))
    part = branch(nodes, level, cell)
    assert checked(part) == branch(tree, level, cell)
    other = ~part
    assert checked(insert(nodes, other, level, cell)) == insert(tree, branch(~tree, level, cell), level, cell)
    for power in range(-1, tree.bits + 1):
        assert checked(scale(nodes, power)) == scale(tree, power)
        assert checked(scale(nodes, power, grow=True)) == scale(tree, power, grow=True)


def test_sets_that_no_memory_holds():
    for bits in (20, 30, 40):
        tree = from_substitution(RULES, "t", bits)
        assert tuple(itertools.islice(tree, 3)) == ((0, 0), (0, 1), (1, 0))
        assert node_counts(tree) == tuple(3**b for b in range(bits + 1))
        assert abs(box_dimension(tree).value - np.log2(3)) < 1e-12
        assert branch(tree, 3, [0, 1]).count == 3 ** (bits - 3)
        assert not branch(tree, 3, [1, 1])
        assert permute(tree, [1, 0]) == tree
        mirror = reflect(tree, [0])
        assert mirror.count == 3**bits
        assert (2**bits - 1, 0) in mirror
        assert reflect(mirror, [0]) == tree
        assert quarter_turn(mirror, 0, 1) == reflect(tree, [0, 1])
        assert scale(tree, 2).count == 3 ** (bits - 2)
        assert scale(scale(tree, -3), 3) == tree
        filled = insert(tree, full(unit_cube(2), 5), 1, [1, 1])
        assert filled.count == 3**bits + 4 ** (bits - 1)
        assert insert(filled, branch(tree, 1, [1, 1]), 1, [1, 1]) == tree


def test_what_is_too_large_is_counted_beforehand():
    tree = from_substitution(RULES, "t", 22)
    for ask in (leaves, lambda t: t.words, lambda t: leaf_runs(t, 1)):
        with pytest.raises(TooManyPieces) as caught:
            ask(tree)
        assert caught.value.count > 2**28
    with pytest.raises(TooManyPieces) as caught:
        leaves(tree)
    assert caught.value.count == 3**22
    small = from_substitution(RULES, "t", 8)
    assert len(leaves(small)) == 3**8
    assert entry_count(small.as_shared) == len(small.words)


def test_cells_of_more_bits_than_a_word():
    half = from_array(np.array([True, False])).at(192)
    assert half.holds_cells(np.array([[0], [2**63], [2**64 - 1]], dtype=np.uint64)).all()
    assert (2**191 - 1,) in half
    assert (2**191,) not in half
    assert (2**192,) not in half
    assert half.holds(np.array([[0.0], [0.499], [0.5], [1.0], [-0.1]])).tolist() == [True, True] + [False] * 3
    mirror = reflect(half, [0])
    assert (2**191,) in mirror
    assert mirror == ~half
    assert mirror.holds(np.array([[0.0], [0.5]])).tolist() == [False, True]
    third = from_points([[1, 2]], 64)
    assert third.holds_cells(np.array([[1, 2], [2, 1]])).tolist() == [True, False]
    assert third.holds(np.array([[2.0**-64, 2.0**-63], [0.5, 0.5]])).tolist() == [True, False]


def test_dilations_that_are_too_large_are_refused():
    with pytest.raises(TooManyPieces):
        dilation(full(unit_cube(3), 20), Ball(3), grow=True)
    for tree in (from_points([[5, 5]], 20), from_points([[5, 5, 5]], 10)):
        for radius in (10**5, 10**9, 1e300):
            for element in (Ball(radius), Diamond(radius)):
                with pytest.raises(TooManyPieces):
                    dilation(tree, element)
    line = from_points([[5]], 40)
    with pytest.raises(TooManyPieces):
        rank(line, Ball(1e300), 2)


def test_dilations_on_the_line():
    rng = np.random.default_rng(3)
    for bits, radius in itertools.product((0, 3, 7, 9), (0, 1, 3, 70, 10**9)):
        array = rng.random(2**bits) < 0.05
        tree, by = from_array(array), min(radius, 2**bits)
        for outside in (False, True):
            padded = np.pad(array, by, constant_values=outside)
            black = np.array([padded[i : i + 2 * by + 1].any() for i in range(2**bits)])
            white = np.array([padded[i : i + 2 * by + 1].all() for i in range(2**bits)])
            assert (to_array(erosion(tree, Box(radius), outside)) == white).all()
            if not outside:
                assert (to_array(dilation(tree, Ball(radius))) == black).all()
                assert dilation(tree, Diamond(radius)) == dilation(tree, Box(radius))
    wide = dilation(from_points([[2**62]], 63), Ball(2.0**60))
    assert wide.count == 2**61 + 1
    assert dilation(Tree(Cube((0.0,), 1.0), 63, wide.form), Ball(1e300)).count == 2**63
