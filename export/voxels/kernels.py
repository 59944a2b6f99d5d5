"""The inner loops of voxelising: a walk over pieces that fills bricks, and bricks put in a row.

A brick is a word of 4 x 4 x 4 cells. Imported inside the functions that use it, for numba is slow to load.
"""

from typing import no_type_check

import numba
import numpy as np

ZERO = np.uint64(0)
ONE = np.uint64(1)
SEARCHED = (
    1 << 16
)  # bricks: larger boxes are not searched for white cells, their pieces are asked about later


@no_type_check
@numba.njit(cache=True, inline="always")
def first_cell(x, top):
    """The cell of the low end of a box."""
    return 0 if x <= 0.0 else min(int(x), top)


@no_type_check
@numba.njit(cache=True, inline="always")
def last_cell(x, first, top):
    """The last cell that the box enters: one that it only touches does not count."""
    if x <= 0.0:
        return first
    cell = int(x)
    if cell == x:
        cell -= 1
    return max(first, min(cell, top))


@no_type_check
@numba.njit(cache=True)
def fill(words, places, masks, f, e):
    """Blacken the cells from f to e on each axis."""
    for x in range(f[0] >> 2, (e[0] >> 2) + 1):
        a = masks[0, max(f[0] - 4 * x, 0), min(e[0] - 4 * x, 3)]
        for y in range(f[1] >> 2, (e[1] >> 2) + 1):
            b = a & masks[1, max(f[1] - 4 * y, 0), min(e[1] - 4 * y, 3)]
            row = places[0, x] | places[1, y]
            for z in range(f[2] >> 2, (e[2] >> 2) + 1):
                words[row | places[2, z]] |= b & masks[2, max(f[2] - 4 * z, 0), min(e[2] - 4 * z, 3)]


@no_type_check
@numba.njit(cache=True)
def full(words, places, masks, f, e):
    """Whether the cells from f to e on each axis are black."""
    for x in range(f[0] >> 2, (e[0] >> 2) + 1):
        a = masks[0, max(f[0] - 4 * x, 0), min(e[0] - 4 * x, 3)]
        for y in range(f[1] >> 2, (e[1] >> 2) + 1):
            b = a & masks[1, max(f[1] - 4 * y, 0), min(e[1] - 4 * y, 3)]
            row = places[0, x] | places[1, y]
            for z in range(f[2] >> 2, (e[2] >> 2) + 1):
                mask = b & masks[2, max(f[2] - 4 * z, 0), min(e[2] - 4 * z, 3)]
                if words[row | places[2, z]] & mask != mask:
                    return False
    return True


@no_type_check
@numba.njit(cache=True)
def extremes(points, count, low, high, whole, order, out_low, out_high):
    """The least and the largest `sum_j p_j c_j` for `low <= p <= high, sum p = 1`, on each axis.

    From p = low, the mass left goes to the smallest (largest) coordinates first. `whole` tells that the
    bounds are 0 and 1, which gives the box around the points. `order[axis]` is a permutation to begin sorting
    from, which neighbouring pieces nearly share.
    """
    for axis in range(3):
        if whole:
            least = most = points[0, axis]
            for j in range(1, count):
                least, most = min(least, points[j, axis]), max(most, points[j, axis])
            out_low[axis], out_high[axis] = least, most
            continue
        left, base = 1.0, 0.0
        row = order[axis]
        for i in range(count):
            left -= low[i]
            base += low[i] * points[i, axis]
            j = row[i]
            value = points[j, axis]
            k = i
            while k > 0 and points[row[k - 1], axis] > value:
                row[k] = row[k - 1]
                k -= 1
            row[k] = j
        rest, least = left, base
        for i in range(count):
            j = row[i]
            part = max(min(high[j] - low[j], rest), 0.0)
            least += part * points[j, axis]
            rest -= part
        rest, most = left, base
        for i in range(count - 1, -1, -1):
            j = row[i]
            part = max(min(high[j] - low[j], rest), 0.0)
            most += part * points[j, axis]
            rest -= part
        out_low[axis], out_high[axis] = least, most


@no_type_check
@numba.njit(cache=True)
def enter(level, cell, system, stack, slack, part, depth):
    """Prepare the pieces of the piece at a level: the boxes, relative to its last control point.

    `shift[level, 0]` holds the control points of the piece relative to the last one, `shift[level, 1 + n]`
    those of its pieces of kind n: pieces of a kind are alike but for their place. All that is prepared
    depends on the shape of the piece alone, not on its place.
    """
    first, sizes, _, kind, weights, kinds, kind_cell, rows, columns, values, box_low, box_high, whole = system
    _, _, _, shift, offset, low, high, small, names, order, room = stack
    for q in range(kinds[cell], kinds[cell + 1]):
        mine = q - kinds[cell]
        target = kind_cell[q]
        points = shift[level, 1 + mine]
        for j in range(sizes[target]):
            x, y, z = 0.0, 0.0, 0.0
            for entry in range(rows[q, j], rows[q, j + 1]):
                k, value = columns[entry], values[entry]
                x += value * shift[level, 0, k, 0]
                y += value * shift[level, 0, k, 1]
                z += value * shift[level, 0, k, 2]
            points[j, 0], points[j, 1], points[j, 2] = x, y, z
        extremes(
            points,
            sizes[target],
            box_low[target],
            box_high[target],
            whole[target],
            order[target],
            room[0, mine],
            room[1, mine],
        )
        if depth >= 0:
            small[level, mine] = level + 1 >= depth
        else:
            small[level, mine] = True
            for axis in range(3):
                if room[1, mine, axis] - room[0, mine, axis] > part:
                    small[level, mine] = False
    for i in range(first[cell], first[cell + 1]):
        n, mine = i - first[cell], kind[i] - kinds[cell]
        for axis in range(3):
            x = 0.0
            for k in range(sizes[cell] - 1):
                x += weights[i, k] * shift[level, 0, k, axis]
            offset[level, n, axis] = x
            low[level, n, axis] = x + room[0, mine, axis] + slack
            high[level, n, axis] = x + room[1, mine, axis] - slack
    names[0, 0] += 1
    names[level + 1, 0] = names[0, 0]


@no_type_check
@numba.njit(cache=True)
def walk(level, system, stack, block, frame, words, places, masks, most, found):
    """Go on with a depth-first walk for at most `most` pieces; the level reached, -1 at the end.

    `block` is the first and the last cell of the grid that is filled, on each axis; `frame` holds the last
    cells of the grid, the slack, the size of the smallest pieces and the depth (-1 for a size). `found`
    gathers how many pieces were seen and the largest square of the diagonal of a box that was filled.
    Where the stack is too small the result is -2 less the level: call again with a larger one.

    `names[level + 1]` is the name of the shape prepared at a level, and the name of the shape above and the
    kind from which it was made: where these come again, nothing is prepared anew.
    """
    first, sizes, targets, kind, _, kinds, _, _, _, _, _, _, _ = system
    cells, labels, base, shift, offset, low, high, small, names, _, _ = stack
    tops, slack, part, depth = frame
    f0, f1, f2, l0, l1, l2 = block[0, 0], block[0, 1], block[0, 2], block[1, 0], block[1, 1], block[1, 2]
    f, e = np.empty(3, np.int64), np.empty(3, np.int64)
    seen = 0
    while level >= 0 and seen < most:
        cell = cells[level]
        begin = first[cell]
        n = labels[level]
        if n == first[cell + 1] - begin:
            level -= 1
            continue
        labels[level] = n + 1
        seen += 1
        x, y, z = base[level, 0], base[level, 1], base[level, 2]
        a0 = first_cell(x + low[level, n, 0], tops[0])
        b0 = last_cell(x + high[level, n, 0], a0, tops[0])
        a1 = first_cell(y + low[level, n, 1], tops[1])
        b1 = last_cell(y + high[level, n, 1], a1, tops[1])
        a2 = first_cell(z + low[level, n, 2], tops[2])
        b2 = last_cell(z + high[level, n, 2], a2, tops[2])
        if b0 < f0 or a0 > l0 or b1 < f1 or a1 > l1 or b2 < f2 or a2 > l2:
            continue
        one = a0 == b0 and a1 == b1 and a2 == b2
        a0, b0 = max(a0, f0) - f0, min(b0, l0) - f0
        a1, b1 = max(a1, f1) - f1, min(b1, l1) - f1
        a2, b2 = max(a2, f2) - f2, min(b2, l2) - f2
        mine = kind[begin + n] - kinds[cell]
        leaf = one or small[level, mine]
        if a0 >> 2 == b0 >> 2 and a1 >> 2 == b1 >> 2 and a2 >> 2 == b2 >> 2:
            brick = places[0, a0 >> 2] | places[1, a1 >> 2] | places[2, a2 >> 2]
            mask = masks[0, a0 & 3, b0 & 3] & masks[1, a1 & 3, b1 & 3] & masks[2, a2 & 3, b2 & 3]
            if leaf:
                words[brick] |= mask
            elif words[brick] & mask == mask:
                continue
        elif leaf or ((b0 - a0) // 4 + 1) * ((b1 - a1) // 4 + 1) * ((b2 - a2) // 4 + 1) <= SEARCHED:
            f[0], f[1], f[2], e[0], e[1], e[2] = a0, a1, a2, b0, b1, b2
            if leaf:
                fill(words, places, masks, f, e)
            elif full(words, places, masks, f, e):
                continue
        if leaf:
            if not one:
                far = 0.0
                for axis in range(3):
                    far += (high[level, n, axis] - low[level, n, axis] + 2 * slack) ** 2
                found[1] = max(found[1], far)
            continue
        if level + 1 == len(cells):
            labels[level] = n
            found[0] += seen
            return -2 - level
        target = targets[begin + n]
        for axis in range(3):
            base[level + 1, axis] = base[level, axis] + offset[level, n, axis]
        above = names[level + 1, 0]
        level += 1
        cells[level], labels[level] = target, 0
        if names[level + 1, 1] != above or names[level + 1, 2] != mine:
            names[level + 1, 1], names[level + 1, 2] = above, mine
            for j in range(sizes[target]):
                for axis in range(3):
                    shift[level, 0, j, axis] = shift[level - 1, 1 + mine, j, axis]
            enter(level, target, system, stack, slack, part, depth)
    found[0] += seen
    return level


@no_type_check
@numba.njit(cache=True)
def compacted(words, used, begin, starts, entries):
    """Entries of bricks: word i is that of the i-th brick whose number has no bits outside `used`.

    Bricks between these are white; `begin` is added to all numbers. Called with empty arrays it only counts.
    """
    n, last = 0, ZERO
    brick, before = ZERO, ZERO
    count = starts.size == 0
    for i in range(words.size):
        if i > 0:
            brick = ((brick | ~used) + ONE) & used
            if last != ZERO and brick != before + ONE:
                if not count:
                    starts[n], entries[n] = begin + before + ONE, ZERO
                n += 1
                last = ZERO
        if words[i] != last:
            if not count:
                starts[n], entries[n] = begin + brick, words[i]
            n += 1
            last = words[i]
        before = brick
    if last != ZERO:
        if not count:
            starts[n], entries[n] = begin + before + ONE, ZERO
        n += 1
    return n


@no_type_check
@numba.njit(cache=True)
def joined(starts, words, number):
    """Entries in rising order, begun at 0; words that repeat the one before, and entries of no length, go."""
    out_starts, out_words = np.empty(starts.size + 1, np.uint64), np.empty(starts.size + 1, np.uint64)
    out_starts[0], out_words[0] = ZERO, ZERO
    n = 1
    for i in range(starts.size):
        if starts[i] >= number:
            break
        if i + 1 < starts.size and starts[i + 1] == starts[i]:
            continue
        if starts[i] == out_starts[n - 1]:
            n -= 1
        if n > 0 and out_words[n - 1] == words[i]:
            continue
        out_starts[n], out_words[n] = starts[i], words[i]
        n += 1
    return out_starts[:n].copy(), out_words[:n].copy()
