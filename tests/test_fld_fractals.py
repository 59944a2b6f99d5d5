"""Rough curves: known exponents, points where nothing converges, and shapes that are no curves."""

import dataclasses
import json
import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import automata
import fld
import ifs
from fld.order import solved_order
from fld.spectrum import dominant


def interpolation(heights, factors):
    """A fractal interpolation function: `(x, y) -> (x/N + k/N, c x + d y + f)` through the given heights.

    Control points are the first and the last data point, and the one that is 1 mm above the first.
    """
    count = len(factors)
    data = [(Fraction(k, count), Fraction(y)) for k, y in enumerate(heights)]
    (x0, y0), (xn, yn) = data[0], data[-1]
    operators = []
    for (xa, ya), (xb, yb), d in zip(data[:-1], data[1:], map(Fraction, factors), strict=True):
        # Images of the ends and of the point above the first: first + s (last - first) + u (above - first).
        images = [(xa, ya), (xa, ya + d), (xb, yb)]
        columns = []
        for x, y in images:
            s = (x - x0) / (xn - x0)
            u = y - y0 - s * (yn - y0)
            columns.append([1 - s - u, u, s])
        operators.append([[str(entry) for entry in row] for row in zip(*columns, strict=True)])
    labels = [str(k) for k in range(count)]
    edge = {
        "points": 3,
        "subdivision": dict.fromkeys(labels, "edge"),
        "boundary": {
            "left": {"cell": "vertex", "points": [0]},
            "right": {"cell": "vertex", "points": [2]},
        },
        "incidence": ["left s = 0 left", f"right s = {labels[-1]} right"],
        "adjacency": [f"{k} right = {k + 1} left" for k in range(count - 1)],
        "matrices": dict(zip(labels, operators, strict=True)),
    }
    cells = {"vertex": {"points": 1, "subdivision": {"s": "vertex"}}, "edge": edge}
    control = np.array([[x0, y0], [x0, y0 + 1], [xn, yn]], dtype=float)
    return ifs.shape(
        automata.describe({"format": "bcifs/1", "shape": "edge", "cells": cells}), control=control
    )


def landsberg(w):
    """The Takagi-Landsberg curve `80 sum w^n s(2^n x)`, s the distance to the nearest integer."""
    w = Fraction(w)
    values = {"edge.0[0,1]": (1 - w) / 2, "edge.0[1,1]": w + Fraction(1, 2)}
    automaton = automata.read("takagi-curve")
    return ifs.shape(dataclasses.replace(automaton, values={**automaton.values, **values}))


def test_koch_has_order_log_3_over_log_4():
    shape = ifs.shape("koch-curve")
    assert abs(fld.critical_order(shape) - math.log(3) / math.log(4)) < 1e-12
    assert np.allclose(list(fld.parametrisation(shape).values()), 0.25, atol=1e-12)


def test_koch_has_no_half_tangents_at_its_ends():
    start, end = fld.half_tangents(ifs.shape("koch-curve"))
    for found in (start, end):
        assert found.status == "several directions"
        assert found.direction is None
        assert np.allclose(found.eigenvalues, 1 / 3)
        assert abs(found.order - math.log(3) / math.log(4)) < 1e-12


def test_koch_spirals_by_60_degrees_at_the_fixed_points_of_its_slanted_pieces():
    for address in ("1", "2"):
        found = fld.behaviour(ifs.shape("koch-curve"), address)
        for side in (found.left, found.right):
            assert side.status == "spiral"
            assert np.allclose(np.abs(side.eigenvalues), 1 / 3)
            assert np.allclose(np.abs(np.angle(side.eigenvalues, deg=True)), 60)
            assert "60 degrees" in side.words


def test_the_shadow_of_koch_on_a_line_leaves_its_ends_in_one_direction():
    shape = ifs.shape("koch-curve", control=np.array([[0.0], [45], [90]]))
    start, end = fld.half_tangents(shape)
    assert (start.status, start.direction.tolist()) == ("half-tangent", [1.0])
    assert (end.status, end.direction.tolist()) == ("half-tangent", [-1.0])
    assert abs(fld.critical_order(shape) - math.log(3) / math.log(4)) < 1e-12
    assert fld.behaviour(shape, "1").right.status == "oscillates"


@pytest.mark.parametrize("w", ["1/10", "1/3", "9/20"])
def test_takagi_landsberg_below_one_half_has_the_slope_of_its_series(w):
    # At 0 the sum of slopes is sum (2w)^n = 1 / (1 - 2w).
    shape = landsberg(w)
    start, _ = fld.half_tangents(shape)
    slope = 1 / (1 - 2 * float(Fraction(w)))
    assert abs(fld.critical_order(shape) - 1) < 1e-12
    assert abs(start.direction[1] / start.direction[0] - slope) < 1e-9 * slope
    assert start.size == pytest.approx(80 * math.hypot(1, slope), rel=1e-9)


def test_takagi_landsberg_with_one_quarter_is_a_parabola():
    # sum (1/4)^n s(2^n x) = 2 x (1 - x): the ordinary derivative at x = 3/8 is 2 - 4x = 1/2.
    found = fld.behaviour(landsberg("1/4"), "0 1 1 (0)*")
    assert found.parameter == pytest.approx(3 / 8, abs=1e-12)
    assert np.allclose(found.point, [30, 80 * 2 * 3 / 8 * 5 / 8])
    assert np.allclose(found.right.direction, np.array([1, 0.5]) / math.hypot(1, 0.5), atol=1e-9)
    assert found.joint == "smooth passage"


@pytest.mark.parametrize("w", ["11/20", "2/3", "4/5"])
def test_takagi_landsberg_above_one_half_has_exponent_minus_log2_w(w):
    shape = landsberg(w)
    start, end = fld.half_tangents(shape)
    assert abs(fld.critical_order(shape) + math.log2(Fraction(w))) < 1e-12
    assert np.allclose([start.direction, end.direction], [[0, 1], [0, 1]], atol=1e-9)
    # At t = 2^-k: sum_(n<k) w^n 2^(n-k) = (w^k - 2^-k) / (2w - 1), so the limit of T / w^k is 1 / (2w - 1).
    assert start.size == pytest.approx(80 / (2 * float(Fraction(w)) - 1), rel=1e-9)


def test_takagi_leaves_vertically_like_h_log_h():
    # T(2^-k) = k 2^-k exactly: the slope of the chord is k, its direction is vertical in the limit.
    shape = ifs.shape("takagi-curve")
    start, end = fld.half_tangents(shape)
    for found in (start, end):
        assert found.status == "half-tangent"
        assert found.block == 2
        assert found.size is None
        assert np.allclose(found.direction, [0, 1], atol=1e-9)
        assert abs(found.order - 1) < 1e-12
    operators = shape.system.states["edge"].operators
    point = np.array([0.0, 0, 1])
    for k in range(1, 12):
        point = operators[0] @ point
        x, y = point @ shape.control
        assert abs(y / x - k) < 1e-9
    assert fld.behaviour(shape, "1 0").joint == "cusp"


def test_an_interpolation_function_on_one_side_of_its_eigenline_converges():
    # As in figure 4.4: the vertical eigenvalue 2/5 of the first map exceeds 1/4, all heights are positive.
    start, _ = fld.half_tangents(interpolation([0, 3, 2, 4, 3], ["2/5", "1/5", "1/5", "1/5"]))
    assert start.status == "half-tangent"
    assert np.allclose(start.direction, [0, 1], atol=1e-9)
    assert np.allclose(np.real(start.eigenvalues), [0.4, 0.25])


def test_an_interpolation_function_on_both_sides_of_its_eigenline_oscillates():
    # As in figure 4.5. In the first map c = 3 - 2/5 * 3 = 9/5 so that the component along the vertical is
    # y + c / (2/5 - 1/4) x = y + 12 x; it is 12/4 + 3 > 0 at the second point and 12/2 - 20 < 0 at the third.
    start, _ = fld.half_tangents(interpolation([0, 3, -20, 4, 3], ["2/5", "1/5", "1/5", "1/5"]))
    assert start.status == "oscillates"
    assert np.allclose(np.abs(start.direction), [0, 1], atol=1e-9)
    assert "both sides" in start.words


def graph(heights, factors, levels):
    """Points of the graph of an interpolation function on the grid of that many levels."""
    y = np.array(heights, dtype=float)
    for _ in range(levels):
        x = np.linspace(0, 1, len(y))
        pieces = []
        for k, d in enumerate(factors):
            c = heights[k + 1] - heights[k] - d * (heights[-1] - heights[0])
            pieces.append(c * x + d * y + heights[k] - d * heights[0])
        y = np.concatenate([piece[:-1] for piece in pieces] + [pieces[-1][-1:]])
    return np.linspace(0, 1, len(y)), y


@settings(max_examples=6, deadline=None)
@given(
    st.lists(st.integers(-9, 9), min_size=5, max_size=5).filter(lambda y: np.diff(y, 2).any()),
    st.sampled_from([0.3, 0.4, 0.5]),
)
def test_each_side_of_an_inner_point_converges_or_oscillates_by_itself(heights, d):
    # As in figure 4.6, at 1^omega: x = 1/3, seen along the vertical of the second map.
    factors = [0.2, d, -0.2, 0.2]
    x, y = graph(heights, factors, 4)
    c = heights[2] - heights[1] - d * (heights[4] - heights[0])
    here = (heights[1] - d * heights[0] + c / 3) / (1 - d)  # y = c x + d y + f with f = y_1 - d y_0
    component = y - here + c / (d - 1 / 4) * (x - 1 / 3)
    shape = interpolation(heights, [str(factor) for factor in factors])
    found = fld.behaviour(shape, "1")
    assert np.allclose(found.point, [1 / 3, here])
    for side, part in ((found.left, component[x <= 1 / 4]), (found.right, component[x >= 1 / 2])):
        low, high = part.min(), part.max()
        margin = 0.1 * np.abs(component).max()  # what lies between the points of the grid
        if low < -1e-9 * margin and high > 1e-9 * margin:
            assert side.status == "oscillates"
        elif low > margin or high < -margin:
            assert side.status == "half-tangent"
            assert np.allclose(side.direction, [0, np.sign(low)], atol=1e-9)


def test_what_control_points_hide_for_good_does_not_count():
    # The rough coordinate of w = 4/5 is hidden: what is left is the segment x = 80 t.
    shape = ifs.shape(landsberg("4/5").automaton, control=np.array([[0.0, 0], [40, 0], [80, 0]]))
    assert abs(fld.critical_order(shape) - 1) < 1e-12
    start, _ = fld.half_tangents(shape)
    assert np.allclose(start.direction, [1, 0])
    assert start.size == pytest.approx(80)


def test_a_negative_eigenvalue_gives_a_line_without_orientation():
    start, _ = fld.half_tangents(interpolation([0, 3, 2, 4, 3], ["-2/5", "1/5", "1/5", "1/5"]))
    assert start.status == "unoriented"
    assert np.allclose(np.abs(start.direction), [0, 1], atol=1e-9)
    assert np.allclose(np.real(start.eigenvalues), [-0.4, 0.25])


def test_eigenvalues_of_equal_modulus_and_opposite_sign_oscillate():
    start, _ = fld.half_tangents(interpolation([0, 3, 2, 4, 3], ["-1/4", "1/5", "1/5", "1/5"]))
    assert start.status == "oscillates"
    assert start.direction is None


def test_every_answer_is_finite_data():
    shapes = [ifs.shape("koch-curve"), ifs.shape("takagi-curve")]
    shapes.append(interpolation([0, 3, -20, 4, 3], ["-1/4", "2/5", "-2/5", "1/5"]))
    for shape in shapes:
        for address in ("0", "1", "1 0", "0 1", "0 0 1 (0)*"):
            found = fld.behaviour(shape, address)
            json.dumps(found.as_data(), allow_nan=False)
            assert "nan" not in found.as_text()


def test_long_addresses_keep_their_digits():
    found = fld.behaviour(ifs.shape("corner-cutting"), "0 1 " * 80 + "(0)*")
    # C'(t) of the spline at t = 1/3: the direction varies linearly from P1 - P0 to P2 - P1.
    assert np.allclose(found.right.direction, np.array([30, 20]) / math.hypot(30, 20), atol=1e-9)
    assert found.right.size == pytest.approx(math.hypot(30, 20), rel=1e-6)


@settings(max_examples=60)
@given(st.lists(st.floats(0.001, 0.999), min_size=2, max_size=9))
def test_the_order_solves_its_equation(moduli):
    order = solved_order(moduli)
    assert abs(math.fsum(modulus ** (1 / order) for modulus in moduli) - 1) < 1e-12


@pytest.mark.parametrize("size", [1, 2, 3])
def test_the_dominant_part_of_jordan_blocks_is_found_in_any_basis(size):
    rng = np.random.default_rng(size)
    blocks = np.zeros((4, 4))
    blocks[:size, :size] = 0.6 * np.eye(size) + np.eye(size, k=1)
    blocks[size:, size:] = 0.2 * np.diag(np.arange(4 - size))
    basis = rng.normal(size=(4, 4))
    found = dominant(basis @ blocks @ np.linalg.inv(basis))
    assert found.block == size
    assert found.ranks == (1,)
    assert abs(found.values[0] - 0.6) < 1e-9
    expected = np.zeros((4, 4))
    expected[0, size - 1] = 1
    assert np.allclose(found.leading[0], basis @ expected @ np.linalg.inv(basis), atol=1e-6)


@pytest.mark.parametrize("name", ["sierpinski-triangle", "menger-sponge", "catmull-clark-patch"])
def test_shapes_that_are_no_curves_are_refused(name):
    with pytest.raises(fld.NotACurve, match="boundary"):
        fld.critical_order(ifs.shape(name))


def test_reversed_pieces_are_refused():
    text = """
format = "bcifs/1"
shape = "edge"
[cells.vertex]
points = 1
subdivision = { s = "vertex" }
[cells.edge]
points = 2
subdivision = { 0 = "edge", 1 = "edge" }
boundary = { left = { cell = "vertex", points = [0] }, right = { cell = "vertex", points = [1] } }
incidence = ["left s = 0 left", "right s = 1 left"]
adjacency = ["0 right = 1 right"]
matrices = { 0 = [[1, "1/2"], [0, "1/2"]], 1 = [[0, "1/2"], [1, "1/2"]] }
[control]
points = [[0, 0], [1, 0]]
"""
    with pytest.raises(fld.NotACurve, match="walking"):
        fld.critical_order(ifs.shape(automata.parse_text(text)))


def test_points_and_pieces_without_size_are_refused():
    with pytest.raises(fld.Collapsed, match="single point") as caught:
        fld.critical_order(ifs.shape("koch-curve", control=np.full((3, 2), 1 / 3)))
    assert caught.value.label is None
    flat = interpolation([0, 0, 0], ["1/3", "1/3"])
    assert fld.critical_order(flat) == pytest.approx(1)  # a straight segment, whatever its vertical factors


@pytest.mark.parametrize(
    ("address", "words"),
    [("7", "unknown label '7'.*0, 1, 2, 3"), ("", "repeat one label"), ("0 (1 9)*", "unknown label '9'")],
)
def test_addresses_that_cannot_be_read_name_the_labels(address, words):
    with pytest.raises(ValueError, match=words):
        fld.behaviour(ifs.shape("koch-curve"), address)


def test_addresses_have_a_largest_length():
    with pytest.raises(ValueError, match="at most 200"):
        fld.behaviour(ifs.shape("koch-curve"), "1 " * 200 + "(0)*")
