"""The inner loops of voxelising: a walk over pieces that fills rows of cells, and rows put into bricks.

A row holds the cells along the last axis, 64 a word; a brick is a word of 4 x 4 x 4 cells. Imported inside
the functions that use it, for numba is slow to load.
"""

from typing import no_type_check

import numba
import numpy as np

ZERO = np.uint64(0)
ONE = np.uint64(1)
ALL = np.uint64(0xFFFFFFFFFFFFFFFF)
SAME = 1e-12  # voxels
SEARCHED = 1 << 12  # rows: larger boxes are not searched for white cells, their pieces are asked about later


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
@numba.njit(cache=True, inline="always")
def some(first, last):
    """The bits from first to last of a word."""
    return (ALL << np.uint64(first)) & (ALL >> np.uint64(63 - last))


@no_type_check
@numba.njit(cache=True)
def fill(rows, f0, e0, f1, e1, f2, e2):
    """Blacken the cells from f to e on each axis."""
    for word in range(f2 >> 6, (e2 >> 6) + 1):
        mask = some(max(f2 - 64 * word, 0), min(e2 - 64 * word, 63))
        for x in range(f0, e0 + 1):
            for y in range(f1, e1 + 1):
                rows[x, y, word] |= mask


@no_type_check
@numba.njit(cache=True)
def full(rows, f0, e0, f1, e1, f2, e2):
    """Whether the cells from f to e on each axis are black."""
    for word in range(f2 >> 6, (e2 >> 6) + 1):
        mask = some(max(f2 - 64 * word, 0), min(e2 - 64 * word, 63))
        for x in range(f0, e0 + 1):
            for y in range(f1, e1 + 1):
                if rows[x, y, word] & mask != mask:
                    return False
    return True


@no_type_check
@numba.njit(cache=True)
def enter(level, cell, forms, stack, slack, limits):
    """Prepare the pieces of the piece at a level: what they are made of, and their boxes.

    `made[level]` holds the piece, an axis a row, from the column `begins[level]` on; `made[level + 1]` gets
    those of its pieces of each kind: pieces of a kind are alike but for their place. All that is prepared
    depends on the shape of the piece alone, not on its place.

    A piece that has less than `coarse` voxels beyond its slow coordinates goes on as these alone, in a ball
    of what it leaves out, `spare`.
    """
    first, _, kind, kinds, kind_cell, column, widths, sizes, simplex, half, blocks, offsets, twins = forms
    (
        _,
        _,
        _,
        begins,
        made,
        place,
        low,
        high,
        small,
        goes_on,
        spare,
        own,
        room,
        _,
        last,
        wide,
        slot,
        count,
        begins_at,
        _,
        _,
    ) = stack
    part, depth, coarse = limits
    size, begin = sizes[cell], begins[level]
    wide[level] = 0.0
    width = widths[cell]
    for axis in range(3):
        row = made[level + 1, axis, :width]
        row[:] = 0.0
        for k in range(size):
            value = made[level, axis, begin + k]
            if value != 0.0:
                line = blocks[cell, k, :width]
                for j in range(width):
                    row[j] += value * line[j]
    for q in range(kinds[cell], kinds[cell + 1]):
        mine = q - kinds[cell]
        target, at = kind_cell[q], column[q]
        twin = twins[target]
        slow = sizes[twin] if twin >= 0 else 0
        left, most, far = 0.0, 0.0, 0.0
        for axis in range(3):
            ball = own[level, axis]
            if simplex[target]:
                a, b = 0.0, 0.0
                for j in range(sizes[target]):
                    value = made[level + 1, axis, at + j]
                    a, b = min(a, value), max(b, value)
            else:
                b, rest = 0.0, 0.0
                for j in range(slow):
                    b += abs(made[level + 1, axis, at + j]) * half[target, j]
                for j in range(slow, sizes[target]):
                    rest += abs(made[level + 1, axis, at + j]) * half[target, j]
                b += rest
                a = -b
                left = max(left, rest)
                spare[level, mine, axis] = rest
            room[0, mine, axis], room[1, mine, axis] = a - ball, b + ball
            most = max(most, b - a + 2 * ball)
            far += (b - a + 2 * ball) ** 2
        wide[level] = max(wide[level], far)
        goes_on[level, mine] = target
        if twin >= 0 and left <= coarse:
            goes_on[level, mine] = twin
        else:
            spare[level, mine] = 0.0
        small[level, mine] = most <= part if depth < 0 else level + 1 >= depth
    for i in range(first[cell], first[cell + 1]):
        n, mine = i - first[cell], kind[i] - kinds[cell]
        for axis in range(3):
            x = 0.0
            for k in range(size):
                x += offsets[i, k] * made[level, axis, begin + k]
            place[level, n, axis] = x
            low[level, n, axis] = x + room[0, mine, axis] + slack
            high[level, n, axis] = x + room[1, mine, axis] - slack
    pieces = first[cell + 1] - first[cell]
    last[level] = pieces > 0
    for mine in range(kinds[cell + 1] - kinds[cell]):
        last[level] = last[level] and small[level, mine]
    if last[level]:
        alike = kinds[cell + 1] - kinds[cell] == 1
        for axis in range(3):
            count[level, axis] = 0
            for n in range(pieces):
                found = count[level, axis]
                if alike:
                    for other in range(found):
                        if abs(low[level, begins_at[level, axis, other], axis] - low[level, n, axis]) <= SAME:
                            found = other
                            break
                if found == count[level, axis]:
                    begins_at[level, axis, found] = n
                    count[level, axis] += 1
                slot[level, n, axis] = found


@no_type_check
@numba.njit(cache=True)
def fill_all(level, pieces, stack, block, tops, rows):
    """Fill all pieces of the piece at a level, when none of them is subdivided.

    Pieces that have the same ends along an axis are placed once along it.
    """
    _, _, base, _, _, _, low, high, _, _, _, _, _, _, _, _, slot, count, begins_at, ends, masks = stack
    for axis in range(3):
        start, top, f, e = base[level, axis], tops[axis], block[0, axis], block[1, axis]
        for at in range(count[level, axis]):
            n = begins_at[level, axis, at]
            a = first_cell(start + low[level, n, axis], top)
            b = last_cell(start + high[level, n, axis], a, top)
            a, b = max(a, f) - f, min(b, e) - f
            ends[axis, at, 0], ends[axis, at, 1] = a, b
            if axis == 2:
                masks[at] = some(a & 63, b & 63) if a <= b and a >> 6 == b >> 6 else ZERO
    n = 0
    while n < pieces:
        x, y, z = slot[level, n, 0], slot[level, n, 1], slot[level, n, 2]
        mask, word = masks[z], ends[2, z, 0] >> 6
        n += 1
        while n < pieces and slot[level, n, 0] == x and slot[level, n, 1] == y:
            other = slot[level, n, 2]
            if mask == ZERO or masks[other] == ZERO or ends[2, other, 0] >> 6 != word:
                break
            mask |= masks[other]
            n += 1
        a0, b0 = ends[0, x, 0], ends[0, x, 1]
        a1, b1 = ends[1, y, 0], ends[1, y, 1]
        if a0 > b0 or a1 > b1:
            continue
        if mask != ZERO:
            for i in range(a0, b0 + 1):
                for j in range(a1, b1 + 1):
                    rows[i, j, word] |= mask
        elif ends[2, z, 0] <= ends[2, z, 1]:
            fill(rows, a0, b0, a1, b1, ends[2, z, 0], ends[2, z, 1])


@no_type_check
@numba.njit(cache=True)
def walk(level, forms, stack, block, tops, slack, limits, rows, most, found):
    """Go on with a depth-first walk for at most `most` pieces; the level reached, -1 at the end.

    `block` is the first and the last cell of the grid that is filled, on each axis, `tops` the last cells of
    the grid; `limits` are the size of the smallest pieces, the depth (-1 for a size) and what may be left
    out. `found` gathers how many pieces were seen and the largest square of the diagonal of a box that
    was filled. Where the stack is too small the result is -2 less the level: call again with a larger one.

    `names[level + 1]` is the name of the shape prepared at a level, and the name of the shape above and the
    kind from which it was made: where these come again, nothing is prepared anew.
    """
    first, _, kind, kinds, _, column, _, _, _, _, _, _, _ = forms
    (
        cells,
        labels,
        base,
        begins,
        _,
        place,
        low,
        high,
        small,
        goes_on,
        spare,
        own,
        _,
        names,
        last,
        wide,
        _,
        _,
        _,
        _,
        _,
    ) = stack
    t0, t1, t2 = tops[0], tops[1], tops[2]
    f0, f1, f2, l0, l1, l2 = block[0, 0], block[0, 1], block[0, 2], block[1, 0], block[1, 1], block[1, 2]
    seen = 0
    while level >= 0 and seen < most:
        cell = cells[level]
        begin = first[cell]
        n = labels[level]
        if n == first[cell + 1] - begin:
            level -= 1
            continue
        if last[level]:
            pieces = first[cell + 1] - begin
            fill_all(level, pieces, stack, block, tops, rows)
            found[1] = max(found[1], wide[level])
            seen += pieces
            level -= 1
            continue
        labels[level] = n + 1
        seen += 1
        x, y, z = base[level, 0], base[level, 1], base[level, 2]
        a0 = first_cell(x + low[level, n, 0], t0)
        b0 = last_cell(x + high[level, n, 0], a0, t0)
        a1 = first_cell(y + low[level, n, 1], t1)
        b1 = last_cell(y + high[level, n, 1], a1, t1)
        a2 = first_cell(z + low[level, n, 2], t2)
        b2 = last_cell(z + high[level, n, 2], a2, t2)
        if b0 < f0 or a0 > l0 or b1 < f1 or a1 > l1 or b2 < f2 or a2 > l2:
            continue
        one = a0 == b0 and a1 == b1 and a2 == b2
        a0, b0 = max(a0, f0) - f0, min(b0, l0) - f0
        a1, b1 = max(a1, f1) - f1, min(b1, l1) - f1
        a2, b2 = max(a2, f2) - f2, min(b2, l2) - f2
        mine = kind[begin + n] - kinds[cell]
        if one or small[level, mine]:
            word = a2 >> 6
            if b0 - a0 <= 1 and b1 - a1 <= 1 and b2 >> 6 == word:
                mask = some(a2 & 63, b2 & 63)
                rows[a0, a1, word] |= mask
                rows[a0, b1, word] |= mask
                rows[b0, a1, word] |= mask
                rows[b0, b1, word] |= mask
            else:
                fill(rows, a0, b0, a1, b1, a2, b2)
            if not one:
                far = 0.0
                for axis in range(3):
                    far += (high[level, n, axis] - low[level, n, axis] + 2 * slack) ** 2
                found[1] = max(found[1], far)
            continue
        if (b0 - a0 + 1) * (b1 - a1 + 1) <= SEARCHED and full(rows, a0, b0, a1, b1, a2, b2):
            continue
        if level + 1 == len(cells):
            labels[level] = n
            found[0] += seen
            return -2 - level
        above = names[level + 1, 0]
        level += 1
        for axis in range(3):
            base[level, axis] = base[level - 1, axis] + place[level - 1, n, axis]
        target = goes_on[level - 1, mine]
        cells[level], labels[level] = target, 0
        if names[level + 1, 1] != above or names[level + 1, 2] != mine:
            names[level + 1, 1], names[level + 1, 2] = above, mine
            begins[level] = column[kinds[cell] + mine]
            for axis in range(3):
                own[level, axis] = own[level - 1, axis] + spare[level - 1, mine, axis]
            enter(level, target, forms, stack, slack, limits)
            names[0, 0] += 1
            names[level + 1, 0] = names[0, 0]
    found[0] += seen
    return level


@no_type_check
@numba.njit(cache=True)
def bricked(rows, axes, places, spread, bricks):
    """Rows put into bricks; `axes` are those of the tree along which the rows' axes lie.

    `spread[axis, n]` has the bits of the cells n (of four) along an axis of a brick, `places` what each axis
    adds to the number of a brick.
    """
    nx, ny, nw = rows.shape
    u, v, w = axes[0], axes[1], axes[2]
    quads = places.shape[1]
    across = np.zeros((4, 4), np.uint64)
    for i in range(4):
        for j in range(4):
            across[i, j] = spread[u, 1 << i] & spread[v, 1 << j]
    lines = np.zeros(16, np.uint64)
    for x in range((nx + 3) >> 2):
        for y in range((ny + 3) >> 2):
            row = places[u, x] | places[v, y]
            for word in range(nw):
                anything = ZERO
                for i in range(4):
                    for j in range(4):
                        inside = 4 * x + i < nx and 4 * y + j < ny
                        value = rows[4 * x + i, 4 * y + j, word] if inside else ZERO
                        lines[4 * i + j] = value
                        anything |= value
                if anything == ZERO:
                    continue
                for q in range(16):
                    shift = np.uint64(4 * q)
                    if (anything >> shift) & np.uint64(15) == ZERO or 16 * word + q >= quads:
                        continue
                    brick = ZERO
                    for i in range(4):
                        for j in range(4):
                            nibble = (lines[4 * i + j] >> shift) & np.uint64(15)
                            brick |= across[i, j] & spread[w, nibble]
                    bricks[row | places[w, 16 * word + q]] = brick


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
