"""Layers of trees as pictures, and the outlines of pictures.

A tree comes as bricks (starts and words) or as a shared binary tree (low and high children); both are walked
from the root, and a branch that does not meet the layer is not entered. A picture has a byte for each cell,
`picture[y - low_y, x - low_x]`.

Imported inside the functions that use it, for numba takes a while to load.
"""

from typing import no_type_check

import numba
import numpy as np

FULL = np.uint64(0xFFFFFFFFFFFFFFFF)
ONE = np.uint64(1)
DEPTH = 64 * 8


@no_type_check
@numba.njit(cache=True, inline="always")
def entry_of(starts, low, high, brick):
    """The entry from `low` to `high` that a brick is in."""
    while low < high:
        middle = (low + high + 1) // 2
        if starts[middle] <= brick:
            low = middle
        else:
            high = middle - 1
    return low


@no_type_check
@numba.njit(cache=True, inline="always")
def cell_of_bit(bit):
    """The place in its brick of a cell."""
    x = (bit >> 5 & 1) << 1 | (bit >> 2 & 1)
    y = (bit >> 4 & 1) << 1 | (bit >> 1 & 1)
    z = (bit >> 3 & 1) << 1 | (bit & 1)
    return x, y, z


@no_type_check
@numba.njit(cache=True)
def layer_of_bricks(starts, words, bits, z, low, picture):
    """Draw the cells of one z; the tree has 2 bits an axis at least."""
    stack = np.zeros((DEPTH, 6), np.int64)  # level, x, y, first brick, entries from, entries to
    stack[0, 5] = words.size - 1
    top = 1
    while top:
        top -= 1
        level, x, y, brick, first, last = stack[top]
        word = words[first]
        if first == last and word == 0:
            continue
        side = 1 << (bits - level)
        if first == last and word == FULL:
            picture[y - low[1] : y - low[1] + side, x - low[0] : x - low[0] + side] = 1
        elif side == 4:
            for bit in range(64):
                if word >> np.uint64(bit) & ONE:
                    dx, dy, dz = cell_of_bit(bit)
                    if dz == z & 3:
                        picture[y + dy - low[1], x + dx - low[0]] = 1
        else:
            half = side >> 1
            each = 1 << 3 * (bits - level - 3)
            for child in range(4):
                number = (child >> 1) << 2 | (child & 1) << 1 | (z & half > 0)
                begin = brick + number * each
                start = entry_of(starts, first, last, np.uint64(begin))
                stack[top, 0] = level + 1
                stack[top, 1] = x + (child >> 1) * half
                stack[top, 2] = y + (child & 1) * half
                stack[top, 3] = begin
                stack[top, 4] = start
                stack[top, 5] = entry_of(starts, start, last, np.uint64(begin + each - 1))
                top += 1


@no_type_check
@numba.njit(cache=True)
def layer_of_shared(lows, highs, root, bits, z, low, picture):
    """Draw the cells of one z."""
    stack = np.zeros((DEPTH, 4), np.int64)  # node, height, x, y
    stack[0] = root, 3 * bits, 0, 0
    top = 1
    while top:
        top -= 1
        node, height, x, y = stack[top]
        if node == 0:
            continue
        if node == 1:
            # halved on x first: x has as many levels left as y, or one fewer
            wide, high = 1 << height // 3, 1 << (height + 1) // 3
            picture[y - low[1] : y - low[1] + high, x - low[0] : x - low[0] + wide] = 1
            continue
        axis, step = 2 - (height - 1) % 3, 1 << (height - 1) // 3
        for side in range(2):
            if axis == 2 and side != (z & step > 0):
                continue
            stack[top, 0] = highs[node - 2] if side else lows[node - 2]
            stack[top, 1] = height - 1
            stack[top, 2] = x + (step * side if axis == 0 else 0)
            stack[top, 3] = y + (step * side if axis == 1 else 0)
            top += 1


@no_type_check
@numba.njit(cache=True, inline="always")
def widen(box, low, sides):
    """Take in a box of cells."""
    for axis in range(3):
        box[0, axis] = min(box[0, axis], low[axis])
        box[1, axis] = max(box[1, axis], low[axis] + sides[axis])


@no_type_check
@numba.njit(cache=True, inline="always")
def within(box, low, sides):
    """Whether a box of cells would change nothing."""
    found = True
    for axis in range(3):
        found &= low[axis] >= box[0, axis] and low[axis] + sides[axis] <= box[1, axis]
    return found


@no_type_check
@numba.njit(cache=True)
def box_of_bricks(starts, words, bits, box):
    """Widen a box to hold all black cells."""
    stack = np.zeros((DEPTH, 7), np.int64)  # level, x, y, z, first brick, entries from, entries to
    stack[0, 6] = words.size - 1
    low, sides = np.zeros(3, np.int64), np.ones(3, np.int64)
    top = 1
    while top:
        top -= 1
        level, x, y, z, brick, first, last = stack[top]
        side = 1 << (bits - level)
        low[0], low[1], low[2] = x, y, z
        sides[:] = side
        word = words[first]
        if (first == last and word == 0) or within(box, low, sides):
            continue
        if first == last and word == FULL:
            widen(box, low, sides)
        elif side == 4:
            sides[:] = 1
            for bit in range(64):
                if word >> np.uint64(bit) & ONE:
                    dx, dy, dz = cell_of_bit(bit)
                    low[0], low[1], low[2] = x + dx, y + dy, z + dz
                    widen(box, low, sides)
        else:
            half = side >> 1
            each = 1 << 3 * (bits - level - 3)
            for child in range(8):
                begin = brick + child * each
                start = entry_of(starts, first, last, np.uint64(begin))
                stack[top, 0] = level + 1
                stack[top, 1] = x + (child >> 2) * half
                stack[top, 2] = y + (child >> 1 & 1) * half
                stack[top, 3] = z + (child & 1) * half
                stack[top, 4] = begin
                stack[top, 5] = start
                stack[top, 6] = entry_of(starts, start, last, np.uint64(begin + each - 1))
                top += 1


@no_type_check
@numba.njit(cache=True)
def box_of_shared(lows, highs, root, bits, box):
    """Widen a box to hold all black cells."""
    stack = np.zeros((DEPTH, 5), np.int64)  # node, height, x, y, z
    stack[0] = root, 3 * bits, 0, 0, 0
    sides = np.zeros(3, np.int64)
    top = 1
    while top:
        top -= 1
        node, height = stack[top, 0], stack[top, 1]
        low = stack[top, 2:].copy()
        for axis in range(3):
            sides[axis] = 1 << (height + axis) // 3
        if node == 0 or within(box, low, sides):
            continue
        if node == 1:
            widen(box, low, sides)
            continue
        axis, step = 2 - (height - 1) % 3, 1 << (height - 1) // 3
        for side in range(2):
            stack[top, 0] = highs[node - 2] if side else lows[node - 2]
            stack[top, 1] = height - 1
            stack[top, 2:] = low
            stack[top, 2 + axis] += step * side
            top += 1


@no_type_check
@numba.njit(cache=True, inline="always")
def black(picture, row, column):
    """Whether a cell is set; the picture has a border of empty cells, which is not counted."""
    return picture[row + 1, column + 1] != 0


@no_type_check
@numba.njit(cache=True)
def corner_count(picture):
    """How many corners the outlines of a picture with an empty border have; two where cells touch at one."""
    count = 0
    for row in range(1, picture.shape[0]):
        for column in range(1, picture.shape[1]):
            a, b = picture[row - 1, column - 1] != 0, picture[row - 1, column] != 0
            c, d = picture[row, column - 1] != 0, picture[row, column] != 0
            ones = int(a) + int(b) + int(c) + int(d)
            if ones == 1 or ones == 3:
                count += 1
            elif ones == 2 and a == d:
                count += 2
    return count


@no_type_check
@numba.njit(cache=True)
def outlines(picture, count):
    """Corners (row, column) of all closed loops of a picture, one after the other, and how many each has.

    The picture has a border of empty cells, which is not counted. The set lies on the right of the way. A
    loop begins with its first side along a row, from left to right, and its sides lie along a row and along
    a column in turn. Cells that touch at a corner stay apart.
    """
    corners = np.zeros((count, 2), np.int32)
    sizes = np.zeros(count // 4 + 1, np.int64)
    seen = np.zeros(picture.shape, np.uint8)
    used, loops = 0, 0
    for first_row in range(picture.shape[0] - 2):
        for first_column in range(picture.shape[1] - 2):
            if seen[first_row, first_column] or not black(picture, first_row, first_column):
                continue
            if black(picture, first_row - 1, first_column):
                continue
            row, column, heading, begin = first_row, first_column, 0, used
            while True:
                corners[used, 0], corners[used, 1] = row, column
                used += 1
                while True:  # along one side
                    if heading == 0:
                        seen[row, column] = 1
                        column += 1
                        right, left = black(picture, row, column), black(picture, row - 1, column)
                    elif heading == 1:
                        row += 1
                        right, left = black(picture, row, column - 1), black(picture, row, column)
                    elif heading == 2:
                        column -= 1
                        right, left = black(picture, row - 1, column - 1), black(picture, row, column - 1)
                    else:
                        row -= 1
                        right, left = black(picture, row - 1, column), black(picture, row - 1, column - 1)
                    if not right or left:
                        break
                heading = (heading + 3) % 4 if right else (heading + 1) % 4
                if row == first_row and column == first_column and heading == 0:
                    break
            sizes[loops] = used - begin
            loops += 1
    return corners[:used], sizes[:loops]


@no_type_check
@numba.njit(cache=True)
def path(corners, sizes, across, across_ends, down, down_ends, out):
    """The loops as the text of an SVG path, from the texts of all columns and rows; the length."""
    at, corner = 0, 0
    for loop in range(sizes.size):
        for turn in range(sizes[loop]):
            row, column = corners[corner, 0], corners[corner, 1]
            corner += 1
            letter = 77 if turn == 0 else (72 if turn % 2 else 86)
            out[at] = letter
            at += 1
            if turn == 0 or turn % 2:
                for k in range(across_ends[column], across_ends[column + 1]):
                    out[at] = across[k]
                    at += 1
            if turn == 0:
                out[at] = 32
                at += 1
            if turn == 0 or turn % 2 == 0:
                for k in range(down_ends[row], down_ends[row + 1]):
                    out[at] = down[k]
                    at += 1
        out[at] = 90
        at += 1
    return at
