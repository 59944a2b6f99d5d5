"""All nodes of equal size that meet around a corner, an edge or a face, in one walk down the tree.

A tuple crosses some axes: it has `2^n` nodes, for n crossed axes, one on each side of each. The halves of its
nodes form a tuple that crosses the same axes where the halved axis is among them, else two of these and one
that crosses the halved axis too. Every tuple of equal nodes comes once. An entry is a run of equal words from
`starts[i]` to before `ends[i]`, the white ones left out.
"""

from typing import no_type_check

import numba
import numpy as np

from trees.kernels import popcount
from trees.topology.pair_kernels import first_from
from trees.topology.word_kernels import ONE, ZERO, ahead, has


@no_type_check
@numba.njit(cache=True)
def begin(entries, top, dimension, most, outside):
    """The stack of the walk: the root, and, with `outside`, all tuples of the root and white cubes around it.

    A frame is `(level, crossed axes in the order in which they came, nodes)`.
    """
    around = 3**dimension if outside else 1
    room, width = 2 * (top + 1) + around + 1, 2**most
    spans, keys = np.zeros((room, width, 2), np.int64), np.zeros((room, width), np.uint64)
    axes, shape = np.zeros((room, dimension + 1), np.int64), np.zeros((room, 2), np.int64)
    for code in range(around):
        n, own, rest = 0, 0, code
        for axis in range(dimension):
            if rest % 3 > 0:
                axes[code, n] = axis
                own |= (rest % 3 - 1) << n
                n += 1
            rest //= 3
        shape[code, 0], shape[code, 1] = top, n
        spans[code, own, 1] = entries
    return spans, keys, axes, shape, around


@no_type_check
@numba.njit(cache=True)
def halved(starts, ends, spans, keys, n, node, level, m, place, upper):
    """Writes a half of a node of frame n as node `place` of frame m."""
    lo, hi, key = spans[n, node, 0], spans[n, node, 1], keys[n, node]
    middle = key | (ONE << np.uint64(level))
    if lo < hi and not (hi - lo == 1 and starts[lo] <= key and ends[lo] - key >= ONE << np.uint64(level + 1)):
        first = first_from(starts, lo, hi, middle)
        if not upper:
            hi = first
        else:
            lo = first - 1 if first > lo and ends[first - 1] > middle else first
    spans[m, place, 0], spans[m, place, 1] = lo, hi
    keys[m, place] = middle if upper else key


@no_type_check
@numba.njit(cache=True)
def tuples(starts, ends, top, low, dimension, most, every, spans, keys, axes, shape, n):
    """Yields the number of a frame of the stack whose nodes are each white or within one entry.

    Tuples cross at most `most` axes. With `every`, tuples with a white node are left out, without it those of
    white nodes alone.
    """
    while n > 0:
        n -= 1
        level, crossed = shape[n, 0], shape[n, 1]
        size = 1 << crossed
        black, whole = 0, True
        for node in range(size):
            lo, hi = spans[n, node, 0], spans[n, node, 1]
            if lo < hi:
                black += 1
                end = keys[n, node] + ((ONE << np.uint64(level)) - ONE)
                whole = whole and starts[lo] <= keys[n, node] and ends[lo] > end
        if black == 0 or (every and black < size):
            continue
        if whole:
            yield n
            continue
        level -= 1
        axis = dimension - 1 - (low + level) % dimension
        place = -1
        for j in range(crossed):
            if axes[n, j] == axis:
                place = j
        # The frames after n are made first, and that in place of n last.
        if place >= 0:
            shape[n, 0] = level
            for node in range(size):
                upper = (node >> place) & 1 == 0
                halved(starts, ends, spans, keys, n, node, level, n, node, upper)
            n += 1
            continue
        last = n + 2 if crossed < most else n + 1
        for frame in range(n + 1, last + 1):
            shape[frame, 0], shape[frame, 1] = level, crossed
            axes[frame] = axes[n]
        for node in range(size):
            halved(starts, ends, spans, keys, n, node, level, n + 1, node, True)
            if crossed < most:
                halved(starts, ends, spans, keys, n, node, level, n + 2, node, False)
                halved(starts, ends, spans, keys, n, node, level, n + 2, node | size, True)
        if crossed < most:
            shape[n + 2, 1], axes[n + 2, crossed] = crossed + 1, axis
        for node in range(size):
            halved(starts, ends, spans, keys, n, node, level, n, node, False)
        shape[n, 0] = level
        n = last + 1


@no_type_check
@numba.njit(cache=True)
def across_faces(starts, ends, words, top, low, lay):
    """`counts[a, m]` times `2^m`, summed over m, are the pairs of black cells that touch across axis a."""
    dimension = lay.steps.size
    counts = np.zeros((dimension, top + 1), np.int64)
    spans, keys, axes, shape, n = begin(starts.size, top, dimension, 1, False)
    for f in tuples(starts, ends, top, low, dimension, 1, True, spans, keys, axes, shape, n):
        level = shape[f, 0]
        word = words[spans[f, 0, 0]]
        if shape[f, 1] == 1:
            axis = axes[f, 0]
            touching = (word >> lay.high[axis]) & lay.low[axis] & words[spans[f, 1, 0]]
            counts[axis, level - along(axis, level, low, dimension)] += popcount(touching)
            continue
        for axis in range(dimension):
            own = along(axis, level, low, dimension)
            counts[axis, level] += popcount(word & ahead(word, axis, lay))
            if own > 0:
                touching = popcount((word >> lay.high[axis]) & lay.low[axis] & word)
                counts[axis, level] += touching
                counts[axis, level - own] -= touching
    return counts


@no_type_check
@numba.njit(cache=True)
def along(axis, level, low, dimension):
    """How many of the levels below this one halve the axis."""
    first = (dimension - 1 - axis - low) % dimension
    return (level - first + dimension - 1) // dimension if level > first else 0


@no_type_check
@numba.njit(cache=True)
def alternating(starts, ends, words, top, low, closed, lay):
    """The alternating sum, modulo 2^64, of the cells of the complex, by their dimensions.

    The complex has the black cells and their faces where `closed`; else its vertices are the black
    cells, its edges pairs of them across a face, and so on.
    """
    dimension = lay.steps.size
    total = np.int64(0)
    spans, keys, axes, shape, n = begin(starts.size, top, dimension, dimension, closed)
    room = 3**dimension
    found, weights = np.empty(room, np.uint64), np.empty(room, np.int64)
    walk = tuples(starts, ends, top, low, dimension, dimension, not closed, spans, keys, axes, shape, n)
    for f in walk:
        level, crossed = shape[f, 0], shape[f, 1]
        full, sign = True, np.int64(-1 if (dimension - crossed if closed else crossed) % 2 == 1 else 1)
        for node in range(1 << crossed):
            white = spans[f, node, 0] >= spans[f, node, 1]
            full = full and (white or words[spans[f, node, 0]] == lay.full)
        if full:
            total += sign
            continue
        corner = ZERO if closed else lay.full
        flags = ZERO
        for node in range(1 << crossed):
            white = spans[f, node, 0] >= spans[f, node, 1]
            word = ZERO if white else words[spans[f, node, 0]]
            for j in range(crossed):
                axis = axes[f, j]
                flags |= ONE << np.uint64(axis)
                if (node >> j) & 1 == 0:
                    word >>= lay.high[axis]
                word &= lay.low[axis]
            corner = corner | word if closed else corner & word
        found[0], weights[0] = corner, sign
        pieces = 1
        for axis in range(dimension):
            if has(flags, axis):
                continue
            times = np.int64(1) << along(axis, level, low, dimension)
            wide = lay.steps[axis] > 0
            m = pieces
            for i in range(pieces):
                word, weight = found[i], weights[i]
                weights[i] = weight * times
                if wide:
                    if closed:
                        found[m] = (word | ahead(word, axis, lay)) & lay.inner[axis]
                    else:
                        found[m] = word & ahead(word, axis, lay)
                    weights[m] = -weight * times
                    m += 1
                if times > 1:
                    beyond = (word >> lay.high[axis]) & lay.low[axis]
                    here = word & lay.low[axis]
                    found[m] = beyond | here if closed else beyond & here
                    weights[m] = -weight * (times - 1)
                    m += 1
            pieces = m
        for i in range(pieces):
            total += weights[i] * popcount(found[i])
    return total
