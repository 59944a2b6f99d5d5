"""The inner loops of sums over cells and of counts of nodes.

Imported inside the functions that use it, for numba takes a while to load.
"""

from typing import no_type_check

import numba
import numpy as np

from trees.kernels import popcount

ZERO = np.uint64(0)
ONE = np.uint64(1)
SIX = np.uint64(6)
BATCH = 64
BYTE = np.uint64(255)
FAR = np.uint64(0xFFFFFFFFFFFFFFFF)
NEAR = np.uint64(12)
NEAR_MASK = np.uint64(4095)


@no_type_check
@numba.njit(cache=True)
def products(starts, words, bricks, table, near, parents, axes, degrees, upto, cuts, radix, limbs, rooms):
    """`sum of W_m(word) X^n` over the aligned blocks of equal bricks, one sum a level, n and m.

    A block of `2^j` bricks is of level j; X is its corner, in blocks, `X_i = x_i >> cuts[j, i]`. The sums
    have `rooms` digits of `radix` bits. `table[t, v]` holds the sums over the cells of byte t of a word
    where it has the value v, `near` the coordinates of the lowest 12 bits of a brick's number. Monomial n is
    that of `parents[n]` times coordinate `axes[n]`; `upto[d]` monomials have degrees up to d.
    """
    levels, k = cuts.shape
    size, order = parents.size, upto.size - 1
    total = np.zeros((levels, rooms, size, size), np.int64)
    weights = np.empty((levels, size, BATCH), np.float64)
    corners = np.ones((levels, limbs, size, BATCH), np.float64)
    places = np.zeros((levels, k, BATCH), np.float64)
    filled = np.zeros(levels, np.int64)
    batches = np.zeros(levels, np.int64)
    weight = np.empty(size, table.dtype)
    powers = np.zeros((size, limbs), np.uint64)
    digits = np.empty(limbs, np.uint64)
    far, coordinates = np.empty(k, np.uint64), np.empty(k, np.uint64)
    last = FAR
    for entry in range(starts.size):
        word = words[entry]
        if word == ZERO:
            continue
        row = table[0, word & BYTE]
        for m in range(size):
            weight[m] = row[m]
        for t in range(1, 8):
            row = table[t, (word >> np.uint64(8 * t)) & BYTE]
            for m in range(size):
                weight[m] += row[m]
        brick = starts[entry]
        stop = starts[entry + 1] if entry + 1 < starts.size else bricks
        while brick < stop:
            level, step = 0, ONE
            while level + 1 < levels and brick & step == ZERO and brick + (step << ONE) <= stop:
                step <<= ONE
                level += 1
            if brick >> NEAR != last:
                last = brick >> NEAR
                separate_into(far, last, NEAR + SIX)
            low = np.int64(brick & NEAR_MASK)
            for i in range(k):
                coordinates[i] = (far[i] | near[low, i]) >> np.uint64(cuts[level, i])
            slot = filled[level]
            for m in range(size):
                weights[level, m, slot] = weight[m]
            if limbs == 1:
                for i in range(k):
                    places[level, i, slot] = coordinates[i]
            else:
                long_powers(powers, coordinates, parents, axes, digits, radix)
                for limb in range(limbs):
                    for n in range(size):
                        corners[level, limb, n, slot] = np.float64(powers[n, limb])
            filled[level] = slot + 1
            if slot + 1 == BATCH:
                if limbs == 1:
                    short_powers(corners[level, 0], places[level], parents, axes)
                gather(total[level], weights[level], corners[level], BATCH, degrees, upto, order)
                filled[level] = 0
                batches[level] += 1
                if batches[level] & 8191 == 0:
                    carry(total[level], radix)
            brick += step
    for level in range(levels):
        if limbs == 1:
            short_powers(corners[level, 0], places[level], parents, axes)
        gather(total[level], weights[level], corners[level], filled[level], degrees, upto, order)
        carry(total[level], radix)
    return total


@no_type_check
@numba.njit(cache=True)
def separate_into(coordinates, key, shift):
    """The coordinates of the cell with Morton key `key << shift`."""
    k = coordinates.size
    coordinates[:] = ZERO
    place = np.int64(shift)
    while key != ZERO:
        coordinates[k - 1 - place % k] |= (key & ONE) << np.uint64(place // k)
        key >>= ONE
        place += 1


@no_type_check
@numba.njit(cache=True)
def short_powers(corners, places, parents, axes):
    """The monomials of a batch of coordinates that stay below `2^53`; the first one is 1 already."""
    for n in range(1, parents.size):
        for slot in range(BATCH):
            corners[n, slot] = corners[parents[n], slot] * places[axes[n], slot]


@no_type_check
@numba.njit(cache=True)
def long_powers(powers, coordinates, parents, axes, digits, radix):
    """The monomials of coordinates, in digits of `radix` bits, at most 30."""
    limbs = digits.size
    mask = (ONE << np.uint64(radix)) - ONE
    powers[:] = ZERO
    powers[0, 0] = ONE
    for n in range(1, parents.size):
        x = coordinates[axes[n]]
        for place in range(limbs):
            digits[place] = x & mask
            x >>= np.uint64(radix)
        for i in range(limbs):
            if digits[i] == ZERO:
                continue
            over = ZERO
            for j in range(limbs - i):
                value = powers[n, i + j] + digits[i] * powers[parents[n], j] + over
                powers[n, i + j] = value & mask
                over = value >> np.uint64(radix)


@no_type_check
@numba.njit(cache=True, fastmath={"reassoc", "contract"})
def gather(total, weights, corners, filled, degrees, upto, order):
    """Add the products of a batch: all are integers below 2^53, so any order of summation is exact."""
    for limb in range(corners.shape[0]):
        for n in range(degrees.size):
            for m in range(upto[order - degrees[n]]):
                found = 0.0
                for slot in range(filled):
                    found += weights[m, slot] * corners[limb, n, slot]
                total[limb, n, m] += np.int64(found)


@no_type_check
@numba.njit(cache=True)
def carry(total, radix):
    """Bring all digits but the highest below `2^radix`."""
    for limb in range(total.shape[0] - 1):
        for n in range(total.shape[1]):
            for m in range(total.shape[2]):
                value = total[limb, n, m]
                total[limb + 1, n, m] += value >> radix
                total[limb, n, m] = value & ((1 << radix) - 1)


@no_type_check
@numba.njit(cache=True)
def occupied(starts, words, bricks, shifts):
    """How many nodes of `2^shift` keys meet the set, modulo 2^64, for each shift, in rising order."""
    counts = np.zeros(shifts.size, np.uint64)
    previous = ZERO
    met = False
    for entry in range(starts.size):
        word = words[entry]
        if word == ZERO:
            continue
        first = starts[entry]
        stop = starts[entry + 1] if entry + 1 < starts.size else bricks
        folded, done = word, 0
        for i in range(shifts.size):
            shift = shifts[i]
            if shift < 6:
                while done < shift:
                    folded |= folded >> (ONE << np.uint64(done))
                    done += 1
                counts[i] += ones(folded & comb(shift)) * (stop - first)
            else:
                s = np.uint64(shift - 6)
                counts[i] += ((stop - ONE) >> s) - (first >> s) + ONE
                if met and previous >> s == first >> s:
                    counts[i] -= ONE
        previous, met = stop - ONE, True
    return counts


@no_type_check
@numba.njit(cache=True, inline="always")
def comb(shift):
    """The word whose bits are the multiples of `2^shift`."""
    word = ZERO
    step = 1 << shift
    for bit in range(0, 64, step):
        word |= ONE << np.uint64(bit)
    return word


@no_type_check
@numba.njit(cache=True, inline="always")
def ones(word):
    """How many bits are 1."""
    return np.uint64(popcount(word))
