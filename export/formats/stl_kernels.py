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
    """Normal and corners of each triangle in single precision; the normal is 0 where there is no area.

    `rows` have a column `numbers` of 12; what else they have stays as it is.
    """
    for i in range(triangles.shape[0]):
        a, b, c = triangles[i, 0], triangles[i, 1], triangles[i, 2]
        row = rows[i].numbers
        ax, ay, az = points[a, 0], points[a, 1], points[a, 2]
        bx, by, bz = points[b, 0], points[b, 1], points[b, 2]
        cx, cy, cz = points[c, 0], points[c, 1], points[c, 2]
        row[3], row[4], row[5] = ax, ay, az
        row[6], row[7], row[8] = bx, by, bz
        row[9], row[10], row[11] = cx, cy, cz
        x0, y0, z0 = np.float64(ax), np.float64(ay), np.float64(az)
        x1, y1, z1 = bx - x0, by - y0, bz - z0
        x2, y2, z2 = cx - x0, cy - y0, cz - z0
        x, y, z = y1 * z2 - z1 * y2, z1 * x2 - x1 * z2, x1 * y2 - y1 * x2
        length = sqrt(x * x + y * y + z * z)
        scale = 1 / length if length > 0 else 0.0
        row[0], row[1], row[2] = x * scale, y * scale, z * scale
