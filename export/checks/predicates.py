"""Exact signs of determinants of points, in floating point.

A determinant is first worked out in double precision with Shewchuk's error bound; only where that
cannot tell its sign is it summed up exactly, as an expansion of doubles that do not overlap
(J. R. Shewchuk, Adaptive Precision Floating-Point Arithmetic, 1997: bounds A of section 4, and
Grow-Expansion). The signs are exact for coordinates of at most 1 in size whose last bits lie
above 2^-302, for then nothing overflows or underflows.

Imported inside the functions that use it, for numba takes a while to load.
"""

from typing import no_type_check

import numba
import numpy as np

ROOM = 256  # doubles of working memory that `turn` and `side` ask for
EPSILON = 2.0**-53
BOUND_2D = (3 + 16 * EPSILON) * EPSILON
BOUND_3D = (7 + 56 * EPSILON) * EPSILON
SPLITTER = 2.0**27 + 1


@no_type_check
@numba.njit(cache=True)
def turn(ax, ay, bx, by, cx, cy, room):
    """The sign of the doubled area of the triangle a, b, c in the plane: 1 when it turns left."""
    left = (ax - cx) * (by - cy)
    right = (ay - cy) * (bx - cx)
    area = left - right
    bound = BOUND_2D * (abs(left) + abs(right))
    if area > bound:
        return 1
    if -area > bound:
        return -1
    if bound == 0.0:
        return 0
    return _exact_turn(ax, ay, bx, by, cx, cy, room)


@no_type_check
@numba.njit(cache=True)
def side(a, b, c, d, room):
    """The sign of det(a - d, b - d, c - d): 1 when d lies below the triangle a, b, c.

    Below means that a, b, c turn right when seen from d.
    """
    adx, ady, adz = a[0] - d[0], a[1] - d[1], a[2] - d[2]
    bdx, bdy, bdz = b[0] - d[0], b[1] - d[1], b[2] - d[2]
    cdx, cdy, cdz = c[0] - d[0], c[1] - d[1], c[2] - d[2]
    bc, cb = bdx * cdy, cdx * bdy
    ca, ac = cdx * ady, adx * cdy
    ab, ba = adx * bdy, bdx * ady
    volume = adz * (bc - cb) + bdz * (ca - ac) + cdz * (ab - ba)
    bound = BOUND_3D * (
        (abs(bc) + abs(cb)) * abs(adz) + (abs(ca) + abs(ac)) * abs(bdz) + (abs(ab) + abs(ba)) * abs(cdz)
    )
    if volume > bound:
        return 1
    if -volume > bound:
        return -1
    if bound == 0.0:
        return 0
    return _exact_side(a, b, c, d, room)


@no_type_check
@numba.njit(cache=True)
def _exact_turn(ax, ay, bx, by, cx, cy, room):
    n = 0
    for x, y, sign in (
        (_difference(ax, cx), _difference(by, cy), 1.0),
        (_difference(ay, cy), _difference(bx, cx), -1.0),
    ):
        for i in range(2):
            for j in range(2):
                if x[i] != 0.0 and y[j] != 0.0:
                    high, low = _product(x[i], y[j])
                    n = _grow(room, n, sign * low)
                    n = _grow(room, n, sign * high)
    return _sign(room, n)


@no_type_check
@numba.njit(cache=True)
def _exact_side(a, b, c, d, room):
    n = 0
    for p, q, r, sign in (
        (a, b, c, 1.0), (b, c, a, 1.0), (c, a, b, 1.0), (b, a, c, -1.0), (c, b, a, -1.0), (a, c, b, -1.0),
    ):  # fmt: skip
        x, y, z = _difference(p[0], d[0]), _difference(q[1], d[1]), _difference(r[2], d[2])
        for i in range(2):
            for j in range(2):
                if x[i] == 0.0 or y[j] == 0.0:
                    continue
                high, low = _product(x[i], y[j])
                for k in range(2):
                    if z[k] == 0.0:
                        continue
                    for part in (low, high):
                        if part != 0.0:
                            first, second = _product(part, z[k])
                            n = _grow(room, n, sign * second)
                            n = _grow(room, n, sign * first)
    return _sign(room, n)


@no_type_check
@numba.njit(cache=True)
def _difference(a, b):
    """a - b as a rounded value and what is missing."""
    x = a - b
    virtual = a - x
    around = x + virtual
    return x, (a - around) + (virtual - b)


@no_type_check
@numba.njit(cache=True)
def _product(a, b):
    """a b as a rounded value and what is missing."""
    x = a * b
    big = SPLITTER * a
    a_high = big - (big - a)
    a_low = a - a_high
    big = SPLITTER * b
    b_high = big - (big - b)
    b_low = b - b_high
    return x, a_low * b_low - (((x - a_high * b_high) - a_low * b_high) - a_high * b_low)


@no_type_check
@numba.njit(cache=True)
def _grow(room, n, value):
    """Add a value to an expansion of n doubles that rise in size and do not overlap."""
    if value == 0.0:
        return n
    kept, total = 0, value
    for i in range(n):
        x = total + room[i]
        virtual = x - total
        rest = (total - (x - virtual)) + (room[i] - virtual)
        total = x
        if rest != 0.0:
            room[kept] = rest
            kept += 1
    if total != 0.0:
        room[kept] = total
        kept += 1
    return kept


@no_type_check
@numba.njit(cache=True)
def _sign(room, n):
    if n == 0:
        return 0
    return 1 if room[n - 1] > 0.0 else -1


@no_type_check
@numba.njit(cache=True)
def turns(a, b, c):
    """`turn` of each row `(n, 2)`."""
    room = np.empty(ROOM)
    signs = np.empty(len(a), np.int64)
    for i in range(len(a)):
        signs[i] = turn(a[i, 0], a[i, 1], b[i, 0], b[i, 1], c[i, 0], c[i, 1], room)
    return signs


@no_type_check
@numba.njit(cache=True)
def sides(a, b, c, d):
    """`side` of each row `(n, 3)`."""
    room = np.empty(ROOM)
    signs = np.empty(len(a), np.int64)
    for i in range(len(a)):
        signs[i] = side(a[i], b[i], c[i], d[i], room)
    return signs
