"""The inner loops of morphology: bricks to rows and back, windows of rows, and what is done to them.

A row is a word whose bit z is the cell z of the last axis. Imported inside the functions that use it.
"""

from typing import no_type_check

import numba
import numpy as np

from trees.kernels import FULL, LOW, ONE, ZERO, put


@no_type_check
@numba.njit(cache=True)
def tile_runs(starts, words, bricks, shift):
    """Runs of tiles of `2^shift` bricks that hold a black cell, and of those without a white one."""
    some = np.empty((starts.size, 2), np.uint64)
    every = np.empty((starts.size, 2), np.uint64)
    n, full = 0, 0
    size = ONE << shift
    for i in range(starts.size):
        if words[i] == ZERO:
            continue
        stop = starts[i + 1] if i + 1 < starts.size else bricks
        low, high = starts[i] >> shift, (stop - ONE) >> shift
        if n > 0 and some[n - 1, 1] + ONE >= low:
            some[n - 1, 1] = high
        else:
            some[n, 0], some[n, 1] = low, high
            n += 1
        if words[i] == FULL:
            low, high = (starts[i] + size - ONE) >> shift, stop >> shift
            if low < high:
                every[full, 0], every[full, 1] = low, high - ONE
                full += 1
    return some[:n].copy(), every[:full].copy()


@no_type_check
@numba.njit(cache=True, inline="always")
def exchange(word, shift, mask):
    """Two bits of the number of each cell of a brick exchanged: a delta swap."""
    moved = ((word >> shift) ^ word) & mask
    return word ^ moved ^ (moved << shift)


@no_type_check
@numba.njit(cache=True)
def rows_of_tiles(starts, words, tiles, shift, layout, store):
    """Rows of some tiles, in `store[2:]`: row `base[brick] + parts[part]` gets a part of each brick."""
    swaps, base, begin, parts, width = layout
    count = base.size
    mask = FULL >> (LOW - (width - ONE))
    for i in range(tiles.size):
        first = tiles[i] << shift
        entry = np.searchsorted(starts, first, side="right") - 1
        rows = store[i + 2]
        rows[:] = ZERO
        brick = 0
        while brick < count:
            word = words[entry]
            stop = count
            if entry + 1 < starts.size and starts[entry + 1] < first + np.uint64(count):
                stop = np.int64(starts[entry + 1] - first)
            if word != ZERO:
                for j in range(swaps.shape[0]):
                    word = exchange(word, swaps[j, 0], swaps[j, 1])
                for b in range(brick, stop):
                    rest = word
                    row, place = base[b], begin[b]
                    for part in range(parts.size):
                        rows[row + parts[part]] |= (rest & mask) << place
                        rest = rest >> width if width < np.uint64(64) else ZERO
            brick = stop
            entry += 1


@no_type_check
@numba.njit(cache=True)
def put_tile(rows, first, swaps, base, begin, parts, width, starts, words, n):
    """Append the bricks of the rows of a tile whose first brick is `first`."""
    mask = FULL >> (LOW - (width - ONE))
    for b in range(base.size):
        word, place = ZERO, ZERO
        row, shift = base[b], begin[b]
        for part in range(parts.size):
            word |= ((rows[row + parts[part]] >> shift) & mask) << place
            place += width
        for j in range(swaps.shape[0] - 1, -1, -1):
            word = exchange(word, swaps[j, 0], swaps[j, 1])
        n = put(starts, words, n, first + np.uint64(b), word)
    return n


@no_type_check
@numba.njit(cache=True)
def fill_window(store, slots, tile_of_row, row_of_row, places, planes):
    """The rows around a tile, cut into words: `planes[j, i]` is word j of row i of the window."""
    across = places.size
    planes[:] = ZERO
    for d in range(across):
        plane, shift = places[d] >> 6, np.uint64(places[d] & 63)
        target = planes[plane]
        for i in range(tile_of_row.size):
            target[i] |= store[slots[tile_of_row[i] * across + d], row_of_row[i]] << shift


@no_type_check
@numba.njit(cache=True)
def widen(wide, planes, reach):
    """`wide`, spread by `reach - 1` cells along rows, becomes spread by `reach`."""
    middle = planes.shape[0] // 2
    q, b = reach >> 6, np.uint64(reach & 63)
    if reach == 0:
        wide[:] = planes[middle]
    elif b == ZERO:
        before, after = planes[middle - q], planes[middle + q]
        for i in range(wide.size):
            wide[i] |= before[i] | after[i]
    else:
        c = np.uint64(64) - b
        left, before = planes[middle - q], planes[middle - q - 1]
        right, after = planes[middle + q], planes[middle + q + 1]
        for i in range(wide.size):
            wide[i] |= (left[i] << b) | (before[i] >> c) | (right[i] >> b) | (after[i] << c)


@no_type_check
@numba.njit(cache=True)
def gather(source, offsets, lines, length, out):
    """`out |= source` moved by each of the offsets, for the lines of the tile; four at a time."""
    count = offsets.size
    for j in range(lines.size):
        target = out[j * length : (j + 1) * length]
        begin = lines[j]
        for i in range(0, count, 4):
            p, q = begin + offsets[i], begin + offsets[min(i + 1, count - 1)]
            r, s = begin + offsets[min(i + 2, count - 1)], begin + offsets[min(i + 3, count - 1)]
            one, two = source[p : p + length], source[q : q + length]
            three, four = source[r : r + length], source[s : s + length]
            for x in range(length):
                target[x] |= (one[x] | two[x]) | (three[x] | four[x])


@no_type_check
@numba.njit(cache=True)
def spread_rows(planes, wide, halves, offsets, lines, length, out):
    """Dilation by a stack of rows: half-widths, rising, and the offsets of the rows."""
    out[:] = ZERO
    reach, first = 0, 0
    while first < halves.size:
        while reach <= halves[first]:
            widen(wide, planes, reach)
            reach += 1
        end = first
        while end < halves.size and halves[end] == halves[first]:
            end += 1
        gather(wide, offsets[first:end], lines, length, out)
        first = end


@no_type_check
@numba.njit(cache=True)
def shifted(wide, planes, move):
    """The rows moved by `move` cells: cell z is what cell `z + move` was."""
    middle = planes.shape[0] // 2
    q, b = move >> 6, np.uint64(move & 63)
    here = planes[middle + q]
    if b == ZERO:
        wide[:] = here
        return
    after, c = planes[middle + q + 1], np.uint64(64) - b
    for i in range(wide.size):
        wide[i] = (here[i] >> b) | (after[i] << c)


@no_type_check
@numba.njit(cache=True)
def join_ahead(planes, move):
    """Each cell z of a row becomes black where cell `z + move` is."""
    count, rows = planes.shape
    q, b = move >> 6, np.uint64(move & 63)
    c = np.uint64(64) - b
    for j in range(count - q):
        here, ahead = planes[j], planes[j + q]
        if b == ZERO:
            for i in range(rows):
                here[i] |= ahead[i]
            continue
        for i in range(rows):
            here[i] |= ahead[i] >> b
        if j + q + 1 < count:
            after = planes[j + q + 1]
            for i in range(rows):
                here[i] |= after[i] << c


@no_type_check
@numba.njit(cache=True)
def spread_box(planes, wide, half, radii, strides, lines, length, out):
    """Dilation by a box, one axis after the other, by doubling. The planes are overwritten."""
    missing, step = 2 * half, 1
    while missing > 0:
        join_ahead(planes, min(step, missing))
        missing -= min(step, missing)
        step *= 2
    shifted(wide, planes, -half)
    back = 0
    for axis in range(radii.size):
        back += radii[axis] * strides[axis]
        missing, step = 2 * radii[axis], 1
        while missing > 0:
            move = min(step, missing)
            shift = move * strides[axis]
            for i in range(wide.size - shift):
                wide[i] |= wide[i + shift]
            missing -= move
            step *= 2
    out[:] = ZERO
    gather(wide, np.full(1, -back), lines, length, out)


@no_type_check
@numba.njit(cache=True)
def count_rows(planes, wide, halves, offsets, least, counters, lines, length, out):
    """Where at least `least` cells of a stack of rows are black: counters of one bit a plane.

    They begin at `2^planes - least`: those that overflow have counted enough.
    """
    digits = counters.shape[0]
    begin = (1 << digits) - least
    for p in range(digits):
        counters[p, :] = FULL if (begin >> p) & 1 else ZERO
    out[:] = ZERO
    carry = np.empty(length, np.uint64)
    largest = halves[halves.size - 1]
    for move in range(-largest, largest + 1):
        shifted(wide, planes, move)
        for i in range(halves.size):
            if abs(move) > halves[i]:
                continue
            for j in range(lines.size):
                begin, here = lines[j] + offsets[i], j * length
                carry[:] = wide[begin : begin + length]
                for p in range(digits):
                    digit = counters[p, here : here + length]
                    for x in range(length):
                        old = digit[x]
                        digit[x] = old ^ carry[x]
                        carry[x] &= old
                target = out[here : here + length]
                for x in range(length):
                    target[x] |= carry[x]


@no_type_check
@numba.njit(cache=True)
def is_white(planes):
    """Whether all words are zero."""
    for j in range(planes.shape[0]):
        for i in range(planes.shape[1]):
            if planes[j, i] != ZERO:
                return False
    return True


@no_type_check
@numba.njit(cache=True)
def filter_tiles(
    store, slots, tiles, shift, after, layout, window, halves, offsets, radii, strides, least, digits
):
    """Bricks of the filtered tiles, and white between them; `least` 0 is a box, 1 a dilation."""
    swaps, base, begin, parts, width = layout
    tile_of_row, row_of_row, places, planes_count, lines, length = window
    planes = np.zeros((planes_count, tile_of_row.size), np.uint64)
    wide = np.zeros(tile_of_row.size, np.uint64)
    out = np.zeros(lines.size * length, np.uint64)
    counters = np.zeros((digits, out.size), np.uint64)
    starts = np.empty(tiles.size * (base.size + 1), np.uint64)
    words = np.empty(starts.size, np.uint64)
    n = 0
    for i in range(tiles.size):
        first = tiles[i] << shift
        if first > after:
            n = put(starts, words, n, after, ZERO)
        fill_window(store, slots[i], tile_of_row, row_of_row, places, planes)
        if is_white(planes):
            n = put(starts, words, n, first, ZERO)
        else:
            if least == 0:
                spread_box(planes, wide, halves[0], radii, strides, lines, length, out)
            elif least == 1:
                spread_rows(planes, wide, halves, offsets, lines, length, out)
            else:
                count_rows(planes, wide, halves, offsets, least, counters, lines, length, out)
            n = put_tile(out, first, swaps, base, begin, parts, width, starts, words, n)
        after = first + np.uint64(base.size)
    return starts[:n].copy(), words[:n].copy(), after
