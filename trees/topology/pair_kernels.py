"""All pairs of pieces that touch, in one walk down the tree with two nodes at a time.

A piece is an aligned block of `2^level` units from unit `start`; pieces are sorted and disjoint. The walk is
that of Guye 1988, V.1, on the binary tree: the halves of a node touch across the axis that is halved; halves
of two nodes that touch across some axes touch across the same ones, and, for d-infinity, also across the axis
that is halved. Every pair of nodes of equal size comes once.
"""

from typing import no_type_check

import numba
import numpy as np

from trees.topology.word_kernels import ONE, ZERO, has


@no_type_check
@numba.njit(cache=True, inline="always")
def first_from(starts, lo, hi, key):
    """The first of the pieces lo to before hi that starts at the key or later; hi where none does."""
    while lo < hi:
        mid = (lo + hi) >> 1
        if starts[mid] < key:
            lo = mid + 1
        else:
            hi = mid
    return lo


@no_type_check
@numba.njit(cache=True, inline="always")
def push(nodes, flags, n, lo, hi, key, lo2, hi2, key2, level, plus, minus):
    nodes[n, 0], nodes[n, 1], nodes[n, 2], nodes[n, 3], nodes[n, 4] = lo, hi, lo2, hi2, level
    flags[n, 0], flags[n, 1], flags[n, 2], flags[n, 3] = key, key2, plus, minus
    return n + 1


@no_type_check
@numba.njit(cache=True)
def begin(pieces, top, dimension, outside):
    """The stack of the walk: the root, and, with `outside`, the root beside each white cube around it."""
    around = 3**dimension - 1 if outside == 2 else 2 * dimension
    room = 4 * (top + 2) + (around if outside > 0 else 0)
    nodes, flags = np.empty((room, 5), np.int64), np.empty((room, 4), np.uint64)
    n = push(nodes, flags, 0, 0, pieces, ZERO, -1, -1, ZERO, top, ZERO, ZERO)
    if outside == 1:
        for axis in range(dimension):
            bit = ONE << np.uint64(axis)
            n = push(nodes, flags, n, 0, pieces, ZERO, 0, 0, ZERO, top, bit, ZERO)
            n = push(nodes, flags, n, 0, pieces, ZERO, 0, 0, ZERO, top, ZERO, bit)
    elif outside == 2:
        for code in range(1, 3**dimension):
            plus, minus, rest = ZERO, ZERO, code
            for axis in range(dimension):
                if rest % 3 == 1:
                    plus |= ONE << np.uint64(axis)
                elif rest % 3 == 2:
                    minus |= ONE << np.uint64(axis)
                rest //= 3
            n = push(nodes, flags, n, 0, pieces, ZERO, 0, 0, ZERO, top, plus, minus)
    return nodes, flags, n


@no_type_check
@numba.njit(cache=True)
def pairs(starts, levels, top, low, dimension, box, white, outside):
    """Yields `(i, j, key, key2, level, plus, minus)`: pieces i and j touch, j lies further on `plus`.

    `top` is the level of the root, `low` how many levels of the tree are within a unit. Without
    `white`, pairs of pieces that touch in several places may be cut short, and none is missed. With it, all
    pairs of equal nodes come, and i or j is -1 where the node is white. `outside` sets the cubes around the
    root in: 0 none, 1 those across faces, 2 all.
    """
    nodes, flags, n = begin(starts.size, top, dimension, outside)
    while n > 0:
        n -= 1
        lo, hi, lo2, hi2, level = nodes[n, 0], nodes[n, 1], nodes[n, 2], nodes[n, 3], nodes[n, 4]
        key, key2, plus, minus = flags[n, 0], flags[n, 1], flags[n, 2], flags[n, 3]
        alone = lo2 < 0
        one, other = hi > lo, hi2 > lo2
        if alone and not (hi - lo > 1 or (white and one)):
            continue
        if not alone and not ((one and other) or (white and (one or other))):
            continue
        uniform = not one or levels[lo] >= level
        uniform2 = alone or not other or levels[lo2] >= level
        if uniform and uniform2:
            if not alone:
                yield (lo if one else -1), (lo2 if other else -1), key, key2, level, plus, minus
            continue
        level -= 1
        half = ONE << np.uint64(level)
        axis = dimension - 1 - (low + level) % dimension
        bit = ONE << np.uint64(axis)
        left, right = hi, lo
        if not uniform:
            left = first_from(starts, lo, hi, key | half)
            right = left
        if alone:
            n = push(nodes, flags, n, lo, left, key, right, hi, key | half, level, bit, ZERO)
            n = push(nodes, flags, n, right, hi, key | half, -1, -1, ZERO, level, ZERO, ZERO)
            n = push(nodes, flags, n, lo, left, key, -1, -1, ZERO, level, ZERO, ZERO)
            continue
        left2, right2 = hi2, lo2
        if not uniform2:
            left2 = first_from(starts, lo2, hi2, key2 | half)
            right2 = left2
        if has(plus, axis):
            n = push(nodes, flags, n, right, hi, key | half, lo2, left2, key2, level, plus, minus)
        elif has(minus, axis):
            n = push(nodes, flags, n, lo, left, key, right2, hi2, key2 | half, level, plus, minus)
        else:
            n = push(nodes, flags, n, lo, left, key, lo2, left2, key2, level, plus, minus)
            n = push(nodes, flags, n, right, hi, key | half, right2, hi2, key2 | half, level, plus, minus)
            if box and (white or not (uniform or uniform2)):
                n = push(nodes, flags, n, lo, left, key, right2, hi2, key2 | half, level, plus | bit, minus)
                n = push(nodes, flags, n, right, hi, key | half, lo2, left2, key2, level, plus, minus | bit)
