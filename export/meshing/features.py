"""Edges and corners of a smooth skin: vertices placed where the planes of their crossings meet."""

import itertools
import math

import numpy as np
from jaxtyping import Bool, Float, Int

CUT = 0.01  # eigenvalues below this share of the largest are taken for 0
WEIGHT = 1e-10  # of the mean of the crossings, for vertices held back by their box

Matrices = Float[np.ndarray, "_n 3 3"]
Rows = Float[np.ndarray, "_n 3"]


def bends(
    offsets: Int[np.ndarray, " _offsets"],
    squares: Int[np.ndarray, " incidences"],
    normals: Float[np.ndarray, "patches 3"],
) -> Float[np.ndarray, " vertices"]:
    """For each vertex the largest angle, in radians, between the normals of two of its rectangles.

    `squares[offsets[v] : offsets[v + 1]]` are those of vertex v; normals of 0 do not count.
    """
    from export.meshing.features_kernels import least_cosines

    cosines = np.empty(len(offsets) - 1)
    least_cosines(offsets, squares, normals, cosines)
    return np.arccos(np.clip(cosines, -1, 1))


def squares_of_vertices(
    starts: Int[np.ndarray, " _offsets"], ring: Int[np.ndarray, " incidences"], vertices: int
) -> tuple[Int[np.ndarray, " incidences"], Int[np.ndarray, " _all"]]:
    """The rectangles around each vertex, vertex after vertex, and where those of each start."""
    square = np.repeat(np.arange(len(starts) - 1), np.diff(starts))
    order = np.argsort(ring, kind="stable")
    return square[order], np.append(0, np.cumsum(np.bincount(ring, minlength=vertices)))


def meeting_places(
    vertex: Int[np.ndarray, " planes"],
    points: Float[np.ndarray, "planes 3"],
    normals: Float[np.ndarray, "planes 3"],
    corners: Float[np.ndarray, "vertices 3"],
    reach: Float[np.ndarray, " vertices"],
    angle: float,
) -> Float[np.ndarray, "vertices 3"]:
    """Where the planes of each vertex meet: the least squares of their distances, in the box within `reach`.

    `vertex` says to which vertex a plane belongs, given by a point and a unit normal. With m the mean of the
    points, `x - m` is the shortest vector that minimises `sum (n . (x - p))^2`, small eigenvalues cut off
    (Ju, Losasso, Schaefer, Warren, Dual contouring of Hermite data, 2002); where it leaves the box, x is the
    least one in the box. `angle` (radians) is the bend from which on edges count; it bounds what is cut off.
    """
    count = len(corners)
    sizes = np.bincount(vertex, minlength=count)
    middle = np.stack([np.bincount(vertex, points[:, a], count) for a in range(3)], axis=1) / sizes[:, None]
    offsets = ((points - middle[vertex]) * normals).sum(axis=1)
    matrix, side = np.empty((count, 3, 3)), np.empty((count, 3))
    for a in range(3):
        side[:, a] = np.bincount(vertex, normals[:, a] * offsets, count)
        for b in range(3):
            matrix[:, a, b] = np.bincount(vertex, normals[:, a] * normals[:, b], count)
    values, vectors = np.linalg.eigh(matrix)
    least = min(CUT, math.tan(angle / 2) ** 2 / 4)
    kept = values > least * values[:, -1:]
    inverse = np.where(kept, 1 / np.where(kept, values, 1.0), 0.0)
    off = (vectors * inverse[:, None, :]) @ (vectors.transpose(0, 2, 1) @ side[:, :, None])
    off = off[:, :, 0]
    low, high = corners - reach[:, None] - middle, corners + reach[:, None] - middle
    out = ((off < low) | (off > high)).any(axis=1)
    if out.any():
        part = vectors[out]
        cut = (part * np.where(kept, values, 0.0)[out][:, None, :]) @ part.transpose(0, 2, 1)
        off[out] = _in_box(
            cut + WEIGHT * np.eye(3), (cut @ off[out][:, :, None])[:, :, 0], low[out], high[out]
        )
    return middle + off


def _in_box(matrix: Matrices, side: Rows, low: Rows, high: Rows) -> Rows:
    """The least of `x M x - 2 b x` in a box, over its inside, its faces, edges and corners."""
    best, result = np.full(len(side), np.inf), np.clip(np.zeros_like(side), low, high)
    for held in itertools.product((0, -1, 1), repeat=3):
        x = np.empty_like(side)
        free = [a for a in range(3) if held[a] == 0]
        fixed = [a for a in range(3) if held[a] != 0]
        for a in fixed:
            x[:, a] = low[:, a] if held[a] < 0 else high[:, a]
        if free:
            reduced = matrix[:, free][:, :, free]
            right = side[:, free]
            if fixed:
                right = right - (matrix[:, free][:, :, fixed] @ x[:, fixed][:, :, None])[:, :, 0]
            x[:, free] = np.linalg.solve(reduced, right[:, :, None])[:, :, 0]
        value = (x * ((matrix @ x[:, :, None])[:, :, 0] - 2 * side)).sum(axis=1)
        better = _inside(x, low, high) & (value < best)
        best, result = np.where(better, value, best), np.where(better[:, None], x, result)
    return result


def _inside(x: Rows, low: Rows, high: Rows) -> Bool[np.ndarray, " _n"]:
    return np.asarray(((x >= low) & (x <= high)).all(axis=1))
