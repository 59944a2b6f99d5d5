"""The skin of a tree whose cells touch at edges or corners, each with a sheet of its own there.

The boundary is meshed as if every corner were one vertex; then the few squares around contacts, and their
vertices, are put right.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int, UInt8, UInt64

from export.meshing.contacts import edges_at_corner, face_slots
from export.meshing.entries import MAX_TRIANGLES, Index, Keys, brick_words
from export.meshing.joining import beside
from export.meshing.sheets import Sheets, contact_sides, exact_corners, means
from ifs.mesh import Mesh
from trees.errors import TooManyPieces
from trees.tree import Tree

Rows = UInt64[np.ndarray, "_blocks 6"]
BATCH = 2**16


def _checkered() -> Bool[np.ndarray, "256 3"]:
    """Whether the edge on the low side of a corner, along x, y or z, lies between two touching cells."""
    slots, edges = face_slots(), edges_at_corner()
    codes = np.arange(256)
    faces = np.array([(codes >> low ^ codes >> high) & 1 for low, high in slots])
    return np.stack([faces[edges[2 * axis]].all(axis=0) for axis in range(3)], axis=1)


CHECKERED = _checkered()


@dataclass(frozen=True, eq=False)
class Touching:
    """The squares that have a corner of several fans, or a side at which two cells touch.

    `squares` are their numbers among all, `vertices` the numbers of the vertices of `sheets`. `size` is how
    many vertices there are in all: the corners of the grid, one for the first fan of each, then the others.
    """

    squares: Int[np.ndarray, " squares"]
    vertices: Int[np.ndarray, " vertices"]
    sheets: Sheets
    size: int


def parted(
    tree: Tree,
    rows: Rows,
    index: Index,
    touched: Keys,
    shares: Float[np.ndarray, " _n"],
    style: str,
    gap: float,
) -> Mesh:
    """The mesh of a tree with contacts, those in `touched`, of which `rows` are the blocks; see `skin`.

    `shares` are those of the crossings, square by square, none for half-way. Raises `TooManyPieces` above
    2^30 triangles.
    """
    from export.meshing.kernels import bent_triangles, placed
    from export.meshing.parted_kernels import put_right

    touching = touching_of(tree, rows, index, touched)
    sheets = touching.sheets
    share = shares[touching.squares, None] if len(shares) else 0.5
    crossings = sheets.inner + 0.5 + share * sheets.normals
    sides, middles = contact_sides(sheets, crossings, style, gap)
    centre = touching.size + len(middles)
    vertices = np.zeros((centre + len(touching.squares), 3))
    choice = _plain(rows, index, shares, style, vertices)
    choice[touching.squares] = 2
    rounds = np.flatnonzero(choice == 2)
    whole = 2 * (len(choice) + len(rounds))
    count = whole + int(np.count_nonzero(sides >= 0))
    if count > MAX_TRIANGLES:
        raise TooManyPieces(count, MAX_TRIANGLES)
    vertices.resize((centre + len(rounds), 3), refcheck=False)
    several = sheets.split > 0
    places = exact_corners(sheets, gap) if style == "exact" else means(sheets, crossings)
    vertices[touching.vertices[several]] = places[several]
    vertices[touching.size : centre] = middles
    faces = np.empty((count, 3), dtype=np.int32)
    bent_triangles(rows, *index, shares, choice, centre, vertices, faces)
    starts = 2 * (touching.squares + np.searchsorted(rounds, touching.squares))
    put_right(sheets.squares, touching.vertices, sides, touching.size, starts, faces, whole)
    placed(vertices, np.array(tree.origin), tree.cell_size)
    return Mesh(vertices, faces)


def touching_of(tree: Tree, rows: Rows, index: Index, touched: Keys) -> Touching:
    """The squares around contacts, and how they hang together."""
    from export.meshing.parted_kernels import codes_of, touching_squares

    # a contact is found in the block it starts in; the squares around it end at most two corners further on
    keys = np.unique(beside(touched, 1))
    at = np.minimum(np.searchsorted(rows[:, 0], keys), len(rows) - 1)
    blocks = at[rows[at, 0] == keys]
    size = int(np.bitwise_count(rows[:, 1]).sum())
    codes, others = np.zeros(size, dtype=np.uint8), np.zeros(size, dtype=np.int32)
    for start in range(0, len(blocks), BATCH):
        some = blocks[start : start + BATCH]
        words = brick_words(tree, beside(rows[some, 0], -1).ravel()).reshape(-1, 8)
        size = codes_of(words, some, rows, index[0], size, codes, others)
    near = np.zeros(len(rows), dtype=bool)
    near[blocks] = True
    limit = int(np.bitwise_count(rows[near, 3:]).sum())
    squares, sheets, vertices = touching_squares(rows, *index, near, codes, others, CHECKERED, limit, size)
    return Touching(squares, vertices, Sheets(*sheets), size)


def _plain(
    rows: Rows,
    index: Index,
    shares: Float[np.ndarray, " _n"],
    style: str,
    vertices: Float[np.ndarray, "_vertices 3"],
) -> UInt8[np.ndarray, " squares"]:
    """Writes each corner as one vertex, in cells; where the diagonal of each square starts, 2 for none."""
    from export.meshing.diagonals import MARGIN
    from export.meshing.kernels import chosen
    from export.meshing.kernels import means as means_of_squares
    from export.meshing.parted_kernels import grid_corners

    choice = np.zeros(np.bitwise_count(rows[:, 3:]).sum(), dtype=np.uint8)
    if style == "exact":
        grid_corners(rows, index[0], vertices)
    else:
        counts = np.zeros(np.bitwise_count(rows[:, 1]).sum(), dtype=np.uint8)
        means_of_squares(rows, *index, shares, vertices, counts)
        chosen(rows, *index, vertices, choice, MARGIN)
    return choice
