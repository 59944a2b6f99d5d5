"""Inverse use and roughness maps, against closed forms and products of matrices."""

import itertools
import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import automata
import fld
import ifs
import subdivision
from fld.design import OutOfReach, fit_behaviour
from fld.roughness import TooManyPieces, roughness

A, B = "edge.0[1,0]", "edge.0[0,1]"


def cutting(a, b):
    return ifs.shape("corner-cutting", {A: a, B: b})


def moduli(a, b):
    """Of corner cutting: eigenvalues a and c of T_0, b and c of T_1."""
    c = 1 - a - b
    return max(abs(a), abs(c)), max(abs(b), abs(c))


def chord(shape, word, letter, far, count=60):
    """The unit chord to the end of the piece `word letter^count`, by floating matrix products."""
    operators = dict(
        zip(shape.system.states["edge"].labels, shape.system.states["edge"].operators, strict=True)
    )
    end = np.linalg.matrix_power(operators[far], 400)[:, 0]
    point = np.linalg.matrix_power(operators[letter], 400)[:, 0]
    step = end - point
    for label in (letter,) * count:
        step = operators[label] @ step
        step -= step.sum() * point
        step /= np.linalg.norm(step)
    for label in reversed(word):
        step = operators[label] @ step
    drawn = step @ shape.control
    return drawn / np.linalg.norm(drawn)


@pytest.mark.parametrize("order", [0.8, 1.2])
def test_corner_cutting_of_a_given_order(order):
    found = fit_behaviour("corner-cutting", order=order, starts=2)
    assert found.ok
    a, b = (float(found.values[name]) for name in "ab")
    assert sum(modulus ** (1 / order) for modulus in moduli(a, b)) == pytest.approx(1, abs=1e-12)
    assert fld.critical_order(cutting(*found.values.values())) == pytest.approx(order, abs=1e-12)


def test_the_order_of_a_member_leads_back_to_it_where_it_is_the_nearest():
    start = fit_behaviour("corner-cutting", order=1.0, starts=2)
    assert dict(start.values) == {"a": Fraction(1, 4), "b": Fraction(1, 4)}
    order = fld.critical_order(cutting("3/20", "2/5"))
    held = fit_behaviour("corner-cutting", order=order, fixed={B: "2/5"}, starts=2)
    assert float(held.values["a"]) == pytest.approx(0.15, abs=1e-9)


def test_koch_is_the_member_of_its_order_nearest_to_itself():
    order = math.log(3) / math.log(4)
    found = fit_behaviour("koch-curve", order=order, starts=1)
    assert found.asked[0].residual < 1e-12
    assert found.values["a"] == Fraction(2, 3)
    rougher = fit_behaviour(subdivision.solve(automata.read("koch-curve")), order=0.72, starts=1)
    assert fld.critical_order(rougher.shape) == pytest.approx(0.72, abs=1e-9)


def test_half_tangents_at_a_joint_are_those_asked_for():
    wanted = fld.behaviour(cutting("1/5", "1/2"), "1 0")
    assert wanted.left is not None
    assert wanted.right is not None
    left, right = (np.array(side.direction, float) for side in (wanted.left, wanted.right))
    left, right = 3 * left, 0.1 * right
    near = replace(automata.read("corner-cutting"), values={A: Fraction(22, 100), B: Fraction(47, 100)})
    found = fit_behaviour(near, left=left, right=right, at="1 0", starts=1)
    assert max(asked.residual for asked in found.asked) < 1e-9
    for which, direction in (("left", left), ("right", right)):
        word, letter, far = (("0",), "1", "0") if which == "left" else (("1",), "0", "1")
        unit = direction / np.linalg.norm(direction)
        assert chord(found.shape, word, letter, far) == pytest.approx(unit, abs=1e-8)


def test_order_and_direction_together():
    found = fit_behaviour("corner-cutting", order=1.1, right=(1, 2), at="0", starts=2)
    a, b = (float(found.values[name]) for name in "ab")
    assert sum(modulus ** (1 / 1.1) for modulus in moduli(a, b)) == pytest.approx(1, abs=1e-12)
    assert chord(found.shape, (), "0", "1") == pytest.approx(np.array([1, 2]) / 5**0.5, abs=1e-9)


def test_what_cannot_be_is_refused_with_the_nearest():
    with pytest.raises(OutOfReach, match="misses: critical order 3: found") as caught:
        fit_behaviour("corner-cutting", order=3.0, fixed={A: "1/4"}, starts=1)
    nearest = caught.value.nearest
    assert not nearest.ok
    assert set(nearest.values) == {"b"}
    assert nearest.asked[0].residual > 0.1
    with pytest.raises(OutOfReach, match="half-tangent"):
        fit_behaviour("corner-cutting", right=(1, 0), at="0", fixed={A: "1/4", B: "1/4"})


@pytest.mark.parametrize(
    ("wishes", "message"),
    [
        ({}, "nothing is asked"),
        ({"order": -1.0}, "above 0 and finite"),
        ({"order": math.nan}, "above 0 and finite"),
        ({"left": (1, 0)}, "give its address"),
        ({"left": (1, 0), "at": "0"}, "no left side"),
        ({"right": (1, 0), "at": "1"}, "no right side"),
        ({"right": (1, 0, 0), "at": "0"}, "expected 2 finite coordinates"),
        ({"right": (0, 0), "at": "0"}, "not all of them 0"),
        ({"right": (1, 0), "at": "7"}, "unknown label '7'"),
    ],
)
def test_wishes_without_sense_are_named(wishes, message):
    with pytest.raises(ValueError, match=message):
        fit_behaviour("corner-cutting", **wishes)


def test_progress_rises_to_the_end_and_can_stop_the_search():
    told = []
    with pytest.raises(OutOfReach):
        fit_behaviour("corner-cutting", order=3.0, fixed={A: "1/4"}, starts=1, report=told.append)
    assert told == sorted(told)
    assert (told[0], told[-1]) == (0.0, 1.0)
    assert len(told) >= 5  # by two methods, for all requests and then for the first one alone

    class Enough(Exception):
        pass

    def stop(done):
        raise Enough

    with pytest.raises(Enough):
        fit_behaviour("corner-cutting", order=3.0, report=stop)


def test_a_shape_that_is_no_curve():
    with pytest.raises(fld.NotACurve):
        fit_behaviour("sierpinski-triangle", order=1.0)


def test_roughness_is_the_local_order_at_the_fixed_points_of_the_pieces():
    shape = cutting("1/5", "1/2")
    for parametrisation in ("natural", "uniform", {"0": Fraction(3, 10), "1": Fraction(7, 10)}):
        found = roughness(shape, 3, parametrisation)
        for word, order in zip(itertools.product("01", repeat=3), found.orders, strict=True):
            expected = fld.orders(shape, f"({' '.join(word)})*", parametrisation)
            known = [side for side in (expected.left, expected.right) if side is not None]
            assert order == pytest.approx(min(known), abs=1e-9)


def test_roughness_of_koch_and_of_the_smooth_curve_is_one_number():
    assert roughness(ifs.shape("koch-curve"), 4).orders == pytest.approx(math.log(3) / math.log(4), abs=1e-12)
    assert roughness(ifs.shape("corner-cutting"), 6).orders == pytest.approx(1.0, abs=1e-9)
    assert roughness(ifs.shape("takagi-curve"), 6).orders == pytest.approx(1.0, abs=1e-6)


def test_detail_draws_more_and_says_the_same():
    plain, fine = (roughness(cutting("1/5", "1/2"), 3, detail=detail) for detail in (0, 4))
    assert (fine.orders == plain.orders.repeat(2**4)).all()
    assert np.allclose(fine.mesh.vertices[:: 2**4], plain.mesh.vertices)
    assert fine.mesh.faces.shape == (2**7, 2)


def test_roughness_of_a_patch_lies_where_its_pieces_lie():
    shape = ifs.shape("fractal-patch")
    state = shape.system.states["face"]
    found = roughness(shape, 2, detail=2)
    frame = np.linalg.qr(np.column_stack([np.ones(16), np.eye(16)[:, 1:]]))[0][:, 1:]
    middles = found.mesh.vertices[found.mesh.faces].mean(axis=1)
    for word in itertools.product(range(4), repeat=2):
        product = state.operators[word[0]] @ state.operators[word[1]]
        radius = np.abs(np.linalg.eigvals(frame.T @ product @ frame)).max()
        inside = product @ np.linalg.matrix_power(state.operators[0] @ state.operators[2], 30)[:, 0]
        nearest = np.linalg.norm(middles - inside @ shape.control, axis=1).argmin()
        assert found.orders[nearest] == pytest.approx(math.log(radius) / math.log(1 / 4), abs=1e-9)


def test_roughness_of_a_surface_of_patches():
    corners = [(x, y, z) for z in (0, 9) for y in (0, 9) for x in (0, 9)]
    sides = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    found = roughness(ifs.surface(corners, sides).complex(), 2)
    assert found.of == "corners"
    assert len(found.orders) == len(found.mesh.faces) == 6 * 4**2
    assert np.isfinite(found.orders).all()
    assert found.orders.max() <= 1 + 1e-9


def test_roughness_refuses_what_it_cannot_map():
    with pytest.raises(fld.NotACurve):
        roughness(ifs.shape("menger-sponge"))
    with pytest.raises(TooManyPieces, match="smaller depth"):
        roughness(ifs.shape("koch-curve"), 12)
    with pytest.raises(ValueError, match="depth is a whole number, 1 or more"):
        roughness(ifs.shape("koch-curve"), 0)
    with pytest.raises(ValueError, match="for curves"):
        roughness(ifs.shape("fractal-patch"), 2, "uniform")
