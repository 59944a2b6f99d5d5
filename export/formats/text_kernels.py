"""Tables of numbers as text: words in between, and numbers of up to six decimals.

Imported inside the functions that use it, for numba takes a while to load.
"""

from typing import no_type_check

import numba
import numpy as np

LONGEST = 21  # bytes that a number takes at most
ZERO, POINT, MINUS = np.uint8(48), np.uint8(46), np.uint8(45)
TEN, MILLION = np.uint64(10), np.uint64(1_000_000)


@no_type_check
@numba.njit(cache=True, inline="always")
def put_whole(out, at, value):
    """Write a uint64; the place after it."""
    digits = 1
    power = TEN
    while digits < 20 and value >= power:
        digits += 1
        power *= TEN
    for place in range(at + digits - 1, at - 1, -1):
        rest = value // TEN
        out[place] = ZERO + np.uint8(value - rest * TEN)
        value = rest
    return at + digits


@no_type_check
@numba.njit(cache=True, inline="always")
def put_millionths(out, at, value):
    """Write an int64 counted in millionths, without zeros at its end; the place after it."""
    if value < 0:
        out[at] = MINUS
        at += 1
        value = -value
    whole = np.uint64(value) // MILLION
    rest = np.uint64(value) - whole * MILLION
    at = put_whole(out, at, whole)
    if rest == 0:
        return at
    out[at] = POINT
    for place in range(at + 6, at, -1):
        tenth = rest // TEN
        out[place] = ZERO + np.uint8(rest - tenth * TEN)
        rest = tenth
    at += 7
    while out[at - 1] == ZERO:
        at -= 1
    return at


@no_type_check
@numba.njit(cache=True, nogil=True)
def rows(table, millionths, words, ends, out):
    """Write rows of int64, the j-th number after the j-th word, one word more at the end; the length.

    The j-th word is `words[ends[j]:ends[j + 1]]`.
    """
    at = 0
    for i in range(table.shape[0]):
        for j in range(table.shape[1] + 1):
            for k in range(ends[j], ends[j + 1]):
                out[at] = words[k]
                at += 1
            if j < table.shape[1]:
                if millionths:
                    at = put_millionths(out, at, table[i, j])
                else:
                    at = put_whole(out, at, np.uint64(table[i, j]))
    return at
