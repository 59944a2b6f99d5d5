"""Parts of pieces, joined to components."""

from typing import no_type_check

import numba
import numpy as np

from trees.kernels import popcount
from trees.topology.pair_kernels import pairs
from trees.topology.word_kernels import ONE, ZERO, across, behind, beside, filled, has


@no_type_check
@numba.njit(cache=True)
def most_parts(words, lay):
    """A bound on the number of parts: every part has a cell without a neighbour before it on any axis."""
    total = 0
    for i in range(words.size):
        word = words[i]
        if word == lay.full:
            total += 1
            continue
        corners = word
        for axis in range(lay.steps.size):
            corners &= ~behind(word, axis, lay)
        total += popcount(corners)
    return total


@no_type_check
@numba.njit(cache=True)
def part_masks(words, room, box, lay):
    """`(offsets, masks)`: the parts of word i are the masks from `offsets[i]` to before `offsets[i + 1]`."""
    offsets = np.empty(words.size + 1, np.int32)
    masks = np.empty(room, np.uint64)
    n = 0
    for i in range(words.size):
        offsets[i] = n
        rest = words[i]
        if rest == lay.full:
            masks[n] = rest
            n += 1
            continue
        several = rest if box else beside(rest, lay)
        while rest != ZERO:
            seed = rest & (~rest + ONE)
            part = seed if seed & several == ZERO else filled(seed, rest, box, lay)
            masks[n] = part
            n += 1
            rest ^= part
    offsets[words.size] = n
    return offsets, masks[:n]


@no_type_check
@numba.njit(cache=True, inline="always")
def root(parents, i):
    while parents[i] != i:
        parents[i] = parents[parents[i]]
        i = parents[i]
    return i


@no_type_check
@numba.njit(cache=True, inline="always")
def join(parents, i, j):
    i, j = root(parents, i), root(parents, j)
    if i < j:
        parents[j] = i
    elif j < i:
        parents[i] = j


@no_type_check
@numba.njit(cache=True, inline="always")
def meet(parents, i, j, plus, minus, words, offsets, masks, box, lay):
    """Joins the parts of pieces i and j that touch across a side."""
    a, b = offsets[i], offsets[j]
    if words[i] == lay.full and words[j] == lay.full:
        join(parents, a, b)
        return
    if a + 1 == offsets[i + 1] and b + 1 == offsets[j + 1] and root(parents, a) == root(parents, b):
        return
    if box:
        for part in range(a, offsets[i + 1]):
            touched = across(masks[part], plus, minus, True, lay) & words[j]
            if touched != ZERO:
                join_touched(parents, part, touched, b, offsets[j + 1], masks)
        return
    axis = 0
    while not has(plus | minus, axis):
        axis += 1
    shift, low, forward = lay.high[axis], lay.low[axis], plus != ZERO
    touching = words[j] & (low if forward else low << shift)
    for part in range(a, offsets[i + 1]):
        touched = (masks[part] >> shift if forward else masks[part] << shift) & touching
        if touched != ZERO:
            join_touched(parents, part, touched, b, offsets[j + 1], masks)


@no_type_check
@numba.njit(cache=True, inline="always")
def join_touched(parents, part, touched, first, stop, masks):
    """Joins a part with those from first to before stop that have touched cells."""
    for other in range(first, stop):
        if touched & masks[other] != ZERO:
            join(parents, part, other)
            touched &= ~masks[other]
            if touched == ZERO:
                break


@no_type_check
@numba.njit(cache=True)
def joined(starts, words, levels, top, low, offsets, masks, box, lay):
    """For each part the first part of its component, by a walk down the tree."""
    parents = np.arange(masks.size).astype(np.int32)
    walk = pairs(starts, levels, top, low, lay.steps.size, box, False, 0)
    for i, j, _key, _key2, _level, plus, minus in walk:
        meet(parents, i, j, plus, minus, words, offsets, masks, box, lay)
    for i in range(parents.size):
        parents[i] = parents[parents[i]]
    return parents


@no_type_check
@numba.njit(cache=True)
def axis_bits(top, low, dimension):
    """The bits of each axis in the number of a brick."""
    bits = np.zeros(dimension, np.uint64)
    for level in range(top):
        bits[dimension - 1 - (low + level) % dimension] |= ONE << np.uint64(level)
    return bits


@no_type_check
@numba.njit(cache=True)
def half_of_directions(dimension, box):
    """One of each two opposite directions, as `(plus, minus)`: that which goes back on its first axis."""
    total = (3**dimension - 1) // 2 if box else dimension
    found = np.zeros((total, 2), np.uint64)
    n = 0
    for first in range(dimension):
        for code in range(3 ** (dimension - 1 - first) if box else 1):
            found[n, 1] = ONE << np.uint64(first)
            rest = code
            for axis in range(first + 1, dimension):
                if rest % 3 > 0:
                    found[n, rest % 3 - 1] |= ONE << np.uint64(axis)
                rest //= 3
            n += 1
    return found


@no_type_check
@numba.njit(cache=True)
def joined_dense(starts, words, levels, top, low, offsets, masks, box, lay):
    """`joined`, by a table of all bricks, for sets that fill much of the cube."""
    dimension = lay.steps.size
    parents = np.arange(masks.size).astype(np.int32)
    owner = np.full(1 << top, -1, np.int32)
    for i in range(starts.size):
        first = np.int64(starts[i])
        owner[first : first + (1 << np.int64(levels[i]))] = i
    bits, around = axis_bits(top, low, dimension), half_of_directions(dimension, box)
    for brick in range(owner.size):
        i = owner[brick]
        if i < 0:
            continue
        for direction in range(around.shape[0]):
            plus, minus = around[direction, 0], around[direction, 1]
            key, inside = np.uint64(brick), True
            for axis in range(dimension):
                own = bits[axis]
                if has(plus, axis):
                    inside = inside and key & own != own
                    key = (((key | ~own) + ONE) & own) | (key & ~own)
                elif has(minus, axis):
                    inside = inside and key & own != ZERO
                    key = (((key & own) - ONE) & own) | (key & ~own)
            if not inside:
                continue
            j = owner[key]
            if j >= 0 and j != i:
                meet(parents, i, j, plus, minus, words, offsets, masks, box, lay)
    for i in range(parents.size):
        parents[i] = parents[parents[i]]
    return parents


@no_type_check
@numba.njit(cache=True)
def measured(parents, levels, offsets, masks):
    """Numbers the components in order of their first parts, in place of the parents; returns their sizes."""
    total = 0
    for i in range(parents.size):
        total += parents[i] == i
    sizes = np.zeros(total, np.uint64)
    n = 0
    for piece in range(levels.size):
        for i in range(offsets[piece], offsets[piece + 1]):
            if parents[i] == i:
                parents[i] = n
                n += 1
            else:
                parents[i] = parents[parents[i]]
            sizes[parents[i]] += np.uint64(popcount(masks[i])) << np.uint64(levels[piece])
    return sizes


@no_type_check
@numba.njit(cache=True)
def renumber(labels, numbers):
    """Puts the new numbers in place of the labels."""
    for i in range(labels.size):
        labels[i] = numbers[labels[i]]


@no_type_check
@numba.njit(cache=True)
def at_border(starts, levels, top, low, offsets, masks, labels, total, lay):
    """Which components have a cell on the border of the cube."""
    touching = np.zeros(total, np.bool_)
    all_bits = axis_bits(top, low, lay.steps.size)
    for axis in range(lay.steps.size):
        bits = all_bits[axis]
        for piece in range(levels.size):
            first = starts[piece]
            last = first | ((ONE << np.uint64(levels[piece])) - ONE)
            for i in range(offsets[piece], offsets[piece + 1]):
                before = first & bits == ZERO and masks[i] & lay.low[axis] != ZERO
                after = last & bits == bits and (masks[i] >> lay.high[axis]) & lay.low[axis] != ZERO
                if before or after:
                    touching[labels[i]] = True
    return touching


@no_type_check
@numba.njit(cache=True)
def labels_of_keys(keys, low, starts, levels, offsets, masks, labels):
    """The labels of the components of these cells, -1 for white ones."""
    found = np.full(keys.size, -1, np.int64)
    for n in range(keys.size):
        brick = keys[n] >> np.uint64(6)
        bit = ONE << (keys[n] & np.uint64(63))
        i = np.searchsorted(starts, brick, side="right") - 1
        if i < 0 or brick - starts[i] >= ONE << np.uint64(levels[i]):
            continue
        for part in range(offsets[i], offsets[i + 1]):
            if masks[part] & bit != ZERO:
                found[n] = labels[part]
                break
    return found


@no_type_check
@numba.njit(cache=True)
def chosen_words(offsets, masks, labels, wanted):
    """The words of the pieces, with the parts of the wanted components alone."""
    words = np.zeros(offsets.size - 1, np.uint64)
    for i in range(words.size):
        for part in range(offsets[i], offsets[i + 1]):
            if labels[part] >= 0 and wanted[labels[part]]:
                words[i] |= masks[part]
    return words
