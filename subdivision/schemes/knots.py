"""States of non-uniform B-splines: which knot intervals a piece or a joint of the curve depends on.

A piece of degree d is a *window*: its own interval in the middle and d - 1 intervals on each side, up to a
common factor, as whole numbers. A joint is a knot between pieces; a knot of multiplicity m (with m - 1
intervals of length 0 beside it) depends on `d + 1 - m` control points and on d - m intervals on each side,
and for m >= d on nothing but the one point that the curve goes through.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import gcd, lcm

from subdivision.schemes.building import Amount, exact

Window = tuple[int, ...]


@dataclass(frozen=True)
class Joint:
    """A knot: the intervals before and after it, nearest ones in the middle, and its number of points."""

    before: tuple[int, ...]
    after: tuple[int, ...]
    points: int

    @property
    def name(self) -> str:
        """`u|v` or `p:u|v:w`, and `corner` for a knot that depends on one point."""
        return f"{text(self.before)}|{text(self.after)}" if self.before else "corner"


def text(intervals: Sequence[int]) -> str:
    return ":".join(map(str, intervals))


def exact_intervals(intervals: Sequence[Amount]) -> tuple[Fraction, ...]:
    """Knot intervals as fractions. Raises `ValueError` for one that is negative or not finite."""
    found = tuple(exact(interval, f"interval {i}") for i, interval in enumerate(intervals))
    for i, interval in enumerate(found):
        if interval < 0:
            raise ValueError(f"knot intervals are 0 or more, interval {i} is {intervals[i]}")
    return found


def ratios(intervals: Sequence[Fraction | int]) -> Window:
    """The same ratios in the smallest whole numbers.

    >>> ratios([Fraction(1, 2), Fraction(3, 4)])
    (2, 3)
    """
    whole = lcm(*(Fraction(interval).denominator for interval in intervals))
    numbers = [int(interval * whole) for interval in intervals]
    common = gcd(*numbers) or 1
    return tuple(number // common for number in numbers)


def halves(window: Window) -> tuple[Window, Window]:
    """The windows of the two halves of a piece, once every interval is replaced by two of half its length.

    >>> halves((1, 2, 4))
    ((1, 2, 2), (1, 1, 2))
    """
    doubled = [interval for interval in window for _ in (0, 1)]
    start = len(window) // 2
    left, right = (doubled[start + half :][: len(window)] for half in (0, 1))
    return ratios(left), ratios(right)


def joints(window: Window) -> tuple[Joint, Joint]:
    """The knots at the two ends of a piece.

    >>> [joint.name for joint in joints((1, 2, 4))], [joint.name for joint in joints((3, 0, 2, 0, 0))]
    (['1|2', '1|2'], ['3|2', 'corner'])
    """
    left = _joint(window)
    right = _joint(window[::-1])
    return left, Joint(right.after[::-1], right.before[::-1], right.points)


def _joint(window: Window) -> Joint:
    side = len(window) // 2
    before = window[:side]
    while before and before[-1] == 0:
        before = before[:-1]
    kept = len(before)
    found = ratios((*before, *window[side : side + kept])) if kept else ()
    return Joint(found[:kept], found[kept:], kept + 1)
