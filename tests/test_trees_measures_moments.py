"""Moments and counts against dense arrays and exact fractions."""

import itertools
from collections.abc import Sequence
from fractions import Fraction
from math import prod

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from trees import Cube, TreeError, empty, from_array, from_morton, from_points, unit_cube
from trees.measures import box_dimension, moments, node_counts
from trees.tree import of_bricks

SIZES = {1: 8, 2: 4, 3: 3, 4: 2}


def blocky(seed: int, dimension: int, bits: int) -> np.ndarray:
    """A random array with uniform regions of several sizes."""
    rng = np.random.default_rng(seed)
    array = np.zeros((1,) * dimension, dtype=bool)
    for _ in range(bits):
        for axis in range(dimension):
            array = array.repeat(2, axis=axis)
        array = array ^ (rng.random(array.shape) < rng.choice([0.02, 0.3]))
    return array


def slow_moment(array: np.ndarray, cube: Cube, a: tuple[int, ...]) -> Fraction | int:
    """Integral of x^a, cell by cell."""
    side = Fraction(cube.size) / array.shape[0]

    def axis_integral(i: int, cell: int) -> Fraction:
        low = Fraction(cube.origin[i]) + cell * side
        return ((low + side) ** (a[i] + 1) - low ** (a[i] + 1)) / (a[i] + 1)

    tables = [[axis_integral(i, cell) for cell in range(array.shape[0])] for i in range(array.ndim)]
    return sum(
        (prod(t[x] for t, x in zip(tables, cell, strict=True)) for cell in np.argwhere(array).tolist()),
        Fraction(0),
    )


def box_moment(lows: Sequence[int], highs: Sequence[int], a: tuple[int, ...], bits: int) -> Fraction:
    """Integral of x^a over a box of cells of the unit cube."""
    return prod(
        (
            (Fraction(high, 2**bits) ** (e + 1) - Fraction(low, 2**bits) ** (e + 1)) / (e + 1)
            for low, high, e in zip(lows, highs, a, strict=True)
        ),
        start=Fraction(1),
    )


def degrees(dimension: int, order: int):
    return [a for a in itertools.product(range(order + 1), repeat=dimension) if sum(a) <= order]


@settings(deadline=None, max_examples=40)
@given(st.integers(1, 4), st.data())
def test_moments_are_the_integrals_over_the_cells(dimension, data):
    array = blocky(data.draw(st.integers(0, 2**32)), dimension, data.draw(st.integers(0, SIZES[dimension])))
    order = data.draw(st.integers(0, 5 if dimension < 3 else 3))
    origin = tuple(data.draw(st.sampled_from([0.0, -1.5, 3.1])) for _ in range(dimension))
    cube = Cube(origin, data.draw(st.sampled_from([1.0, 0.3, 8.0])))
    found = moments(from_array(array, cube), order)
    assert sorted(found.table) == degrees(dimension, order)
    for a in list(found.table)[:: max(len(found.table) // 8, 1)]:
        assert found.table[a] == slow_moment(array, cube, a)


@pytest.mark.parametrize(
    ("dimension", "bits"), [(1, 64), (1, 57), (2, 32), (3, 21), (3, 20), (4, 16), (6, 10)]
)
def test_the_widest_trees_have_exact_moments(dimension, bits):
    rng = np.random.default_rng(bits)
    cells = rng.integers(0, 2**bits, (40, dimension), dtype=np.uint64, endpoint=False)
    tree = from_points(cells, bits)
    order = 3 if dimension < 6 else 2
    found, rest = moments(tree, order).table, moments(~tree, order).table
    rows = {tuple(row) for row in cells.tolist()}
    for a in degrees(dimension, order):
        assert found[a] == sum(box_moment(row, [x + 1 for x in row], a, bits) for row in rows)
        assert found[a] + rest[a] == prod((Fraction(1, e + 1) for e in a), start=Fraction(1))


@pytest.mark.parametrize("order", [0, 1, 4, 6, 9])
def test_words_repeated_over_the_cube_and_orders_beyond_the_machine_integers(order):
    pattern = 0x0F0F_1234_0000_0001
    tree = of_bricks(unit_cube(1), 10, np.zeros(1, np.uint64), np.array([pattern], np.uint64))
    cells = [64 * i + b for i in range(16) for b in range(64) if pattern >> b & 1]
    assert moments(tree, order).table[(order,)] == sum(box_moment([x], [x + 1], (order,), 10) for x in cells)


def test_a_pattern_repeated_two_to_the_fifty_times():
    tree = of_bricks(unit_cube(4), 14, np.zeros(1, np.uint64), np.array([1], np.uint64))
    found = moments(tree, 2)
    # The black cell is the lowest of a brick of 2 x 2 x 4 x 4 cells.
    cell, steps = Fraction(1, 2**14), (2, 2, 4, 4)
    means = []
    for step in steps:
        places = 2**14 // step
        first = cell * step * Fraction(places - 1, 2)
        second = (cell * step) ** 2 * Fraction((places - 1) * (2 * places - 1), 6)
        means.append((Fraction(1), first + cell / 2, second + first * cell + cell**2 / 3))
    for a in degrees(4, 2):
        assert found.table[a] == Fraction(1, 64) * prod(mean[e] for mean, e in zip(means, a, strict=True))


def test_volume_centroid_covariance_and_inertia_of_a_box():
    array = np.zeros((8, 8, 8), dtype=bool)
    array[1:5, 2:4, 0:8] = True
    found = moments(from_array(array, Cube((10.0, 0.0, -4.0), 8.0)), 2)
    assert found.volume == 64
    assert found.centroid.tolist() == [13.0, 3.0, 0.0]
    assert found.covariance == pytest.approx(np.diag([16 / 12, 4 / 12, 64 / 12]))
    # m (b^2 + c^2) / 12 about each axis.
    assert found.inertia == pytest.approx(64 / 12 * np.diag([4 + 64, 16 + 64, 16 + 4]))
    assert found.central().table[(1, 0, 0)] == 0
    assert found.central().central().table == found.central().table


def test_means_are_those_of_points_spread_over_the_cells():
    array = blocky(5, 2, 4)
    found = moments(from_array(array, Cube((1.0, 2.0), 16.0)), 3)
    # Gauss-Legendre points with two nodes an axis integrate degree 3 exactly.
    nodes = np.array(list(itertools.product([0.5 - 12**-0.5, 0.5 + 12**-0.5], repeat=2)))
    points = (np.argwhere(array)[:, None, :] + nodes + np.array([1.0, 2.0])).reshape(-1, 2)
    centred = points - points.mean(axis=0)
    assert found.centroid == pytest.approx(points.mean(axis=0))
    assert found.means(2) == pytest.approx(centred.T @ centred / len(points))
    assert found.means(3) == pytest.approx(np.einsum("ni,nj,nk->ijk", *[centred] * 3) / len(points))


def test_what_has_no_moments_is_refused():
    with pytest.raises(TreeError, match="empty set"):
        _ = moments(empty(unit_cube(2), 3)).centroid
    with pytest.raises(TreeError, match="order -1"):
        moments(empty(unit_cube(2), 3), -1)
    with pytest.raises(TreeError, match="more than 4096"):
        moments(empty(unit_cube(6), 3), 20)
    with pytest.raises(TreeError, match="not 2"):
        _ = moments(~empty(unit_cube(2), 3)).inertia
    with pytest.raises(TreeError, match="degree 3"):
        moments(~empty(unit_cube(2), 3), 2).means(3)


@settings(deadline=None, max_examples=40)
@given(st.integers(1, 5), st.data())
def test_node_counts_are_those_of_coarser_trees(dimension, data):
    bits = data.draw(st.integers(0, SIZES.get(dimension, 2)))
    tree = from_array(blocky(data.draw(st.integers(0, 2**32)), dimension, bits))
    for some in (tree, ~tree):
        assert node_counts(some) == tuple(some.at(b).count for b in range(bits + 1))


def test_node_counts_of_wide_trees():
    assert node_counts(~empty(unit_cube(2), 32)) == tuple(4**b for b in range(33))
    assert node_counts(empty(unit_cube(1), 64)) == (0,) * 65
    tree = from_morton(np.array([0, 2**63 - 1, 2**64 - 1], dtype=np.uint64), unit_cube(1), 64)
    assert node_counts(tree) == (1, 2, *[3] * 63)


def test_box_dimensions_of_self_similar_sets_and_of_smooth_ones():
    x, y = np.indices((64, 64))
    gasket = box_dimension(from_array(x & y == 0))
    assert gasket.value == pytest.approx(np.log2(3))
    assert gasket.residual == pytest.approx(0, abs=1e-12)
    circle = np.abs(np.hypot(x - 31.5, y - 31.5) - 25) < 0.75
    assert box_dimension(from_array(circle), first=2).value == pytest.approx(1, abs=0.1)
    assert box_dimension(from_array(np.ones((8, 8, 8), bool)), 0, 2).value == pytest.approx(3)
    with pytest.raises(TreeError, match="levels 3 to 3"):
        box_dimension(from_array(circle), 3, 3)
    with pytest.raises(TreeError, match="empty"):
        box_dimension(empty(unit_cube(2), 3))
