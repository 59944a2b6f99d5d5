"""Black cells that touch white ones, by words."""

from typing import no_type_check

import numba
import numpy as np

from trees.topology.pair_kernels import pairs
from trees.topology.word_kernels import ONE, ZERO, across, grown, has


@no_type_check
@numba.njit(cache=True)
def fixed_bits(plus, minus, level, low, dimension):
    """`(mask, value)`: the bits of the bricks of a node at its side towards `plus` and `minus`."""
    mask, value = ZERO, ZERO
    for n in range(level):
        axis = dimension - 1 - (low + n) % dimension
        if has(plus, axis):
            mask |= ONE << np.uint64(n)
            value |= ONE << np.uint64(n)
        elif has(minus, axis):
            mask |= ONE << np.uint64(n)
    return mask, value


@no_type_check
@numba.njit(cache=True)
def mark(i, key, level, plus, minus, touched, marks, levels, words, low, bricks, shell, n, lay):
    """Marks the cells of piece i, in the node from key, that touch white; returns how many are listed."""
    if levels[i] == 0:
        marks[i] |= touched & words[i]
        return n
    dimension = lay.steps.size
    mask, value = fixed_bits(plus, minus, level, low, dimension)
    free = ((ONE << np.uint64(level)) - ONE) & ~mask
    if bricks.size == 0:
        count = 1
        for bit in range(level):
            if (free >> np.uint64(bit)) & ONE == ONE:
                count *= 2
        return n + count
    part = ZERO
    while True:
        bricks[n], shell[n] = key | value | part, touched
        n += 1
        part = (part - free) & free
        if part == ZERO:
            return n


@no_type_check
@numba.njit(cache=True)
def boundary(starts, words, levels, top, low, box, outside, bricks, shell, lay):
    """`(marks, n)`: the boundary in each piece of one brick, and how many bricks of larger pieces have some.

    These go into `bricks` and `shell`, some several times; where `bricks` is empty they are only counted.
    """
    marks = np.zeros(words.size, np.uint64)
    for i in range(words.size):
        if words[i] != lay.full:
            marks[i] = words[i] & grown(~words[i] & lay.full, box, lay)
    n = 0
    walk = pairs(starts, levels, top, low, lay.steps.size, box, True, outside)
    for i, j, key, key2, level, plus, minus in walk:
        word = words[i] if i >= 0 else ZERO
        word2 = words[j] if j >= 0 else ZERO
        if i >= 0 and word2 != lay.full:
            touched = across(~word2 & lay.full, minus, plus, box, lay)
            if touched & word != ZERO:
                n = mark(
                    i, key, level, plus, minus, touched, marks, levels, words, low, bricks, shell, n, lay
                )
        if j >= 0 and word != lay.full:
            touched = across(~word & lay.full, plus, minus, box, lay)
            if touched & word2 != ZERO:
                n = mark(
                    j, key2, level, minus, plus, touched, marks, levels, words, low, bricks, shell, n, lay
                )
    return marks, n
