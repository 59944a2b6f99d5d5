"""The inner loops: cells of convex sets, images of trees, and depths along an axis.

All walk a target cube by halving one axis after the other and write the runs of its black cells in
Morton order. Imported inside the functions that use it, for numba takes a while to load.
"""

from typing import no_type_check

import numba
import numpy as np

ZERO = np.uint64(0)
ONE = np.uint64(1)
SIX = np.uint64(6)
LOW = np.uint64(63)
FULL = np.uint64(0xFFFFFFFFFFFFFFFF)


@no_type_check
@numba.njit(cache=True, inline="always")
def halved(corners, keys, depths, top, depth, k, step):
    """Put the halves of the box that stood at `top` on the stack, the low one uppermost; the new top."""
    key, d = keys[top], depths[top]
    for j in range(k):
        corners[top + 1, j] = corners[top, j]
    corners[top, d % k] += step
    keys[top], depths[top] = key | (ONE << np.uint64(depth - d - 1)), d + 1
    keys[top + 1], depths[top + 1] = key, d + 1
    return top + 2


@no_type_check
@numba.njit(cache=True, inline="always")
def advance(digits, sizes, k):
    """The next combination of k digits, the last one first; False after all of them."""
    j = k - 1
    while j >= 0:
        digits[j] += 1
        if digits[j] < sizes[j]:
            return True
        digits[j] = 0
        j -= 1
    return False


@no_type_check
@numba.njit(cache=True)
def emit(lows, highs, n, low, high):
    """Append a run, joined to the one before where it touches; the arrays double when they are full."""
    if n > 0 and highs[n - 1] + ONE == low:
        highs[n - 1] = high
        return lows, highs, n
    if n == lows.size:
        more = np.empty(2 * n, np.uint64)
        more[:n] = lows
        lows = more
        more = np.empty(2 * n, np.uint64)
        more[:n] = highs
        highs = more
    lows[n] = low
    highs[n] = high
    return lows, highs, n + 1


@no_type_check
@numba.njit(cache=True, inline="always")
def mask_of(free):
    """The word with this many low bits."""
    return ZERO if free == 0 else FULL >> np.uint64(64 - free)


@no_type_check
@numba.njit(cache=True)
def convex(normals, offsets, slack, k, bits, limit):
    """Runs of the cells of the unit cube with `normal . x <= offset + slack |normal|_1` somewhere, for all.

    A half-space that holds all of a box is not asked again inside it.
    """
    depth = k * bits
    m = offsets.size
    active = np.empty((depth + 1, m), np.int64)
    counts = np.zeros(depth + 1, np.int64)
    corners = np.zeros((depth + 2, k))
    keys = np.zeros(depth + 2, np.uint64)
    depths = np.zeros(depth + 2, np.int64)
    norms = np.zeros(m)
    for f in range(m):
        for j in range(k):
            norms[f] += abs(normals[f, j])
    edges = np.ones((depth + 1, k))
    for d in range(depth):
        edges[d + 1] = edges[d]
        edges[d + 1, d % k] *= 0.5
    lows, highs, n = np.empty(1024, np.uint64), np.empty(1024, np.uint64), 0
    top = 1
    while top > 0:
        top -= 1
        key, d = keys[top], depths[top]
        count, out = 0, False
        before = m if d == 0 else counts[d - 1]
        for i in range(before):
            f = i if d == 0 else active[d - 1, i]
            centre, reach = 0.0, 0.0
            for j in range(k):
                half = 0.5 * edges[d, j]
                centre += normals[f, j] * (corners[top, j] + half)
                reach += abs(normals[f, j]) * half
            bound = offsets[f] + slack * norms[f]
            if centre - reach > bound:
                out = True
                break
            if centre + reach > bound:
                active[d, count] = f
                count += 1
        if out:
            continue
        if count == 0 or d == depth:
            lows, highs, n = emit(lows, highs, n, key, key | mask_of(depth - d))
            if n > limit:
                break
            continue
        counts[d] = count
        top = halved(corners, keys, depths, top, depth, k, edges[d + 1, d % k])
    return lows[:n].copy(), highs[:n].copy()


@no_type_check
@numba.njit(cache=True)
def spread_table(k):
    """The bits of 0 to 255, k places apart."""
    table = np.zeros(256, np.uint64)
    for x in range(256):
        for bit in range(8):
            if (x >> bit) & 1 and bit * k < 64:
                table[x] |= ONE << np.uint64(bit * k)
    return table


@no_type_check
@numba.njit(cache=True, inline="always")
def spread(x, k, table):
    """The bits of a coordinate, k places apart."""
    key, shift = ZERO, 0
    while x > 0:
        key |= table[x & 255] << np.uint64(shift)
        x >>= 8
        shift += 8 * k
    return key


@no_type_check
@numba.njit(cache=True, inline="always")
def look(pyramid, level, key):
    """Whether the cell of this key is black at this level of the pyramid."""
    starts, words, first, table, rows, shifts = pyramid
    brick = key >> SIX
    block = rows[level] + np.int64(brick >> shifts[level])
    base = first[level]
    low, high = base + table[block], base + table[block + 1]
    while low < high:
        middle = (low + high + 1) >> 1
        if starts[middle] <= brick:
            low = middle
        else:
            high = middle - 1
    return (words[low] >> (key & LOW)) & ONE == ONE


@no_type_check
@numba.njit(cache=True)
def shifted(black, white, shift, k, bits, limit):
    """Runs of the cells x of the cube for which `x + shift` is black; all outside the cube is white."""
    depth = k * bits
    side = np.int64(1) << bits
    table = spread_table(k)
    corners = np.zeros((depth + 2, k), np.int64)
    keys = np.zeros(depth + 2, np.uint64)
    depths = np.zeros(depth + 2, np.int64)
    parts = np.zeros((k, 2), np.uint64)
    sizes, digits = np.zeros(k, np.int64), np.zeros(k, np.int64)
    lows, highs, n = np.empty(1024, np.uint64), np.empty(1024, np.uint64), 0
    top = 1
    while top > 0:
        top -= 1
        key, d = keys[top], depths[top]
        coarse = bits - d // k
        level = bits - coarse
        any_black, any_white, empty = False, False, False
        for j in range(k):
            edge = np.int64(1) << (bits - d // k - (1 if j < d % k else 0))
            a = corners[top, j] + shift[j]
            b = a + edge - 1
            if a < 0 or b >= side:
                any_white = True
            if b < 0 or a >= side:
                empty = True
                break
            a, b = max(a, 0) >> coarse, min(b, side - 1) >> coarse
            sizes[j] = b - a + 1
            digits[j] = 0
            for t in range(sizes[j]):
                parts[j, t] = spread(a + t, k, table) << np.uint64(k - 1 - j)
        if empty:
            continue
        while True:
            where = ZERO
            for j in range(k):
                where |= parts[j, digits[j]]
            if look(black, level, where):
                any_black = True
                any_white = any_white or look(white, level, where)
            else:
                any_white = True
            if any_black and any_white:
                break
            if not advance(digits, sizes, k):
                break
        if not any_black:
            continue
        if not any_white:
            lows, highs, n = emit(lows, highs, n, key, key | mask_of(depth - d))
            if n > limit:
                break
            continue
        top = halved(corners, keys, depths, top, depth, k, np.int64(1) << (bits - d // k - 1))
    return lows[:n].copy(), highs[:n].copy()


@no_type_check
@numba.njit(cache=True)
def depths(lows, highs, heights, upwards, missing, columns):
    """The least (or, downwards, greatest) of the heights of the runs of columns over each column."""
    found = np.full(columns, missing)
    for i in range(lows.size):
        height = heights[i]
        for column in range(np.int64(lows[i]), np.int64(highs[i]) + 1):
            if found[column] == missing or (height < found[column]) == upwards:
                found[column] = height
    return found
