"""From blocks of corners to vertices, squares and triangles, where no two sheets touch.

Every corner on the boundary is then one vertex: its number is that of the block's first and how many of the
block's corners come before it. Imported inside the functions that use it.
"""

from typing import no_type_check

import numba
import numpy as np

from export.meshing.diagonals import fits
from export.meshing.words import AXES, FIRST, ONE, ZERO, along, before, lowest, place
from trees.kernels import popcount

SPREAD = np.uint64(0x9E3779B97F4A7C15)


@no_type_check
@numba.njit(cache=True)
def bases_of(rows, bases):
    """The number of the first vertex of each block."""
    total = 0
    for i in range(rows.shape[0]):
        bases[i] = total
        total += popcount(rows[i, 1])


@no_type_check
@numba.njit(cache=True)
def table_of(rows, slots):
    """A hash table of the blocks' keys, of `2^n` slots at first -1."""
    last = np.uint64(slots.size - 1)
    for i in range(rows.shape[0]):
        slot = (rows[i, 0] * SPREAD >> np.uint64(32)) & last
        while slots[slot] >= 0:
            slot = (slot + ONE) & last
        slots[slot] = i


@no_type_check
@numba.njit(cache=True, inline="always")
def found(rows, slots, key):
    """The block of a key, -1 where it has no corner on the boundary."""
    last = np.uint64(slots.size - 1)
    slot = (key * SPREAD >> np.uint64(32)) & last
    while slots[slot] >= 0:
        if rows[slots[slot], 0] == key:
            return np.int64(slots[slot])
        slot = (slot + ONE) & last
    return -1


@no_type_check
@numba.njit(cache=True)
def look_around(rows, bases, slots, i, numbers, masks):
    """First vertex and active corners of block i and of the blocks x, y, z before, at `x + 2 y + 4 z`."""
    key = rows[i, 0]
    numbers[0], masks[0] = bases[i], rows[i, 1]
    faces = rows[i, 3] | rows[i, 4] | rows[i, 5]
    for o in range(1, 7):
        wanted, other = faces, key
        for axis in range(3):
            if o >> axis & 1:
                wanted &= FIRST[axis]
                if wanted != ZERO:
                    other = before(other, axis)
        if wanted != ZERO:
            j = found(rows, slots, other)
            if j >= 0:
                numbers[o], masks[o] = bases[j], rows[j, 1]


@no_type_check
@numba.njit(cache=True, inline="always")
def number(numbers, masks, bit, at):
    """The vertex at corner `bit` of the block that `look_around` put at `at`."""
    return numbers[at] + popcount(masks[at] & ((ONE << bit) - ONE))


@no_type_check
@numba.njit(cache=True)
def squares_of(rows, bases, slots, i, numbers, masks, squares, kinds):
    """Writes the squares of block i, counter-clockwise from outside, and their kinds; returns how many.

    The kind is `bit + 64 axis`, `bit` being the highest corner, and 256 more if the filled cell is the lower
    one. The first corner is the lowest, the third the highest.
    """
    look_around(rows, bases, slots, i, numbers, masks)
    n = 0
    low = rows[i, 2]
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        along_u, along_v = np.uint64(AXES[u]), np.uint64(AXES[v])
        faces = rows[i, 3 + axis]
        while faces != ZERO:
            bit = np.uint64(lowest(faces))
            faces &= faces - ONE
            out = np.int64(low >> bit & ONE)
            # one before on u, and on v: in a block before where the coordinate is 0
            at_u = np.uint64(bit & along_u == ZERO) << np.uint64(u)
            at_v = np.uint64(bit & along_v == ZERO) << np.uint64(v)
            less_u, less_v = ((bit & along_u) - ONE) & along_u, ((bit & along_v) - ONE) & along_v
            rest = bit & ~(along_u | along_v)
            before_u = number(numbers, masks, less_u | bit & along_v | rest, at_u)
            before_v = number(numbers, masks, less_v | bit & along_u | rest, at_v)
            squares[n, 0] = number(numbers, masks, less_u | less_v | rest, at_u | at_v)
            squares[n, 1] = before_v if out else before_u
            squares[n, 2] = number(numbers, masks, bit, ZERO)
            squares[n, 3] = before_u if out else before_v
            kinds[n] = np.int64(bit) | axis << 6 | out << 8
            n += 1
    return n


@no_type_check
@numba.njit(cache=True)
def corners(rows, origin, pitch, vertices):
    """The places of the corners, `origin + pitch * corner`."""
    n = 0
    for i in range(rows.shape[0]):
        x, y, z = place(rows[i, 0], 0), place(rows[i, 0], 1), place(rows[i, 0], 2)
        active = rows[i, 1]
        while active != ZERO:
            bit = lowest(active)
            active &= active - ONE
            vertices[n, 0] = origin[0] + (x + along(bit, 0)) * pitch
            vertices[n, 1] = origin[1] + (y + along(bit, 1)) * pitch
            vertices[n, 2] = origin[2] + (z + along(bit, 2)) * pitch
            n += 1


@no_type_check
@numba.njit(cache=True)
def flat_triangles(rows, bases, slots, triangles):
    """Two triangles for each square, cut from the lowest corner to the highest."""
    numbers, masks = np.zeros(8, np.int64), np.zeros(8, np.uint64)
    squares, kinds = np.empty((192, 4), np.int64), np.empty(192, np.int64)
    t = 0
    for i in range(rows.shape[0]):
        for f in range(squares_of(rows, bases, slots, i, numbers, masks, squares, kinds)):
            a, c = squares[f, 0], squares[f, 2]
            triangles[t, 0], triangles[t, 1], triangles[t, 2] = a, squares[f, 1], c
            triangles[t + 1, 0], triangles[t + 1, 1], triangles[t + 1, 2] = a, c, squares[f, 3]
            t += 2


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
def means(rows, bases, slots, shares, vertices, counts):
    """At each vertex the mean of its squares' crossings, in cells; `shares` of none means half-way."""
    numbers, masks = np.zeros(8, np.int64), np.zeros(8, np.uint64)
    squares, kinds = np.empty((192, 4), np.int64), np.empty(192, np.int64)
    corner, crossing = np.empty(3, np.int64), np.empty(3)
    n = 0
    for i in range(rows.shape[0]):
        stand(rows, i, corner)
        for f in range(squares_of(rows, bases, slots, i, numbers, masks, squares, kinds)):
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
def chosen(rows, bases, slots, vertices, choice, margin):
    """For each square the corner its diagonal starts from, 0 or 1, or 2 for none: see `triangulate`.

    Returns how many are 2.
    """
    numbers, masks = np.zeros(8, np.int64), np.zeros(8, np.uint64)
    squares, kinds = np.empty((192, 4), np.int64), np.empty(192, np.int64)
    corner, centre, ring = np.empty(3, np.int64), np.empty(3), np.empty((4, 3))
    n, rounds = 0, 0
    for i in range(rows.shape[0]):
        stand(rows, i, corner)
        for f in range(squares_of(rows, bases, slots, i, numbers, masks, squares, kinds)):
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
def bent_triangles(rows, bases, slots, shares, choice, centre, vertices, triangles):
    """Two triangles for a square with a diagonal, else four around its crossing, the next vertex from
    `centre` on."""
    numbers, masks = np.zeros(8, np.int64), np.zeros(8, np.uint64)
    squares, kinds = np.empty((192, 4), np.int64), np.empty(192, np.int64)
    corner, crossing = np.empty(3, np.int64), np.empty(3)
    n, t = 0, 0
    for i in range(rows.shape[0]):
        stand(rows, i, corner)
        for f in range(squares_of(rows, bases, slots, i, numbers, masks, squares, kinds)):
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
