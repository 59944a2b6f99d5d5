"""The inner loops of the Peano-Hilbert curve.

Imported inside the functions that use it, for numba takes a while to load.
"""

from typing import no_type_check

import numba
import numpy as np

ZERO = np.uint64(0)
ONE = np.uint64(1)


@no_type_check
@numba.njit(cache=True)
def indices(keys, k, bits):
    """Places on the curve of Morton keys, after Skilling: undo the turns, then the Gray code."""
    found = np.empty(keys.size, np.uint64)
    x = np.empty(k, np.uint64)
    for i in range(keys.size):
        spread(keys[i], x, bits)
        for bit in range(bits - 1, 0, -1):
            for axis in range(k):
                turn(x, axis, bit)
        for axis in range(1, k):
            x[axis] ^= x[axis - 1]
        flips = ZERO
        for bit in range(bits - 1, 0, -1):
            if (x[k - 1] >> np.uint64(bit)) & ONE:
                flips ^= (ONE << np.uint64(bit)) - ONE
        for axis in range(k):
            x[axis] ^= flips
        found[i] = gather(x, bits)
    return found


@no_type_check
@numba.njit(cache=True)
def keys(indices, k, bits):
    """Morton keys at these places of the curve: the steps of `indices` backwards."""
    found = np.empty(indices.size, np.uint64)
    x = np.empty(k, np.uint64)
    for i in range(indices.size):
        spread(indices[i], x, bits)
        last = x[k - 1] >> ONE
        for axis in range(k - 1, 0, -1):
            x[axis] ^= x[axis - 1]
        x[0] ^= last
        for bit in range(1, bits):
            for axis in range(k - 1, -1, -1):
                turn(x, axis, bit)
        found[i] = gather(x, bits)
    return found


@no_type_check
@numba.njit(cache=True, inline="always")
def turn(x, axis, bit):
    """One turn, its own inverse: mirror axis 0 below the bit where it is set, else swap it with the axis."""
    low = (ONE << np.uint64(bit)) - ONE
    chosen = low & (ZERO - ((x[axis] >> np.uint64(bit)) & ONE))  # low where the bit is set, else 0
    swapped = (x[0] ^ x[axis]) & (low ^ chosen)
    x[0] ^= swapped ^ chosen
    x[axis] ^= swapped


@no_type_check
@numba.njit(cache=True, inline="always")
def spread(key, x, bits):
    """The bits of a key, level by level, dealt to the axes."""
    k = x.size
    for axis in range(k):
        x[axis] = ZERO
    shift = k * bits
    for _ in range(bits):
        for axis in range(k):
            shift -= 1
            x[axis] = (x[axis] << ONE) | ((key >> np.uint64(shift)) & ONE)


@no_type_check
@numba.njit(cache=True, inline="always")
def gather(x, bits):
    """The key of the bits of the axes: the inverse of `spread`."""
    key = ZERO
    for bit in range(bits - 1, -1, -1):
        for axis in range(x.size):
            key = (key << ONE) | ((x[axis] >> np.uint64(bit)) & ONE)
    return key
