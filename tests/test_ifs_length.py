"""Lengths of curves against closed forms."""

import math

import numpy as np
import pytest

import ifs
from ifs.measures.chains import NoChain
from ifs.measures.length import length
from subdivision.schemes import bezier, menger_wall, takagi


def test_a_parabola_has_the_length_of_its_integral():
    # y = 2 x (1 - x) over [0, 1], slope from 2 to -2: (sqrt 5 / 2 + asinh(2) / 4) of the width.
    curve = ifs.shape(bezier(2), control=np.array([[0.0, 0], [40, 80], [80, 0]]))
    found = length(curve)
    assert found.value == pytest.approx(80 * (math.sqrt(5) / 2 + math.asinh(2) / 4), rel=1e-9)
    assert not found.exact
    assert np.all(np.diff(found.polygons) > 0)


def test_self_similar_curves_are_infinitely_long_and_grow_by_the_sum_of_their_ratios():
    for curve, growth in ((ifs.shape("koch-curve"), 4 / 3), (ifs.shape(menger_wall()), 5 / 3)):
        found = length(curve, 4)
        assert found.value == math.inf
        assert found.exact
        assert found.growth == pytest.approx(growth, rel=1e-12)
        np.testing.assert_allclose(found.polygons, found.polygons[0] * growth ** np.arange(5), rtol=1e-12)


def test_a_straight_curve_is_as_long_as_its_chord():
    found = length(ifs.shape(bezier(1), control=np.array([[0.0, 0], [30, 40]])), 3)
    assert (found.value, found.exact) == (pytest.approx(50), True)


def test_takagis_curve_settles_on_nothing():
    assert length(ifs.shape(takagi())).value is None


def test_what_is_no_curve_is_refused():
    with pytest.raises(NoChain):
        length(ifs.shape("menger-sponge"))
    with pytest.raises(ValueError, match="3 or more"):
        length(ifs.shape("koch-curve"), 2)
