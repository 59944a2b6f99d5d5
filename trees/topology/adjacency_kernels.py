"""Pairs of leaves that touch, as arrays."""

from typing import no_type_check

import numba
import numpy as np

from trees.topology.pair_kernels import pairs


@no_type_check
@numba.njit(cache=True)
def count_adjacent(starts, levels, top, dimension, box):
    """How many pairs `adjacent` writes."""
    total = 0
    for _pair in pairs(starts, levels, top, 0, dimension, box, False, 0):
        total += 1
    return total


@no_type_check
@numba.njit(cache=True)
def adjacent(starts, levels, top, dimension, box, total):
    """The pairs, the smaller number first."""
    found = np.empty((total, 2), np.int64)
    walk = pairs(starts, levels, top, 0, dimension, box, False, 0)
    for n, (i, j, _key, _key2, _level, _plus, _minus) in enumerate(walk):
        found[n, 0], found[n, 1] = min(i, j), max(i, j)
    return found
