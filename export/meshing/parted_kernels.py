"""The squares of a boundary where it touches itself; imported inside the functions that use it."""

from typing import no_type_check

import numba
import numpy as np

from export.meshing.contacts import FAN_COUNT, FANS
from export.meshing.kernels import corners, low_cell, squares_of, stand
from export.meshing.numbering import SIX
from export.meshing.words import ONE, ZERO, code_at, lowest, spread
from trees.kernels import popcount

NOWHERE = np.zeros(3)


@no_type_check
@numba.njit(cache=True)
def grid_corners(rows, bases, vertices):
    """The corners on the boundary, in cells."""
    numbers = np.zeros(125, np.int32)
    for i in range(rows.shape[0]):
        corners(rows, i, bases[i], NOWHERE, 1.0, numbers, vertices)


@no_type_check
@numba.njit(cache=True)
def codes_of(words, blocks, rows, bases, total, codes, others):
    """Writes the codes of the corners of these blocks, whose rows of `words` are as `spread` takes them.

    The first fan of a corner has the corner's own number, further ones are numbered from `total` on; fan f of
    such a corner has the number `others + f`. Returns how many numbers are given then.
    """
    octants = np.empty(8, np.uint64)
    for k in range(blocks.size):
        octants[:] = words[k]
        spread(octants)
        corner, left = bases[blocks[k]], rows[blocks[k], 1]
        while left != ZERO:
            code = code_at(octants, lowest(left))
            left &= left - ONE
            codes[corner] = code
            if FAN_COUNT[code] > 1:
                others[corner] = total - 1
                total += FAN_COUNT[code] - 1
            corner += 1
    return total


@no_type_check
@numba.njit(cache=True)
def contact_bits(codes, square, axis, out, checkered):
    """Bit s is set where side s of a square is an edge at which two filled cells touch."""
    u, v = (axis + 1) % 3, (axis + 2) % 3
    before_u, before_v = (square[3], square[1]) if out else (square[1], square[3])
    top = square[2]
    # sides from the lowest corner on: along u, then v, back along u, then v, or the other way round
    along_u, along_v = checkered[codes[before_v], u], checkered[codes[top], v]
    back_u, back_v = checkered[codes[top], u], checkered[codes[before_u], v]
    if out:
        return along_u | along_v << 1 | back_u << 2 | back_v << 3
    return back_v | back_u << 1 | along_v << 2 | along_u << 3


@no_type_check
@numba.njit(cache=True)
def touching_squares(rows, bases, groups, slots, near, codes, others, checkered, limit, total):
    """The squares of the blocks that are `near` that have a corner of several fans or a contact side.

    Returns their numbers, then what `Sheets` has, at most `limit` squares, and last the numbers of its
    vertices, all in all `total`.
    """
    numbers = np.zeros(125, np.int32)
    ring, kinds = np.empty((192, 4), np.int64), np.empty(192, np.int64)
    below = np.empty(3, np.int64)
    which, squares = np.empty(limit, np.int64), np.empty((limit, 4), np.int32)
    inner, normals = np.empty((limit, 3), np.int32), np.zeros((limit, 3), np.int32)
    contact = np.empty(limit, np.uint8)
    cells, split = np.empty((4 * limit, 3), np.int32), np.empty(4 * limit, np.uint8)
    names, rank = np.empty(4 * limit, np.int32), np.zeros(total, np.int32)
    n, m, known, own = 0, 0, 0, 0
    for i in range(rows.shape[0]):
        own += groups[own, 0] != rows[i, 0] >> SIX
        if not near[i]:
            n += popcount(rows[i, 3]) + popcount(rows[i, 4]) + popcount(rows[i, 5])
            continue
        stand(rows, i, below)
        for f in range(squares_of(rows, bases, groups, slots, own, i, numbers, ring, kinds)):
            axis, out = kinds[f] >> 6 & 3, kinds[f] >> 8
            bits = contact_bits(codes, ring[f], axis, out, checkered)
            several = False
            for s in range(4):
                several |= others[ring[f, s]] > 0
            if bits == 0 and not several:
                n += 1
                continue
            which[m], contact[m] = n, bits
            for a in range(3):
                inner[m, a] = low_cell(below, kinds[f], a)
            inner[m, axis] += 1 - out
            normals[m, axis] = 1 if out else -1
            for s in range(4):
                corner = ring[f, s]
                slot = (3, 2, 0, 1)[s] if out else (3, 1, 0, 2)[s]
                fan = FANS[codes[corner], 4 * axis + slot] if others[corner] > 0 else 0
                vertex = others[corner] + fan if fan else corner
                if rank[vertex] == 0:
                    for a in range(3):
                        cells[known, a] = low_cell(below, kinds[f], a) + 1
                    cells[known, (axis + 1) % 3] -= slot & 1
                    cells[known, (axis + 2) % 3] -= slot >> 1
                    split[known], names[known] = others[corner] > 0, vertex
                    known += 1
                    rank[vertex] = known
                squares[m, s] = rank[vertex] - 1
            m += 1
            n += 1
    some = cells[:known].copy(), split[:known].copy(), squares[:m], inner[:m], normals[:m], contact[:m]
    return which[:m], some, names[:known].copy()


@no_type_check
@numba.njit(cache=True)
def put_right(squares, names, sides, middle, starts, faces, end):
    """Gives the four triangles of each square, from `starts` on, the vertices of their fans.

    A side with a middle, numbered from `middle` on, has two triangles, the second of them from `end` on.
    """
    for f in range(squares.shape[0]):
        for s in range(4):
            face = faces[starts[f] + s]
            face[1], face[2] = names[squares[f, s]], names[squares[f, (s + 1) & 3]]
            if sides[f, s] >= 0:
                faces[end, 0], faces[end, 1], faces[end, 2] = face[0], middle + sides[f, s], face[2]
                face[2] = faces[end, 1]
                end += 1
