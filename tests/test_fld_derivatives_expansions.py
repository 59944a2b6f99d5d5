"""Terms of higher order, Hölder exponents and parametrisations, against Taylor series and known exponents."""

import json
import math
from fractions import Fraction

import numpy as np
import pytest
from scipy.interpolate import BSpline
from test_fld_curves import bezier, corner_cutting, given_curve
from test_fld_fractals import landsberg

import fld
import ifs
from fld.curve import curve
from fld.monomials import frame, monomials

CONTROL = np.array([[0.0, 0], [10, 30], [40, 5], [60, 20], [70, -30]])


@pytest.mark.parametrize("where", ["0", "2", "1", "0 1 (0)*", "(0 2)*", "1 (0 1 2)*"])
def test_bezier_curves_have_their_taylor_coefficients(where):
    degree = 4
    shape = given_curve(bezier(degree, ["1/5", "7/10"]), CONTROL)
    spline = BSpline(np.repeat([0.0, 1.0], degree + 1), CONTROL, degree)
    place = fld.orders(shape, where).parameter
    for found, sign in zip(fld.expansions(shape, where), (-1, 1), strict=True):
        if found is None:
            continue
        assert [round(term.order, 8) for term in found.terms] == [1, 2, 3, 4]
        for m, term in enumerate(found.terms, 1):
            assert term.exact
            wanted = sign**m * spline.derivative(m)(place)
            assert np.linalg.norm(term.derivative - wanted) <= 1e-9 * np.linalg.norm(wanted)
        one, two = spline.derivative(1)(place), spline.derivative(2)(place)
        curvature = abs(one[0] * two[1] - one[1] * two[0]) / np.linalg.norm(one) ** 3
        assert 2 * found.bend.size == pytest.approx(curvature, rel=1e-9)
        assert found.bend.exponent == pytest.approx(2, abs=1e-9)
        assert found.bend.exact


def test_the_sum_of_the_terms_is_the_curve_at_the_ends_of_pieces():
    # Corner cutting with other coefficients: terms of orders that are not whole, at h = h_0 r^k.
    shape = corner_cutting("1/5", "1/3")
    own, parts = curve(shape), fld.parametrisation(shape)
    _, right = fld.expansions(shape, "1 0")
    operator, one = own.operator(("0",)), own.operator(("1",))
    point, far = np.array([1 / 3, 1 / 5, 0]) / (8 / 15), np.array([0, 1 / 3, 1 / 5]) / (8 / 15)
    for k in range(5):
        chord = one @ np.linalg.matrix_power(operator, k) @ (far - point) @ shape.control
        h = parts["1"] * parts["0"] ** k
        total = sum(term.vector * h**term.order for term in right.terms)
        assert np.allclose(total, chord, atol=1e-9)
        assert not any(term.exact for term in right.terms)


def test_the_takagi_curve_has_a_logarithm():
    # T(2^-k) = k 2^-k, so T(h) = h log(1/h) / log 2 at h = 2^-k; 80 mm a unit.
    _, right = fld.expansions(ifs.shape("takagi-curve"), "0")
    assert [(round(term.order, 9), term.power) for term in right.terms] == [(1.0, 1)]
    assert np.allclose(right.terms[0].vector, [0, 80 / math.log(2)], atol=1e-6)
    assert right.bend is None


def test_a_spiral_is_the_real_part_of_a_complex_term():
    shape = ifs.shape("koch-curve")
    own = curve(shape)
    _, right = fld.expansions(shape, "1")
    (term,) = right.terms
    operator = own.operator(("1",))
    point = np.linalg.matrix_power(operator, 60) @ np.full(3, 1 / 3)
    far = np.linalg.matrix_power(own.operator(("3",)), 60) @ np.full(3, 1 / 3)
    turn = np.angle(term.eigenvalue)
    for k in range(6):
        chord = np.linalg.matrix_power(operator, k) @ (far - point) @ shape.control
        h = (1 - 1 / 3) * 0.25**k
        assert np.allclose(np.real(term.vector * np.exp(1j * k * turn)) * h**term.order, chord, atol=1e-8)


def test_powers_of_the_parameter_are_coordinates_of_polynomial_curves():
    shape = given_curve(bezier(4, ["1/5", "7/10"]), CONTROL)
    own, parts = curve(shape), {"0": 0.2, "1": 0.5, "2": 0.3}
    rows = monomials(own, parts, 9)
    assert len(rows) == 5
    places = {"0": 0.0, "1": 0.2, "2": 0.7}
    point, t = frame(own)[:, 0], 0.0
    for label in "0212010211":
        point, t = own.operator((label,)) @ point, places[label] + parts[label] * t
        # The row on the frame, at the coordinates of the point.
        local = np.concatenate([[1.0], frame(own)[:, 1:].T @ (point - frame(own)[:, 0])])
        assert np.allclose(rows @ local, t ** np.arange(5), atol=1e-10)
    assert len(monomials(own, dict.fromkeys("012", 1 / 3), 4)) == 1
    assert len(monomials(curve(ifs.shape("koch-curve")), dict.fromkeys("0123", 0.25), 2)) == 1


@pytest.mark.parametrize("where", ["0 1", "(0 1)*", "0 (1 1 0)*", "1 (0 0 1 1)*"])
def test_takagi_landsberg_curves_have_their_known_exponents(where):
    # Above 1/2 it is -log2 w everywhere; below, the curve has a slope where t is no dyadic number, and beyond
    # it -log2 w again; a corner at dyadic ones. With 1/4 it is a parabola.
    assert fld.orders(landsberg("2/3"), where).holder == pytest.approx(-math.log2(2 / 3), abs=1e-9)
    rough = fld.orders(landsberg("1/3"), where)
    assert rough.holder == pytest.approx(1 if where == "0 1" else math.log2(3), abs=1e-9)
    assert fld.orders(landsberg("1/4"), where).holder == math.inf
    json.dumps(fld.orders(landsberg("1/4"), where).as_data(), allow_nan=False)


def test_local_orders_under_any_parametrisation():
    koch = ifs.shape("koch-curve")
    parts = {"0": 0.4, "1": 0.3, "2": 0.2, "3": 0.1}
    log = {label: math.log(part) for label, part in parts.items()}
    for period in ("0", "12", "013", "2233"):
        found = fld.orders(koch, f"1 ({' '.join(period)})*", parts)
        order = len(period) * math.log(1 / 3) / sum(log[label] for label in period)
        for side in (found.left, found.right):
            if side is not None and period != "0":
                assert side == pytest.approx(order, rel=1e-9)
    # A joint has two addresses: piece 1 starts with 0's, piece 0 ends with 3's.
    joint = fld.orders(koch, "1 0", parts)
    assert joint.left == pytest.approx(math.log(1 / 3) / log["3"])
    assert joint.right == pytest.approx(math.log(1 / 3) / log["0"])
    assert joint.holder == min(joint.left, joint.right)
    assert joint.parameter == pytest.approx(0.4)
    assert fld.orders(koch, "1 0", "uniform").right == pytest.approx(math.log(3) / math.log(4))


def test_a_smooth_curve_in_a_poor_parametrisation_is_not_smooth():
    shape = given_curve(bezier(2, ["1/3"]), [[0, 0], [10, 30], [40, 0]])
    assert fld.orders(shape, "0").holder == math.inf
    assert fld.orders(shape, "0", "uniform").holder == pytest.approx(math.log(3) / math.log(2))
    right = fld.derivatives(shape, "0", 1, "uniform").right
    assert right.status == "zero"
    exact = fld.derivatives(shape, "0", None, {"0": Fraction(1, 3), "1": Fraction(2, 3)}).right
    assert exact.holds == "all h"
    assert np.allclose(exact.value, [20, 60], atol=1e-9)


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ("arc length", "'natural', 'uniform'"),
        ({"0": 1.0}, "wrong: 1, 2, 3"),
        ({"0": 0.5, "1": 0.5, "2": 0.5, "3": -0.5}, "'3' must lie between 0 and 1"),
        (dict.fromkeys("0123", 0.3), "sum to 1.2"),
    ],
)
def test_parts_that_are_no_parametrisation_are_named(parts, words):
    with pytest.raises(fld.WrongParts, match=words):
        fld.orders(ifs.shape("koch-curve"), "0", parts)
