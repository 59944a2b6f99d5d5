"""The numbers of the vertices of a block of corners and of those before it, found by groups of blocks.

Where no two sheets touch every corner on the boundary is one vertex: its number is that of the block's first
and how many of the block's corners come before it. Imported inside the functions that use it.
"""

from typing import no_type_check

import numba
import numpy as np

from export.meshing.words import CELLS, FIRST, FULL, LAST, ONE, ZERO, before, lowest
from trees.kernels import popcount

SPREAD = np.uint64(0x9E3779B97F4A7C15)
FOUR, SIX, LOW = np.uint64(4), np.uint64(6), np.uint64(63)
PLACE = np.array([25 * x + 5 * y + z + 31 for x, y, z in CELLS], dtype=np.uint64)
# to the next corner on each axis, among those of a block and those one before
STEP = (np.uint64(25), np.uint64(5), np.uint64(1))


@no_type_check
@numba.njit(cache=True)
def groups_of(rows):
    """How many groups of 4 x 4 x 4 blocks have a row."""
    n = 0
    for i in range(rows.shape[0]):
        n += i == 0 or rows[i, 0] >> SIX != rows[i - 1, 0] >> SIX
    return n


@no_type_check
@numba.njit(cache=True)
def index(rows, bases, groups, slots):
    """Writes the number of the first vertex of each block, and the groups with a hash table of their keys.

    A row of `groups` is its key, the blocks it has, and the first of these; `slots` are `2^n`, at first -1.
    """
    total, g = 0, -1
    for i in range(rows.shape[0]):
        bases[i] = total
        total += popcount(rows[i, 1])
        key, block = rows[i, 0] >> SIX, rows[i, 0] & LOW
        if g < 0 or groups[g, 0] != key:
            g += 1
            groups[g, 0], groups[g, 1], groups[g, 2] = key, ZERO, np.uint64(i)
        groups[g, 1] |= ONE << block
    last = np.uint64(slots.size - 1)
    for g in range(groups.shape[0]):
        slot = (groups[g, 0] * SPREAD >> np.uint64(32)) & last
        while slots[slot] >= 0:
            slot = (slot + ONE) & last
        slots[slot] = g


@no_type_check
@numba.njit(cache=True, inline="always")
def found(groups, slots, own, key):
    """The block of a key, -1 where it has no corner on the boundary; `own` is the group looked at first."""
    wanted, block = key >> SIX, key & LOW
    g = own
    if groups[own, 0] != wanted:
        last = np.uint64(slots.size - 1)
        slot = (wanted * SPREAD >> np.uint64(32)) & last
        while slots[slot] >= 0 and groups[slots[slot], 0] != wanted:
            slot = (slot + ONE) & last
        g = np.int64(slots[slot])
    if g < 0 or groups[g, 1] >> block & ONE == ZERO:
        return -1
    return np.int64(groups[g, 2]) + popcount(groups[g, 1] & ((ONE << block) - ONE))


@no_type_check
@numba.njit(cache=True)
def look_before(rows, bases, groups, slots, own, i, numbers):
    """Writes the vertices that squares of block i have in blocks before: see `look_around`."""
    for o in range(1, 7):
        wanted, last, shift, other = ZERO, FULL, ZERO, rows[i, 0]
        for axis in range(3):
            if o >> axis & 1 == 0:
                wanted |= rows[i, 3 + axis]
        for axis in range(3):
            if o >> axis & 1:
                wanted &= FIRST[axis]
                last &= LAST[axis]
                shift += FOUR * STEP[axis]
        if wanted == ZERO:
            continue
        for axis in range(3):
            if o >> axis & 1:
                other = before(other, axis)
        j = found(groups, slots, own, other)
        if j >= 0:
            active, base = rows[j, 1], bases[j]
            left = active & last
            while left != ZERO:
                bit = left & (~left + ONE)
                left ^= bit
                numbers[PLACE[popcount(bit - ONE)] - shift] = base + popcount(active & (bit - ONE))


@no_type_check
@numba.njit(cache=True)
def look_around(rows, bases, groups, slots, own, i, numbers):
    """Writes the vertices of block i, of group `own`, and those that its squares have in blocks before.

    `numbers` are those at 5 x 5 x 5 corners, the block's own 4 x 4 x 4 ending them.
    """
    n, active = bases[i], rows[i, 1]
    while active != ZERO:
        numbers[PLACE[lowest(active)]] = n
        active &= active - ONE
        n += 1
    look_before(rows, bases, groups, slots, own, i, numbers)
