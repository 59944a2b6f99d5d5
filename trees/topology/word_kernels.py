"""Words moved by one cell, across faces, and filled from a cell."""

from typing import no_type_check

import numba
import numpy as np

ZERO = np.uint64(0)
ONE = np.uint64(1)


@no_type_check
@numba.njit(cache=True, inline="always")
def has(flags, axis):
    """Whether the bit of the axis is set."""
    return (flags >> np.uint64(axis)) & ONE == ONE


@no_type_check
@numba.njit(cache=True)
def ahead(word, axis, lay):
    """Cell x of the result is cell x + 1 on the axis, white beyond the word."""
    moved = ZERO
    for t in range(lay.steps[axis]):
        moved |= (word >> lay.shifts[axis, t]) & lay.masks[axis, t]
    return moved


@no_type_check
@numba.njit(cache=True)
def behind(word, axis, lay):
    """Cell x of the result is cell x - 1 on the axis, white before the word."""
    moved = ZERO
    for t in range(lay.steps[axis]):
        moved |= (word & lay.masks[axis, t]) << lay.shifts[axis, t]
    return moved


@no_type_check
@numba.njit(cache=True)
def beside(word, lay):
    """The cells of the word or around it that have a neighbour in it across a face."""
    result = ZERO
    for axis in range(lay.steps.size):
        result |= ahead(word, axis, lay) | behind(word, axis, lay)
    return result


@no_type_check
@numba.njit(cache=True)
def grown(word, box, lay):
    """The word and all neighbours of its cells within the word."""
    result = word
    for axis in range(lay.steps.size):
        source = result if box else word
        result |= ahead(source, axis, lay) | behind(source, axis, lay)
    return result


@no_type_check
@numba.njit(cache=True)
def filled(seed, word, box, lay):
    """The cells of the word that are joined to the seed within the word."""
    if lay.steps.size == 3 and lay.steps[0] == 2 and lay.steps[1] == 2 and lay.steps[2] == 2:
        return filled_cube(seed, word, box, lay)
    found = seed
    while True:
        before = found
        if box:
            found = grown(found, True, lay) & word
        else:
            for axis in range(lay.steps.size):
                found |= (ahead(found, axis, lay) | behind(found, axis, lay)) & word
        if found == before:
            return found


@no_type_check
@numba.njit(cache=True, inline="always")
def beside_in_cube(word, bit, single, carry):
    """The neighbours of the cells of a word of 4 x 4 x 4 on the axis whose levels are `bit` and `bit + 3`."""
    near, far = np.uint64(1 << bit), np.uint64(7 << bit)
    near_ones = ((word >> near) & single) | ((word & single) << near)
    return near_ones | ((word >> far) & carry) | ((word & carry) << far)


@no_type_check
@numba.njit(cache=True)
def filled_cube(seed, word, box, lay):
    """`filled` for words of 4 x 4 x 4 cells."""
    single, carry = lay.masks[2, 0], lay.masks[2, 1]
    single1, carry1 = lay.masks[1, 0], lay.masks[1, 1]
    single0, carry0 = lay.masks[0, 0], lay.masks[0, 1]
    keep = np.uint64(0xFFFFFFFFFFFFFFFF) if box else word
    found = seed
    while True:
        before = found
        found |= beside_in_cube(found, 0, single, carry) & keep
        found |= beside_in_cube(found, 1, single1, carry1) & keep
        found |= beside_in_cube(found, 2, single0, carry0) & keep
        found &= word
        if found == before:
            return found


@no_type_check
@numba.njit(cache=True)
def across(word, plus, minus, box, lay):
    """The cells, of the neighbouring word, that touch this word.

    That word lies one further on the axes of `plus` and one before on those of `minus`; with `box`,
    cells touch also if they lie one apart on the other axes.
    """
    for axis in range(lay.steps.size):
        if has(plus, axis):
            word = (word >> lay.high[axis]) & lay.low[axis]
        elif has(minus, axis):
            word = (word & lay.low[axis]) << lay.high[axis]
        elif box:
            word |= ahead(word, axis, lay) | behind(word, axis, lay)
    return word
