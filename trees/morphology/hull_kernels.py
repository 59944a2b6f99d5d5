"""The inner loops of convex hulls. Imported inside the functions that use it."""

from typing import no_type_check

import numba
import numpy as np

from trees.kernels import FULL, LOW, ZERO, put
from trees.morphology.kernels import put_tile


@no_type_check
@numba.njit(cache=True)
def hull_row(normals, limits, corner, edge, row):
    """The cells of a row of a tile with `normals x <= limits`, as a word."""
    k = corner.size
    low, high = np.int64(0), np.int64(edge - 1)
    for f in range(limits.size):
        left, rest = limits[f] - normals[f, k - 1] * corner[k - 1], row
        for axis in range(k - 2, -1, -1):
            left -= normals[f, axis] * (corner[axis] + rest % edge)
            rest //= edge
        c = normals[f, k - 1]
        if c > 0:
            high = min(high, left // c)
        elif c < 0:
            low = max(low, -(left // -c))
        elif left < 0:
            return ZERO
        if low > high:
            return ZERO
    return (FULL << np.uint64(low)) & (FULL >> (LOW - np.uint64(high)))


@no_type_check
@numba.njit(cache=True)
def hull_tiles(normals, limits, tiles, corners, edge, count, shift, layout, bricks):
    """Bricks of the tiles, in rising order, filled with the cells with `normals x <= limits`."""
    swaps, base, begin, parts, width = layout
    k = normals.shape[1]
    rows = np.zeros(count, np.uint64)
    starts = np.empty(tiles.size * (base.size + 1) + 1, np.uint64)
    words = np.empty(starts.size, np.uint64)
    some_normals, some_limits = np.empty_like(normals), np.empty_like(limits)
    n, after = 0, ZERO
    for i in range(tiles.size):
        cutting = 0
        for f in range(limits.size):
            most = np.int64(0)
            for axis in range(k):
                c = normals[f, axis]
                most += c * corners[i, axis] + max(c * (edge - 1), 0)
            if most > limits[f]:
                some_normals[cutting] = normals[f]
                some_limits[cutting] = limits[f]
                cutting += 1
        for row in range(count):
            rows[row] = hull_row(some_normals[:cutting], some_limits[:cutting], corners[i], edge, row)
        first = tiles[i] << shift
        if first > after:
            n = put(starts, words, n, after, ZERO)
        n = put_tile(rows, first, swaps, base, begin, parts, width, starts, words, n)
        after = first + np.uint64(base.size)
    if after < bricks:
        n = put(starts, words, n, after, ZERO)
    return starts[:n].copy(), words[:n].copy()
