"""Moments and areas in exact fractions, against sums of independent digits, brute force and chaos games."""

from fractions import Fraction
from itertools import product
from math import comb

import numpy as np
import pytest

import ifs
from automata import parse_text
from ifs.measures.areas import NoArea, area, area_form, swept_area
from ifs.measures.chains import NoChain
from ifs.measures.moments import WrongProbabilities, barycentric_moments, moments
from ifs.measures.operators import operators
from subdivision.schemes import b_spline, hilbert, koch

F = Fraction


def digit_moment(weights, base, order):
    """E x^k of x = sum d_k base^-k, d independent: `x = (d + x') / base`, multiplied out."""
    found = [F(1)]
    for k in range(1, order + 1):
        lower = sum(
            comb(k, j) * found[j] * sum(p * F(d) ** (k - j) for d, p in weights.items()) for j in range(k)
        )
        found.append(lower / (F(base) ** k - 1))
    return found


def test_mengers_sponge_has_the_moments_of_its_digits():
    found = moments(ifs.shape("menger-sponge"), order=4)
    weights = {0: F(8, 20), 1: F(4, 20), 2: F(8, 20)}
    expected = digit_moment(weights, 3, 4)
    for axis, power in product(range(3), range(5)):
        exponent = tuple(power * (k == axis) for k in range(3))
        assert found.table[exponent] == 54**power * expected[power]
    assert found.mean == (27, 27, 27)


def test_sierpinskis_triangle_exactly():
    shape = ifs.shape("sierpinski-triangle", control=np.array([[0, 0], [1, 0], [0, 1]]))
    found = moments(shape, order=3)
    for axis in range(2):
        one = digit_moment({0: F(2, 3), 1: F(1, 3)}, 2, 3)
        assert [found.table[tuple(k * (axis == i) for i in range(2))] for k in range(4)] == one
    # xy = (d + x)(e + y) / 4 with de = 0, E d y = E d E y.
    assert found.table[1, 1] == 2 * F(1, 3) * F(1, 3) / 3


@pytest.mark.parametrize("seed", range(2))
def test_random_systems_against_brute_force(seed):
    rng = np.random.default_rng(seed)
    table = {}
    for cell, targets in {"x": ("x", "y"), "y": ("y", "x", "x")}.items():
        table[cell] = {}
        for k, target in enumerate(targets):
            rows = [[F(int(n), 10) for n in row] for row in rng.integers(-3, 4, size=(2, 3))]
            rows.append([1 - rows[0][j] - rows[1][j] for j in range(3)])
            table[cell][str(k)] = (target, tuple(map(tuple, rows)))
    weights = {"x": {"0": F(1, 3), "1": F(2, 3)}, "y": {"0": F(1, 2), "1": F(1, 6), "2": F(1, 3)}}
    found = barycentric_moments(table, 4, weights)
    # The equations themselves, in floats and with all coordinates: tensors of the fourth order.
    tensors = {}
    for cell in table:
        full = np.zeros((3,) * 4)
        for index in product(range(3), repeat=4):
            full[index] = _full_moment(found[cell], index)
        tensors[cell] = full
    for cell, row in table.items():
        moved = sum(
            float(weights[cell][label])
            * np.einsum("ai,bj,ck,dl,ijkl->abcd", *[np.array(rows, float)] * 4, tensors[target])
            for label, (target, rows) in row.items()
        )
        np.testing.assert_allclose(moved, tensors[cell], rtol=1e-9, atol=1e-9)
        assert tensors[cell].sum() == pytest.approx(1)
    assert all(isinstance(value, Fraction) for row in found.values() for value in row.values())


def _full_moment(table, index):
    """E p_i p_j p_k p_l with p_2 = 1 - p_0 - p_1, multiplied out."""
    terms = {(0, 0): F(1)}
    for place in index:
        grown = {}
        for (a, b), value in terms.items():
            steps = [((1, 0), 1)] if place == 0 else [((0, 1), 1)] if place == 1 else None
            for (da, db), sign in steps or [((0, 0), 1), ((1, 0), -1), ((0, 1), -1)]:
                grown[a + da, b + db] = grown.get((a + da, b + db), 0) + sign * value
        terms = grown
    return float(sum(value * table[key] for key, value in terms.items()))


def test_a_chaos_game_has_the_moments_within_sampling_error():
    shape = ifs.shape("koch-curve")
    weights = {"edge": {"0": 0.1, "1": 0.2, "2": 0.3, "3": 0.4}}
    found = moments(shape, 2, weights)
    assert isinstance(found.mean[0], float)
    rng = np.random.default_rng(5)
    state = shape.system.states["edge"]
    stack = np.stack(state.operators)
    points = np.repeat(ifs.sample(shape.system)["edge"][None], 200_000, axis=0)
    for _ in range(30):
        points = np.einsum(
            "nij,nj->ni", stack[rng.choice(4, size=len(points), p=[0.1, 0.2, 0.3, 0.4])], points
        )
    places = points @ shape.control
    error = 5 * places.std(axis=0) / np.sqrt(len(places))
    assert (np.abs(places.mean(axis=0) - np.array(found.mean)) <= error).all()
    np.testing.assert_allclose(np.cov(places.T), np.array(found.covariance), rtol=0.02, atol=2)


def test_a_bezier_patch_of_curves_integrates_its_polynomial():
    # The uniform measure of a quadratic B-spline on halves: E p_j is the integral of its basis function.
    spline = ifs.shape(b_spline(2), control=np.array([[1, 0], [0, 1], [0, 0]]))
    found = moments(spline, 2)
    assert found.mean == (F(1, 6), F(2, 3))
    assert found.table[2, 0] == F(1, 20)  # the integral of ((1 - t)^2 / 2)^2


def test_wrong_probabilities_are_named():
    shape = ifs.shape("koch-curve")
    quarter = {str(k): F(1, 4) for k in range(4)}
    for given, message in [
        ({"face": {}}, "no cell 'face'"),
        ({"edge": {"0": 1}}, "wrong: 1, 2, 3"),
        ({"edge": quarter | {"0": F(-1, 4), "1": F(3, 4)}}, "'0' in cell 'edge'"),
        ({"edge": quarter | {"0": F(1, 3)}}, "they sum to 13/12"),
    ]:
        with pytest.raises(WrongProbabilities, match=message):
            moments(shape, 1, given)
    with pytest.raises(ValueError, match="too many"):
        moments(ifs.shape("catmull-clark-patch"), 4)
    with pytest.raises(ValueError, match="0 or more"):
        moments(shape, -1)


def test_kochs_snowflake_has_eight_fifths_of_its_triangle():
    # Between the curve and its chord: 3/5 of the triangle of its hull, a third of the triangle.
    form = area_form(ifs.shape(koch()))
    assert form[0][1] == F(3, 5)
    third = F(1, 3) * form[0][1]
    assert 1 + 3 * third == F(8, 5)
    corners = np.array([[0, 0], [30, 52], [60, 0]])
    curve = ifs.shape(koch())
    total = F(0)
    for k in range(3):
        a, b = corners[k], corners[(k + 1) % 3]
        tip = (a + b) / 2 + np.array([-(b - a)[1], (b - a)[0]]) / np.sqrt(12)
        total += swept_area(curve, np.stack([a, tip, b]))
    base = -60 * 52 / 2  # clockwise, with the tips outside
    sides = sum(float(np.sum((corners[k] - corners[k - 1]) ** 2)) for k in range(3))
    assert float(total) == pytest.approx(base - sides / np.sqrt(12) * 3 / 10)


def test_areas_of_known_curves():
    parabola = ifs.shape(b_spline(2), control=np.array([[-1, 1], [0, -1], [1, 1]]))
    # The curve runs from (-1/2, 0) to (1/2, 0) over y = 2 x^2 - 1/2; the segment cut off is a third.
    assert area(parabola) == F(1, 3)
    assert area(ifs.shape("takagi-curve", control=np.array([[0, 0], [1, 1], [2, 0]]))) == -2
    square = ifs.shape(hilbert(), control=np.array([[0, 0], [0, 1], [1, 1], [1, 0]]))
    polygons = [_polygon_area(square, depth) for depth in (1, 4, 6)]
    assert float(area(square)) == pytest.approx(polygons[-1], abs=1e-3)
    with pytest.raises(NoChain, match="triangle"):
        area(ifs.shape("sierpinski-triangle"))


def _polygon_area(shape, depth):
    """Of the polygon of the joints of pieces and the chord, by the shoelace formula."""
    controls = [shape.control]
    for _ in range(depth):
        controls = [t.T @ c for c in controls for t in shape.system.states["edge"].operators]
    corners = np.array([c[0] for c in controls] + [controls[-1][-1]])
    x, y = corners.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def test_areas_that_do_not_settle_are_refused():
    text = """
format = "bcifs/1"
name = "Levy"
shape = "edge"
[cells.vertex]
points = 1
subdivision = { s = "vertex" }
[cells.edge]
points = 3
subdivision = { 0 = "edge", 1 = "edge" }
boundary = { left = { cell = "vertex", points = [0] }, right = { cell = "vertex", points = [2] } }
incidence = ["left s = 0 left", "right s = 1 right"]
adjacency = ["0 right = 1 left"]
[cells.edge.matrices]
0 = [[1, "1/2", 0], [0, 1, 1], [0, "-1/2", 0]]
1 = [[0, "-1/2", 0], [1, 1, 0], [0, "1/2", 1]]
[control]
points = [[0, 0], [1, 1], [2, 0]]
"""
    with pytest.raises(NoArea, match="sum to 1 times"):
        area(ifs.shape(parse_text(text)))


def test_operators_are_exact():
    found = operators(ifs.shape("koch-curve"))
    assert all(
        sum(row[j] for row in rows) == 1
        for table in found.values()
        for _, rows in table.values()
        for j in range(len(rows[0]))
    )
