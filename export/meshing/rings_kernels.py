"""Rings of vertices around rectangles, and their triangles; imported inside the functions that use it."""

from typing import no_type_check

import numba


@no_type_check
@numba.njit(cache=True, inline="always")
def side_axis(axis, out, side):
    """The axis along which a side of a rectangle runs; corners turn counter-clockwise from outside."""
    return (axis + 1 + (side + (0 if out else 1)) % 2) % 3


@no_type_check
@numba.njit(cache=True)
def lengths_of(axes, outs, corners, ranks, starts):
    """Where the ring of each rectangle starts: it has four corners and what lies on its sides.

    `ranks[a, v]` counts the vertices before v in the order of the lines along axis a.
    """
    total = 0
    for f in range(axes.size):
        starts[f] = total
        for side in range(4):
            a = side_axis(axes[f], outs[f], side)
            one, two = ranks[a, corners[f, side]], ranks[a, corners[f, (side + 1) % 4]]
            total += abs(two - one)
    starts[axes.size] = total


@no_type_check
@numba.njit(cache=True)
def fill_rings(axes, outs, corners, ranks, orders, starts, ring, turns):
    """Writes the vertices around each rectangle, and at which place in the ring its corners are."""
    for f in range(axes.size):
        at = starts[f]
        for side in range(4):
            a = side_axis(axes[f], outs[f], side)
            one, two = ranks[a, corners[f, side]], ranks[a, corners[f, (side + 1) % 4]]
            step = 1 if two > one else -1
            turns[f, side] = at - starts[f]
            while one != two:
                ring[at] = orders[a, one]
                at += 1
                one += step


@no_type_check
@numba.njit(cache=True, inline="always")
def gap_of(places, one, two):
    total = 0
    for a in range(3):
        total += (places[one, a] - places[two, a]) ** 2
    return total


@no_type_check
@numba.njit(cache=True)
def flat_strips(starts, ring, turns, places, triangles):
    """Triangles of flat rectangles, two less than the vertices of the ring, none without area.

    The corner triangle at either end is a fan over the points of that end; between two opposite sides lies a
    strip, whose next diagonal is the shorter one.
    """
    t = 0
    for f in range(starts.size - 1):
        first, m = starts[f], starts[f + 1] - starts[f]
        b, c, d = turns[f, 1], turns[f, 2], turns[f, 3]
        for k in range(d, m):
            triangles[t, 0], triangles[t, 1] = ring[first + k], ring[first + (k + 1) % m]
            triangles[t, 2] = ring[first + 1]
            t += 1
        for k in range(b, c):
            triangles[t, 0], triangles[t, 1] = ring[first + k], ring[first + k + 1]
            triangles[t, 2] = ring[first + (c + 1) % m]
            t += 1
        low, high = 1, d
        while low < b or high > c + 1:
            if high == c + 1:
                forward = True
            elif low == b:
                forward = False
            else:
                here, there = ring[first + low], ring[first + high]
                forward = gap_of(places, ring[first + low + 1], there) <= gap_of(
                    places, here, ring[first + high - 1]
                )
            triangles[t, 0], triangles[t, 2] = ring[first + low], ring[first + high]
            if forward:
                low += 1
                triangles[t, 1] = ring[first + low]
            else:
                high -= 1
                triangles[t, 1] = ring[first + high]
            t += 1
    return t
