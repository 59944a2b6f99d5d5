"""How far the normals around a vertex differ; imported inside the function that uses it."""

from typing import no_type_check

import numba


@no_type_check
@numba.njit(cache=True)
def least_cosines(offsets, squares, normals, cosines):
    """The least product of two normals around each vertex, 1 where there are none; 0 is no normal."""
    for vertex in range(cosines.size):
        least = 1.0
        for i in range(offsets[vertex], offsets[vertex + 1]):
            p = squares[i]
            px, py, pz = normals[p, 0], normals[p, 1], normals[p, 2]
            if px == 0 and py == 0 and pz == 0:
                continue
            for j in range(i + 1, offsets[vertex + 1]):
                q = squares[j]
                qx, qy, qz = normals[q, 0], normals[q, 1], normals[q, 2]
                if qx == 0 and qy == 0 and qz == 0:
                    continue
                least = min(least, px * qx + py * qy + pz * qz)
        cosines[vertex] = least
