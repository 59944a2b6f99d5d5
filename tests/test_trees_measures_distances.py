"""Distances of cells and of sets against brute force."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import directed_hausdorff

from trees import Cube, TreeError, distance, empty, from_array, from_points, unit_cube
from trees.measures import cell_distance, hausdorff_distance, jaccard_distance, node_distance

SIZES = {1: 5, 2: 3, 3: 2, 4: 1}


def key(cell, bits: int) -> str:
    return "".join(str(int(x) >> (bits - 1 - level) & 1) for level in range(bits) for x in cell)


def slow_cell_distance(a, b, bits: int) -> Fraction:
    one, other = key(a, bits), key(b, bits)
    common = next((i for i, (x, y) in enumerate(zip(one, other, strict=True)) if x != y), len(one))
    return Fraction(2 ** (len(one) - common) - 1, 2 ** len(one))


@st.composite
def some_sets(draw, number: int):
    dimension = draw(st.integers(1, 4))
    side = 2 ** draw(st.integers(0, SIZES[dimension]))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    shares = draw(st.tuples(*[st.sampled_from([0.05, 0.5, 0.95])] * number))
    return tuple(rng.random((side,) * dimension) < share for share in shares)


@settings(deadline=None, max_examples=30)
@given(some_sets(3))
def test_node_distance_is_the_hausdorff_distance_of_the_ultrametric_of_cells(arrays):
    bits = arrays[0].shape[0].bit_length() - 1
    cells = [np.argwhere(array) for array in arrays]
    trees = [from_array(array) for array in arrays]
    found = {}
    for i in range(3):
        for j in range(3):
            found[i, j] = node_distance(trees[i], trees[j])
            if len(cells[i]) == 0 or len(cells[j]) == 0:
                assert found[i, j] == (0.0 if len(cells[i]) == len(cells[j]) else math.inf)
                continue
            table = [[slow_cell_distance(a, b, bits) for b in cells[j]] for a in cells[i]]
            expected = max(max(map(min, table)), max(map(min, zip(*table, strict=True))))
            assert found[i, j] == expected
    assert found[0, 2] <= max(found[0, 1], found[1, 2])


@settings(deadline=None, max_examples=25)
@given(some_sets(2))
def test_hausdorff_and_jaccard_distances_are_those_of_arrays(arrays):
    a, b = arrays
    cube = Cube((1.0,) * a.ndim, 4.0)
    one, other = from_array(a, cube), from_array(b, cube)
    either = (a | b).sum()
    assert jaccard_distance(one, other) == (pytest.approx((a ^ b).sum() / either) if either else 0.0)
    assert hausdorff_distance(one, one) == 0
    if a.any() and b.any():
        left, right = np.argwhere(a), np.argwhere(b)
        expected = max(directed_hausdorff(left, right)[0], directed_hausdorff(right, left)[0])
        assert hausdorff_distance(one, other) == pytest.approx(expected * 4 / a.shape[0])
    elif a.any() or b.any():
        assert hausdorff_distance(one, other) == math.inf


def test_figures_of_the_source_and_what_it_calls_ultrametric():
    cells = np.array([[0], [3], [2], [5]])
    others = np.array([[1], [4], [5], [5]])
    assert cell_distance(cells, others, 3).tolist() == [1 / 8, 7 / 8, 7 / 8, 0]
    assert cell_distance(cells[:1], others[:1], 3, volume=8.0).tolist() == [1.0]
    nothing, one, two = empty(unit_cube(1), 3), from_points([[0]], 3), from_points([[0], [1]], 3)
    assert distance(nothing, two) > max(distance(nothing, one), distance(one, two))
    with pytest.raises(TreeError, match="float64"):
        cell_distance(cells / 2, others, 3)


def test_sets_in_different_cubes_and_precisions():
    coarse = from_points([[0, 0]], bits=0, cube=Cube((0.0, 0.0), 1.0))
    fine = from_points([[3, 3]], bits=3, cube=Cube((0.0, 0.0), 4.0))
    assert jaccard_distance(coarse, fine) == 1
    assert hausdorff_distance(coarse, fine) == pytest.approx(math.hypot(1.5, 1.5))
    assert node_distance(~empty(unit_cube(2), 32), from_points([[0, 0]], bits=32)) == pytest.approx(1)
