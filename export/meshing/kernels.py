"""From blocks of corners to vertices, squares and triangles, where no two sheets touch.

Imported inside the functions that use it.
"""

from typing import no_type_check

import numba
import numpy as np

from export.meshing.diagonals import fits
from export.meshing.numbering import PLACE, SIX, STEP, look_around, look_before
from export.meshing.words import CELLS, ONE, ZERO, along, lowest, place
from trees.kernels import popcount

COORDINATES = np.array(CELLS, dtype=np.float64)


@no_type_check
@numba.njit(cache=True)
def squares_of(rows, bases, groups, slots, own, i, numbers, squares, kinds):
    """Writes the squares of block i, counter-clockwise from outside, and their kinds; returns how many.

    The kind is `bit + 64 axis`, `bit` being the highest corner, and 256 more if the filled cell is the lower
    one. The first corner is the lowest, the third the highest.
    """
    look_around(rows, bases, groups, slots, own, i, numbers)
    n = 0
    low = rows[i, 2]
    for axis in range(3):
        along_u, along_v = STEP[(axis + 1) % 3], STEP[(axis + 2) % 3]
        faces = rows[i, 3 + axis]
        while faces != ZERO:
            bit = np.uint64(lowest(faces))
            faces &= faces - ONE
            out = np.int64(low >> bit & ONE)
            at = PLACE[bit]
            before_u, before_v = numbers[at - along_u], numbers[at - along_v]
            squares[n, 0] = numbers[at - along_u - along_v]
            squares[n, 1] = before_v if out else before_u
            squares[n, 2] = numbers[at]
            squares[n, 3] = before_u if out else before_v
            kinds[n] = np.int64(bit) | axis << 6 | out << 8
            n += 1
    return n


@no_type_check
@numba.njit(cache=True)
def corners(rows, i, n, origin, pitch, numbers, vertices):
    """Numbers the vertices of block i from n on and writes their places, `origin + pitch * corner`."""
    x, y, z = float(place(rows[i, 0], 0)), float(place(rows[i, 0], 1)), float(place(rows[i, 0], 2))
    active, row = rows[i, 1], np.uint64(n)
    while active != ZERO:
        bit = np.uint64(lowest(active))
        active &= active - ONE
        numbers[PLACE[bit]] = row
        vertices[row, 0] = origin[0] + (x + COORDINATES[bit, 0]) * pitch
        vertices[row, 1] = origin[1] + (y + COORDINATES[bit, 1]) * pitch
        vertices[row, 2] = origin[2] + (z + COORDINATES[bit, 2]) * pitch
        row += ONE


@no_type_check
@numba.njit(cache=True)
def flat(rows, bases, groups, slots, origin, pitch, vertices, triangles):
    """The corners, and two triangles for each square, cut from the lowest corner to the highest."""
    numbers = np.zeros(125, np.int32)
    t, own = ZERO, 0
    for i in range(rows.shape[0]):
        own += groups[own, 0] != rows[i, 0] >> SIX
        corners(rows, i, bases[i], origin, pitch, numbers, vertices)
        look_before(rows, bases, groups, slots, own, i, numbers)
        low = rows[i, 2]
        for axis in range(3):
            along_u, along_v = STEP[(axis + 1) % 3], STEP[(axis + 2) % 3]
            faces = rows[i, 3 + axis]
            while faces != ZERO:
                bit = np.uint64(lowest(faces))
                faces &= faces - ONE
                out = low >> bit & ONE != ZERO
                at = PLACE[bit]
                first, top = numbers[at - along_u - along_v], numbers[at]
                before_u, before_v = numbers[at - along_u], numbers[at - along_v]
                triangles[t, 0] = first
                triangles[t, 1] = before_v if out else before_u
                triangles[t, 2] = top
                triangles[t, 3] = first
                triangles[t, 4] = top
                triangles[t, 5] = before_u if out else before_v
                t += ONE


@no_type_check
@numba.njit(cache=True, inline="always")
def stand(rows, i, corner):
    """Writes the first corner of block i."""
    for axis in range(3):
        corner[axis] = place(rows[i, 0], axis)


@no_type_check
@numba.njit(cache=True, inline="always")
def low_cell(corner, kind, axis):
    """On an axis, the cell below the highest corner of a square: the lower one of the two it parts."""
    return corner[axis] + along(kind & 63, axis) - 1


@no_type_check
@numba.njit(cache=True)
def cells_beside(rows, first, limit, inside, outside):
    """The filled and the empty cell of each square of the blocks from `first` on.

    Returns the next block and how many squares there are: as many whole blocks as `limit` squares hold.
    """
    n, i = 0, first
    corner = np.empty(3, np.int64)
    while i < rows.shape[0]:
        more = popcount(rows[i, 3]) + popcount(rows[i, 4]) + popcount(rows[i, 5])
        if n + more > limit:
            break
        stand(rows, i, corner)
        for axis in range(3):
            faces = rows[i, 3 + axis]
            while faces != ZERO:
                bit = lowest(faces)
                faces &= faces - ONE
                out = np.int64(rows[i, 2] >> np.uint64(bit) & ONE)
                for a in range(3):
                    cell = low_cell(corner, bit, a)
                    inside[n, a] = cell + int(a == axis and not out)
                    outside[n, a] = cell + int(a == axis and out)
                n += 1
        i += 1
    return i, n


@no_type_check
@numba.njit(cache=True, inline="always")
def cross(corner, kind, share, crossing):
    """The crossing of a square: this share of the way from the centre of its filled cell to the empty one."""
    axis, out = kind >> 6 & 3, kind >> 8
    for a in range(3):
        crossing[a] = low_cell(corner, kind, a) + 0.5
    crossing[axis] += share if out else 1 - share


@no_type_check
@numba.njit(cache=True)
def means(rows, bases, groups, slots, shares, vertices, counts):
    """At each vertex the mean of its squares' crossings, in cells; `shares` of none means half-way."""
    numbers = np.zeros(125, np.int32)
    squares, kinds = np.empty((192, 4), np.int64), np.empty(192, np.int64)
    corner, crossing = np.empty(3, np.int64), np.empty(3)
    n, own = 0, 0
    for i in range(rows.shape[0]):
        own += groups[own, 0] != rows[i, 0] >> SIX
        stand(rows, i, corner)
        for f in range(squares_of(rows, bases, groups, slots, own, i, numbers, squares, kinds)):
            share = shares[n] if shares.size else 0.5
            cross(corner, kinds[f], share, crossing)
            for s in range(4):
                vertex = squares[f, s]
                counts[vertex] += 1
                for a in range(3):
                    vertices[vertex, a] += crossing[a]
            n += 1
    for vertex in range(counts.size):
        for a in range(3):
            vertices[vertex, a] /= counts[vertex]


@no_type_check
@numba.njit(cache=True)
def chosen(rows, bases, groups, slots, vertices, choice, margin):
    """For each square the corner its diagonal starts from, 0 or 1, or 2 for none: see `fits`.

    Returns how many are 2.
    """
    numbers = np.zeros(125, np.int32)
    squares, kinds = np.empty((192, 4), np.int64), np.empty(192, np.int64)
    corner, centre, ring = np.empty(3, np.int64), np.empty(3), np.empty((4, 3))
    n, own, rounds = 0, 0, 0
    for i in range(rows.shape[0]):
        own += groups[own, 0] != rows[i, 0] >> SIX
        stand(rows, i, corner)
        for f in range(squares_of(rows, bases, groups, slots, own, i, numbers, squares, kinds)):
            axis = kinds[f] >> 6 & 3
            u, v = (axis + 1) % 3, (axis + 2) % 3
            out = 1 if kinds[f] >> 8 else -1
            cross(corner, kinds[f], 0.0, centre)
            for s in range(4):
                vertex = squares[f, s]
                ring[s, 0] = vertices[vertex, u] - centre[u]
                ring[s, 1] = (vertices[vertex, v] - centre[v]) * out
                ring[s, 2] = (vertices[vertex, axis] - centre[axis]) * out
            best = np.inf
            choice[n] = 2
            for s in range(2):
                length = 0.0
                for a in range(3):
                    length += (ring[s, a] - ring[s + 2, a]) ** 2
                if length < best - margin and fits(ring, s, margin):
                    choice[n] = s
                    best = length
            rounds += choice[n] == 2
            n += 1
    return rounds


@no_type_check
@numba.njit(cache=True)
def bent_triangles(rows, bases, groups, slots, shares, choice, centre, vertices, triangles):
    """Two triangles for a square with a diagonal, else four around its crossing, the next vertex from
    `centre` on."""
    numbers = np.zeros(125, np.int32)
    squares, kinds = np.empty((192, 4), np.int64), np.empty(192, np.int64)
    corner, crossing = np.empty(3, np.int64), np.empty(3)
    n, t, own = 0, 0, 0
    for i in range(rows.shape[0]):
        own += groups[own, 0] != rows[i, 0] >> SIX
        stand(rows, i, corner)
        for f in range(squares_of(rows, bases, groups, slots, own, i, numbers, squares, kinds)):
            s = choice[n]
            if s < 2:
                a, c = squares[f, s], squares[f, s + 2]
                triangles[t, 0], triangles[t, 1], triangles[t, 2] = a, squares[f, s + 1], c
                triangles[t + 1, 0], triangles[t + 1, 1] = a, c
                triangles[t + 1, 2] = squares[f, (s + 3) % 4]
                t += 2
            else:
                cross(corner, kinds[f], shares[n] if shares.size else 0.5, crossing)
                for a in range(3):
                    vertices[centre, a] = crossing[a]
                for s in range(4):
                    triangles[t, 0], triangles[t, 1] = centre, squares[f, s]
                    triangles[t, 2] = squares[f, (s + 1) % 4]
                    t += 1
                centre += 1
            n += 1


@no_type_check
@numba.njit(cache=True)
def placed(vertices, origin, pitch):
    """In place, from cells to mm."""
    for i in range(vertices.shape[0]):
        for a in range(3):
            vertices[i, a] = origin[a] + vertices[i, a] * pitch
