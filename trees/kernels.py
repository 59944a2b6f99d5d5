"""The inner loops: bits of keys, runs of keys, and words of bricks.

Imported inside the functions that use it, for numba takes a while to load.
"""

from typing import no_type_check

import numba
import numpy as np

FULL = np.uint64(0xFFFFFFFFFFFFFFFF)
ZERO = np.uint64(0)
ONE = np.uint64(1)
SIX = np.uint64(6)
LOW = np.uint64(63)


@no_type_check
@numba.njit(cache=True, inline="always")
def popcount(word):
    """How many bits are set (LLVM makes one instruction of it)."""
    word = word - ((word >> np.uint64(1)) & np.uint64(0x5555555555555555))
    word = (word & np.uint64(0x3333333333333333)) + ((word >> np.uint64(2)) & np.uint64(0x3333333333333333))
    word = (word + (word >> np.uint64(4))) & np.uint64(0x0F0F0F0F0F0F0F0F)
    return np.int64((word * np.uint64(0x0101010101010101)) >> np.uint64(56))


@no_type_check
@numba.njit(cache=True)
def interleave(cells, bits):
    """Morton keys of cells `(n, k)`; within a level, axis 0 has the highest bit."""
    n, k = cells.shape
    keys = np.zeros(n, np.uint64)
    for i in range(n):
        key = ZERO
        for bit in range(bits - 1, -1, -1):
            for axis in range(k):
                key = (key << ONE) | ((cells[i, axis] >> np.uint64(bit)) & ONE)
        keys[i] = key
    return keys


@no_type_check
@numba.njit(cache=True)
def separate(keys, k, bits):
    """Cells `(n, k)` of Morton keys."""
    cells = np.zeros((keys.size, k), np.uint64)
    for i in range(keys.size):
        shift = k * bits
        for _ in range(bits):
            for axis in range(k):
                shift -= 1
                cells[i, axis] = (cells[i, axis] << ONE) | ((keys[i] >> np.uint64(shift)) & ONE)
    return cells


@no_type_check
@numba.njit(cache=True, inline="always")
def between(low, high):
    """The word with the bits from low to high, both included."""
    return (FULL << low) & (FULL >> (LOW - high))


@no_type_check
@numba.njit(cache=True, inline="always")
def put(starts, words, n, start, word):
    """Append, unless the word goes on."""
    if n > 0 and words[n - 1] == word:
        return n
    starts[n] = start
    words[n] = word
    return n + 1


@no_type_check
@numba.njit(cache=True)
def pack(lows, highs, bricks):
    """Bricks of runs `[low, high]`, in rising order; one may begin in the last cell of the one before."""
    starts = np.empty(4 * lows.size + 2, np.uint64)
    words = np.empty(4 * lows.size + 2, np.uint64)
    n, brick, word = 0, ZERO, ZERO
    for i in range(lows.size):
        first, last = lows[i] >> SIX, highs[i] >> SIX
        if first != brick:
            n = put(starts, words, n, brick, word)
            if first > brick + ONE:
                n = put(starts, words, n, brick + ONE, ZERO)
            brick, word = first, ZERO
        if first == last:
            word |= between(lows[i] & LOW, highs[i] & LOW)
        else:
            n = put(starts, words, n, first, word | between(lows[i] & LOW, LOW))
            if last > first + ONE:
                n = put(starts, words, n, first + ONE, FULL)
            brick, word = last, between(ZERO, highs[i] & LOW)
    n = put(starts, words, n, brick, word)
    if brick + ONE < bricks:
        n = put(starts, words, n, brick + ONE, ZERO)
    return starts[:n].copy(), words[:n].copy()


@no_type_check
@numba.njit(cache=True)
def unpack(starts, words, bricks, room):
    """The longest runs `[low, high]` of black keys, in rising order."""
    lows, highs = np.empty(room, np.uint64), np.empty(room, np.uint64)
    n = 0
    for i in range(starts.size):
        word = words[i]
        if word == ZERO:
            continue
        stop = starts[i + 1] if i + 1 < starts.size else bricks
        brick = starts[i]
        while brick < stop:
            if word == FULL:
                low, high = brick << SIX, ((stop - ONE) << SIX) | LOW
                brick = stop
                if n > 0 and highs[n - 1] + ONE == low:
                    highs[n - 1] = high
                else:
                    lows[n], highs[n] = low, high
                    n += 1
                continue
            base, bit = brick << SIX, 0
            while bit < 64:
                if (word >> np.uint64(bit)) & ONE == ZERO:
                    bit += 1
                    continue
                begin = bit
                while bit < 64 and (word >> np.uint64(bit)) & ONE == ONE:
                    bit += 1
                low, high = base | np.uint64(begin), base | np.uint64(bit - 1)
                if n > 0 and highs[n - 1] + ONE == low:
                    highs[n - 1] = high
                else:
                    lows[n], highs[n] = low, high
                    n += 1
            brick += ONE
    return lows[:n].copy(), highs[:n].copy()


@no_type_check
@numba.njit(cache=True)
def merge(starts_a, words_a, starts_b, words_b, both, first, second, starts, words):
    """Entries combined brick by brick: the masks tell which bits of both, of a alone, of b alone stay.

    Steps are additions, not branches, for branches could not be foretold: an entry is written where the
    next one goes, and stays only if it differs from the one before. Returns how many there are.
    """
    i, j, n = 0, 0, 0
    a, b = words_a[0], words_b[0]
    last = ~((a & b & both) | (a & ~b & first) | (~a & b & second))
    while True:
        a, b = words_a[i], words_b[j]
        word = (a & b & both) | (a & ~b & first) | (~a & b & second)
        starts[n], words[n] = max(starts_a[i], starts_b[j]), word
        n += int(word != last)
        last = word
        more_a, more_b = i + 1 < starts_a.size, j + 1 < starts_b.size
        if more_a and more_b:
            next_a, next_b = starts_a[i + 1], starts_b[j + 1]
            i += int(next_a <= next_b)
            j += int(next_b <= next_a)
        elif more_a:
            i += 1
        elif more_b:
            j += 1
        else:
            return n


@no_type_check
@numba.njit(cache=True)
def merge_flat(words_a, words_b, both, first, second, words):
    """Words combined one by one, into `words`; returns how many differ from the one before."""
    changes = 1
    for begin in range(0, words.size, 1024):  # words are compared while they are still in the cache
        end = min(begin + 1024, words.size)
        # Loops over slices from 0 on are those that the compiler makes vector code of.
        a, b, out = words_a[begin:end], words_b[begin:end], words[begin:end]
        for i in range(out.size):
            out[i] = (a[i] & b[i] & both) | (a[i] & ~b[i] & first) | (~a[i] & b[i] & second)
        changes += int(begin > 0 and words[begin] != words[begin - 1]) + differing(out)
    return changes


@no_type_check
@numba.njit(cache=True)
def changes_of(words):
    """How many words differ from the one before, the first included."""
    return 1 + differing(words)


@no_type_check
@numba.njit(cache=True)
def differing(words):
    """How many words differ from the one before."""
    before, after = words[:-1], words[1:]
    found = 0
    for i in range(after.size):
        found += int(before[i] != after[i])
    return found


@no_type_check
@numba.njit(cache=True)
def squeezed(words, changes):
    """Starts and words of the runs of equal words, of which there are `changes`."""
    starts, firsts = np.empty(changes + 1, np.uint64), np.empty(changes + 1, np.uint64)
    n, last = 0, ~words[0]
    for i in range(words.size):
        starts[n], firsts[n] = i, words[i]
        n += int(words[i] != last)
        last = words[i]
    return starts[:n].copy(), firsts[:n].copy()


@no_type_check
@numba.njit(cache=True)
def spread(starts, words, bricks):
    """The word of every brick."""
    flat = np.empty(bricks, np.uint64)
    for i in range(starts.size):
        stop = starts[i + 1] if i + 1 < starts.size else np.uint64(bricks)
        flat[starts[i] : stop] = words[i]
    return flat


@no_type_check
@numba.njit(cache=True)
def gathered(array, corners, offsets):
    """Words of a flat array of Booleans: bit b of word i is the cell at `corners[i] + offsets[b]`."""
    words = np.empty(corners.size, np.uint64)
    for i in range(corners.size):
        word = ZERO
        for b in range(offsets.size):
            word |= np.uint64(array[corners[i] + offsets[b]]) << np.uint64(b)
        words[i] = word
    return words


@no_type_check
@numba.njit(cache=True)
def scattered(words, corners, offsets, array):
    """The inverse of `gathered`, into an array of white cells."""
    for i in range(corners.size):
        word = words[i]
        if word != ZERO:
            for b in range(offsets.size):
                array[corners[i] + offsets[b]] = (word >> np.uint64(b)) & ONE == ONE


@no_type_check
@numba.njit(cache=True)
def count_blocks(lows, highs, step, depth):
    """How many aligned blocks of `2^(step n)` keys, as large as possible, the runs are cut into."""
    total = 0
    for i in range(lows.size):
        low = lows[i]
        while True:
            last = low | block_mask(low, highs[i], step, depth)
            total += 1
            if last == highs[i]:
                break
            low = last + ONE
    return total


@no_type_check
@numba.njit(cache=True)
def block_mask(low, high, step, depth):
    """`2^(step n) - 1` for the largest block that starts at low and ends at or before high."""
    mask = ZERO
    width = step
    while width <= depth:
        wider = FULL >> np.uint64(64 - width)
        if low & wider != ZERO or (low | wider) > high:
            break
        mask = wider
        width += step
    return mask


@no_type_check
@numba.njit(cache=True)
def blocks(lows, highs, step, depth, total):
    """First and last keys of the blocks that `count_blocks` counts."""
    first, last = np.empty(total, np.uint64), np.empty(total, np.uint64)
    n = 0
    for i in range(lows.size):
        low = lows[i]
        while True:
            first[n] = low
            last[n] = low | block_mask(low, highs[i], step, depth)
            n += 1
            if last[n - 1] == highs[i]:
                break
            low = last[n - 1] + ONE
    return first, last
