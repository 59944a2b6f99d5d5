"""The inner loops of deflate (RFC 1951): repeats found by a hash table, Huffman codes of each block.

A token is a literal byte, or `MATCH | (length - 3) << 16 | (distance - 1)`. All is integer arithmetic, so the
bytes are the same on every machine.

Imported inside the functions that use it, for numba takes a while to load.
"""

from typing import no_type_check

import numba
import numpy as np

MATCH = np.uint32(1 << 30)
SHORTEST, LONGEST, FARTHEST = 4, 258, 32768
HASH_BITS = 15
SPREAD = np.uint64(0x9E3779B1)
LOWER = np.uint64(0xFFFFFFFF)
END = 256
LITERALS, DISTANCES, LENGTHS = 286, 30, 19
DEEPEST, DEEPEST_LENGTH = 15, 7
HEAD_BITS = 400  # about what the codes of a block take


def _ranges(count, per_step, first):
    """The first value and the extra bits of each symbol: two, or four, of each size."""
    base, extra = np.zeros(count, np.int64), np.zeros(count, np.int64)
    at = first
    for symbol in range(count):
        base[symbol] = at
        extra[symbol] = max(symbol // per_step - 1, 0)
        at += 1 << extra[symbol]
    return base, extra


def _symbols(base, most):
    """The symbol of each value up to `most`."""
    return (np.searchsorted(base, np.arange(most + 1), side="right") - 1).astype(np.int64)


LENGTH_BASE, LENGTH_EXTRA = _ranges(29, 4, 3)
LENGTH_BASE[28], LENGTH_EXTRA[28] = 258, 0
LENGTH_SYMBOL = _symbols(LENGTH_BASE, LONGEST)
DISTANCE_BASE, DISTANCE_EXTRA = _ranges(30, 2, 1)
DISTANCE_SYMBOL = _symbols(DISTANCE_BASE, FARTHEST)
ORDER = np.array([16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15])


@no_type_check
@numba.njit(cache=True, inline="always")
def four_bytes(data, i):
    return (
        np.uint64(data[i])
        | np.uint64(data[i + np.uint64(1)]) << np.uint64(8)
        | np.uint64(data[i + np.uint64(2)]) << np.uint64(16)
        | np.uint64(data[i + np.uint64(3)]) << np.uint64(24)
    )


@no_type_check
@numba.njit(cache=True, inline="always")
def slot_of(word):
    return ((word * SPREAD) & LOWER) >> np.uint64(32 - HASH_BITS)


@no_type_check
@numba.njit(cache=True, nogil=True)
def tokens_of(data, size, tokens):
    """Fill in the tokens of `data[:size]`, greedily: each repeat is looked for at one earlier place only."""
    one, four = np.uint64(1), np.uint64(4)
    table = np.full(1 << HASH_BITS, -1, np.int32)
    count, i, end = 0, np.uint64(0), np.uint64(size)
    last = np.uint64(max(size - SHORTEST + 1, 0))
    while i < last:
        word = four_bytes(data, i)
        slot = slot_of(word)
        earlier = table[slot]
        table[slot] = i
        if (
            earlier >= 0
            and i - np.uint64(earlier) <= FARTHEST
            and four_bytes(data, np.uint64(earlier)) == word
        ):
            distance = i - np.uint64(earlier)
            stop = min(end, i + np.uint64(LONGEST))
            j = i + four
            while j + four <= stop and four_bytes(data, j) == four_bytes(data, j - distance):
                j += four
            while j < stop and data[j] == data[j - distance]:
                j += one
            length = j - i
            tokens[count] = MATCH | np.uint32((length - np.uint64(3)) << np.uint64(16) | (distance - one))
            count += 1
            inner = i + one
            i = j
            while inner < j and inner < last:
                table[slot_of(four_bytes(data, inner))] = inner
                inner += one
        else:
            tokens[count] = data[i]
            count += 1
            i += one
    while i < end:
        tokens[count] = data[i]
        count += 1
        i += one
    return count


@no_type_check
@numba.njit(cache=True)
def rising(weights):
    """The places of the weights in rising order, equal ones in their own."""
    order = np.zeros(weights.size, np.int64)
    for i in range(weights.size):
        at = i
        while at > 0 and weights[order[at - 1]] > weights[i]:
            order[at] = order[at - 1]
            at -= 1
        order[at] = i
    return order


@no_type_check
@numba.njit(cache=True)
def code_lengths(frequencies, deepest):
    """The lengths of a Huffman code, none above `deepest`; a single symbol has a code of one bit."""
    symbols, weights = np.zeros(frequencies.size, np.int64), np.zeros(frequencies.size, np.int64)
    lengths = np.zeros(frequencies.size, np.int64)
    used = 0
    for symbol in range(frequencies.size):
        if frequencies[symbol] > 0:
            symbols[used], weights[used] = symbol, frequencies[symbol]
            used += 1
    if used < 2:
        for i in range(used):
            lengths[symbols[i]] = 1
        return lengths
    weights = weights[:used]
    while True:
        order = rising(weights)
        parents, sums = np.zeros(2 * used - 1, np.int64), np.zeros(2 * used - 1, np.int64)
        for i in range(used):
            sums[i] = weights[order[i]]
        leaf, inner = 0, used
        for node in range(used, 2 * used - 1):
            for _ in range(2):
                if leaf < used and (inner >= node or sums[leaf] <= sums[inner]):
                    least = leaf
                    leaf += 1
                else:
                    least = inner
                    inner += 1
                sums[node] += sums[least]
                parents[least] = node
        depths = np.zeros(2 * used - 1, np.int64)
        for node in range(2 * used - 3, -1, -1):
            depths[node] = depths[parents[node]] + 1
        deepest_leaf = 0
        for i in range(used):
            lengths[symbols[order[i]]] = depths[i]
            deepest_leaf = max(deepest_leaf, depths[i])
        if deepest_leaf <= deepest:
            return lengths
        for i in range(used):
            weights[i] = (weights[i] + 1) >> 1


@no_type_check
@numba.njit(cache=True)
def codes_of(lengths):
    """The canonical codes of these lengths, their first bit lowest."""
    codes = np.zeros(lengths.size, np.uint64)
    code = 0
    for length in range(1, DEEPEST + 1):
        for symbol in range(lengths.size):
            if lengths[symbol] == length:
                turned = 0
                for bit in range(length):
                    turned |= (code >> bit & 1) << (length - 1 - bit)
                codes[symbol] = turned
                code += 1
        code <<= 1
    return codes


@no_type_check
@numba.njit(cache=True, inline="always")
def put(out, state, value, bits):
    """Append bits, lowest first. `state`: the place in `out`, the bits that wait, and their number."""
    state[1] |= np.uint64(value) << state[2]
    state[2] += np.uint64(bits)
    while state[2] >= 8:
        out[state[0]] = state[1] & np.uint64(255)
        state[0] += np.uint64(1)
        state[1] >>= np.uint64(8)
        state[2] -= np.uint64(8)


@no_type_check
@numba.njit(cache=True)
def put_lengths(out, state, lengths, distances):
    """The head of a block with codes of its own: how many symbols there are, and how long their codes."""
    literals = LITERALS
    while literals > 257 and lengths[literals - 1] == 0:
        literals -= 1
    far = DISTANCES
    while far > 1 and distances[far - 1] == 0:
        far -= 1
    every = np.zeros(literals + far, np.int64)
    every[:literals] = lengths[:literals]
    every[literals:] = distances[:far]
    symbols, repeats = np.zeros(every.size, np.int64), np.zeros(every.size, np.int64)
    count, i = 0, 0
    while i < every.size:
        zeros = 0
        while i + zeros < every.size and zeros < 138 and every[i + zeros] == 0:
            zeros += 1
        if zeros >= 3:
            symbols[count] = 17 if zeros < 11 else 18
            repeats[count] = zeros
            i += zeros
        else:
            symbols[count] = every[i]
            i += 1
        count += 1
    frequencies = np.zeros(LENGTHS, np.int64)
    for j in range(count):
        frequencies[symbols[j]] += 1
    own = code_lengths(frequencies, DEEPEST_LENGTH)
    codes = codes_of(own)
    given = LENGTHS
    while given > 4 and own[ORDER[given - 1]] == 0:
        given -= 1
    put(out, state, literals - 257, 5)
    put(out, state, far - 1, 5)
    put(out, state, given - 4, 4)
    for j in range(given):
        put(out, state, own[ORDER[j]], 3)
    for j in range(count):
        put(out, state, codes[symbols[j]], own[symbols[j]])
        if symbols[j] == 17:
            put(out, state, repeats[j] - 3, 3)
        elif symbols[j] == 18:
            put(out, state, repeats[j] - 11, 7)


@no_type_check
@numba.njit(cache=True, nogil=True)
def block(data, size, tokens, out):
    """One block of the bytes `data[:size]` in `out`, then an empty stored one to end at a byte; its length.

    The block has the codes that RFC 1951 names where these are shorter than codes of its own.
    """
    count = tokens_of(data, size, tokens)
    literals, far = np.zeros(LITERALS, np.int64), np.zeros(DISTANCES, np.int64)
    literals[END] = 1
    for j in range(count):
        token = tokens[j]
        if token & MATCH:
            literals[257 + LENGTH_SYMBOL[((token >> np.uint32(16)) & np.uint32(255)) + np.uint32(3)]] += 1
            far[DISTANCE_SYMBOL[(token & np.uint32(65535)) + np.uint32(1)]] += 1
        else:
            literals[token] += 1
    lengths = code_lengths(literals, DEEPEST)
    distances = code_lengths(far, DEEPEST)
    fixed = np.full(LITERALS, 8, np.int64)
    fixed[144:256] = 9
    fixed[256:280] = 7
    state = np.zeros(3, np.uint64)
    own, given = HEAD_BITS, 0
    for symbol in range(LITERALS):
        own += literals[symbol] * lengths[symbol]
        given += literals[symbol] * fixed[symbol]
    for symbol in range(DISTANCES):
        own += far[symbol] * distances[symbol]
        given += far[symbol] * 5
    if own < given:
        put(out, state, 4, 3)
        put_lengths(out, state, lengths, distances)
        codes, codes_far = codes_of(lengths), codes_of(distances)
    else:
        put(out, state, 2, 3)
        lengths, distances = fixed, np.full(DISTANCES, 5, np.int64)
        whole = np.full(288, 8, np.int64)
        whole[:LITERALS] = fixed
        codes, codes_far = codes_of(whole), codes_of(distances)
    at, waiting, bits = np.int64(state[0]), state[1], state[2]
    for j in range(count):
        token = tokens[j]
        if token & MATCH:
            length = ((token >> np.uint32(16)) & np.uint32(255)) + np.uint32(3)
            distance = (token & np.uint32(65535)) + np.uint32(1)
            symbol = LENGTH_SYMBOL[length]
            waiting |= codes[257 + symbol] << bits
            bits += np.uint64(lengths[257 + symbol])
            waiting |= np.uint64(length - LENGTH_BASE[symbol]) << bits
            bits += np.uint64(LENGTH_EXTRA[symbol])
            symbol = DISTANCE_SYMBOL[distance]
            waiting |= codes_far[symbol] << bits
            bits += np.uint64(distances[symbol])
            waiting |= np.uint64(distance - DISTANCE_BASE[symbol]) << bits
            bits += np.uint64(DISTANCE_EXTRA[symbol])
        else:
            waiting |= codes[token] << bits
            bits += np.uint64(lengths[token])
        while bits >= 8:
            out[at] = waiting & np.uint64(255)
            at += 1
            waiting >>= np.uint64(8)
            bits -= np.uint64(8)
    state[0], state[1], state[2] = at, waiting, bits
    put(out, state, codes[END], lengths[END])
    put(out, state, 0, 3)
    if state[2] > 0:
        put(out, state, 0, 8 - state[2])
    put(out, state, 0xFFFF0000, 32)
    return np.int64(state[0])
