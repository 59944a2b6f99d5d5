"""Whether two triangles meet in more than their common corners and edges: exactly.

Imported inside the functions that use it, for numba takes a while to load.
"""

from typing import no_type_check

import numba
import numpy as np

from export.checks.predicates import ROOM, side, turn

APART, CROSSING, OVERLAPPING = 0, 1, 2


@no_type_check
@numba.njit(cache=True)
def flat_axis(a, b, c, room):
    """An axis along which the triangle still has an area when it is flattened; -1 for a triangle without."""
    for axis in range(3):
        if _turn(a, b, c, axis, room) != 0:
            return axis
    return -1


@no_type_check
@numba.njit(cache=True)
def _turn(a, b, c, axis, room):
    x, y = (axis + 1) % 3, (axis + 2) % 3
    return turn(a[x], a[y], b[x], b[y], c[x], c[y], room)


@no_type_check
@numba.njit(cache=True)
def meet(p, q, room):
    """How two triangles `(3, 3)`, both with an area, meet apart from what they share.

    Corners at equal positions are shared. APART: they have nothing else in common than the corner
    or edge between shared corners; OVERLAPPING: they lie in one plane and have more in common;
    CROSSING: they lie in different planes and have more in common.
    """
    shared = 0
    first, second = 0, 0  # the last shared corner in each; and, when two are shared, the sums of their places
    sum_p, sum_q = 0, 0
    for i in range(3):
        for j in range(3):
            if p[i, 0] == q[j, 0] and p[i, 1] == q[j, 1] and p[i, 2] == q[j, 2]:
                shared += 1
                first, second = i, j
                sum_p += i
                sum_q += j
    if shared == 3:
        return OVERLAPPING
    if shared == 2:
        return _hinged(p, q, 3 - sum_p, 3 - sum_q, room)
    if shared == 1:
        return _tipped(p, q, first, second, room)
    return _strangers(p, q, room)


@no_type_check
@numba.njit(cache=True)
def _hinged(p, q, i, j, room):
    """Two triangles on a common edge: i and j are the corners that are not on it."""
    a, b = p[(i + 1) % 3], p[(i + 2) % 3]
    if side(a, b, p[i], q[j], room) != 0:
        return APART
    axis = flat_axis(a, b, p[i], room)
    if _turn(a, b, p[i], axis, room) == _turn(a, b, q[j], axis, room):
        return OVERLAPPING
    return APART


@no_type_check
@numba.njit(cache=True)
def _tipped(p, q, i, j, room):
    """Two triangles with one common corner: p[i] and q[j]."""
    a, b, c, d = p[(i + 1) % 3], p[(i + 2) % 3], q[(j + 1) % 3], q[(j + 2) % 3]
    tip = p[i]
    above_c, above_d = side(tip, a, b, c, room), side(tip, a, b, d, room)
    if above_c * above_d > 0:
        return APART
    if above_c == 0 and above_d == 0:
        return _sectors(tip, a, b, c, d, room)
    above_a, above_b = side(tip, c, d, a, room), side(tip, c, d, b, room)
    if above_a * above_b > 0:
        return APART
    if _pierces(c, d, above_c, above_d, tip, a, b, room) or _pierces(a, b, above_a, above_b, tip, c, d, room):
        return CROSSING
    return APART


@no_type_check
@numba.njit(cache=True)
def _sectors(tip, a, b, c, d, room):
    """Whether two sectors in one plane have more in common than their tip."""
    axis = flat_axis(tip, a, b, room)
    if _turn(tip, a, b, axis, room) < 0:
        a, b = b, a
    if _turn(tip, c, d, axis, room) < 0:
        c, d = d, c
    ac, ad = _turn(tip, a, c, axis, room), _turn(tip, a, d, axis, room)
    bc, bd = _turn(tip, b, c, axis, room), _turn(tip, b, d, axis, room)
    within = (ac >= 0 and bc <= 0) or (ad >= 0 and bd <= 0) or (ac <= 0 and ad >= 0) or (bc <= 0 and bd >= 0)
    return OVERLAPPING if within else APART


@no_type_check
@numba.njit(cache=True)
def _strangers(p, q, room):
    """Two triangles without common corners."""
    u, v, w = side(p[0], p[1], p[2], q[0], room), side(p[0], p[1], p[2], q[1], room), 0
    if u * v > 0:
        w = side(p[0], p[1], p[2], q[2], room)
        if u * w > 0:
            return APART
    else:
        w = side(p[0], p[1], p[2], q[2], room)
    if u == 0 and v == 0 and w == 0:
        return OVERLAPPING if _flat_meet(p, q, room) else APART
    f, g = side(q[0], q[1], q[2], p[0], room), side(q[0], q[1], q[2], p[1], room)
    h = side(q[0], q[1], q[2], p[2], room)
    if f * g > 0 and f * h > 0:
        return APART
    if (
        _pierces(q[0], q[1], u, v, p[0], p[1], p[2], room)
        or _pierces(q[1], q[2], v, w, p[0], p[1], p[2], room)
        or _pierces(q[2], q[0], w, u, p[0], p[1], p[2], room)
        or _pierces(p[0], p[1], f, g, q[0], q[1], q[2], room)
        or _pierces(p[1], p[2], g, h, q[0], q[1], q[2], room)
        or _pierces(p[2], p[0], h, f, q[0], q[1], q[2], room)
    ):
        return CROSSING
    return APART


@no_type_check
@numba.njit(cache=True)
def _pierces(s, e, above_s, above_e, a, b, c, room):
    """Whether the segment from s to e, on these sides of the plane of a, b, c, meets that triangle."""
    if above_s * above_e > 0:
        return False
    if above_s == 0 and above_e == 0:
        return _segment_meets(s, e, a, b, c, flat_axis(a, b, c, room), room)
    x, y, z = side(s, e, a, b, room), side(s, e, b, c, room), side(s, e, c, a, room)
    return (x >= 0 and y >= 0 and z >= 0) or (x <= 0 and y <= 0 and z <= 0)


@no_type_check
@numba.njit(cache=True)
def _flat_meet(p, q, room):
    """Whether two triangles in one plane meet."""
    axis = flat_axis(p[0], p[1], p[2], room)
    for i in range(3):
        if _segment_meets(q[i], q[(i + 1) % 3], p[0], p[1], p[2], axis, room):
            return True
    return _holds(q[0], q[1], q[2], p[0], axis, room)


@no_type_check
@numba.njit(cache=True)
def _segment_meets(s, e, a, b, c, axis, room):
    """Whether a segment in the plane of a triangle meets it."""
    return (
        _holds(a, b, c, s, axis, room)
        or _segments_meet(s, e, a, b, axis, room)
        or _segments_meet(s, e, b, c, axis, room)
        or _segments_meet(s, e, c, a, axis, room)
    )


@no_type_check
@numba.njit(cache=True)
def _holds(a, b, c, x, axis, room):
    u, v, w = _turn(a, b, x, axis, room), _turn(b, c, x, axis, room), _turn(c, a, x, axis, room)
    return (u >= 0 and v >= 0 and w >= 0) or (u <= 0 and v <= 0 and w <= 0)


@no_type_check
@numba.njit(cache=True)
def _segments_meet(s, e, a, b, axis, room):
    u, v = _turn(s, e, a, axis, room), _turn(s, e, b, axis, room)
    if u * v > 0:
        return False
    f, g = _turn(a, b, s, axis, room), _turn(a, b, e, axis, room)
    if f * g > 0:
        return False
    if u == 0 and v == 0 and f == 0 and g == 0:  # on one line, as are their spans on each axis
        for x in range(3):
            if max(s[x], e[x]) < min(a[x], b[x]) or max(a[x], b[x]) < min(s[x], e[x]):
                return False
    return True


@no_type_check
@numba.njit(cache=True)
def meetings(p, q):
    """`meet` of each pair of triangles `(n, 3, 3)`; APART where one of them has no area."""
    room = np.empty(ROOM)
    found = np.zeros(len(p), np.int64)
    for i in range(len(p)):
        if (
            flat_axis(p[i, 0], p[i, 1], p[i, 2], room) >= 0
            and flat_axis(q[i, 0], q[i, 1], q[i, 2], room) >= 0
        ):
            found[i] = meet(p[i], q[i], room)
    return found
