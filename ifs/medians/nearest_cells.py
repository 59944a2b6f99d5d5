"""For every cell of a grid the nearest cell of a set, exactly; numba kernels."""

from typing import no_type_check

import numba
import numpy as np
from jaxtyping import Bool, Int32

_FAR = np.int64(1) << 40


def nearest_cells(cells: Bool[np.ndarray, "x y z"]) -> Int32[np.ndarray, "x y z"]:
    """The index in the flat array of the nearest cell of a set that is not empty.

    One axis after the other, each line by the lower envelope of its parabolas, in whole numbers (Meijster,
    Roerdink and Hesselink, 2000): exact, in time and memory proportional to the grid. Of equally near cells
    that with the smallest first, then second, then third index is taken.

    >>> nearest_cells(np.array([[[True, False, False, False, True]]])).tolist()
    [[[0, 0, 0, 4, 4]]]
    """
    near = np.empty(cells.shape, dtype=np.int32)
    squares = np.empty(cells.shape, dtype=np.int64)
    _last_axis(cells, near, squares)
    for axis in (1, 0):
        stride = int(np.prod(cells.shape[axis + 1 :]))
        _swept(np.moveaxis(near, axis, 2), np.moveaxis(squares, axis, 2), stride)
    return near


@numba.njit(cache=True)
@no_type_check
def half_way(result, cells, table, towards):
    """Mark the middles between cells and the cells that a table names; return the largest squared distance.

    Middles are rounded towards the cell that the table names, or else towards the other.
    """
    nx, ny, nz = cells.shape
    farthest = 0
    for i in range(nx):
        for j in range(ny):
            for k in range(nz):
                if not cells[i, j, k]:
                    continue
                number = table[i, j, k]
                a, b, c = number // (ny * nz), number // nz % ny, number % nz
                farthest = max(farthest, (a - i) ** 2 + (b - j) ** 2 + (c - k) ** 2)
                if towards:
                    result[_middle(a, i), _middle(b, j), _middle(c, k)] = True
                else:
                    result[_middle(i, a), _middle(j, b), _middle(k, c)] = True
    return farthest


@numba.njit(cache=True)
@no_type_check
def _middle(kept, other):
    half = abs(other - kept) // 2
    return kept + half if other >= kept else kept - half


@numba.njit(cache=True)
@no_type_check
def _last_axis(cells, near, squares):
    nx, ny, nz = cells.shape
    for i in range(nx):
        for j in range(ny):
            seen = -1
            for k in range(nz):
                if cells[i, j, k]:
                    seen = k
                near[i, j, k] = seen
                squares[i, j, k] = (k - seen) ** 2 if seen >= 0 else _FAR
            seen = -1
            for k in range(nz - 1, -1, -1):
                if cells[i, j, k]:
                    seen = k
                if seen >= 0 and (seen - k) ** 2 < squares[i, j, k]:
                    near[i, j, k] = seen
                    squares[i, j, k] = (seen - k) ** 2


@numba.njit(cache=True)
@no_type_check
def _swept(near, squares, stride):
    """Go on along the last axis of two views, whose cells are `stride` apart in the flat array."""
    nx, ny, nz = near.shape
    heights, best = np.empty(nz, np.int64), np.empty(nz, np.int64)
    points, starts, old = np.empty(nz, np.int64), np.empty(nz, np.int64), np.empty(nz, np.int64)
    for i in range(nx):
        for j in range(ny):
            for k in range(nz):
                heights[k], old[k] = squares[i, j, k], near[i, j, k]
            if not _envelope(heights, best, points, starts):
                continue
            for k in range(nz):
                b = best[k]
                near[i, j, k] = b * stride + old[b]
                squares[i, j, k] = heights[b] + (k - b) ** 2


@numba.njit(cache=True)
@no_type_check
def _envelope(heights, best, points, starts):
    """For each x the p that makes `heights[p] + (x - p)^2` least, the smaller p of two; False without any."""
    count = 0
    for q in range(len(heights)):
        if heights[q] >= _FAR:
            continue
        start = 0
        while count > 0:
            p = points[count - 1]
            start = (heights[q] + q * q - heights[p] - p * p) // (2 * (q - p)) + 1
            if start > starts[count - 1]:
                break
            count -= 1
            start = 0
        points[count], starts[count] = q, start
        count += 1
    at = 0
    for x in range(len(heights) if count else 0):
        while at + 1 < count and starts[at + 1] <= x:
            at += 1
        best[x] = points[at]
    return count > 0
