"""One suite for both forms, and trees whose keys are wider than 64 bits."""

import itertools
import pickle
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from trees import (
    Cube,
    Tree,
    TreeError,
    compact,
    empty,
    from_array,
    from_points,
    from_reals,
    from_states,
    from_substitution,
    full,
    to_array,
    unit_cube,
)
from trees.errors import DamagedFile, KeyTooWide
from trees.files import from_bytes, read_tree, to_bytes, write_tree
from trees.measures import moments
from trees.runs import embed
from trees.shared import Shared, check_nodes
from trees.topology import face_counts

SIZES = {1: 9, 2: 4, 3: 3, 4: 2, 6: 1}


@st.composite
def arrays(draw, number: int = 2):
    dimension = draw(st.sampled_from(sorted(SIZES)))
    bits = draw(st.integers(0, SIZES[dimension]))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    found = []
    for _ in range(number):
        array = np.zeros((1,) * dimension, dtype=bool)
        for _ in range(bits):
            for axis in range(dimension):
                array = array.repeat(2, axis=axis)
            array = array ^ (rng.random(array.shape) < rng.choice([0.02, 0.3]))
        found.append(array)
    return tuple(found)


def shared(tree: Tree) -> Tree:
    return Tree(tree.cube, tree.bits, tree.as_shared)


def slow_nodes(array: np.ndarray, axis: int, found: dict) -> int:
    """The number of a node, by cutting arrays."""
    if array.all() or not array.any():
        return int(array.flat[0])
    low, high = (slow_nodes(half, (axis + 1) % array.ndim, found) for half in np.split(array, 2, axis))
    return found.setdefault((low, high), len(found) + 2)


@settings(deadline=None, max_examples=150)
@given(arrays())
def test_shared_trees_are_those_of_the_definition(pair):
    for array in pair:
        tree = from_array(array)
        found: dict = {}
        root = slow_nodes(array, 0, found)
        form = tree.as_shared
        check_nodes(form)
        assert (form.root, list(zip(form.lows.tolist(), form.highs.tolist(), strict=True))) == (
            root,
            list(found),
        )
        again = shared(tree)
        assert again == tree
        assert hash(again) == hash(tree)
        assert again.count == tree.count == array.sum()
        assert again.as_bricks.same(tree.as_bricks)
        assert np.array_equal(to_array(again), array)
        assert list(again) == list(tree)
        assert pickle.loads(pickle.dumps(again)) == tree


@settings(deadline=None, max_examples=150)
@given(arrays(), st.booleans())
def test_operations_in_every_form(pair, both):
    a, b = pair
    one, other = shared(from_array(a)), from_array(b)
    if both:
        other = shared(other)
    for tree, array in (
        (one | other, a | b),
        (one & other, a & b),
        (one ^ other, a ^ b),
        (one - other, a & ~b),
        (other - one, b & ~a),
        (~one, ~a),
    ):
        assert tree == from_array(array)
        if both:
            assert isinstance(tree.form, Shared)
            check_nodes(tree.form)
    assert bool(one) == a.any()
    cells = np.argwhere(np.ones_like(a))
    assert np.array_equal(one.holds_cells(cells), a.ravel())


@settings(deadline=None, max_examples=100)
@given(arrays(1), st.integers(0, 3))
def test_precision_and_cubes_in_every_form(single, change):
    tree = from_array(single[0])
    for bits in {max(tree.bits - change, 0), tree.bits + min(change, 1)}:
        assert shared(tree).at(bits) == tree.at(bits)
        assert shared(tree).at(bits).as_shared.same(tree.at(bits).as_shared)
    for cube in (Cube((-1.0,) * tree.dimension, 2.0), Cube((-0.5,) * tree.dimension, 2.0)):
        if tree.bits or cube.origin[0] == -1.0:
            assert embed(shared(tree), cube) == embed(tree, cube)


@settings(deadline=None, max_examples=60)
@given(st.integers(3, 6), st.integers(22, 62), st.integers(0, 2**32), st.integers(0, 12))
def test_wide_cells(dimension, bits, seed, count):
    rng = np.random.default_rng(seed)
    rows = rng.integers(0, 2**bits, (count, dimension), dtype=np.uint64)
    rows[: count // 2, 0] = rows[: count // 2, 1]
    cells = {tuple(row) for row in rows.tolist()}
    tree = from_points(np.concatenate([rows, rows[::-1]]), bits)
    check_nodes(tree.as_shared)
    assert tree.count == len(cells)
    assert set(tree) == cells
    keys = ["".join(str(x >> bit & 1) for bit in range(bits - 1, -1, -1) for x in cell) for cell in tree]
    assert keys == sorted(keys)
    assert tree.holds_cells(rows).all()
    assert (2**bits - 1,) * dimension in ~tree or (2**bits - 1,) * dimension in cells
    half = from_points(rows[: count // 2], bits)
    assert set(tree - half) == cells - set(half)
    assert (tree - half) | half == tree
    assert tree ^ tree == empty(tree.cube, bits)
    assert (~tree).count == 2 ** (dimension * bits) - len(cells)
    coarse = tree.at(10)
    assert set(coarse) == {tuple(x >> (bits - 10) for x in cell) for cell in cells}


def test_wide_trees_say_what_they_cannot():
    tree = from_points([[1, 2, 3]], bits=40)
    with pytest.raises(KeyTooWide, match="at most 21 bits"):
        _ = tree.words
    with pytest.raises(TreeError, match="512 are possible"):
        from_points(np.zeros((1, 9), dtype=int), bits=60)
    with pytest.raises(TreeError, match="0 to 64 are possible"):
        from_points([[1]], bits=65)
    assert from_reals([[0.5, 0.5, 0.25]], bits=50).depth == 150
    assert tree in {tree}
    assert full(tree.cube, 40) == ~empty(tree.cube, 40)


def test_sierpinski_at_a_million_cells_a_side():
    rules = {"t": ["t", False, False, "t", False, "t", "t", False]}
    tetrahedron = from_substitution(rules, "t", bits=20)
    assert tetrahedron.count == 4**20
    assert len(tetrahedron.as_shared.lows) <= 120
    mirrored = from_substitution({"t": rules["t"][::-1]}, "t", bits=20)
    assert (tetrahedron & mirrored).count == 0
    assert (tetrahedron | mirrored).measure == 2 * tetrahedron.measure
    assert tetrahedron.at(4) == from_substitution(rules, "t", bits=4)
    assert tetrahedron.at(30).measure == tetrahedron.measure
    cells = {cell for cell in np.ndindex(8, 8, 8) if cell in tetrahedron.at(3)}
    assert cells == {cell for cell in np.ndindex(8, 8, 8) if cell[0] ^ cell[1] ^ cell[2] == 0}


def test_an_automaton_with_fractions_as_states():
    def third(state, axis):
        """The interval [0, 1/3] of the line, by where the box lies."""
        low, size = state
        if low + size <= Fraction(1, 3):
            return True
        if low >= Fraction(1, 3):
            return False
        return (low, size / 2), (low + size / 2, size / 2)

    tree = from_states(third, (Fraction(0), Fraction(1)), unit_cube(1), bits=40)
    assert tree.count == -(-(2**40) // 3)
    with pytest.raises(TreeError, match="state 'a' at level 0 gives 7"):
        from_states(lambda state, axis: 7, "a", unit_cube(1), bits=3)  # pyright: ignore[reportArgumentType]
    with pytest.raises(TreeError, match="no rule for 'b'"):
        from_substitution({"a": ["a", "b"]}, "a", bits=2)
    with pytest.raises(TreeError, match="2\\^k of them"):
        from_substitution({"a": ["a", "a", "a"]}, "a", bits=2)


def test_the_smaller_form_is_chosen():
    x, y = np.indices((64, 64))
    assert isinstance(compact(from_array(x & y == 0)).form, Shared)
    noise = from_array(np.random.default_rng(0).random((64, 64)) < 0.5)
    assert compact(noise) is noise


def test_nodes_from_outside_are_checked():
    ok = from_array(np.indices((4, 4)).sum(axis=0) % 3 == 0).as_shared
    for change in itertools.product(range(len(ok.lows)), range(len(ok.lows) + 3), (True, False)):
        node, child, side = change
        lows, highs = ok.lows.copy(), ok.highs.copy()
        (lows if side else highs)[node] = child
        other = Shared(ok.depth, ok.root, lows, highs)
        try:
            check_nodes(other)
        except TreeError:
            continue
        tree = Tree(unit_cube(2), 2, other)
        assert from_array(to_array(tree)) == tree
    with pytest.raises(TreeError, match="root 5"):
        check_nodes(Shared(4, 5, ok.lows, ok.highs))
    with pytest.raises(TreeError, match="1 halvings deep"):
        check_nodes(Shared(1, ok.root, ok.lows, ok.highs))


def test_measures_of_nodes_are_those_of_words():
    rng = np.random.default_rng(4)
    for dimension, bits in ((1, 6), (2, 3), (3, 2), (3, 3), (4, 2), (2, 0)):
        tree = from_array(rng.random((2**bits,) * dimension) < 0.6)
        assert dict(moments(shared(tree), 3).table) == dict(moments(tree, 3).table)
        assert face_counts(shared(tree)) == face_counts(tree)
    rules = {"t": ["t", False, False, "t", False, "t", "t", False]}
    tetrahedron = from_substitution(rules, "t", bits=20)
    assert face_counts(tetrahedron) == (2 * 4**20,) * 3
    assert moments(tetrahedron, 1).centroid.tolist() == [0.5, 0.5, 0.5]


def test_files_of_shared_trees(tmp_path):
    wide = from_points([[1, 2, 2**40 - 1], [5, 5, 5]], bits=40)
    board = compact(from_array(np.indices((64, 64)).prod(axis=0) % 7 == 0))
    for tree in (wide, board, empty(wide.cube, 40), full(wide.cube, 40), shared(board)):
        write_tree(tree, tmp_path / "a.tree")
        again = read_tree(tmp_path / "a.tree")
        assert again == tree
        assert type(again.form) is type(tree.form)
    data = to_bytes(wide)
    for place in range(0, len(data), 3):
        changed = data[:place] + bytes([data[place] ^ 4]) + data[place + 1 :]
        with pytest.raises(DamagedFile):
            from_bytes(changed)
        with pytest.raises(DamagedFile):
            from_bytes(data[:place])
