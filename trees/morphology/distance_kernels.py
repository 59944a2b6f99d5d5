"""The inner loops of distance transforms: rows laid out in an array, and one axis after the other.

Imported inside the functions that use it.
"""

from typing import no_type_check

import numba
import numpy as np

BLOCK = 16


@no_type_check
@numba.njit(cache=True)
def lay_out(store, slots, corners, edge, lows, shape, far, array):
    """`array` becomes 0 at black cells and `far` elsewhere, from the rows of tiles with these corners."""
    k = shape.size
    cell = np.zeros(k, np.int64)
    for i in range(slots.size):
        rows = store[slots[i]]
        begin = max(corners[i, k - 1] - lows[k - 1], 0)
        end = min(corners[i, k - 1] + edge - lows[k - 1], shape[k - 1])
        shift = lows[k - 1] - corners[i, k - 1]
        for row in range(rows.size):
            rest, inside, place = row, True, 0
            for axis in range(k - 2, -1, -1):
                cell[axis] = corners[i, axis] + rest % edge - lows[axis]
                rest //= edge
                inside = inside and 0 <= cell[axis] < shape[axis]
            if not inside:
                continue
            for axis in range(k - 1):
                place = place * shape[axis] + cell[axis]
            place *= shape[k - 1]
            word = rows[row]
            for z in range(begin, end):
                array[place + z] = far * (1 - np.int64((word >> np.uint64(z + shift)) & np.uint64(1)))


@no_type_check
@numba.njit(cache=True, inline="always")
def value(metric, x, i, g):
    """The distance of x from a place i where it is g on the axes before: squared, of d1, or of d-infinity."""
    if metric == 0:
        return (x - i) * (x - i) + g
    if metric == 1:
        return abs(x - i) + g
    return max(abs(x - i), g)


@no_type_check
@numba.njit(cache=True, inline="always")
def last_before(metric, i, u, g, h, far):
    """The last place that is as near to i, with g, as to u, with h, or nearer; `i < u`."""
    if metric == 0:
        return (u * u - i * i + h - g) // (2 * (u - i))
    if metric == 1:
        if h >= g + u - i:
            return far
        if g > h + u - i:
            return -far
        return (h - g + u + i) // 2
    if g <= h:
        return max(i + h, (i + u) // 2)
    return min(u - g, (i + u) // 2)


@no_type_check
@numba.njit(cache=True)
def one_axis(array, before, extent, after, metric, far):
    """The lower envelope along an axis of an array seen as (before, extent, after): Meijster's two scans."""
    lines = np.empty((BLOCK, extent), np.int64)
    place, begin = np.empty(extent, np.int64), np.empty(extent, np.int64)
    for outer in range(before):
        for first in range(0, after, BLOCK):
            count = min(BLOCK, after - first)
            base = outer * extent * after + first
            for x in range(extent):
                for j in range(count):
                    lines[j, x] = array[base + x * after + j]
            for j in range(count):
                g = lines[j]
                q = 0
                place[0], begin[0] = 0, 0
                for u in range(1, extent):
                    if g[u] >= far:
                        continue
                    while q >= 0 and value(metric, begin[q], place[q], g[place[q]]) > value(
                        metric, begin[q], u, g[u]
                    ):
                        q -= 1
                    if q < 0:
                        q = 0
                        place[0] = u
                    else:
                        w = 1 + last_before(metric, place[q], u, g[place[q]], g[u], far)
                        if w < extent:
                            q += 1
                            place[q], begin[q] = u, w
                for x in range(extent - 1, -1, -1):
                    here = value(metric, x, place[q], g[place[q]])
                    array[base + x * after + j] = min(here, far)
                    if x == begin[q]:
                        q -= 1
