"""The infinite product watched letter by letter, against closed forms and splines."""

import json
import math
from itertools import cycle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BSpline
from test_fld_curves import corner_cutting
from test_fld_fractals import interpolation, landsberg

import fld
import ifs

KOCH = math.log(3) / math.log(4)


def thue_morse(place):
    return "01"[place.bit_count() % 2]


@settings(max_examples=5, deadline=None)
@given(st.integers(0, 10**6), st.sampled_from(["left", "right"]))
def test_splines_have_their_derivative_at_any_address(seed, side):
    rng = np.random.default_rng(seed)
    word = rng.choice(["0", "1"], 200).tolist()
    control = np.array([[3.0, -2, 7], [30, 60, 1], [70, 10, -20]])
    found = fld.watch(corner_cutting("1/4", "1/4", control), word, side=side)
    t = sum(int(label) * 0.5 ** (k + 1) for k, label in enumerate(word))
    spline = BSpline(np.arange(-2.0, 4), control, 2)
    assert found.status == "value"
    assert found.error < 1e-6
    assert np.allclose(found.value, spline.derivative()(t), rtol=1e-9, atol=1e-9)
    assert np.allclose(found.point, spline(t), atol=1e-9)
    assert found.local_order == pytest.approx(1, abs=1e-6)


def test_koch_is_zero_below_its_order_infinite_above_and_oscillates_at_it():
    shape = ifs.shape("koch-curve")
    word = np.random.default_rng(5).choice(list("0123"), 400).tolist()
    assert fld.watch(shape, word, 0.7).status == "zero"
    assert fld.watch(shape, word, 0.9).status == "infinite"
    at = fld.watch(shape, word)
    assert at.status == "oscillating"
    assert at.order == pytest.approx(KOCH, abs=1e-12)
    assert at.local_order == pytest.approx(KOCH, abs=1e-3)
    # At the start the joints lie in two directions, and at the end in two others.
    start, end = fld.watch(shape, cycle("0")), fld.watch(shape, cycle("3"), side="left")
    for found, angles in ((start, [0, 30]), (end, [-30, 0])):
        assert found.status == "oscillating"
        assert np.allclose(sorted(np.degrees(np.arctan2(*found.directions.T[::-1]))), angles, atol=1e-6)
        assert found.spread == pytest.approx(30, abs=1e-9)


def test_koch_spirals_on_its_slanted_pieces():
    found = fld.watch(ifs.shape("koch-curve"), cycle("1"))
    assert found.status == "spiralling"
    assert found.turn == pytest.approx(60, abs=0.1)


def test_closed_forms_and_the_product_agree():
    for shape in (landsberg("2/3"), corner_cutting("1/5", "1/3")):
        closed = fld.derivatives(shape, "0").right
        seen = fld.watch(shape, cycle("0"), closed.order, steps=1500)
        assert seen.status == "value"
        assert np.allclose(seen.value, closed.value, rtol=1e-6, atol=1e-6)
    rough = interpolation([0, 3, -20, 4, 3], ["2/5", "1/5", "1/5", "1/5"])
    closed = fld.derivatives(rough, "0").right
    seen = fld.watch(rough, cycle("0"), closed.order, steps=600)
    assert seen.status == closed.status == "oscillating"
    assert np.allclose(np.sort(seen.directions[:, 1]), [-1, 1])


def test_addresses_that_repeat_nothing():
    smooth, rough = landsberg("1/3"), landsberg("2/3")
    assert fld.watch(smooth, thue_morse).status == "value"
    seen = fld.watch(rough, thue_morse)
    assert seen.status == "oscillating"
    assert np.allclose(np.abs(seen.directions), [[0, 1]], atol=1e-9)
    assert seen.local_order == pytest.approx(-math.log2(2 / 3), abs=1e-2)


def test_too_few_letters_are_said():
    found = fld.watch(ifs.shape("koch-curve"), "0123012")
    assert found.status == "undecided"
    assert "7 letters" in found.words
    assert found.value is None
    slow = fld.watch(ifs.shape("takagi-curve"), cycle("0"))
    assert slow.status == "undecided"  # log(1/h) grows too slowly to be told from what oscillates
    for answer in (found, slow, fld.watch(ifs.shape("koch-curve"), cycle("0"))):
        json.dumps(answer.as_data(), allow_nan=False)


def test_wrong_input_is_named():
    shape = ifs.shape("koch-curve")
    with pytest.raises(ValueError, match="'7' at place 3"):
        fld.watch(shape, ["0", "1", "7"])
    with pytest.raises(ValueError, match="above 0"):
        fld.watch(shape, cycle("0"), 0.0)
    with pytest.raises(ValueError, match="'left' or 'right'"):
        fld.watch(shape, cycle("0"), side="up")
    with pytest.raises(ValueError, match="1 to 100000"):
        fld.watch(shape, cycle("0"), steps=0)
