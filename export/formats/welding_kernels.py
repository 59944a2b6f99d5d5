"""Equal positions found by hashing.

Imported inside the functions that use it, for numba takes a while to load.
"""

from typing import no_type_check

import numba
import numpy as np

ODD = (np.uint64(0x9E3779B97F4A7C15), np.uint64(0xC2B2AE3D27D4EB4F), np.uint64(0x165667B19E3779F9))
HALF = np.uint64(32)


@no_type_check
@numba.njit(cache=True)
def first_of_each(words, slots):
    """The number of each row of words (uint64) among the different rows, and where each of these comes first.

    `slots` are -1, a power of two of them, more than there are rows.
    """
    number = np.empty(len(words), np.int64)
    first = np.empty(len(words), np.int64)
    last = np.uint64(len(slots) - 1)
    count = 0
    for i in range(len(words)):
        a, b, c = words[i, 0], words[i, 1], words[i, 2]
        mixed = a * ODD[0]
        mixed = ((mixed ^ (mixed >> HALF)) + b) * ODD[1]
        mixed = ((mixed ^ (mixed >> HALF)) + c) * ODD[2]
        place = (mixed ^ (mixed >> HALF)) & last
        while True:
            found = slots[place]
            if found < 0:
                slots[place] = number[i] = count
                first[count] = i
                count += 1
                break
            row = first[found]
            if words[row, 0] == a and words[row, 1] == b and words[row, 2] == c:
                number[i] = found
                break
            place = (place + np.uint64(1)) & last
    return number, first[:count]
