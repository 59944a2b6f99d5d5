"""Codes, predicates and points in mm: what a tree is made from and turned into."""

import doctest
import importlib
import pkgutil
import subprocess
import sys
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import trees
from trees import (
    CodeError,
    Cube,
    KeyTooWide,
    TreeError,
    depth_first_code,
    empty,
    from_array,
    from_depth_first_code,
    from_leaf_codes,
    from_morton,
    from_points,
    from_post_order_code,
    from_predicate,
    from_reals,
    leaf_codes,
    post_order_code,
    to_array,
    unit_cube,
)
from trees.codes import AROUND

DEPTH_FIRST, POST_ORDER = "2 2 0 0 0 1 0 2 0 0 0 1 1", "0 0 0 1 2 0 0 0 0 1 2 1 2"
BLACK, WHITE = ["03", "23", "3X"], ["00", "01", "02", "1X", "20", "21", "22"]


@pytest.mark.parametrize("quadrants", [AROUND, None])
def test_figure_1_of_the_report(quadrants):
    tree = from_leaf_codes(BLACK, 2, 2, quadrants)
    assert depth_first_code(tree, quadrants) == DEPTH_FIRST
    assert post_order_code(tree, quadrants) == POST_ORDER
    assert leaf_codes(tree, quadrants) == BLACK
    assert leaf_codes(~tree, quadrants) == WHITE
    assert from_depth_first_code(DEPTH_FIRST, 2, 2, quadrants) == tree
    assert from_post_order_code(POST_ORDER, 2, 2, quadrants) == tree
    assert from_leaf_codes(WHITE[::-1], 2, 2, quadrants) == ~tree


def test_the_quadrants_of_figure_1():
    south_east = {(x, y) for x in (2, 3) for y in (0, 1)}
    assert set(from_leaf_codes(BLACK, 2, 2, AROUND)) == south_east | {(1, 0), (3, 2)}


def recursive_code(array: np.ndarray, quadrants, post: bool) -> str:
    """The code by the recursive definition, on a dense array."""
    if array.all() or not array.any():
        return str(int(array.all()))
    half = array.shape[0] // 2
    children = []
    for quadrant in quadrants:
        sides = [(quadrant >> (array.ndim - 1 - axis)) & 1 for axis in range(array.ndim)]
        part = array[tuple(slice(side * half, (side + 1) * half) for side in sides)]
        children.append(recursive_code(part, quadrants, post))
    return " ".join([*children, "2"] if post else ["2", *children])


@settings(deadline=None, max_examples=80)
@given(st.integers(1, 4), st.integers(0, 3), st.floats(0, 1), st.integers(0, 2**32))
def test_codes_there_and_back(dimension, bits, density, seed):
    bits = min(bits, 2) if dimension == 4 else bits
    rng = np.random.default_rng(seed)
    array = rng.random((2 ** max(bits - 1, 0),) * dimension) < density
    for axis in range(dimension if bits else 0):
        array = array.repeat(2, axis)
    array = array ^ (rng.random(array.shape) < 0.05)
    tree, quadrants = from_array(array), rng.permutation(2**dimension).tolist()
    first, post = depth_first_code(tree, quadrants), post_order_code(tree, quadrants)
    assert first == recursive_code(array, quadrants, False)
    assert post == recursive_code(array, quadrants, True)
    assert from_depth_first_code(first, dimension, bits, quadrants) == tree
    assert from_post_order_code(post, dimension, bits, quadrants) == tree
    assert from_leaf_codes(leaf_codes(tree, quadrants), dimension, bits, quadrants) == tree


def test_codes_of_uniform_trees():
    whole = ~empty(unit_cube(3), 2)
    assert depth_first_code(whole) == post_order_code(whole) == "1"
    assert leaf_codes(whole) == ["XX"]
    assert leaf_codes(~whole) == []
    assert from_depth_first_code("2 11111111", 3, 2) == whole
    assert from_leaf_codes(["0X", "00", "0X"], 3, 2) == from_leaf_codes(["0X"], 3, 2)


@pytest.mark.parametrize(
    ("code", "place", "message"),
    [
        ("2 0 3 0 0", 2, "no colour"),
        ("2 0 0 1", 4, "ends where a node of level 1"),
        ("2 0 0 0 1 0", 5, "complete"),
        ("2 2 2 0 0 0 0", 2, "grey node at level 2"),
        ("", 0, "ends"),
        ("0 x", 1, "no colour"),
    ],
)
def test_depth_first_errors_name_the_place(code, place, message):
    with pytest.raises(CodeError, match=message) as caught:
        from_depth_first_code(code, 2, 2)
    assert caught.value.place == place


@pytest.mark.parametrize(
    ("code", "place", "message"),
    [
        ("0 0 0 1 2 2 2", 4, "grey node at level 2"),
        ("0 0 0 1", 2, "complete"),
        ("0 0 1 2", 0, "ends where a node of level 1"),
    ],
)
def test_post_order_errors_name_the_place(code, place, message):
    with pytest.raises(CodeError, match=message) as caught:
        from_post_order_code(code, 2, 2)
    assert caught.value.place == place


@pytest.mark.parametrize("wrong", ["4X", "0", "000", "X0", "0-", "0x", ""])
def test_leaf_code_errors_name_the_place(wrong):
    with pytest.raises(CodeError) as caught:
        from_leaf_codes(["00", wrong], 2, 2)
    assert caught.value.place == 1


def test_codes_refuse_what_they_cannot_say():
    with pytest.raises(TreeError, match="digits for 1 to 5"):
        leaf_codes(empty(unit_cube(6), 1))
    with pytest.raises(TreeError, match="each of 0 to 3"):
        depth_first_code(empty(unit_cube(2), 1), (0, 1, 2, 2))


def ball(lows: np.ndarray, highs: np.ndarray) -> np.ndarray:
    near, far = np.clip(0.0, lows, highs), np.maximum(abs(lows), abs(highs))
    return np.where((far**2).sum(1) <= 1, 1, np.where((near**2).sum(1) > 1, 0, 2))


@pytest.mark.parametrize(("dimension", "bits"), [(1, 6), (2, 6), (3, 4), (4, 3)])
def test_a_predicate_gives_the_cells_that_meet_the_ball(dimension, bits):
    cube = Cube((-1.25,) * dimension, 2.5)
    tree = from_predicate(ball, cube, bits)
    low = np.stack(np.meshgrid(*[np.arange(2**bits)] * dimension, indexing="ij"), -1) * tree.cell_size - 1.25
    near = np.clip(0.0, low, low + tree.cell_size)
    assert np.array_equal(to_array(tree), (near**2).sum(-1) <= 1)
    coarse = from_predicate(ball, cube, bits - 1)
    assert not tree - coarse
    assert tree.at(bits - 1) == coarse


def test_predicates_that_return_something_else():
    with pytest.raises(TreeError, match="1 integers are needed"):
        from_predicate(lambda lows, highs: np.ones(3, int), unit_cube(2), 2)
    with pytest.raises(TreeError, match="returns 7 for the box"):
        from_predicate(lambda lows, highs: np.full(len(lows), 7), unit_cube(2), 2)
    assert from_predicate(lambda lows, highs: np.full(len(lows), 2), unit_cube(2), 2).count == 16


@settings(deadline=None, max_examples=80)
@given(
    st.lists(st.tuples(*[st.floats(-1e3, 1e3)] * 2), min_size=1, max_size=8),
    st.integers(0, 6),
    st.sampled_from([None, Cube((0.0, 0.0), 1.0), Cube((0.25, -3.0), 1.5), Cube((-1.0, -1.0), 2.0)]),
)
def test_points_in_mm_are_held_by_their_cells(points, bits, cube):
    tree = from_reals(points, bits, cube)
    assert tree.holds(np.array(points)).all()
    assert len(tree) <= len(points)
    assert cube is None or tree.cell_size == cube.size / 2**bits
    low, high = np.array(tree.origin), np.array(tree.origin) + tree.size
    assert all((low <= point).all() and (point < high).all() for point in np.array(points))
    if cube is None:
        assert all(start % tree.size in (0, tree.size / 2) for start in tree.origin)


def test_points_on_and_beside_the_grid():
    tree = from_reals([[-1e-20], [0.0], [np.nextafter(1.0, 0)]], 2, Cube((-1.0,), 2.0))
    assert list(tree) == [(1,), (2,), (3,)]
    assert from_reals([[1.0]], 1, Cube((0.0,), 1.0)).size == 2
    assert list(from_reals([[5e-324]], 3)) == [(0,)]
    assert from_reals(np.zeros((0, 2)), 3, unit_cube(2)) == empty(unit_cube(2), 3)


def test_points_beside_the_faces_of_any_cube():
    cube = Cube((0.5, -1.67), 1.72)
    point = np.array([[np.nextafter(0.5 + 1.72, 0), -1.0]])
    inside = Fraction(point[0, 0]) < Fraction(0.5) + Fraction(1.72)
    assert inside
    assert from_reals(point, 7, cube).holds(point).all()
    for start, size in [(0.5, 1.72), (0.1, 0.7), (-0.3, 0.9), (-1.67, 1.72)]:
        end = Fraction(start) + Fraction(size)
        for x in (float(end), np.nextafter(float(end), -9), np.nextafter(float(end), 9)):
            whole = ~empty(Cube((start,), size), 3)
            assert whole.holds(np.array([[x]]))[0] == (Fraction(x) < end)
    with pytest.raises(TreeError, match="few binary digits"):
        from_reals([[0.95]], 3, Cube((0.1,), 0.7))


def test_wrong_input_is_named():
    with pytest.raises(TreeError, match="point 1: coordinate inf on axis 0"):
        from_reals([[0.0, 0.0], [np.inf, 0.0]], 3)
    with pytest.raises(TreeError, match="at most 12 bits"):
        from_reals([[0.0] * 40], 13)
    with pytest.raises(TreeError, match=r"axis 0: points from -1e.300 to 1e.300"):
        from_reals([[-1e300], [1e300]], 3)
    with pytest.raises(TreeError, match="at most 62"):
        from_reals([[1e100]], 3, unit_cube(1))
    with pytest.raises(TreeError, match="no points"):
        from_reals(np.zeros((0, 2)), 3)
    with pytest.raises(TreeError, match="point 1: coordinate 4 on axis 1"):
        from_points([[0, 0], [0, 4]], 2)
    with pytest.raises(TreeError, match="point 0: coordinate -1"):
        from_points([[-1, 0]], 2)
    with pytest.raises(TreeError, match="integers"):
        from_points(np.array([[0.5, 0.0]]), 2)
    with pytest.raises(TreeError, match="key 1 is 16"):
        from_morton(np.array([3, 16]), unit_cube(2), 2)
    with pytest.raises(KeyTooWide) as caught:
        _ = from_points([[0, 0, 0]], 22).words
    assert (caught.value.dimension, caught.value.bits) == (3, 22)
    for shape in [(3, 3), (2, 4), ()]:
        with pytest.raises(TreeError, match="shape"):
            from_array(np.zeros(shape, dtype=bool))
    with pytest.raises(TreeError, match="Booleans"):
        from_array(np.zeros((2, 2)))
    with pytest.raises(TreeError, match="cube of size"):
        Cube((0.0,), 0.0)


def test_importing_trees_loads_no_numba():
    asked = "import sys, trees; print(sorted({'numba', 'jax', 'scipy'} & set(sys.modules)))"
    answer = subprocess.run([sys.executable, "-c", asked], capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == "[]"


def test_the_examples_of_the_docstrings():
    tried = 0
    for module in pkgutil.iter_modules(trees.__path__):
        result = doctest.testmod(importlib.import_module(f"trees.{module.name}"))
        assert result.failed == 0
        tried += result.attempted
    assert tried > 30
