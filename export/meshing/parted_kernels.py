"""Vertices by fans of faces, where a boundary touches itself; imported inside the functions that use it."""

from typing import no_type_check

import numba
import numpy as np

from export.meshing.kernels import low_cell, squares_of, stand
from export.meshing.words import ONE, ZERO, along, code_at, lowest, place, spread


@no_type_check
@numba.njit(cache=True)
def codes_of(words, active, total):
    """The codes of the active corners of blocks, whose rows of words are as `spread` takes them."""
    codes = np.empty(total, np.uint8)
    octants = np.empty(8, np.uint64)
    n = 0
    for i in range(active.size):
        octants[:] = words[i]
        spread(octants)
        left = active[i]
        while left != ZERO:
            codes[n] = code_at(octants, lowest(left))
            left &= left - ONE
            n += 1
    return codes


@no_type_check
@numba.njit(cache=True)
def corner_cells(rows, total):
    """The coordinates of the corners on the boundary."""
    cells = np.empty((total, 3), np.int64)
    n = 0
    for i in range(rows.shape[0]):
        left = rows[i, 1]
        while left != ZERO:
            bit = lowest(left)
            left &= left - ONE
            for axis in range(3):
                cells[n, axis] = place(rows[i, 0], axis) + along(bit, axis)
            n += 1
    return cells


@no_type_check
@numba.njit(cache=True)
def sheet_squares(rows, bases, slots, codes, first, fans, checkered, squares, inner, normals, contact):
    """Writes the rows of `Sheets`; `first` is the first vertex of each corner."""
    numbers, masks = np.zeros(8, np.int64), np.zeros(8, np.uint64)
    ring, kinds = np.empty((192, 4), np.int64), np.empty(192, np.int64)
    below = np.empty(3, np.int64)
    n = 0
    for i in range(rows.shape[0]):
        stand(rows, i, below)
        for f in range(squares_of(rows, bases, slots, i, numbers, masks, ring, kinds)):
            axis, out = kinds[f] >> 6 & 3, kinds[f] >> 8
            u, v = (axis + 1) % 3, (axis + 2) % 3
            before_u, before_v = (ring[f, 3], ring[f, 1]) if out else (ring[f, 1], ring[f, 3])
            top = ring[f, 2]
            for s in range(4):
                slot = (3, 2, 0, 1)[s] if out else (3, 1, 0, 2)[s]
                corner = ring[f, s]
                squares[n, s] = first[corner] + fans[codes[corner], 4 * axis + slot]
            # sides from the lowest corner on: along u, then v, back along u, then v, or the other way round
            sides = (
                checkered[codes[before_v], u],
                checkered[codes[top], v],
                checkered[codes[top], u],
                checkered[codes[before_u], v],
            )
            for s in range(4):
                if sides[s if out else 3 - s]:
                    contact[n] |= 1 << s
            for a in range(3):
                inner[n, a] = low_cell(below, kinds[f], a)
            inner[n, axis] += 1 - out
            normals[n, axis] = 1 if out else -1
            n += 1
