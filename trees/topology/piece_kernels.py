"""Entries of a tree cut into pieces, and bricks put together to entries."""

from typing import no_type_check

import numba
import numpy as np

from trees.topology.word_kernels import ONE, ZERO


@no_type_check
@numba.njit(cache=True)
def block_level(start, end):
    """The level of the largest aligned block from start that does not go beyond end."""
    level = 0
    while level < 63:
        size = ONE << np.uint64(level + 1)
        if start & (size - ONE) != ZERO or size > end - start:
            break
        level += 1
    return level


@no_type_check
@numba.njit(cache=True)
def count_pieces(starts, ends, words, full):
    """How many pieces `cut` makes, as a float, for there may be too many."""
    total = 0.0
    for i in range(starts.size):
        if words[i] == full:
            start = starts[i]
            while start < ends[i]:
                start += ONE << np.uint64(block_level(start, ends[i]))
                total += 1.0
        elif words[i] != ZERO:
            total += np.float64(ends[i] - starts[i])
    return total


@no_type_check
@numba.njit(cache=True)
def cut(starts, ends, words, full, total):
    """First bricks, words and levels of the pieces."""
    first, word = np.empty(total, np.uint64), np.empty(total, np.uint64)
    levels = np.zeros(total, np.uint8)
    n = 0
    for i in range(starts.size):
        if words[i] == ZERO:
            continue
        start = starts[i]
        while start < ends[i]:
            level = block_level(start, ends[i]) if words[i] == full else 0
            first[n], word[n], levels[n] = start, words[i], level
            start += ONE << np.uint64(level)
            n += 1
    return first, word, levels


@no_type_check
@numba.njit(cache=True)
def entries(first, words, levels, bricks):
    """Canonical starts and words of sorted pieces; words of one brick are united, white is put between."""
    starts, result = np.empty(2 * first.size + 1, np.uint64), np.empty(2 * first.size + 1, np.uint64)
    n, end, i = 0, ZERO, 0
    while i < first.size:
        start, word = first[i], words[i]
        stop = start + (ONE << np.uint64(levels[i]))
        i += 1
        while i < first.size and first[i] < stop:
            word |= words[i]
            i += 1
        if word == ZERO:
            continue
        if start > end and (n == 0 or result[n - 1] != ZERO):
            starts[n], result[n] = end, ZERO
            n += 1
        if n == 0 or result[n - 1] != word:
            starts[n], result[n] = start, word
            n += 1
        end = stop
    if end < bricks:
        starts[n], result[n] = end, ZERO
        n += 1
    return starts[:n].copy(), result[:n].copy()
