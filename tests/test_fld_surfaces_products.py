"""Tensor products of curves: directional derivatives and quarter planes against closed forms and limits."""

import json
import math
from dataclasses import replace
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import NdBSpline

import fld
import ifs
import subdivision
from fld.error import NotACurve
from fld.surfaces import directional, product, product_point, quarters
from ifs.orbits.addresses import UnknownLabel
from subdivision.schemes import b_spline, bezier, corner_cutting, interpolation, koch, takagi

ADDRESSES = (("0", 0.0), ("1 0", 0.5), ("(0 1)*", 1 / 3), ("0 1 (1 0)*", 5 / 12), ("1", 1.0))


def random_control(m, n, seed=0):
    return np.random.default_rng(seed).uniform(-50, 50, (m, n, 3))


def bernstein(degree, t, order):
    """The values (order 0) or first derivatives of the Bernstein polynomials at t."""
    if order:
        lower = np.array([0.0, *bernstein(degree - 1, t, 0), 0.0])
        return degree * (lower[:-1] - lower[1:])
    return np.array([math.comb(degree, i) * t**i * (1 - t) ** (degree - i) for i in range(degree + 1)])


SPLINES = product(b_spline(3), b_spline(2), np.zeros((4, 3, 3)))
BEZIER = product(bezier(5), bezier(3), np.zeros((6, 4, 3)))


def way(vector):
    return vector / np.linalg.norm(vector)


@pytest.mark.parametrize(("u", "s"), ADDRESSES)
@pytest.mark.parametrize(("v", "t"), ADDRESSES[1:4])
def test_derivatives_of_b_spline_surfaces_are_those_of_scipy(u, s, v, t):
    control = random_control(4, 3)
    spline = NdBSpline((np.arange(-3.0, 5.0), np.arange(-2.0, 4.0)), control, (3, 2))
    at = product_point(replace(SPLINES, control=control), u, v)
    assert np.allclose(at.parameters, (s, t), atol=1e-12)
    assert np.allclose(at.point, spline([[s, t]])[0], atol=1e-10)
    du, dv = spline([[s, t]], nu=(1, 0))[0], spline([[s, t]], nu=(0, 1))[0]
    for step in ((1.0, 0.0), (0.0, -1.0), (0.5, -3.0), (-2.0, 0.25)):
        if (s == 0 and step[0] < 0) or (s == 1 and step[0] > 0):
            continue
        found = directional(at, step)
        assert found.status == "value"
        assert abs(found.order - 1) < 1e-12
        assert np.allclose(found.value, step[0] * du + step[1] * dv, atol=1e-10)


@pytest.mark.parametrize(("u", "s"), ADDRESSES[:4])
def test_derivatives_of_bezier_surfaces_are_the_closed_forms(u, s):
    control = random_control(6, 4, 1)
    at = product_point(replace(BEZIER, control=control), u, "1 0")
    du = np.einsum("i,ijd,j->d", bernstein(5, s, 1), control, bernstein(3, 0.5, 0))
    dv = np.einsum("i,ijd,j->d", bernstein(5, s, 0), control, bernstein(3, 0.5, 1))
    found = directional(at, (2.0, 3.0))
    assert found.status == "value"
    assert np.allclose(found.value, 2 * du + 3 * dv, atol=1e-10)


def test_orders_below_and_above_the_critical_one_give_zero_and_infinity():
    at = product_point(product(bezier(2), bezier(2), random_control(3, 3)), "1 0", "1 0")
    below, above = directional(at, (1.0, 1.0), 0.5), directional(at, (1.0, 1.0), 1.5)
    assert below.status == "zero"
    assert np.all(below.value == 0)
    assert above.status == "infinite"
    assert above.value is None
    assert np.allclose(above.direction, way(directional(at, (1.0, 1.0)).value), atol=1e-10)


@pytest.mark.parametrize("w", [Fraction(3, 4), Fraction(2, 3)])
def test_a_landsberg_curve_gives_its_exponent_to_one_direction(w):
    at = product_point(product(takagi(w), bezier(3)), "0", "1 0")
    exponent = -math.log2(w)
    along = directional(at, (1.0, 0.0))
    assert abs(along.critical - exponent) < 1e-12
    # T(2^-k) = 80 sum_{n<k} w^n 2^(n-k) is 80 (w^k - 2^-k) / (2w - 1), and h^a = w^k.
    k = 200
    quotient = 80 * float((w**k - Fraction(1, 2) ** k) / (2 * w - 1) / w**k)
    height = at.u["right"].drawn.vector[2]
    bump = product(takagi(w), bezier(3)).control[1, 0, 2]
    assert np.isclose(height, quotient * bump / 40, rtol=1e-10)
    assert along.status == "log-periodic"
    assert np.isclose(np.linalg.norm(along.value), math.gamma(1 + exponent) * height, rtol=1e-10)
    # The rougher direction alone counts as soon as it has a share.
    both = directional(at, (2.0, -5.0))
    assert abs(both.critical - exponent) < 1e-12
    assert np.allclose(both.value, 2**exponent * along.value, rtol=1e-10)
    assert directional(at, (2.0, -5.0), 1.0).status == "infinite"
    across = directional(at, (0.0, 1.0))
    assert across.status == "value"
    assert abs(across.critical - 1) < 1e-12


def test_takagis_own_curve_is_vertical_and_infinite_at_the_order_1():
    at = product_point(product(takagi(), bezier(3)), "1 0", "(0 1)*")
    found = directional(at, (1.0, 1.0))
    assert found.status == "infinite"
    assert at.u["right"].drawn.block == 2
    assert np.allclose(found.direction, (0, 0, 1), atol=1e-12)
    assert quarters(at).joint == "fold along v"


@pytest.mark.parametrize(("s", "t"), [(1, 1), (2, 3), (7, 0.5)])
def test_the_mixed_term_counts_where_both_curves_stand_still(s, t):
    corner = np.array([3.0, -1.0, 2.0])
    control = np.zeros((2, 2, 3))
    control[1, 1] = corner  # S(u, v) = u v corner
    at = product_point(product(bezier(1), bezier(1), control), "0", "0")
    found = directional(at, (s, t))
    assert found.status == "value"
    assert abs(found.critical - 2) < 1e-12
    assert np.allclose(found.value, math.gamma(3) * s * t * corner, rtol=1e-10)
    assert directional(at, (1.0, 0.0)).status == "zero"


def test_terms_may_cancel():
    control = np.zeros((2, 2, 3))
    control[1, 0], control[0, 1], control[1, 1] = (1, 0, 0), (-1, 0, 0), (0, 1, 0)
    at = product_point(product(bezier(1), bezier(1), control), "0", "0")
    found = directional(at, (1.0, 1.0))
    assert found.status == "zero"
    assert "cancel" in found.words


def cornered():
    """A surface like figure 4.7: two interpolation functions of three and two pieces."""
    one = interpolation([(0, 0), (30, 25), (60, 5), (90, 30)], [0.25, 0.125, 0.25])
    other = interpolation([(0, 0), (45, 30), (90, 10)], [0.25, 0.375])
    control = np.zeros((4, 3, 3))
    heights, others = (0, 25, 5, 30), (0, 30, 10)
    for i in range(4):
        for j in range(3):
            control[i, j] = 30 * i, 45 * j, heights[i] + others[j]
    return one, other, control


def exact(operators, labels, point):
    """`T_l1 T_l2 ... point` in fractions."""
    column = [Fraction(int(i == point % len(operators["0"]))) for i in range(len(operators["0"]))]
    for label in reversed(labels):
        column = [sum(a * x for a, x in zip(row, column, strict=True)) for row in operators[label]]
    return column


def limit_direction(operators, control, word, repeat, far, steps=120):
    """The direction of the chord from the point `word repeat^omega` to `word repeat^steps far`."""
    labels = (word, *[repeat] * steps)
    ends = exact(operators, labels, far), exact(operators, labels, 0 if far else -1)
    chord = [
        sum((a - b) * Fraction(x) for a, b, x in zip(*ends, column, strict=True)) for column in control.T
    ]
    with mpmath.workdps(50):
        found = [mpmath.mpf(x.numerator) / x.denominator for x in chord]
        size = mpmath.sqrt(sum(x * x for x in found))
        return np.array([float(x / size) for x in found])


def test_two_cornered_curves_have_four_quarter_planes():
    one, other, control = cornered()
    at = product_point(product(one, other, control), "1 0", "1 0")
    found = quarters(at)
    assert found.joint == "corner"
    assert len(found.quarters) == 4
    sections = control[:, 1], control[1]  # the joints are control points
    one, other = (subdivision.solve(automaton).numbers()["edge"] for automaton in (one, other))
    tangents = {
        ("u", "right"): limit_direction(one, sections[0], "1", "0", -1),
        ("u", "left"): limit_direction(one, sections[0], "0", "2", 0),
        ("v", "right"): limit_direction(other, sections[1], "1", "0", -1),
        ("v", "left"): limit_direction(other, sections[1], "0", "1", 0),
    }
    normals = []
    for quarter in found.quarters:
        a, b = tangents["u", quarter.sides[0]], tangents["v", quarter.sides[1]]
        assert quarter.status == "plane"
        assert np.allclose(quarter.tangents, (a, b), atol=1e-10)
        normal = way(np.cross(a, b)) * (1 if quarter.sides[0] == quarter.sides[1] else -1)
        assert np.allclose(quarter.normal, normal, atol=1e-10)
        normals.append(normal)
    angles = [
        math.degrees(math.acos(one @ other))
        for one, other in zip(normals, [*normals[1:], normals[0]], strict=True)
    ]
    assert np.allclose(found.angles, angles, atol=1e-5)
    assert min(found.angles) > 1


def test_chords_of_a_quarter_lie_between_its_half_tangents():
    one, other, control = cornered()
    at = product_point(product(one, other, control), "1 0", "1 0")
    quarter = quarters(at).quarters[0]
    one, other = (subdivision.solve(automaton).numbers()["edge"] for automaton in (one, other))
    joint = exact(one, "1", 0), exact(other, "1", 0)
    for k, m in ((60, 95), (60, 98), (40, 64)):  # 3^-k and 2^-m are of one size
        far = exact(one, ("1", *["0"] * k), -1), exact(other, ("1", *["0"] * m), -1)
        places = [
            (i, j, far[0][i] * far[1][j] - joint[0][i] * joint[1][j]) for i in range(4) for j in range(3)
        ]
        chord = np.array(
            [float(sum(weight * Fraction(control[i, j, x]) for i, j, weight in places)) for x in range(3)]
        )
        a, b = np.linalg.lstsq(np.array(quarter.tangents).T, chord, rcond=None)[0]
        assert a > 0
        assert b > 0
        assert abs(way(chord) @ quarter.normal) < 1e-4


def test_smooth_cornered_and_folded_joints():
    smooth, spline = corner_cutting(Fraction(1, 4), Fraction(1, 4)), b_spline(3)
    corner = interpolation([(0, 0), (45, 30), (90, 10)], [0.25, 0.375])

    def joint(one, other, m, n):
        return quarters(product_point(product(one, other, random_control(m, n, 3)), "1 0", "1 0")).joint

    assert joint(smooth, spline, 3, 4) == "smooth"
    assert joint(corner, spline, 3, 4) == "crease along v"
    assert joint(spline, corner, 4, 3) == "crease along u"
    assert joint(corner, corner, 3, 3) == "corner"


def test_a_curve_that_turns_in_one_plane_leaves_one_plane():
    corner = interpolation([(0, 0), (45, 30), (90, 10)], [0.25, 0.375])
    control = random_control(3, 3, 4)
    control[:, :, 2] = 0.0
    found = quarters(product_point(product(corner, corner, control), "1 0", "1 0"))
    assert {round(abs(quarter.normal[2]), 12) for quarter in found.quarters} == {1.0}


def test_at_the_end_of_a_curve_there_are_two_quarters_and_at_a_corner_one():
    patch = product(bezier(2), bezier(2), random_control(3, 3))
    assert [q.sides for q in quarters(product_point(patch, "0", "1 0")).quarters] == [
        ("right", "right"),
        ("right", "left"),
    ]
    assert quarters(product_point(patch, "0", "1 0")).joint == "smooth"
    assert len(quarters(product_point(patch, "1", "1")).quarters) == 1
    with pytest.raises(ValueError, match="ends here: it has nothing on the left side of u"):
        directional(product_point(patch, "0", "1 0"), (-1.0, 0.0))


def test_koch_gives_words_and_no_plane():
    at = product_point(product(koch(), bezier(2)), "1 0", "1 0")
    found = quarters(at)
    assert found.joint is None
    assert all(
        quarter.status == "none" and "eigenvalue 0.333333" in quarter.words for quarter in found.quarters
    )
    along = directional(at, (1.0, 0.0))
    assert along.status == "several directions"
    assert abs(along.critical - math.log(3) / math.log(4)) < 1e-12
    assert directional(at, (1.0, 0.0), 1.0).status == "infinite"
    assert directional(at, (0.0, 1.0)).status == "value"


def test_negative_and_complex_eigenvalues_are_named():
    # The first operator of an interpolation function has the eigenvalues 1 / N and its scale.
    flipping = interpolation([(0, 0), (45, 30), (90, 10)], [-0.625, 0.25])
    negative = product_point(product(flipping, bezier(2), random_control(3, 3)), "0", "1 0")
    assert negative.u["right"].drawn.status == "unoriented"
    assert "opposite (eigenvalue -0.625)" in negative.u["right"].drawn.words
    assert directional(negative, (1.0, 0.0)).status == "unoriented"
    spiral = product_point(product(koch(), bezier(2)), "(1)*", "1 0")
    assert spiral.u["right"].drawn.status == "spiral"
    assert "turning by 60 degrees" in spiral.u["right"].drawn.words


fractions = st.integers(3, 30).map(lambda k: Fraction(k, 64))


@settings(max_examples=4, deadline=None)
@given(fractions, fractions, st.sampled_from(["0", "1 0", "0 1 1 (0)*", "1 0 (1)*"]), st.integers(0, 99))
def test_sections_leave_as_curves_do(a, b, address, seed):
    control = random_control(3, 3, seed)
    automaton = corner_cutting(a, b)
    at = product_point(product(automaton, bezier(2), control), address, "1 0")
    section = np.einsum("ijd,j->id", control, bernstein(2, 0.5, 0))
    reference = fld.behaviour(ifs.shape(automaton, control=section), address)
    for side, expected in (("left", reference.left), ("right", reference.right)):
        found = at.u[side]
        assert (found is None) == (expected is None)
        if found is not None:
            assert found.drawn.status == expected.status
            if expected.direction is not None:
                assert np.allclose(found.drawn.direction, expected.direction, atol=1e-7)
                assert abs(found.drawn.order - expected.order) < 1e-9
            if expected.size is not None:
                assert np.isclose(found.drawn.size, expected.size, rtol=1e-7)


PAIR = corner_cutting(Fraction(1, 3), Fraction(1, 5)), b_spline(3)
SURFACES = product(*PAIR, np.zeros((3, 4, 3))), product(*PAIR[::-1], np.zeros((4, 3, 3)))


@settings(max_examples=4, deadline=None)
@given(st.integers(0, 999))
def test_affine_maps_carry_derivatives_and_exchange_keeps_them(seed):
    rng = np.random.default_rng(seed)
    control, linear, shift = rng.normal(size=(3, 4, 3)), rng.normal(size=(3, 3)), rng.normal(size=3)
    one, other = SURFACES
    at = product_point(replace(one, control=control), "1 0", "(0 1)*")
    moved = product_point(replace(one, control=control @ linear.T + shift), "1 0", "(0 1)*")
    turned = product_point(replace(other, control=control.transpose(1, 0, 2)), "(0 1)*", "1 0")
    found = directional(at, (1.0, -2.0))
    assert np.allclose(directional(moved, (1.0, -2.0)).value, linear @ found.value, atol=1e-8)
    assert np.allclose(directional(turned, (-2.0, 1.0)).value, found.value, atol=1e-8)


def test_reversal_exchanges_left_and_right():
    control = random_control(4, 3, 8)
    at = product_point(product(bezier(3), bezier(2), control), "0 1 (0 1)*", "1 0")
    back = product_point(product(bezier(3), bezier(2), control[::-1]), "1 0 (1 0)*", "1 0")
    assert np.allclose(at.point, back.point, atol=1e-10)
    found, other = directional(at, (1.0, 0.5)), directional(back, (-1.0, 0.5))
    assert np.allclose(found.value, other.value, atol=1e-10)


def test_parts_of_the_parameter_are_the_users():
    control = random_control(3, 3)
    half = product_point(product(bezier(2), bezier(2), control), "0", "0")
    uneven = product_point(product(bezier(2), bezier(2), control, ([0.25, 0.75], None)), "0", "0")
    assert abs(half.u["right"].drawn.order - 1) < 1e-12
    assert abs(uneven.u["right"].drawn.order - 0.5) < 1e-12
    assert np.allclose(half.u["right"].drawn.direction, uneven.u["right"].drawn.direction, atol=1e-12)


def test_answers_become_json():
    one, other, control = cornered()
    at = product_point(product(one, other, control), "1 0", "1 0")
    text = json.dumps([directional(at, (1, 1)).as_data(), *(q.as_data() for q in quarters(at).quarters)])
    assert "NaN" not in text
    assert quarters(at).words.count("\n") == 4


def test_wrong_input_is_named():
    with pytest.raises(ValueError, match="expected 3 by 4 control points"):
        product(bezier(2), bezier(3), np.zeros((3, 3, 3)))
    with pytest.raises(ValueError, match=r"\[1, 2\] is not finite"):
        product(bezier(2), bezier(2), np.where(np.arange(9).reshape(3, 3, 1) == 5, np.nan, 1.0))
    with pytest.raises(ValueError, match="positive and of sum 1"):
        product(bezier(2), bezier(2), np.zeros((3, 3, 3)), ([0.5, 0.6], None))
    with pytest.raises(NotACurve):
        product("sierpinski-triangle", bezier(2))
    patch = product(bezier(2), bezier(2), random_control(3, 3))
    with pytest.raises(UnknownLabel):
        product_point(patch, "2", "0")
    at = product_point(patch, "1 0", "1 0")
    for step in ((0.0, 0.0), (math.nan, 1.0)):
        with pytest.raises(ValueError, match="two finite components"):
            directional(at, step)
    with pytest.raises(ValueError, match="more than 0"):
        directional(at, (1.0, 0.0), -1.0)
    flat = product(bezier(1), bezier(1), np.arange(8.0).reshape(2, 2, 2))
    with pytest.raises(ValueError, match="2 dimensions"):
        quarters(product_point(flat, "0", "0"))
