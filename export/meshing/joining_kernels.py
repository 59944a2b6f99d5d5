"""Filling up contacts in words: imported inside the functions that use it."""

from typing import no_type_check

import numba
import numpy as np

from export.meshing.words import AXES, ONE, ZERO, lowest, spread, touching


@no_type_check
@numba.njit(cache=True, inline="always")
def octant_of(bit, octant):
    """The cell at an octant of a corner, and the brick it lies in (`x + 2 y + 4 z` bricks before)."""
    brick = 0
    for axis in range(3):
        if octant >> axis & 1 == 0:
            mask = AXES[axis]
            brick |= int(bit & mask == 0) << axis
            bit = ((bit & mask) - 1) & mask | bit & ~mask
    return bit, brick


@no_type_check
@numba.njit(cache=True)
def fill(words, places, contact, repair):
    """Fills, in place, at each corner with a contact in turn; returns which words have changed.

    Row i of `places` says where the words of block i are: its own brick and those before it.
    """
    changed = np.zeros(words.size, np.bool_)
    octants = np.empty(8, np.uint64)
    for i in range(places.shape[0]):
        for o in range(8):
            octants[o] = words[places[i, o]]
        spread(octants)
        left = touching(octants)
        while left != ZERO:
            bit = lowest(left)
            left &= left - ONE
            code = 0
            for octant in range(8):
                cell, brick = octant_of(bit, octant)
                code |= np.int64(words[places[i, brick]] >> np.uint64(cell) & ONE) << octant
            if not contact[code]:
                continue
            for octant in range(8):
                if repair[code] >> octant & 1:
                    cell, brick = octant_of(bit, octant)
                    words[places[i, brick]] |= ONE << np.uint64(cell)
                    changed[places[i, brick]] = True
    return changed
