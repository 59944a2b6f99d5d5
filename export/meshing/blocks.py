"""The blocks of corners through which the boundary of a tree passes, found in one walk down the tree.

A block is the 4 x 4 x 4 corners at the low ends of the cells of a brick; the corners at the high end of the
cube belong to blocks of their own, so keys of blocks have one bit more an axis than those of bricks. A frame
of the walk is a node of the tree of blocks with the eight nodes of bricks that its corners can see: the same
one and its low neighbours. Where all eight are full, or all empty, nothing below is looked at. The walk ends
at nodes of 4 x 4 x 4 bricks, whose words are laid out together with those that lie one before them.
Imported inside the functions that use it.
"""

from typing import no_type_check

import numba
import numpy as np

from export.meshing.words import CELLS, FULL, ONE, ZERO, checkered, opposite, spread
from trees.kernels import popcount

MIXED = 2
SIDE = (25, 5, 1)  # how far the next brick lies on each axis in a window of 5 x 5 x 5


def _window() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """For each of the eight nodes that a frame sees, the bricks that a window needs and their places there.

    Also how many there are. The window begins one brick before the frame's own node on each axis.
    """
    bricks, places, counts = np.zeros((8, 64), np.uint64), np.zeros((8, 64), np.int64), np.zeros(8, np.int64)
    for node in range(8):
        for brick in range(64):
            cell = CELLS[brick]
            before = [node >> axis & 1 for axis in range(3)]
            if all(c == 3 for c, b in zip(cell, before, strict=True) if b):
                at = sum(s * (0 if b else c + 1) for s, c, b in zip(SIDE, cell, before, strict=True))
                bricks[node, counts[node]], places[node, counts[node]] = brick, at
                counts[node] += 1
    return bricks, places, counts


NEEDED, PLACES, COUNTS = _window()


@no_type_check
@numba.njit(cache=True, inline="always")
def entry_of(starts, lo, hi, key):
    """The last entry from lo to hi that starts at or before the key."""
    if starts.size == 0:
        return np.int64(key)
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
def descend(starts, words, lo, hi, begin, keys, levels, frame, low, high, first, colours):
    """Puts in place of a frame its children through which the boundary may pass; returns the next frame."""
    level, parent = levels[frame], keys[frame]
    halves(starts, lo, hi, begin, frame, level, low, high, first)
    for at in range(27):
        colours[at] = colour_of(words, low[at], high[at])
    for turn in range(8):
        child = 7 - turn
        colour = colours[seen(child, 0)]
        same = colour != MIXED
        for o in range(1, 8):
            same &= colours[seen(child, o)] == colour
        if same:
            continue
        for o in range(8):
            at = seen(child, o)
            lo[frame, o], hi[frame, o], begin[frame, o] = low[at], high[at], first[at]
        keys[frame], levels[frame] = parent << np.uint64(3) | np.uint64(child), level - 1
        frame += 1
    return frame


@no_type_check
@numba.njit(cache=True)
def lay_out(starts, words, lo, hi, begin, frame, window):
    """The words of a node of 4 x 4 x 4 bricks and of those one before; returns if not all full or empty."""
    some, every = ZERO, FULL
    for node in range(8):
        entry, last, base = lo[frame, node], hi[frame, node], begin[frame, node]
        for k in range(COUNTS[node]):
            word = ZERO
            if entry >= 0:
                key = base + NEEDED[node, k]
                if starts.size == 0:
                    word = words[key]
                else:
                    while entry < last and starts[entry + 1] <= key:
                        entry += 1
                    word = words[entry]
            window[PLACES[node, k]] = word
            some |= word
            every &= word
    return some != ZERO and every != FULL


@no_type_check
@numba.njit(cache=True, inline="always")
def see(window, at, octants):
    """The brick at a place of a window and its low neighbours; returns if not all full or empty."""
    some, every = ZERO, FULL
    for o in range(8):
        word = window[at - SIDE[0] * (o & 1) - SIDE[1] * (o >> 1 & 1) - SIDE[2] * (o >> 2)]
        octants[o] = word
        some |= word
        every &= word
    return some != ZERO and every != FULL


@no_type_check
@numba.njit(cache=True)
def touches(octants):
    """Whether two sheets touch at a corner of the block, or on an edge that goes up from one."""
    contact = opposite(octants)
    for axis in range(3):
        contact |= checkered(octants, axis, 1)
    return contact != ZERO


@no_type_check
@numba.njit(cache=True)
def collected(starts, words, top, wanted):
    """The blocks with corners on the boundary, in Morton order, and the keys of those with contacts.

    A row is the block's key, its corners on the boundary, the cells below its corners (octant 0), and its
    faces across x, y and z, each at its highest corner. `top`, at least 2, is the bits of bricks an axis;
    without `starts` there is a word for every brick. With `wanted` "contacts" (1) the rows stay out.
    """
    room = 8 * (top + 2)
    lo, hi = np.empty((room, 8), np.int64), np.empty((room, 8), np.int64)
    begin, keys, levels = np.empty((room, 8), np.uint64), np.empty(room, np.uint64), np.empty(room, np.int64)
    low, high, first = np.empty(27, np.int64), np.empty(27, np.int64), np.empty(27, np.uint64)
    colours, octants, window = np.empty(27, np.int64), np.empty(8, np.uint64), np.zeros(125, np.uint64)
    rows, touched = np.empty((1024, 6), np.uint64), np.empty((64, 1), np.uint64)
    n, contacts, vertices, faces = 0, 0, 0, 0
    frames = roots(lo, hi, begin, keys, levels, max(starts.size, words.size), top)
    while frames > 0:
        frames -= 1
        if levels[frames] > 2:
            frames = descend(starts, words, lo, hi, begin, keys, levels, frames, low, high, first, colours)
            continue
        if not lay_out(starts, words, lo, hi, begin, frames, window):
            continue
        if n + 64 > rows.shape[0]:
            rows = wider(rows, n + n // 2 + 64)
        if contacts + 64 > touched.shape[0]:
            touched = wider(touched, 2 * contacts + 64)
        for k in range(64):
            if not see(window, PLACES[0, k], octants):
                continue
            spread(octants)
            some, every = ZERO, FULL
            for o in range(8):
                some |= octants[o]
                every &= octants[o]
            active = some & ~every
            if active == ZERO:
                continue
            key = keys[frames] << np.uint64(6) | np.uint64(k)
            if touches(octants):
                touched[contacts, 0] = key
                contacts += 1
            if wanted == 1:
                continue
            rows[n, 0], rows[n, 1], rows[n, 2] = key, active, octants[0]
            for axis in range(3):
                rows[n, 3 + axis] = octants[0] ^ octants[1 << axis]
                faces += popcount(rows[n, 3 + axis])
            vertices += popcount(active)
            n += 1
    return rows[:n], touched[:contacts, 0].copy(), vertices, faces
