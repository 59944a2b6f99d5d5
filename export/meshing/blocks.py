"""The blocks of corners through which the boundary of a tree passes, found in one walk down the tree.

A block is the 4 x 4 x 4 corners at the low ends of the cells of a brick; the corners at the high end of the
cube belong to blocks of their own, so keys of blocks have one bit more an axis than those of bricks. A frame
of the walk is a node of the tree of blocks with the eight nodes of bricks that its corners can see: the same
one and its low neighbours. Where all eight are full, or all empty, nothing below is looked at.
Imported inside the functions that use it.
"""

from typing import no_type_check

import numba
import numpy as np

from export.meshing.words import FULL, ONE, ZERO, checkered, opposite, spread
from trees.kernels import popcount

MIXED = 2


@no_type_check
@numba.njit(cache=True, inline="always")
def entry_of(starts, lo, hi, key):
    """The last entry from lo to hi that starts at or before the key."""
    while lo < hi:
        middle = (lo + hi + 1) >> 1
        if starts[middle] <= key:
            lo = middle
        else:
            hi = middle - 1
    return lo


@no_type_check
@numba.njit(cache=True, inline="always")
def colour_of(words, lo, hi):
    """0 for white, 1 for black, `MIXED` for the rest; -1 for lo means outside, which is white."""
    if lo < 0:
        return 0
    if lo != hi:
        return MIXED
    if words[lo] == ZERO:
        return 0
    return 1 if words[lo] == FULL else MIXED


@no_type_check
@numba.njit(cache=True)
def roots(lo, hi, begin, keys, levels, entries, top):
    """The eight nodes of blocks that cover the cube and its high ends; returns how many frames there are."""
    for frame in range(8):
        node = 7 - frame
        keys[frame], levels[frame] = node, top
        for o in range(8):
            same = (node >> 2 == o & 1) and (node >> 1 & 1 == o >> 1 & 1) and (node & 1 == o >> 2)
            lo[frame, o], hi[frame, o] = (0, entries - 1) if same else (-1, -1)
            begin[frame, o] = ZERO
    return 8


@no_type_check
@numba.njit(cache=True)
def halves(starts, lo, hi, begin, frame, level, low, high, first):
    """The 27 children of the nodes of a frame that its own children can see, at `9 x + 3 y + z`."""
    size = ONE << np.uint64(3 * (level - 1))
    for at in range(27):
        x, y, z = at // 9, at // 3 % 3, at % 3
        node = int(x == 0) | int(y == 0) << 1 | int(z == 0) << 2
        child = int(x != 1) << 2 | int(y != 1) << 1 | int(z != 1)
        start = begin[frame, node] + np.uint64(child) * size
        first[at] = start
        i, j = lo[frame, node], hi[frame, node]
        if i < j:
            i = entry_of(starts, i, j, start)
            j = entry_of(starts, i, j, start + (size - ONE))
        low[at], high[at] = i, j


@no_type_check
@numba.njit(cache=True, inline="always")
def seen(child, o):
    """Where `halves` puts what a child of a frame sees, `o` bits: one before on x, y, z."""
    x, y, z = 1 + (child >> 2) - (o & 1), 1 + (child >> 1 & 1) - (o >> 1 & 1), 1 + (child & 1) - (o >> 2)
    return 9 * x + 3 * y + z


@no_type_check
@numba.njit(cache=True)
def wider(array, rows):
    result = np.empty((rows, array.shape[1]), array.dtype)
    result[: array.shape[0]] = array
    return result


@no_type_check
@numba.njit(cache=True)
def collected(starts, words, top, wanted):
    """The blocks with corners on the boundary, in Morton order, and the keys of those with contacts.

    A row is the block's key, its corners on the boundary, the cells below its corners (octant 0), and its
    faces across x, y and z, each at its highest corner. `top`, at least 1, is the bits of bricks an axis.
    With `wanted` "contacts" (1) the rows stay out.
    """
    room = 8 * (top + 2)
    lo, hi = np.empty((room, 8), np.int64), np.empty((room, 8), np.int64)
    begin, keys, levels = np.empty((room, 8), np.uint64), np.empty(room, np.uint64), np.empty(room, np.int64)
    low, high, first = np.empty(27, np.int64), np.empty(27, np.int64), np.empty(27, np.uint64)
    colours, octants = np.empty(27, np.int64), np.empty(8, np.uint64)
    rows, touched = np.empty((1024, 6), np.uint64), np.empty((64, 1), np.uint64)
    n, contacts, vertices, faces = 0, 0, 0, 0
    frames = roots(lo, hi, begin, keys, levels, starts.size, top)
    while frames > 0:
        frames -= 1
        level, parent = levels[frames], keys[frames]
        halves(starts, lo, hi, begin, frames, level, low, high, first)
        for at in range(27):
            colours[at] = colour_of(words, low[at], high[at])
        for turn in range(8):
            child = 7 - turn if level > 1 else turn
            colour = colours[seen(child, 0)]
            same = colour != MIXED
            for o in range(1, 8):
                same &= colours[seen(child, o)] == colour
            if same:
                continue
            key = parent << np.uint64(3) | np.uint64(child)
            if level > 1:
                for o in range(8):
                    at = seen(child, o)
                    lo[frames, o], hi[frames, o], begin[frames, o] = low[at], high[at], first[at]
                keys[frames], levels[frames] = key, level - 1
                frames += 1
                continue
            for o in range(8):
                at = seen(child, o)
                octants[o] = words[low[at]] if low[at] >= 0 else ZERO
            spread(octants)
            some, every = ZERO, FULL
            for o in range(8):
                some |= octants[o]
                every &= octants[o]
            active = some & ~every
            if active == ZERO:
                continue
            contact = opposite(octants)
            for axis in range(3):
                contact |= checkered(octants, axis, 1)
            if contact != ZERO:
                if contacts == touched.shape[0]:
                    touched = wider(touched, 2 * contacts)
                touched[contacts, 0] = key
                contacts += 1
            if wanted == 1:
                continue
            if n == rows.shape[0]:
                rows = wider(rows, n + n // 2)
            rows[n, 0], rows[n, 1], rows[n, 2] = key, active, octants[0]
            for axis in range(3):
                rows[n, 3 + axis] = octants[0] ^ octants[1 << axis]
                faces += popcount(rows[n, 3 + axis])
            vertices += popcount(active)
            n += 1
    return rows[:n], touched[:contacts, 0].copy(), vertices, faces
