"""From a tree to the closed triangle mesh of its boundary, straight from its words."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int, UInt64

from export.meshing.crossings import Field, Gradient, share_of
from export.meshing.entries import MAX_TRIANGLES, check_space, entries, indexed
from export.meshing.grading import Grading
from export.meshing.joining import join_at
from ifs.mesh import Mesh
from trees.errors import TooManyPieces
from trees.tree import Tree

BATCH = 2**18


class EmptySolid(ValueError):
    """There is no filled voxel, so there is nothing to thicken, to mesh or to print."""


@dataclass(frozen=True, eq=False)
class Blocks:
    """The boundary by blocks of 4 x 4 x 4 corners, and where their vertices are numbered from.

    Rows are those of `blocks.collected`, `groups` and `slots` those of `numbering.index`.
    """

    rows: UInt64[np.ndarray, "blocks 6"]
    bases: Int[np.ndarray, " blocks"]
    groups: UInt64[np.ndarray, "groups 3"]
    slots: Int[np.ndarray, " slots"]
    vertices: int
    squares: int


def skin(
    tree: Tree,
    style: str = "exact",
    contacts: str = "join",
    field: Field | None = None,
    gap: float = 0.05,
    *,
    grading: Grading | None = None,
    merge: bool = False,
    features: float | None = None,
    gradient: Gradient | None = None,
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

    `grading` makes resolution vary: outside its regions cells are gone through by blocks, which are black as
    soon as one cell in them is (`export.meshing.grading.graded`). A square is then what lies between two
    blocks, and has those vertices of its neighbours that lie on its border, so that the mesh is closed as
    before; a vertex moves by half its blocks at most. Contacts are joined by whole blocks. `merge=True`
    merges the squares of the exact style to rectangles: the same solid in fewer triangles. `features`
    (degrees) keeps edges and corners of the smooth style: where normals of the field differ by more than this
    angle around a vertex, it goes to the place where their planes meet, within half a cell of its corner (Ju,
    Losasso, Schaefer, Warren, Dual contouring of Hermite data, 2002). The field is then asked anywhere, not
    at centres alone; its normals are those of `gradient`, `(n, 3)` for `(n, 3)` in mm, or central
    differences. With one of these, vertices come by rising x, y, z, extra ones last, contacts must be "join",
    the tree has at most 20 bits an axis, and a triangle takes up to ten times as long as without.

    Vertices come by blocks of 4 x 4 x 4 corners in Morton order, extra ones last. Regions that are full or
    empty are not looked at; memory is that of the mesh and about a tenth more (where
    most separate cells touch, up to three times the mesh). `faces` are int32 where that is enough.

    Raises `EmptySolid` when no cell is black, `ValueError` for an unknown style or rule, a gap out of range,
    or a field of another shape, with NaN or -inf, and wishes that do not go together; `TreeError` for a
    dimension other than 3, `TooManyPieces` above 2^30 triangles.

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
    if grading is not None or merge or features is not None or gradient is not None:
        from export.meshing.patched import Wishes, check_wishes, patched

        wishes = Wishes(grading, merge, features, gradient)
        check_wishes(wishes, style, contacts, field)
        return patched(tree, style, field, wishes)
    blocks, touched = _blocks(tree)
    if len(touched) and contacts == "separate":
        from export.meshing.parted import parted

        shares = _shares(tree, blocks, None if style == "exact" else field)
        index = blocks.bases, blocks.groups, blocks.slots
        return parted(tree, blocks.rows, index, touched, shares, style, gap)
    if len(touched):
        tree = join_at(tree, touched)
        blocks, _ = _blocks(tree)
    return _exact(tree, blocks) if style == "exact" else _smooth(tree, blocks, field)


def _blocks(tree: Tree) -> tuple[Blocks, UInt64[np.ndarray, " _touched"]]:
    """The blocks of a tree, and the keys of those with contacts."""
    from export.meshing.blocks import collected

    rows, touched, *counts = collected(*entries(tree), 0)
    vertices, squares = (int(count) for count in counts)
    if 2 * squares > MAX_TRIANGLES:
        raise TooManyPieces(2 * squares, MAX_TRIANGLES)
    return Blocks(rows, *indexed(rows), vertices, squares), touched


def _exact(tree: Tree, blocks: Blocks) -> Mesh:
    from export.meshing.kernels import flat

    vertices = np.empty((blocks.vertices, 3))
    pairs = np.empty((blocks.squares, 6), dtype=np.int32)
    where = blocks.rows, blocks.bases, blocks.groups, blocks.slots
    flat(*where, np.array(tree.origin), tree.cell_size, vertices, pairs)
    return Mesh(vertices, pairs.reshape(-1, 3))


def _smooth(tree: Tree, blocks: Blocks, field: Field | None) -> Mesh:
    from export.meshing.diagonals import MARGIN
    from export.meshing.kernels import bent_triangles, chosen, means, placed

    where = blocks.rows, blocks.bases, blocks.groups, blocks.slots
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
        shares[done : done + n] = share_of(tree, field, inside[:n] + 0.5, outside[:n] + 0.5)
        done += n
    return shares
