"""Local fractional derivatives in closed form: against splines, series, and quotients in 300 digits."""

import dataclasses
import json
import math
from fractions import Fraction

import mpmath as mp
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.interpolate import BSpline
from test_fld_curves import bezier, corner_cutting, given_curve, planes
from test_fld_fractals import landsberg

import fld
import ifs
import subdivision
from fld.address import address, parse_address
from fld.curve import curve
from fld.derivative import derivative
from fld.local import local, repeated

few = settings(max_examples=4, deadline=None)
KOCH = math.log(3) / math.log(4)


def affine_interpolation(x, y, factors):
    """A fractal interpolation function through (x, y): `(x, y) -> (a_i x + e_i, c_i x + d_i y + f_i)`.

    L_i has the eigenvalues `a_i = x_(i+1) - x_i` and d_i (vertical). Control points as in `interpolation`.
    """
    x, y, factors = ([Fraction(str(v)) for v in row] for row in (x, y, factors))
    operators = []
    for k, d in enumerate(factors):
        images = [(x[k], y[k]), (x[k], y[k] + d), (x[k + 1], y[k + 1])]
        columns = []
        for px, py in images:
            u = py - y[0] - px * (y[-1] - y[0])
            columns.append([1 - px - u, u, px])
        operators.append([list(row) for row in zip(*columns, strict=True)])
    return given_curve(operators, [[0, y[0]], [0, y[0] + 1], [1, y[-1]]])


class Referee:
    """Difference quotients of a curve from its exact operators, in 300 digits."""

    def __init__(self, shape, parts):
        with mp.workdps(300):
            self._read(shape, parts)

    def _read(self, shape, parts):
        numbers = subdivision.solve(shape.automaton).numbers()[shape.automaton.shape]
        self.labels = curve(shape).labels
        self.operators = {
            label: mp.matrix(
                [[mp.mpf(v.numerator) / v.denominator for v in map(Fraction, row)] for row in rows]
            )
            for label, rows in numbers.items()
        }
        self.control = mp.matrix(shape.control.tolist())
        self.parts = {label: mp.mpf(parts[label]) for label in self.labels}
        self.begins = {label: sum(list(self.parts.values())[:k]) for k, label in enumerate(self.labels)}

    def at(self, word, repeat):
        """Point and parameter of an address."""
        size, shift, power = mp.mpf(1), mp.mpf(0), mp.eye(self.control.rows)
        for label in repeat[::-1]:
            size, shift = self.parts[label] * size, self.begins[label] + self.parts[label] * shift
            power = self.operators[label] * power
        for _ in range(13):
            power = power * power
        column, place = power[:, 0], shift / (1 - size)
        for label in word[::-1]:
            column = self.operators[label] * column
            place = self.begins[label] + self.parts[label] * place
        return column.T * self.control, place

    def quotient(self, where, steps, tail, order, last="0"):
        """`± Gamma(1 + q) (H(t ± h) - H(t)) / h^q` from `w u^omega` to `w u^steps tail last^omega`."""
        with mp.workdps(300):
            here, t = self.at(where.word, where.repeat)
            there, s = self.at([*where.word, *where.repeat * steps, *tail], [last])
            sign = 1 if s > t else -1
            scale = sign * mp.gamma(1 + mp.mpf(order)) / abs(s - t) ** mp.mpf(order)
            return np.array([float(v * scale) for v in there - here])


def referee(shape, found):
    return Referee(shape, found.parts)


def close(one, other, tolerance):
    return np.linalg.norm(np.subtract(one, other)) <= tolerance * np.linalg.norm(other)


periods = st.lists(st.sampled_from("01"), min_size=1, max_size=5)
words = st.lists(st.sampled_from("01"), max_size=4)


@few
@given(words, periods)
def test_quadratic_splines_have_their_ordinary_derivative_at_every_period(word, period):
    control = np.array([[3.0, -2, 7], [30, 60, 1], [70, 10, -20]])
    spline = BSpline(np.arange(-2.0, 4), control, 2)
    found = fld.derivatives(corner_cutting("1/4", "1/4", control), str(address(word, period)))
    derivative = spline.derivative()(found.parameter)
    assert np.allclose(found.point, spline(found.parameter), atol=1e-10)
    for side in filter(None, (found.left, found.right)):
        assert (side.status, side.holds) == ("value", "all h")
        assert close(side.value, derivative, 1e-10)
        assert side.lengths[0] == side.lengths[1]
    assert found.passage in (None, "one derivative of order 1")


@pytest.mark.parametrize("where", ["0", "2", "1", "0 1 (0)*", "(0 2)*", "2 (1 0 0)*"])
@pytest.mark.parametrize("degree", [1, 3, 4])
def test_bezier_curves_have_their_ordinary_derivative(degree, where):
    control = np.array([[0.0, 0], [10, 30], [40, 5], [60, 20], [70, -30]])[: degree + 1]
    shape = given_curve(bezier(degree, ["1/5", "7/10"]), control)
    spline = BSpline(np.repeat([0.0, 1.0], degree + 1), control, degree)
    found = fld.derivatives(shape, where)
    for side in filter(None, (found.left, found.right)):
        assert (side.status, side.holds) == ("value", "all h")
        assert abs(side.local_order - 1) < 1e-12
        assert close(side.value, spline.derivative()(found.parameter), 1e-10)


def test_where_the_derivative_vanishes_order_two_answers():
    shape = given_curve(bezier(3, ["1/2"]), [[5, 5], [5, 5], [45, 35], [60, 0]])
    right = fld.derivatives(shape, "0").right
    assert abs(right.order - 2) < 1e-9
    assert right.holds == "all h"
    assert np.allclose(right.value, 6 * np.array([40, 30]), atol=1e-8)  # the second derivative
    assert fld.derivatives(shape, "0", order=1).right.status == "zero"


def test_koch_oscillates_between_two_directions_on_each_side():
    shape = ifs.shape("koch-curve")
    found = fld.derivatives(shape, "1 0")
    assert found.parameter == pytest.approx(0.25)
    for side in (found.left, found.right):
        assert side.status == "oscillating"
        assert side.value is None
        assert abs(side.local_order - KOCH) < 1e-12
        assert side.cone.angle == pytest.approx(30, abs=1e-9)
        assert 30 <= side.cone.outer < 30 + 1e-3
    # Seen from (30, 0): piece 0 lies behind, within 30 degrees of the axis; piece 1 rises at 60 degrees.
    angles = {
        which: sorted(np.degrees(np.arctan2(*side.cone.directions.T[::-1])) % 360)
        for which, side in (("left", found.left), ("right", found.right))
    }
    assert np.allclose(angles["left"], [150, 180], atol=1e-6)
    assert np.allclose(angles["right"], [60, 90], atol=1e-6)
    # At the start the end of the curve is 90 mm away, at the distance 1 in parameter.
    start = fld.derivatives(shape, "0").right
    assert np.allclose(start.ends, [[math.gamma(1 + KOCH) * 90, 0]], atol=1e-9)
    check = referee(shape, found)
    for tail, direction in ((["2"], [math.cos(math.pi / 6), 0.5]), (["1"], [1, 0]), (["3"], [1, 0])):
        chord = check.quotient(parse_address("0", curve(shape)), 40, tail, KOCH)
        assert np.allclose(chord / np.linalg.norm(chord), direction, atol=1e-12)
        assert start.lengths[0] <= np.linalg.norm(chord) <= start.lengths[1]


def test_below_the_order_zero_and_above_it_infinite():
    shape = ifs.shape("koch-curve")
    for where in ("0", "1", "2 (0 3)*", "(0 1 3)*"):
        for side, order, status in (
            ("right", 0.7, "zero"),
            ("right", 0.9, "infinite"),
            ("left", 0.9, "infinite"),
        ):
            found = getattr(fld.derivatives(shape, where, order), side)
            if found:
                assert (found.status, found.holds) == (status, "all h")
    check = Referee(shape, dict.fromkeys("0123", 0.25))
    where = parse_address("(0 1 3)*", curve(shape))
    sizes = [np.linalg.norm(check.quotient(where, k, ["3", "1"], 0.9)) for k in (5, 10)]
    # 15 letters further h is 4^-15 of what it was, and the quotient grows like h^(alpha - q).
    assert sizes[1] / sizes[0] == pytest.approx(4 ** (15 * (0.9 - KOCH)), rel=1e-9)


@pytest.mark.parametrize("w", ["11/20", "2/3", "4/5"])
def test_takagi_landsberg_has_a_vertical_derivative_along_the_ends_of_pieces(w):
    shape, number = landsberg(w), float(Fraction(w))
    right = fld.derivatives(shape, "0").right
    order = -math.log2(number)
    assert abs(right.order - order) < 1e-12
    assert (right.status, right.holds) == ("value", "ends of pieces")
    assert close(right.value, [0, math.gamma(1 + order) * 80 / (2 * number - 1)], 1e-9)
    # T(2^-k x) w^-k tends to T(x) + x / (2w - 1), for x in [1/2, 1]: the quotients of all h.
    x = np.linspace(0.5, 1, 2**12 + 1)
    heights = sum(number**n * np.abs(2**n * x - np.round(2**n * x)) for n in range(60))
    sizes = math.gamma(1 + order) * 80 * (heights + x / (2 * number - 1)) / x**order
    low, high = right.lengths
    assert low <= sizes.min() * (1 + 1e-12)
    assert high >= sizes.max() * (1 - 1e-12)
    assert low == pytest.approx(sizes.min(), rel=2e-3)
    assert high <= sizes.max() * 1.04
    check, start = Referee(shape, {"0": 0.5, "1": 0.5}), parse_address("0", curve(shape))
    vector = check.quotient(start, 180, ["1", "0", "1"], order)
    assert abs(vector[1] - sizes[2**10]) < 1e-6 * sizes[2**10]


def test_takagi_grows_with_the_logarithm():
    shape = ifs.shape("takagi-curve")
    right = fld.derivatives(shape, "0").right
    assert (right.status, right.holds, right.block) == ("infinite", "all h", 2)
    assert "log(1/h)" in right.words
    assert fld.derivatives(shape, "0", 0.9).right.status == "zero"


def test_an_interpolation_function_that_converges():
    # Figure 4.4: the eigenvalues 0.39 (vertical) and 0.36 at c_0; all pieces on one side of the eigenline.
    x, y = [0, "0.36", "0.6", "0.8", 1], [0, 3, 2, 4, 3]
    shape = affine_interpolation(x, y, ["0.39", "0.1", "0.1", "0.1"])
    found = fld.derivatives(shape, "0")
    right = found.right
    assert (right.status, right.holds) == ("value", "ends of pieces")
    # The other eigenvector is (1, m) with c + 0.39 m = 0.36 m, c = 3 - 0.39 * 3.
    m = -(3 - 0.39 * 3) / 0.03
    assert close(right.value, [0, math.gamma(1 + right.order) * (3 - m)], 1e-9)
    check = referee(shape, found)
    # The end of the curve is that of the piece 3 3 3 …; the part that is left falls like (0.36 / 0.39)^k.
    quotient = check.quotient(parse_address("0", curve(shape)), 420, [], right.order, "3")
    assert close(quotient, right.value, 1e-10)


def test_an_interpolation_function_that_oscillates():
    # Figure 4.5: the eigenvalues 0.31 and 0.23 at c_0; pieces on both sides of the eigenline.
    shape = affine_interpolation(
        [0, "0.23", "0.5", "0.75", 1], [0, 3, -25, 4, 3], ["0.31", "0.1", "0.1", "0.1"]
    )
    found = fld.derivatives(shape, "0")
    assert found.right.status == "oscillating"
    assert np.allclose(np.abs(found.right.cone.directions), [[0, 1], [0, 1]], atol=1e-9)
    assert found.right.lengths[0] == 0
    check, start = referee(shape, found), parse_address("0", curve(shape))
    signs = {np.sign(check.quotient(start, 150, [label], found.right.order)[1]) for label in "123"}
    assert signs == {1, -1}
    above = fld.derivatives(shape, "0", order=0.99 + found.right.order - 0.9).right
    assert above.status == "oscillating"


def test_an_interpolation_function_that_converges_on_one_side():
    # Figure 4.6: the eigenvalues 0.27 and 0.18 at c_1, which converges to the left and not to the right.
    x, y = [0, "0.3", "0.48", "0.7", 1], [0, 4, 6, -9, 8]
    shape = affine_interpolation(x, y, ["0.1", "0.27", "0.1", "0.1"])
    found = fld.derivatives(shape, "1")
    left, right = found.left, found.right
    assert left.local_order == pytest.approx(math.log(0.27) / math.log(found.parts["1"]), rel=1e-12)
    assert (left.status, left.holds) == ("value", "ends of pieces")
    assert right.status == "oscillating"
    assert found.passage is None
    check, where = referee(shape, found), parse_address("1", curve(shape))
    assert close(check.quotient(where, 130, [], left.order), left.value, 1e-9)


def test_a_negative_eigenvalue_swings():
    shape = affine_interpolation([0, "1/4", "1/2", "3/4", 1], [0, 3, 2, 4, 3], ["-2/5", "1/5", "1/5", "1/5"])
    found = fld.derivatives(shape, "0")
    assert found.right.status == "oscillating"
    assert np.allclose(found.right.ends[0], -found.right.ends[1], rtol=1e-9)
    check, where = referee(shape, found), parse_address("0", curve(shape))
    for k in (100, 101):
        quotient = check.quotient(where, k, [], found.right.order, "3")
        assert close(quotient, found.right.ends[k % 2], 1e-9)


inside = st.tuples(st.integers(1, 39), st.integers(1, 39)).filter(
    lambda n: n[0] + n[1] < 40 and 2 * n[0] + n[1] != 40 and n[0] + 2 * n[1] != 40
)


@few
@given(inside, planes, words, periods)
def test_quotients_in_many_digits_tend_to_the_closed_form(numerators, points, word, period):
    shape = corner_cutting(*(Fraction(n, 40) for n in numerators), np.array(points, float))
    where = address(word, period)
    found = fld.derivatives(shape, str(where))
    check, seen = referee(shape, found), []
    for side, label in ((found.left, "0"), (found.right, "1")):
        if side is None or side.ends is None:
            continue
        own = parse_address(side.address, curve(shape))
        # The convergence is that of the second eigenvalue against the first.
        tangent = getattr(fld.behaviour(shape, str(where)), side.side)
        values = np.abs(tangent.eigenvalues)
        steps = int(math.log(1e-9) / math.log(values[1] / values[0])) + 8
        if steps * len(own.repeat) <= 400 and own.repeat[0] != label:
            quotient = check.quotient(own, steps, [], side.order, label)
            assert close(quotient, side.ends[0], 1e-6)
            seen.append(side)
    assume(seen)


@few
@given(inside, planes, words, periods)
def test_what_happens_after_a_word_is_carried_by_it(numerators, points, word, period):
    # Equations 4.7 and 4.8: D H(w t) = L_w / r_w^q D H(t).
    shape = corner_cutting(*(Fraction(n, 40) for n in numerators), np.array(points, float))
    own = curve(shape)
    whole = fld.derivatives(shape, str(address(word, period)))
    piece = dataclasses.replace(shape, control=own.operator(tuple(word)).T @ shape.control)
    alone = fld.derivatives(piece, str(address([], period)))
    factor = np.prod([whole.parts[label] for label in word])
    for one, two in ((whole.left, alone.left), (whole.right, alone.right)):
        if two is not None and two.value is not None:
            assert one.status == two.status
            assert one.order == pytest.approx(two.order, abs=1e-9)
            # The normal form of an address may start its period at another letter.
            ends = one.ends * factor**one.order
            rolled = [np.roll(two.ends, k, axis=0) for k in range(len(ends))]
            assert any(np.allclose(ends, other, rtol=1e-6, atol=1e-9) for other in rolled)


affine_maps = st.lists(st.integers(-9, 9), min_size=4, max_size=4).filter(
    lambda m: abs(m[0] * m[3] - m[1] * m[2]) > 5
)


@few
@given(inside, planes, affine_maps, words, periods)
def test_affine_maps_carry_derivatives(numerators, points, entries, word, period):
    a, b = (Fraction(n, 40) for n in numerators)
    control, linear = np.array(points, float), np.array(entries, float).reshape(2, 2)
    where = str(address(word, period))
    before = fld.derivatives(corner_cutting(a, b, control), where)
    after = fld.derivatives(corner_cutting(a, b, control @ linear.T + [7, -9]), where)
    for one, two in ((before.left, after.left), (before.right, after.right)):
        if one is not None:
            assert one.status == two.status
            assert one.order == pytest.approx(two.order, abs=1e-9)
            if one.ends is not None:
                scale = np.linalg.norm(linear, 2) * np.linalg.norm(one.ends)
                assert np.linalg.norm(one.ends @ linear.T - two.ends) <= 1e-6 * scale


@few
@given(inside, planes, words, periods)
def test_reversal_exchanges_left_and_right_and_turns_derivatives_round(numerators, points, word, period):
    a, b = (Fraction(n, 40) for n in numerators)
    control = np.array(points, float)
    other = {"0": "1", "1": "0"}
    where = address(word, period)
    back = address([other[x] for x in where.word], [other[x] for x in where.repeat])
    one = fld.derivatives(corner_cutting(a, b, control), str(where))
    two = fld.derivatives(corner_cutting(b, a, control[::-1].copy()), str(back))
    assert one.parameter == pytest.approx(1 - two.parameter, abs=1e-12)
    for before, after in ((one.left, two.right), (one.right, two.left)):
        assert (before is None) == (after is None)
        if before is not None:
            assert before.status == after.status
            assert before.order == pytest.approx(after.order, abs=1e-9)
            if before.ends is not None:
                assert close(before.ends, -after.ends, 1e-6)


def test_going_twice_through_the_period_changes_nothing():
    shape = corner_cutting("1/5", "1/3")
    own = curve(shape)
    parts = fld.parametrisation(shape)
    side = local(own, parts, address(["1"], ["0", "1", "1"]), "right")
    once, twice = derivative(side), derivative(repeated(side, 2))
    assert once.status == twice.status == "value"
    assert np.allclose(once.value, twice.value, rtol=1e-9)
    assert np.allclose(np.vstack([once.ends, once.ends]), twice.ends, rtol=1e-9)
    assert np.allclose(once.lengths, twice.lengths, rtol=1e-3)


def test_both_sides_are_compared():
    assert fld.derivatives(corner_cutting("1/4", "1/4"), "0 1").passage == "one derivative of order 1"
    skewed = fld.derivatives(corner_cutting("1/5", "1/3"), "1 0").passage
    assert skewed.startswith("one direction, lengths in the ratio")
    assert fld.derivatives(landsberg("2/3"), "0 1").passage == "cusp"
    assert fld.derivatives(landsberg("1/3"), "0 1").passage.startswith("corner")


def test_long_periods_keep_their_digits():
    control = np.array([[0.0, 0], [30, 60], [60, 0]])
    period = [*"0110100110010110100101100110100110010110"]
    found = fld.derivatives(corner_cutting("1/4", "1/4", control), str(address(["1"], period)))
    spline = BSpline(np.arange(-2.0, 4), control, 2)
    for side in (found.left, found.right):
        assert close(side.value, spline.derivative()(found.parameter), 1e-9)


@pytest.mark.parametrize("order", [0, -1.0, math.nan, math.inf])
def test_orders_must_be_above_0(order):
    with pytest.raises(ValueError, match="above 0"):
        fld.derivatives(ifs.shape("koch-curve"), "0", order)


def test_answers_are_finite_data_and_words():
    shapes = [ifs.shape("koch-curve"), ifs.shape("takagi-curve"), landsberg("3/5")]
    shapes.append(affine_interpolation([0, "1/4", "1/2", 1], [0, 3, -9, 3], ["-1/4", "2/5", "-2/5"]))
    for shape, where, order in zip(
        shapes, ("1 0", "0 (1 0)*", "1 0", "0 (1 0 1)*"), (None, 1, 1.7, None), strict=True
    ):
        found = fld.derivatives(shape, where, order)
        json.dumps(found.as_data(), allow_nan=False)
        assert "nan" not in found.as_text()
        assert all(side.words for side in (found.left, found.right) if side)
