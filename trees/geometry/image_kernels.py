"""The inner loop of images under homographies: target boxes against the cells of the source.

Imported inside the functions that use it, for numba takes a while to load.
"""

from typing import no_type_check

import numba
import numpy as np

from trees.geometry.kernels import ZERO, advance, emit, halved, look, mask_of, spread, spread_table

NOTHING, SURE, LOOSE = 0, 1, 2
MOST_CORNERS = 6


@no_type_check
@numba.njit(cache=True)
def inverse_box(inverse, errors, corner, edge, affine, floor, sign, low, high, centre):
    """The bounds of the inverse image of a target box, widened (sign 1) or narrowed (-1) by its rounding.

    All in cells of the source. NOTHING where no weight of the box reaches `floor`, LOOSE where some do not.
    """
    k = corner.size
    if affine:
        for i in range(k):
            middle, reach = inverse[i, k], 0.0
            for j in range(k):
                middle += inverse[i, j] * (corner[j] + 0.5 * edge[j])
                reach += abs(inverse[i, j]) * 0.5 * edge[j]
            centre[i] = middle
            low[i] = middle - reach - sign * errors[i]
            high[i] = middle + reach + sign * errors[i]
        return SURE
    middle, reach = inverse[k, k], 0.0
    for j in range(k):
        middle += inverse[k, j] * (corner[j] + 0.5 * edge[j])
        reach += abs(inverse[k, j]) * 0.5 * edge[j]
    if middle + reach + errors[k] < floor:
        return NOTHING
    for i in range(k):
        value = inverse[i, k]
        for j in range(k):
            value += inverse[i, j] * (corner[j] + 0.5 * edge[j])
        centre[i] = value / max(middle, floor)
    least = middle - reach - errors[k]
    if least < floor or k > MOST_CORNERS:
        light, heavy = max(least, floor), middle + reach + errors[k]
        for i in range(k):
            value, spread_i = inverse[i, k], errors[i]
            for j in range(k):
                value += inverse[i, j] * (corner[j] + 0.5 * edge[j])
                spread_i += abs(inverse[i, j]) * 0.5 * edge[j]
            a, b = value - spread_i, value + spread_i
            low[i] = a / (light if a < 0 else heavy)
            high[i] = b / (heavy if b < 0 else light)
        return LOOSE if least < floor else SURE
    for i in range(k):
        low[i], high[i] = np.inf, -np.inf
    for c in range(1 << k):
        weight = inverse[k, k]
        for j in range(k):
            weight += inverse[k, j] * (corner[j] + edge[j] * ((c >> j) & 1))
        for i in range(k):
            value = inverse[i, k]
            for j in range(k):
                value += inverse[i, j] * (corner[j] + edge[j] * ((c >> j) & 1))
            value /= weight
            low[i], high[i] = min(low[i], value), max(high[i], value)
    for i in range(k):
        far = max(abs(low[i]), abs(high[i]))
        margin = sign * 2 * (errors[i] + far * errors[k]) / least
        low[i] -= margin
        high[i] += margin
    return SURE


@no_type_check
@numba.njit(cache=True)
def planes_of(forward, corner, planes, reaches):
    """The faces of a target cell as functions `planes . (x, 1)` of the source, negative at the cell's side.

    `reaches` is how much each varies from the centre of a source cell to its corners.
    """
    k = corner.size
    for i in range(k):
        for side in range(2):
            at, turn = corner[i] + side, 2.0 * side - 1.0
            reach = 0.0
            for j in range(k + 1):
                planes[2 * i + side, j] = turn * (forward[i, j] - at * forward[k, j])
                if j < k:
                    reach += 0.5 * abs(planes[2 * i + side, j])
            reaches[2 * i + side] = reach


@no_type_check
@numba.njit(cache=True)
def apart(cell, size, low, high, planes, reaches, slacks, centre, normals, supports, norms, loose):
    """Whether a hyperplane parts a source cell, of this edge, from the inverse image of a target cell."""
    k = cell.size
    for j in range(k):
        if cell[j] > high[j] or cell[j] + size < low[j]:
            return True
    for p in range(2 * k):
        value = planes[p, k]
        for j in range(k):
            value += planes[p, j] * (cell[j] + 0.5 * size)
        if value - size * reaches[p] > slacks[p >> 1]:
            return True
    if loose:
        return False
    for m in range(supports.size):
        value = 0.0
        for j in range(k):
            value += normals[m, j] * (cell[j] + 0.5 * size - centre[j])
        if abs(value) > supports[m] + 0.5 * size * norms[m]:
            return True
    return False


@no_type_check
@numba.njit(cache=True)
def image(
    black, white, k, bits, source_bits, inverse, errors, forward, slacks, normals, supports, norms,
    affine, sharp, floor, sign, limit,
):  # fmt: skip
    """Runs of the target cells whose inverse image no tested hyperplane parts from all black cells."""
    depth = k * bits
    side = np.int64(1) << source_bits
    table = spread_table(k)
    corners = np.zeros((depth + 2, k))
    keys = np.zeros(depth + 2, np.uint64)
    depths = np.zeros(depth + 2, np.int64)
    edges = np.full((depth + 1, k), 2.0**bits)
    for d in range(depth):
        edges[d + 1] = edges[d]
        edges[d + 1, d % k] *= 0.5
    room = 8
    parts = np.zeros((k, room), np.uint64)
    firsts, sizes, digits = np.zeros(k, np.int64), np.zeros(k, np.int64), np.zeros(k, np.int64)
    low, high, centre = np.zeros(k), np.zeros(k), np.zeros(k)
    planes, reaches = np.zeros((2 * k, k + 1)), np.zeros(2 * k)
    stack = np.zeros((2 + (source_bits + 1) * (1 << min(k, 16)), k), np.int64)
    stack_levels = np.zeros(stack.shape[0], np.int64)
    cell = np.zeros(k, np.int64)
    lows, highs, n = np.empty(1024, np.uint64), np.empty(1024, np.uint64), 0
    top = 1
    while top > 0:
        top -= 1
        key, d = keys[top], depths[top]
        last = d == depth
        state = inverse_box(
            inverse, errors, corners[top], edges[d], affine, floor, sign if last else 1.0, low, high, centre
        )
        if state == NOTHING:
            continue
        if last and state == SURE:
            # The middle of the cell comes from a black cell.
            inside, where = True, ZERO
            for j in range(k):
                if not 0 <= centre[j] < side:
                    inside = False
                    break
                where |= spread(np.int64(centre[j]), k, table) << np.uint64(k - 1 - j)
            if inside and look(black, source_bits, where):
                lows, highs, n = emit(lows, highs, n, key, key)
                if n > limit:
                    break
                continue
        outside, beyond, extent = False, False, 0.0
        for j in range(k):
            if low[j] > side or high[j] < 0:
                outside = True
                break
            if low[j] < 0 or high[j] > side:
                beyond = True
            extent = max(extent, min(high[j], side) - max(low[j], 0))
        if outside:
            continue
        coarse = 0
        while extent > 2 and coarse < source_bits:
            extent *= 0.5
            coarse += 1
        level = source_bits - coarse
        for j in range(k):
            a = np.int64(np.ceil(max(low[j], 0.0))) - 1
            b = np.int64(np.floor(min(high[j], side)))
            a, b = max(a, 0) >> coarse, min(b, side - 1) >> coarse
            firsts[j], sizes[j], digits[j] = a, b - a + 1, 0
            for t in range(sizes[j]):
                parts[j, t] = spread(a + t, k, table) << np.uint64(k - 1 - j)
        if last:
            planes_of(forward, corners[top], planes, reaches)
        any_black, any_white = False, beyond
        while True:
            where = ZERO
            for j in range(k):
                where |= parts[j, digits[j]]
            if not look(black, level, where):
                any_white = True
            elif last:
                for j in range(k):
                    cell[j] = firsts[j] + digits[j]
                any_black = meets(
                    black, white, source_bits, coarse, cell, stack, stack_levels, table, low, high, planes,
                    reaches, slacks, centre, normals, supports, norms, state == LOOSE, sharp,
                )  # fmt: skip
                if any_black:
                    break
            else:
                any_black = True
                any_white = any_white or look(white, level, where)
            if any_black and any_white:
                break
            if not advance(digits, sizes, k):
                break
        if not any_black:
            continue
        if last or (not any_white and state == SURE):
            lows, highs, n = emit(lows, highs, n, key, key | mask_of(depth - d))
            if n > limit:
                break
            continue
        top = halved(corners, keys, depths, top, depth, k, edges[d + 1, d % k])
    return lows[:n].copy(), highs[:n].copy()


@no_type_check
@numba.njit(cache=True)
def meets(
    black, white, source_bits, coarse, cell, stack, stack_levels, table, low, high, planes,
    reaches, slacks, centre, normals, supports, norms, loose, sharp,
):  # fmt: skip
    """Whether a black cell in this cell of a coarser level is not parted from the target cell.

    Where the test is sharp, a block of black cells stands for all of them.
    """
    k = cell.size
    top = 1
    stack[0], stack_levels[0] = cell << coarse, coarse
    while top > 0:
        top -= 1
        down = stack_levels[top]
        for j in range(k):
            cell[j] = stack[top, j]
        size = np.int64(1) << down
        if apart(
            cell, size, low, high, planes, reaches, slacks, centre, normals, supports, norms, loose
        ):  # fmt: skip
            continue
        where = ZERO
        for j in range(k):
            where |= spread(cell[j] >> down, k, table) << np.uint64(k - 1 - j)
        if not look(black, source_bits - down, where):
            continue
        if down == 0 or (sharp and not look(white, source_bits - down, where)):
            return True
        half = size >> 1
        for child in range(1 << k):
            for j in range(k):
                stack[top, j] = cell[j] + half * ((child >> j) & 1)
            stack_levels[top] = down - 1
            top += 1
    return False
