"""Wrong input at the doors of the engine, and attractors that are single points."""

from fractions import Fraction

import numpy as np
import pytest

import bcifs
import ifs
import subdivision
from automata import parse_text
from subdivision.schemes.catmull_clark import Coefficients

CUBE = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
CORNERS = 10.0 * np.array([(i & 1, i >> 1 & 1, i >> 2) for i in range(8)])


@pytest.mark.parametrize("shift", ["[1, 1]", "[1, 0]", "[0, 0]"])
def test_an_attractor_of_one_point_is_bounded_at_once(shift):
    one = parse_text(f'format = "bcifs/1"\nname = "one"\n[[maps]]\nscale = "1/3"\ntranslation = {shift}\n')
    low, high = ifs.bounding_box(ifs.shape(one))
    fixed = 1.5 * np.array([float(x) for x in shift[1:-1].split(",")])  # x = x / 3 + shift
    assert np.abs(low - fixed).max() < 1e-9
    assert np.abs(high - fixed).max() < 1e-9


@pytest.mark.parametrize("value", [0.25, "1/4", Fraction(1, 4)])
def test_values_may_be_any_number(value):
    found = bcifs.shape("corner-cutting", {"edge.0[1,0]": value})
    assert found.system.states["edge"].operators[0][1, 0] == 0.25


@pytest.mark.parametrize("value", ["a quarter", float("nan"), "1/0"])
def test_other_values_are_named(value):
    with pytest.raises(subdivision.WrongValue, match=r"edge.0\[1,0\] = .*expected a finite number"):
        bcifs.shape("corner-cutting", {"edge.0[1,0]": value})


def test_coefficients_without_a_surface_are_refused():
    with pytest.raises(ifs.NotContracting):
        ifs.smooth(CORNERS, CUBE, 2, regions=[ifs.Region([0], Coefficients(end=Fraction(50)))])


@pytest.mark.parametrize("depth", [-1, 65])
def test_depths_are_whole_numbers(depth):
    with pytest.raises(ValueError, match="the depth is a whole number"):
        ifs.smooth(CORNERS, CUBE, depth)
