"""Cutting the squares of a voxel surface into triangles that do not meet one another."""

from dataclasses import dataclass
from typing import no_type_check

import numba
import numpy as np
from jaxtyping import Float, Int, UInt8

from export.meshing.diagonals import MARGIN


@dataclass(frozen=True, eq=False)
class Polygons:
    """Squares between a filled and an empty voxel, lengths in voxels.

    `squares` are rows of `vertices`; `crossings` is the point of each square on the segment from
    `inner`, the centre of the filled voxel, to `inner + normals`, that of the empty one; `split`
    marks vertices that share their corner of the grid with another one.
    """

    vertices: Float[np.ndarray, "vertices 3"]
    squares: Int[np.ndarray, "squares 4"]
    crossings: Float[np.ndarray, "squares 3"]
    inner: Float[np.ndarray, "squares 3"]
    normals: Int[np.ndarray, "squares 3"]
    split: UInt8[np.ndarray, "vertices"]


def triangulate(
    polygons: Polygons,
    sides: Int[np.ndarray, "squares 4"] | None,
    middles: Float[np.ndarray, "middles 3"],
) -> tuple[Float[np.ndarray, "all 3"], Int[np.ndarray, "triangles 3"]]:
    """Triangles of all squares, and the vertices they need.

    `sides[f, s]` is the row of `middles` to be put between corner s and the next of square f, or
    -1. A square without such, and without split corners, is cut along a diagonal if that keeps its
    triangles in the envelope of the square: the four tetrahedra spanned by the segment between the
    two voxel centres and a side of the square. Envelopes of different squares only share faces
    (Ju and Udeshi, Intersection-free contouring on an octree grid, 2006). Other squares become a
    fan around their crossing, which always lies in the envelope.
    """
    squares, vertices = polygons.squares, polygons.vertices
    choice = _choose(vertices, squares, polygons.inner, polygons.normals, MARGIN)
    if polygons.split.any():
        choice[polygons.split[squares].any(axis=1)] = 2
    if sides is not None:
        choice[(sides >= 0).any(axis=1)] = 2
    cut = choice < 2
    start = choice[cut][:, None]
    pairs = [np.take_along_axis(squares[cut], (start + np.array(k)) % 4, 1) for k in _HALVES]
    flat = np.stack(pairs, axis=1).reshape(-1, 3)
    round_ = np.flatnonzero(~cut)
    first_middle = len(vertices)
    first_centre = first_middle + len(middles)
    centres = first_centre + np.arange(len(round_))
    fans = []
    for side in range(4):
        one, two = squares[round_, side], squares[round_, (side + 1) % 4]
        middle = np.full(len(round_), -1) if sides is None else sides[round_, side]
        whole = middle < 0
        fans.append(np.column_stack([centres, one, two])[whole])
        halves = np.column_stack([centres, one, first_middle + middle, two])[~whole]
        fans += [halves[:, [0, 1, 2]], halves[:, [0, 2, 3]]]
    faces = np.concatenate([flat, *fans])
    return np.concatenate([vertices, middles, polygons.crossings[round_]]), faces


_HALVES = ([0, 1, 2], [0, 2, 3])


@numba.njit(cache=True)
@no_type_check
def _choose(vertices, squares, inner, normals, margin):
    """For each square the corner its diagonal starts from (0 or 1, the shorter one), or 2."""
    choice = np.full(len(squares), 2, dtype=np.uint8)
    ring = np.empty((4, 3))
    for f in range(len(squares)):
        axis = 0
        while normals[f, axis] == 0:
            axis += 1
        u, v = (axis + 1) % 3, (axis + 2) % 3
        out = normals[f, axis]
        for s in range(4):
            from_inner = vertices[squares[f, s]] - inner[f]
            ring[s, 0] = from_inner[u]
            ring[s, 1] = from_inner[v] * out
            ring[s, 2] = from_inner[axis] * out
        best = np.inf
        for s in range(2):
            length = ((ring[s] - ring[s + 2]) ** 2).sum()
            if length < best - margin and _safe(ring, s, margin):
                choice[f] = s
                best = length
    return choice


@numba.njit(cache=True)
@no_type_check
def _safe(ring, s, margin):
    """Whether the diagonal from corner s keeps to the envelope; the axis is the third coordinate
    from 0 (inside) to 1 (outside) and the corners turn around it counter-clockwise."""
    a, b, c, d = ring[s], ring[s + 1], ring[(s + 2) % 4], ring[(s + 3) % 4]
    turn = _cross(a, c)
    if abs(turn) <= margin * margin:
        share = _dot(a, a - c) / _dot(a - c, a - c)
        height = a[2] + share * (c[2] - a[2])
        return margin < height < 1 - margin
    if turn < 0:
        a, b, c, d = c, d, a, b
    # the diagonal passes on the side of b, the axis goes through the triangle a c d
    ac, cd, da = _cross(a, c), _cross(c, d), _cross(d, a)
    height = (cd * a[2] + da * c[2] + ac * d[2]) / (ac + cd + da)
    if not margin < height < 1 - margin:
        return False
    # where the diagonal crosses the half-plane of b: within the triangle of b and the axis?
    ab, bc = _cross(a, b), _cross(b, c)
    share = ab / (ab + bc)
    x = a[0] + share * (c[0] - a[0])
    y = a[1] + share * (c[1] - a[1])
    z = a[2] + share * (c[2] - a[2])
    near = (x * b[0] + y * b[1]) / (b[0] ** 2 + b[1] ** 2)
    low = near * b[2]
    return near <= 1 and low - margin <= z <= low + (1 - near) + margin


@numba.njit(cache=True, inline="always")
@no_type_check
def _cross(p, q):
    return p[0] * q[1] - p[1] * q[0]


@numba.njit(cache=True, inline="always")
@no_type_check
def _dot(p, q):
    return p[0] * q[0] + p[1] * q[1]
