"""The boundary of voxels as squares: sheets, whose corners are shared only within a fan."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int, UInt8


@dataclass(frozen=True, eq=False)
class Sheets:
    """The boundary of voxels as unit squares whose corners are shared along each sheet.

    A vertex is one fan of squares around a corner of the grid. `corners` is `(vertices, 3)`, in
    voxels; `split` marks vertices that share their corner with another fan; `squares` is
    `(squares, 4)`, counter-clockwise from outside; `inner` is the filled voxel behind each square
    and `normals` the step out of it; `contact` has bit s set where side s of a square (from its
    corner s to the next) is an edge at which two filled voxels touch.
    """

    corners: Int[np.ndarray, "vertices 3"]
    split: UInt8[np.ndarray, "vertices"]
    squares: Int[np.ndarray, "squares 4"]
    inner: Int[np.ndarray, "squares 3"]
    normals: Int[np.ndarray, "squares 3"]
    contact: UInt8[np.ndarray, "squares"]


def means(sheets: Sheets, places: Float[np.ndarray, "squares 3"]) -> Float[np.ndarray, "vertices 3"]:
    """At each vertex the mean of what its squares hold."""
    ids, size = sheets.squares.ravel(), len(sheets.corners)
    counts = np.bincount(ids, minlength=size)
    sums = [np.bincount(ids, np.repeat(places[:, a], 4), minlength=size) for a in range(3)]
    return np.column_stack(sums) / counts[:, None]


def exact_corners(sheets: Sheets, gap: float) -> Float[np.ndarray, "vertices 3"]:
    """The corners of the grid, those of several fans moved towards their own voxels."""
    vertices = sheets.corners.astype(np.float64)
    moved = np.flatnonzero(sheets.split)
    if len(moved):
        pull = (means(sheets, sheets.inner + 0.5) - vertices)[moved]
        vertices[moved] += gap * pull / np.abs(pull).max(axis=1, keepdims=True)
    return vertices


def contact_sides(
    sheets: Sheets, crossings: Float[np.ndarray, "squares 3"], style: str, gap: float
) -> tuple[Int[np.ndarray, "squares 4"], Float[np.ndarray, "middles 3"]]:
    """The number of the vertex put into the middle of each side, -1 for none, and their places.

    A contact edge gets one on each of its two sheets, as both may end at the same two vertices. Two squares
    share it, those of one voxel.
    """
    square, side = np.nonzero((sheets.contact[:, None] >> np.arange(4)) & 1)
    start, end = sheets.squares[square, side], sheets.squares[square, (side + 1) % 4]
    twice = sheets.corners[start] + sheets.corners[end]
    way = (2 * sheets.inner[square] + 1 > twice) @ np.array([1, 2, 4])
    low, high = (some.astype(np.int64) for some in (np.minimum(start, end), np.maximum(start, end)))
    order = np.argsort(low << 33 | high << 3 | way)
    one, two = order[0::2], order[1::2]
    if style == "exact":
        places = twice[one] / 2
        pull = sheets.inner[square[one]] + 0.5 - places
        places += gap * pull / np.abs(pull).max(axis=1, keepdims=True)
    else:
        places = (crossings[square[one]] + crossings[square[two]]) / 2
    sides = np.full((len(sheets.squares), 4), -1, dtype=np.int64)
    sides[square[order], side[order]] = np.repeat(np.arange(len(one)), 2)
    return sides, places
