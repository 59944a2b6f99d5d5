"""The rows of binary STL.

Imported inside the functions that use it, for numba takes a while to load.
"""

from math import sqrt
from typing import no_type_check

import numba
import numpy as np


@no_type_check
@numba.njit(cache=True)
def fill(points, triangles, rows):
    """Normal and corners of each triangle as words of 16 bits; the normal is 0 where there is no area."""
    edge, numbers = np.zeros((2, 3)), np.zeros(12, np.float32)
    words = numbers.view(np.uint16)
    for i in range(triangles.shape[0]):
        for corner in range(3):
            for axis in range(3):
                numbers[3 + 3 * corner + axis] = points[triangles[i, corner], axis]
        for axis in range(3):
            start = np.float64(numbers[3 + axis])
            edge[0, axis] = np.float64(numbers[6 + axis]) - start
            edge[1, axis] = np.float64(numbers[9 + axis]) - start
        x = edge[0, 1] * edge[1, 2] - edge[0, 2] * edge[1, 1]
        y = edge[0, 2] * edge[1, 0] - edge[0, 0] * edge[1, 2]
        z = edge[0, 0] * edge[1, 1] - edge[0, 1] * edge[1, 0]
        length = sqrt(x * x + y * y + z * z)
        scale = 1 / length if length > 0 else 0.0
        numbers[0], numbers[1], numbers[2] = x * scale, y * scale, z * scale
        for k in range(24):
            rows[i, k] = words[k]
