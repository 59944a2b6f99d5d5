"""Words of 4 x 4 x 4 cells: the eight octants around each corner of a brick, and where they touch.

Bit `32 x1 + 16 y1 + 8 z1 + 4 x0 + 2 y0 + z0` of a word is the cell `(2 x1 + x0, 2 y1 + y0, 2 z1 + z0)` of its
brick, and also the corner of the grid at the low end of that cell. Octant `x + 2 y + 4 z` of a corner is the
cell on its `x`, `y`, `z` side (0 low, 1 high). Imported inside the functions that use it.
"""

from typing import no_type_check

import numba
import numpy as np

from trees.kernels import popcount

ZERO = np.uint64(0)
ONE = np.uint64(1)
FULL = np.uint64(0xFFFFFFFFFFFFFFFF)
NEAR = (4, 2, 1)  # how far the next cell lies on each axis if the low bit is free, else
FAR = (28, 14, 7)
BACK = (36, 18, 9)  # from the last cell of an axis to its first
AXES = (36, 18, 9)  # the bits of each axis in the index of a cell


def _cells() -> list[tuple[int, int, int]]:
    """The coordinates of each cell of a brick."""
    x, y, z = ([(b >> (2 - a) & 1) + 2 * (b >> (5 - a) & 1) for b in range(64)] for a in range(3))
    return list(zip(x, y, z, strict=True))


CELLS = _cells()


def _masks(wanted: int) -> tuple[np.uint64, ...]:
    """For each axis the cells whose coordinate is `wanted`."""
    cells = [[b for b in range(64) if CELLS[b][axis] == wanted] for axis in range(3)]
    return tuple(np.uint64(sum(1 << b for b in some)) for some in cells)


FIRST, SECOND, THIRD, LAST = (_masks(coordinate) for coordinate in range(4))
EVEN = tuple(first | third for first, third in zip(FIRST, THIRD, strict=True))


@no_type_check
@numba.njit(cache=True, inline="always")
def lowest(word):
    """The number of the lowest bit that is set."""
    return popcount((word & (~word + ONE)) - ONE)


@no_type_check
@numba.njit(cache=True, inline="always")
def behind(own, low, axis):
    """Cell x of the result is cell x - 1 on the axis, that of brick `low` for the first ones."""
    near, far, back = np.uint64(NEAR[axis]), np.uint64(FAR[axis]), np.uint64(BACK[axis])
    inside = ((own & EVEN[axis]) << near) | ((own & SECOND[axis]) << far)
    return inside | ((low & LAST[axis]) >> back)


@no_type_check
@numba.njit(cache=True)
def spread(words):
    """In place: from a brick and its low neighbours to the eight octants of the brick's corners.

    At first, word `x + 2 y + 4 z` is the brick x, y, z bricks before; then bit b of word o is octant o of
    corner b.
    """
    for axis in range(3):
        step = 1 << axis
        for i in range(8):
            if i & step == 0:
                own, low = words[i], words[i | step]
                words[i | step] = own
                words[i] = behind(own, low, axis)


@no_type_check
@numba.njit(cache=True, inline="always")
def checkered(octants, axis, side):
    """The corners whose edge on this side of the axis has two cells of a colour on either diagonal."""
    u, v = 1 << (axis + 1) % 3, 1 << (axis + 2) % 3
    at = side << axis
    p, q, r, t = octants[at], octants[at | u], octants[at | v], octants[at | u | v]
    return (p ^ q) & (p ^ r) & ~(p ^ t)


@no_type_check
@numba.njit(cache=True)
def opposite(octants):
    """The corners at which two opposite octants, and these alone, are filled or empty."""
    found = ZERO
    for i in range(4):
        both, none = octants[i] & octants[7 - i], octants[i] | octants[7 - i]
        some, every = ZERO, FULL
        for j in range(4):
            if j != i:
                some |= octants[j] | octants[7 - j]
                every &= octants[j] & octants[7 - j]
        found |= (both & ~some) | (~none & every)
    return found


@no_type_check
@numba.njit(cache=True)
def touching(octants):
    """The corners at which two sheets of the boundary touch, here or along an edge."""
    found = opposite(octants)
    for axis in range(3):
        found |= checkered(octants, axis, 0) | checkered(octants, axis, 1)
    return found


@no_type_check
@numba.njit(cache=True, inline="always")
def code_at(octants, bit):
    """The code of a corner: bit o is octant o."""
    code = 0
    for octant in range(8):
        code |= np.int64((octants[octant] >> np.uint64(bit)) & ONE) << octant
    return code


@no_type_check
@numba.njit(cache=True, inline="always")
def along(bit, axis):
    """The coordinate of cell `bit` on an axis."""
    return (bit >> (2 - axis) & 1) | (bit >> (5 - axis) & 1) << 1


@no_type_check
@numba.njit(cache=True)
def place(key, axis):
    """The coordinate of the first cell of a block, on an axis, from its Morton key."""
    key = key >> np.uint64(2 - axis) & np.uint64(0x1249249249249249)
    key = (key | key >> np.uint64(2)) & np.uint64(0x10C30C30C30C30C3)
    key = (key | key >> np.uint64(4)) & np.uint64(0x100F00F00F00F00F)
    key = (key | key >> np.uint64(8)) & np.uint64(0x001F0000FF0000FF)
    key = (key | key >> np.uint64(16)) & np.uint64(0x001F00000000FFFF)
    key = (key | key >> np.uint64(32)) & np.uint64(0x00000000001FFFFF)
    return np.int64(key) << 2


@no_type_check
@numba.njit(cache=True, inline="always")
def before(key, axis):
    """The key of the block one before on the axis, for coordinates above 0."""
    mask = np.uint64(0x4924924924924924 >> axis)
    return (((key & mask) - ONE) & mask) | (key & ~mask)
