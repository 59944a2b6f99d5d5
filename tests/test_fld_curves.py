"""Smooth curves: orders, parametrisations and tangents against derivatives; symmetries of the answers."""

import dataclasses
import json
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BSpline

import automata
import fld
import ifs

few = settings(max_examples=6, deadline=None)


def corner_cutting(a, b, control=None):
    automaton = automata.read("corner-cutting")
    values = {"edge.0[1,0]": Fraction(a), "edge.0[0,1]": Fraction(b)}
    return ifs.shape(dataclasses.replace(automaton, values=values), control=control)


def given_curve(operators, control):
    """A curve whose ends are its first and last control points, from the rows of its operators."""
    labels = [str(k) for k in range(len(operators))]
    points = len(control)
    ends = {"left": [0], "right": [points - 1]}
    cell = {
        "points": points,
        "subdivision": dict.fromkeys(labels, "edge"),
        "boundary": {label: {"cell": "vertex", "points": chosen} for label, chosen in ends.items()},
        "incidence": ["left s = 0 left", f"right s = {labels[-1]} right"],
        "adjacency": [f"{k} right = {k + 1} left" for k in range(len(labels) - 1)],
        "matrices": {
            label: [[str(x) for x in row] for row in rows]
            for label, rows in zip(labels, operators, strict=True)
        },
    }
    cells = {"vertex": {"points": 1, "subdivision": {"s": "vertex"}}, "edge": cell}
    return ifs.shape(
        automata.describe({"format": "bcifs/1", "shape": "edge", "cells": cells}),
        control=np.array(control, dtype=float),
    )


def bezier(degree, cuts):
    """Operators that cut a Bezier curve at the given parameters: column j is the blossom at u^(d-j) v^j."""

    def blossom(arguments):
        row = [Fraction(1)]
        for t in arguments:
            row = [
                (row[k] * (1 - t) if k < len(row) else 0) + (row[k - 1] * t if k else 0)
                for k in range(len(row) + 1)
            ]
        return row

    marks = [Fraction(0), *map(Fraction, cuts), Fraction(1)]
    operators = []
    for u, v in pairwise(marks):
        columns = [blossom([u] * (degree - j) + [v] * j) for j in range(degree + 1)]
        operators.append([list(row) for row in zip(*columns, strict=True)])
    return operators


coordinates = st.integers(-50, 50)
planes = st.lists(st.tuples(coordinates, coordinates), min_size=3, max_size=3).filter(
    lambda p: np.linalg.det(np.column_stack([np.array(p, dtype=float), np.ones(3)])) ** 2 > 1
)


def unit(vector):
    return np.asarray(vector, float) / np.linalg.norm(vector)


def test_splines_have_order_one():
    assert abs(fld.critical_order(ifs.shape("corner-cutting")) - 1) < 1e-12
    cubic = given_curve(bezier(3, ["1/2"]), [[0, 0], [10, 30], [40, 5], [60, 20]])
    assert abs(fld.critical_order(cubic) - 1) < 1e-12
    for control in ([[0.0], [1], [2]], [[0.0, 0], [1, 2], [3, 6]], [[0.0], [0], [2]]):
        assert abs(fld.critical_order(corner_cutting("1/4", "1/4", np.array(control))) - 1) < 1e-12


def test_directions_outside_the_curve_do_not_count():
    # One control point more, which the curve forgets at the rate 9/10 > 1/3, 2/3.
    forgotten = [[Fraction(1, 10), 0, Fraction(9, 10), 0]]
    operators = []
    for rows in bezier(2, ["1/3"]):
        columns = [list(column) for column in zip(*rows, strict=True)]
        columns = [[first, middle, 0, last] for first, middle, last in columns]
        operators.append(list(zip(*columns[:2], *forgotten, columns[2], strict=True)))
    shape = given_curve(operators, [[0, 0], [10, 30], [99, 77], [40, 0]])
    assert np.allclose(list(fld.parametrisation(shape).values()), [1 / 3, 2 / 3], atol=1e-12)
    start, _ = fld.half_tangents(shape)
    assert np.allclose(start.direction, unit([10, 30]), atol=1e-9)
    assert start.size == pytest.approx(2 * np.hypot(10, 30), rel=1e-9)


def test_the_parametrisation_of_an_unevenly_cut_curve_is_where_it_was_cut():
    shape = given_curve(bezier(2, ["1/5", "7/10"]), [[0, 0], [20, 50], [60, 0]])
    assert np.allclose(list(fld.parametrisation(shape).values()), [0.2, 0.5, 0.3], atol=1e-12)
    found = fld.behaviour(shape, "(1)*")
    # The point 1^omega: t = 1/5 + t/2, so t = 2/5; C'(t) = 2 ((1-t)(P1-P0) + t(P2-P1)).
    derivative = 2 * (0.6 * np.array([20, 50]) + 0.4 * np.array([40, -50]))
    assert abs(found.parameter - 0.4) < 1e-12
    assert np.allclose(found.right.direction, unit(derivative), atol=1e-10)
    assert np.allclose(found.left.direction, -unit(derivative), atol=1e-10)
    # The size along the ends of the pieces is the length of the derivative, on both sides.
    assert np.allclose([found.left.size, found.right.size], np.linalg.norm(derivative), rtol=1e-9)
    assert found.joint == "smooth passage"


@pytest.mark.parametrize("address", ["0", "1", "1 0", "0 1", "0 1 (0)*", "1 1 0 1 0 0 1 (0)*", "0 0 0 (1)*"])
def test_quadratic_splines_have_the_tangents_of_their_derivative(address):
    control = np.array([[3.0, -2, 7], [30, 60, 1], [70, 10, -20]])
    spline = BSpline(np.arange(-2.0, 4), control, 2)
    found = fld.behaviour(corner_cutting("1/4", "1/4", control), address)
    derivative = spline.derivative()(found.parameter)
    assert np.allclose(found.point, spline(found.parameter), atol=1e-10)
    for side, sign in ((found.right, 1), (found.left, -1)):
        if side is not None:
            assert side.status == "half-tangent"
            assert np.allclose(side.direction, sign * unit(derivative), atol=1e-10)
            assert abs(side.size / np.linalg.norm(derivative) - 1) < 1e-9
            assert abs(side.order - 1) < 1e-9


def test_where_the_derivative_vanishes_the_order_is_two():
    # Control values 0, 0, 2 are the blossom of t^2: the point moves like h^2 at 0, like 2h at 1.
    start, end = fld.half_tangents(corner_cutting("1/4", "1/4", np.array([[0.0], [0], [2]])))
    assert abs(start.order - 2) < 1e-9
    assert abs(start.size - 1) < 1e-9
    assert start.direction.tolist() == [1.0]
    assert abs(end.order - 1) < 1e-9
    assert abs(end.size - 2) < 1e-9
    assert end.direction.tolist() == [-1.0]


def test_a_bezier_curve_with_a_double_end_leaves_towards_the_next_point():
    start, end = fld.half_tangents(given_curve(bezier(3, ["1/2"]), [[5, 5], [5, 5], [45, 35], [60, 0]]))
    assert np.allclose(start.direction, [0.8, 0.6], atol=1e-10)
    assert abs(start.order - 2) < 1e-9
    assert abs(start.size - 3 * 50) < 1e-6
    assert np.allclose(end.direction, unit([-15, 35]), atol=1e-10)
    assert abs(end.size - 3 * np.hypot(15, 35)) < 1e-6


def source_directions(a, b, control):
    """The eigenvectors of section 4.3.1, projected, for the dominant eigenvalue of each operator."""
    right = [1, -1, 0] if 1 - 2 * a - b > 0 else [-b, 1 - 2 * a, 2 * a + b - 1]
    left = [0, 1, -1] if 1 - a - 2 * b > 0 else [a + 2 * b - 1, 1 - 2 * b, -a]
    return unit(np.array(right, float) @ control), unit(np.array(left, float) @ control)


inside = st.tuples(st.integers(1, 39), st.integers(1, 39)).filter(
    lambda n: n[0] + n[1] < 40 and 2 * n[0] + n[1] != 40 and n[0] + 2 * n[1] != 40
)


@few
@given(inside, planes)
def test_corner_cutting_leaves_along_the_eigenvectors_of_the_source(numerators, points):
    a, b = (Fraction(n, 40) for n in numerators)
    control = np.array(points, float)
    shape = corner_cutting(a, b, control)
    for found, expected in zip(
        fld.half_tangents(shape), source_directions(float(a), float(b), control), strict=True
    ):
        assert found.status == "half-tangent"
        assert abs(abs(found.direction @ expected) - 1) < 1e-9
        # The eigenvalues: 1 - a - b and a at the start, 1 - a - b and b at the end.
        other = a if found.side == "right" else b
        largest = sorted([float(1 - a - b), float(other)], reverse=True)
        assert np.allclose(np.real(found.eigenvalues), largest, atol=1e-9)


@few
@given(inside)
def test_the_joint_of_corner_cutting_is_smooth_in_the_region_of_gregory_only(numerators):
    a, b = (Fraction(n, 40) for n in numerators)
    smooth = 2 * a + b < 1 and a + 2 * b < 1
    joint = fld.behaviour(corner_cutting(a, b), "1 0").joint
    assert (joint == "smooth passage") == smooth
    assert smooth or joint.startswith("corner")


@few
@given(st.integers(1, 9), st.integers(11, 19))
def test_corner_cutting_has_cusps_where_a_coefficient_is_negative(n, m):
    # Region 2: 1 - a - b dominates on both sides, and a < 0 < b with a + b > 0.
    a, b = Fraction(-n, 40), Fraction(m, 40)
    assert 1 - 2 * a - b > 0
    assert 1 - a - 2 * b > 0
    assert fld.behaviour(corner_cutting(a, b), "1 0").joint == "cusp"


def exact_chord(a, b, start, steps, control):
    """The chord from `start^omega` to a point `steps` repetitions away, in exact arithmetic."""
    operators = {
        "0": [[1 - a, b, 0], [a, 1 - b, 1 - a], [0, 0, a]],
        "1": [[b, 0, 0], [1 - b, 1 - a, b], [0, a, 1 - b]],
    }
    fixed = {
        "0": [b / (a + b), a / (a + b), Fraction(0)],
        "1": [Fraction(0), b / (a + b), a / (a + b)],
    }
    far = fixed["1" if start == "0" else "0"]
    difference = [p - q for p, q in zip(far, fixed[start], strict=True)]
    for _ in range(steps):
        difference = [sum(x * y for x, y in zip(row, difference, strict=True)) for row in operators[start]]
    size = max(abs(x) for x in difference)
    projected = [sum(x / size * int(p[k]) for x, p in zip(difference, control, strict=True)) for k in (0, 1)]
    return unit([float(x) for x in projected])


@few
@given(inside, planes)
def test_exact_chords_tend_to_the_half_tangents(numerators, points):
    a, b = (Fraction(n, 40) for n in numerators)
    start, end = fld.half_tangents(corner_cutting(a, b, np.array(points, float)))
    for found, label in ((start, "0"), (end, "1")):
        other = a if label == "0" else b
        rate = min(other, 1 - a - b) / max(other, 1 - a - b)
        steps = min(1200, int(np.log(1e-12) / np.log(float(rate))) + 1)
        tolerance = 1e-8 + 1e6 * float(rate) ** steps
        chord = exact_chord(a, b, label, steps, points)
        assert np.allclose(chord, found.direction, atol=tolerance)


affine_maps = st.lists(coordinates, min_size=4, max_size=4).filter(
    lambda m: abs(m[0] * m[3] - m[1] * m[2]) > 20
)


@few
@given(inside, planes, affine_maps, st.sampled_from(["0", "1", "1 0", "0 1 1 (0)*"]))
def test_affine_maps_of_the_control_points_carry_the_half_tangents(numerators, points, entries, address):
    a, b = (Fraction(n, 40) for n in numerators)
    control, linear = np.array(points, float), np.array(entries, float).reshape(2, 2)
    before = fld.behaviour(corner_cutting(a, b, control), address)
    after = fld.behaviour(corner_cutting(a, b, control @ linear.T + [7, -9]), address)
    assert before.critical_order == pytest.approx(after.critical_order, abs=1e-12)
    for one, two in ((before.left, after.left), (before.right, after.right)):
        assert (one is None) == (two is None)
        if one is not None:
            assert np.allclose(unit(linear @ one.direction), two.direction, atol=1e-6)
            assert np.linalg.norm(linear @ one.direction) * one.size == pytest.approx(two.size, rel=1e-6)


@few
@given(inside, planes)
def test_reversal_exchanges_left_and_right(numerators, points):
    a, b = (Fraction(n, 40) for n in numerators)
    control = np.array(points, float)
    start, end = fld.half_tangents(corner_cutting(a, b, control))
    last, first = fld.half_tangents(corner_cutting(b, a, control[::-1].copy()))
    for one, two in ((start, first), (end, last)):
        assert {one.side, two.side} == {"left", "right"}
        assert np.allclose(one.direction, two.direction, atol=1e-9)
        assert one.order == pytest.approx(two.order, abs=1e-12)
        assert one.size == pytest.approx(two.size, rel=1e-9)


@few
@given(inside, planes, st.lists(st.sampled_from("01"), max_size=6))
def test_a_piece_behaves_like_the_curve_of_its_own_control_points(numerators, points, word):
    # Equations 4.7 and 4.8: at w 0^omega the curve is that of the control points P T_w at 0^omega.
    a, b = (Fraction(n, 40) for n in numerators)
    control = np.array(points, float)
    shape = corner_cutting(a, b, control)
    state = shape.system.states["edge"]
    product = np.eye(3)
    for label in word:
        product = product @ state.operators[state.labels.index(label)]
    parts = fld.parametrisation(shape)
    whole = fld.behaviour(shape, " ".join([*word, "(0)*"])).right
    piece = fld.half_tangents(corner_cutting(a, b, product.T @ control))[0]
    shrunk = np.prod([parts[label] for label in word])
    assert np.allclose(whole.direction, piece.direction, atol=1e-6)
    assert whole.size * shrunk**whole.order == pytest.approx(piece.size, rel=1e-6)


def test_both_addresses_of_a_joint_tell_the_same():
    shape = corner_cutting("9/20", "2/5")
    one, two = fld.behaviour(shape, "0 1 (0)*"), fld.behaviour(shape, "0 0 1")
    assert np.allclose(one.point, two.point, atol=1e-12)
    assert one.parameter == pytest.approx(two.parameter, abs=1e-12)
    assert one.left.as_data() == two.left.as_data()
    assert one.right.as_data() == two.right.as_data()
    assert one.joint == two.joint


def test_the_answer_is_plain_data_and_text():
    found = fld.behaviour(ifs.shape("corner-cutting"), "1 0 0")
    data = json.loads(json.dumps(found.as_data(), allow_nan=False))
    assert data["address"] == "1 (0)*"
    assert np.allclose(data["point"], [30, 45])
    assert data["right"]["eigenvalues"][0] == pytest.approx([0.5, 0])
    assert "smooth passage" in found.as_text()


def test_a_piece_that_shrinks_to_nothing_is_named():
    half = Fraction(1, 2)
    operators = [[[1, half], [0, half]], [[half, half], [half, half]], [[half, 0], [half, 1]]]
    with pytest.raises(fld.Collapsed, match="'1'") as caught:
        fld.critical_order(given_curve(operators, [[0, 0], [9, 3]]))
    assert caught.value.label == "1"
    stuck = [[[1, 0], [0, 1]], [[0, 0], [1, 1]]]
    with pytest.raises(ifs.NotContracting, match="'0'"):
        fld.critical_order(given_curve(stuck, [[0, 0], [9, 3]]))
