"""From a tree to the closed triangle mesh of its boundary, straight from its words."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int, UInt64

from export.meshing.entries import check_space, entries
from export.meshing.joining import join_at
from ifs.mesh import Mesh
from trees.errors import TooManyPieces
from trees.tree import Tree

Field = Callable[[Float[np.ndarray, "points 3"]], Float[np.ndarray, " points"]]

CLEAR = 0.05  # a crossing keeps this share of the pitch from the centres on either side
JOINED = -0.5  # the field, in pitches, of a cell that was filled to join a contact
BATCH = 2**18
MAX_TRIANGLES = 2**30  # of which 32 bits number all vertices, with one more for each square


class EmptySolid(ValueError):
    """There is no filled voxel, so there is nothing to thicken, to mesh or to print."""


@dataclass(frozen=True, eq=False)
class Blocks:
    """The boundary by blocks of 4 x 4 x 4 corners, and where their vertices are numbered from.

    Rows are those of `skin_blocks.collected`; `slots` is a hash table of their keys.
    """

    rows: UInt64[np.ndarray, "blocks 6"]
    bases: Int[np.ndarray, " blocks"]
    slots: Int[np.ndarray, " slots"]
    vertices: int
    squares: int


def skin(
    tree: Tree,
    style: str = "exact",
    contacts: str = "join",
    field: Field | None = None,
    gap: float = 0.05,
) -> Mesh:
    """The boundary of the black cells of space: closed, outward, every edge in two triangles, every vertex
    in one fan.

    `style="exact"` keeps the squares of the cells: the volume is `tree.measure`, the area that of
    `trees.topology.surface_area`. `style="smooth"` (surface nets) moves each vertex to the mean of the places
    where the field changes sign between the cells on either side of its own squares, which stays within half
    a cell of the corner in each coordinate. `field` takes centres of cells, `(n, 3)` in mm, and gives n
    distances in mm, at most 0 in black cells; without it these places are half-way. The topology is the
    same: one vertex for each fan of faces around a corner. A square is cut along a diagonal that keeps both
    triangles between the two cells it parts, or into four triangles around its crossing where neither
    diagonal does (Ju and Udeshi, Intersection-free contouring on an octree grid, 2006); with joined contacts
    no two triangles intersect therefore.

    `contacts="join"` first fills cells that touch at an edge or a corner only (`join_contacts`).
    `contacts="separate"` gives each black cell its own sheet there; in the exact style the sheets are moved
    apart by `gap` cells (at most 0.25; 0 leaves them in one place). Without contacts the two do nothing.

    Vertices come by blocks of 4 x 4 x 4 corners in Morton order, extra ones last. Regions that are full or
    empty are not looked at; memory is that of the mesh and about a tenth more (where
    separate cells touch, several times the mesh). `faces` are int32 where that is enough.

    Raises `EmptySolid` when no cell is black, `ValueError` for an unknown style or rule, a gap out of range,
    or a field of another shape, with NaN or -inf, `TreeError` for a dimension other than 3, `TooManyPieces`
    above 2^30 triangles.

    >>> from trees import from_points
    >>> cube = skin(from_points([[1, 1, 1]], bits=2))
    >>> cube.vertices.shape, cube.faces.shape
    ((8, 3), (12, 3))
    """
    if style not in ("smooth", "exact") or contacts not in ("join", "separate"):
        raise ValueError(
            f"a skin is 'smooth' or 'exact' and contacts 'join' or 'separate', not {style!r} and {contacts!r}"
        )
    if not 0 <= gap <= 0.25:
        raise ValueError(f"the gap is a share of a cell from 0 to 0.25, not {gap}")
    check_space(tree)
    if not tree:
        raise EmptySolid("no cell is black: there is no surface")
    blocks, touched = _blocks(tree)
    if len(touched) and contacts == "separate":
        from export.meshing.parted import parted

        shares = _shares(tree, blocks, None if style == "exact" else field)
        return parted(tree, blocks.rows, shares, style, gap)
    if len(touched):
        tree = join_at(tree, touched)
        blocks, _ = _blocks(tree)
    return _exact(tree, blocks) if style == "exact" else _smooth(tree, blocks, field)


def _blocks(tree: Tree) -> tuple[Blocks, UInt64[np.ndarray, " _touched"]]:
    """The blocks of a tree, and the keys of those with contacts."""
    from export.meshing.blocks import collected
    from export.meshing.kernels import bases_of, table_of

    rows, touched, *counts = collected(*entries(tree), 0)
    vertices, squares = (int(count) for count in counts)
    if 2 * squares > MAX_TRIANGLES:
        raise TooManyPieces(2 * squares, MAX_TRIANGLES)
    bases = np.empty(len(rows), dtype=np.int32)
    slots = np.full(1 << (len(rows) * 3 // 2).bit_length(), -1, dtype=np.int32)
    bases_of(rows, bases)
    table_of(rows, slots)
    return Blocks(rows, bases, slots, vertices, squares), touched


def _exact(tree: Tree, blocks: Blocks) -> Mesh:
    from export.meshing.kernels import corners, flat_triangles

    vertices = np.empty((blocks.vertices, 3))
    corners(blocks.rows, np.array(tree.origin), tree.cell_size, vertices)
    faces = np.empty((2 * blocks.squares, 3), dtype=np.int32)
    flat_triangles(blocks.rows, blocks.bases, blocks.slots, faces)
    return Mesh(vertices, faces)


def _smooth(tree: Tree, blocks: Blocks, field: Field | None) -> Mesh:
    from export.meshing.kernels import bent_triangles, chosen, means, placed
    from export.meshing.triangulate import MARGIN

    where = blocks.rows, blocks.bases, blocks.slots
    shares = _shares(tree, blocks, field)
    vertices = np.zeros((blocks.vertices, 3))
    means(*where, shares, vertices, np.zeros(blocks.vertices, dtype=np.uint8))
    choice = np.empty(blocks.squares, dtype=np.uint8)
    rounds = chosen(*where, vertices, choice, MARGIN)
    vertices.resize((blocks.vertices + rounds, 3), refcheck=False)
    faces = np.empty((2 * blocks.squares + 2 * rounds, 3), dtype=np.int32)
    bent_triangles(*where, shares, choice, blocks.vertices, vertices, faces)
    placed(vertices, np.array(tree.origin), tree.cell_size)
    return Mesh(vertices, faces)


def _shares(tree: Tree, blocks: Blocks, field: Field | None) -> Float[np.ndarray, " squares"]:
    """How far the field changes sign on the way from the filled cell of each square to the empty one.

    Without a field there are none: everywhere half-way.
    """
    from export.meshing.kernels import cells_beside

    if field is None:
        return np.zeros(0)
    shares = np.empty(blocks.squares)
    inside, outside = np.empty((BATCH, 3), dtype=np.int64), np.empty((BATCH, 3), dtype=np.int64)
    block, done = 0, 0
    while block < len(blocks.rows):
        block, n = cells_beside(blocks.rows, block, BATCH, inside, outside)
        shares[done : done + n] = share_of(tree, field, inside[:n], outside[:n])
        done += n
    return shares


def share_of(
    tree: Tree, field: Field, inside: Int[np.ndarray, "squares 3"], outside: Int[np.ndarray, "squares 3"]
) -> Float[np.ndarray, " squares"]:
    """The place of the change of sign between two cells, from 0 in the first to 1 in the second."""
    low, high = _values(tree, field, inside), _values(tree, field, outside)
    low[low > 0] = JOINED
    high[np.isinf(high)] = 0.5
    high = np.maximum(high, 0.0)
    level = high == low
    share = np.where(level, 0.5, -low / np.where(level, 1.0, high - low))
    return np.clip(share, CLEAR, 1 - CLEAR)


def _values(tree: Tree, field: Field, cells: Int[np.ndarray, "cells 3"]) -> Float[np.ndarray, " cells"]:
    """The field at the centres of cells, in cells."""
    places = np.array(tree.origin) + (cells + 0.5) * tree.cell_size
    values = np.asarray(field(places), dtype=np.float64)
    if values.shape != (len(cells),):
        raise ValueError(f"the field gives shape {values.shape} for {len(cells)} points: one number each")
    wrong = np.isnan(values) | (values == -np.inf)
    if wrong.any():
        where = int(np.argmax(wrong))
        raise ValueError(f"the field is {values[where]} at {places[where].tolist()} mm: give a distance")
    return values / tree.cell_size
