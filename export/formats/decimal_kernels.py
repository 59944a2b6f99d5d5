"""Decimal numbers in text, read to the nearest double.

Imported inside the functions that use it, for numba takes a while to load.

A number w 10^q with an integer w below 2^64 is w times a power of five, up to a power of two. The product
of w with the first 128 bits of that power gives the first bits of the number; the rest is below one unit of
the last of these (D. Lemire, Number Parsing at a Gigabyte per Second, 2021, section 5). Where that leaves
open how to round, and it hardly ever does, the answer is nan and the caller asks Python.
"""

from fractions import Fraction
from typing import no_type_check

import numba
import numpy as np

FARTHEST = 64
MOST_DIGITS = 19
LOW = np.uint64(0xFFFFFFFF)
HALF, ONE = np.uint64(32), np.uint64(1)
REST = np.uint64((1 << 10) - 1)  # the bits behind the 53 and the one that rounds
MIDDLE = np.uint64(1 << 10)
NEARLY = np.uint64(2**64 - 8)
EXACT = np.array([10.0**k for k in range(23)])


def _five(q: int) -> tuple[int, int, int]:
    """The first 128 bits of 5^q, cut off, in two words, and the exponent of two of the first."""
    power = Fraction(5) ** q
    top = power.numerator.bit_length() - power.denominator.bit_length()
    top -= power < Fraction(2) ** top
    bits = int(power * Fraction(2) ** (127 - top))
    return bits >> 64, bits & (2**64 - 1), top


_ROWS = [_five(q) for q in range(-FARTHEST, FARTHEST + 1)]
HIGHS = np.array([row[0] for row in _ROWS], dtype=np.uint64)
LOWS = np.array([row[1] for row in _ROWS], dtype=np.uint64)
TOPS = np.array([row[2] for row in _ROWS], dtype=np.int64)


@no_type_check
@numba.njit(cache=True, inline="always")
def times(a, b):
    """The two words of a product."""
    a1, a0, b1, b0 = a >> HALF, a & LOW, b >> HALF, b & LOW
    low, first, other = a0 * b0, a1 * b0, a0 * b1
    middle = (low >> HALF) + (first & LOW) + (other & LOW)
    return a1 * b1 + (first >> HALF) + (other >> HALF) + (middle >> HALF), (middle << HALF) | (low & LOW)


@no_type_check
@numba.njit(cache=True)
def nearest(whole, exponent):
    """The double nearest to `whole` (uint64) times a power of ten; nan where this does not decide it."""
    if whole == 0:
        return 0.0
    if whole <= np.uint64(1 << 53) and -22 <= exponent <= 22:
        return whole * EXACT[exponent] if exponent >= 0 else whole / EXACT[-exponent]
    if exponent < -FARTHEST or exponent > FARTHEST:
        return np.nan
    shift = 0
    while whole >> np.uint64(63) == 0:
        whole <<= ONE
        shift += 1
    row = exponent + FARTHEST
    high, low = times(whole, HIGHS[row])
    more, _ = times(whole, LOWS[row])
    low += more
    if low < more:
        high += ONE
    # the number lies between high:low and two units of low above it, four when they are doubled
    top = TOPS[row] + exponent + 64 - shift
    if high >> np.uint64(63) == 0:
        high = (high << ONE) | (low >> np.uint64(63))
        low <<= ONE
        top -= 1
    rest = high & REST
    kept = high >> np.uint64(11)
    if high & MIDDLE:
        if rest == 0 and low == 0:
            return np.nan
        kept += ONE
    elif rest == REST and low >= NEARLY:
        return np.nan
    return np.ldexp(np.float64(kept), top - 52)


@no_type_check
@numba.njit(cache=True)
def real(text, at):
    """The number that begins at a place of text (uint8) and the place after it; nan where there is none.

    Digits with or without sign, point and exponent are read. Also nan: what `nearest` does not decide, from
    the first 19 digits that count.
    """
    size = len(text)
    minus = at < size and text[at] == 45
    if at < size and (text[at] == 45 or text[at] == 43):
        at += 1
    whole, digits, seen, exponent, point, cut = np.uint64(0), 0, False, 0, False, False
    while at < size:
        letter = text[at]
        if 48 <= letter <= 57:
            seen = True
            if digits < MOST_DIGITS:
                whole = whole * np.uint64(10) + np.uint64(letter - 48)
                digits += whole > 0
                exponent -= point
            else:
                cut |= letter != 48
                exponent += not point
        elif letter == 46 and not point:
            point = True
        else:
            break
        at += 1
    if seen and at < size and (text[at] == 101 or text[at] == 69):
        at += 1
        sign = 1
        if at < size and (text[at] == 45 or text[at] == 43):
            sign = -1 if text[at] == 45 else 1
            at += 1
        seen, power = False, 0
        while at < size and 48 <= text[at] <= 57:
            seen = True
            power = min(power * 10 + text[at] - 48, 100_000)
            at += 1
        exponent += sign * power
    value = nearest(whole, exponent) if seen else np.nan
    if cut and nearest(whole + ONE, exponent) != value:
        value = np.nan
    return -value if minus else value, at
