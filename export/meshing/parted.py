"""The skin of a tree whose cells touch at edges or corners, each with a sheet of its own there."""

import numpy as np
from jaxtyping import Bool, Float, UInt8, UInt64

from export.meshing.contacts import FAN_COUNT, FANS, edges_at_corner, face_slots
from export.meshing.entries import brick_words
from export.meshing.joining import beside
from export.meshing.sheets import Sheets, contact_sides, exact_corners, means
from export.meshing.triangulate import Polygons, triangulate
from ifs.mesh import Mesh
from trees.tree import Tree

BATCH = 2**16


def _checkered() -> Bool[np.ndarray, "256 3"]:
    """Whether the edge on the low side of a corner, along x, y or z, lies between two touching cells."""
    slots, edges = face_slots(), edges_at_corner()
    codes = np.arange(256)
    faces = np.array([(codes >> low ^ codes >> high) & 1 for low, high in slots])
    return np.stack([faces[edges[2 * axis]].all(axis=0) for axis in range(3)], axis=1)


CHECKERED = _checkered()


def parted(
    tree: Tree, rows: UInt64[np.ndarray, "blocks 6"], shares: Float[np.ndarray, " _n"], style: str, gap: float
) -> Mesh:
    """The mesh of a tree with contacts, of which `rows` are the blocks; see `skin`.

    `shares` are those of the crossings, square by square, none for half-way.
    """
    sheets = sheets_of(tree, rows)
    share = shares[:, None] if len(shares) else 0.5
    crossings = sheets.inner + 0.5 + (0.5 if style == "exact" else share) * sheets.normals
    vertices = exact_corners(sheets, gap) if style == "exact" else means(sheets, crossings)
    polygons = Polygons(vertices, sheets.squares, crossings, sheets.inner + 0.5, sheets.normals, sheets.split)
    sides, middles = contact_sides(sheets, crossings, "exact" if style == "exact" else "smooth", gap)
    vertices, faces = triangulate(polygons, sides, middles)
    narrow = np.int32 if len(vertices) < 2**31 else np.int64
    return Mesh(np.array(tree.origin) + vertices * tree.cell_size, faces.astype(narrow))


def sheets_of(tree: Tree, rows: UInt64[np.ndarray, "blocks 6"]) -> Sheets:
    """The squares of the boundary and how they hang together: see `export.surface.Sheets`."""
    from export.meshing.kernels import bases_of, table_of
    from export.meshing.parted_kernels import corner_cells, sheet_squares

    codes = corner_codes(tree, rows)
    fans = FAN_COUNT[codes].astype(np.int64)
    first = np.cumsum(fans) - fans
    bases = np.empty(len(rows), dtype=np.int32)
    slots = np.full(1 << (len(rows) * 3 // 2).bit_length(), -1, dtype=np.int32)
    bases_of(rows, bases)
    table_of(rows, slots)
    count = int(np.bitwise_count(rows[:, 3:]).sum())
    squares = np.empty((count, 4), dtype=np.int64)
    inner, normals = np.empty((count, 3), dtype=np.int64), np.zeros((count, 3), dtype=np.int64)
    contact = np.zeros(count, dtype=np.uint8)
    sheet_squares(rows, bases, slots, codes, first, FANS, CHECKERED, squares, inner, normals, contact)
    corners = np.repeat(corner_cells(rows, len(codes)), fans, axis=0)
    split = np.repeat(fans > 1, fans).astype(np.uint8)
    return Sheets(corners, split, squares, inner, normals, contact)


def corner_codes(tree: Tree, rows: UInt64[np.ndarray, "blocks 6"]) -> UInt8[np.ndarray, " corners"]:
    """The codes of the corners on the boundary, block by block."""
    from export.meshing.parted_kernels import codes_of

    parts = []
    for start in range(0, len(rows), BATCH):
        some = rows[start : start + BATCH]
        near = beside(some[:, 0], -1)
        words = brick_words(tree, near.ravel()).reshape(-1, 8)
        parts.append(codes_of(words, some[:, 1], int(np.bitwise_count(some[:, 1]).sum())))
    return np.concatenate(parts)
