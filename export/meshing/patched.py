"""The skin over blocks of several sizes, with fewer triangles where it is flat, or with its edges kept."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from export.meshing.crossings import (
    Field,
    Gradient,
    exact_shares,
    field_at,
    normals_at,
    share_of,
)
from export.meshing.diagonals import MARGIN
from export.meshing.features import bends, meeting_places, squares_of_vertices
from export.meshing.grading import Grading, graded
from export.meshing.joining import join_contacts
from export.meshing.patches import Leaves, Patches, graded_patches, merged_patches
from export.meshing.rings import Rings, rings_of
from export.meshing.seams import Bent, uncrossed
from ifs.mesh import Mesh
from trees.tree import Tree

NEAREST = 1e-3  # the share of half a block by which a vertex keeps off the blocks' centres

Places = Float[np.ndarray, "_vertices 3"]


@dataclass(frozen=True, eq=False)
class Wishes:
    """What is asked of a skin beyond its style: see `export.meshing.skin.skin`."""

    grading: Grading | None = None
    merge: bool = False
    features: float | None = None
    gradient: Gradient | None = None


def check_wishes(wishes: Wishes, style: str, contacts: str, field: Field | None) -> None:
    """Raises `ValueError` where wishes do not go together."""
    if contacts != "join":
        raise ValueError("a grading, merged squares and features take joined contacts, not separate ones")
    if wishes.merge and style != "exact":
        raise ValueError(f"merged squares are those of the exact style: ask for it, not for the {style} one")
    if wishes.gradient is not None and wishes.features is None:
        raise ValueError("a gradient is for features: say from which angle on, in degrees")
    if wishes.features is None:
        return
    if not 0 < wishes.features < 180:
        raise ValueError(
            f"features are kept from an angle between 0 and 180 degrees on, not {wishes.features}"
        )
    if style != "smooth" or field is None:
        raise ValueError("features are those of a field, in the smooth style: give both")


def patched(tree: Tree, style: str, field: Field | None, wishes: Wishes) -> Mesh:
    """The boundary of a tree as rectangles in rings of vertices: see `export.meshing.skin.skin`."""
    features, gradient = wishes.features, wishes.gradient
    tree, patches = _settled(tree, wishes.grading or Grading(1), wishes.merge)
    rings = rings_of(patches, tree.bits)
    if style == "exact":
        return _flat(tree, rings)
    inner, outer = patches.inner, patches.outer
    assert inner is not None
    assert outer is not None
    start, stop = _centres(inner), _centres(outer)
    if field is None:
        shares = inner.size / (inner.size + outer.size)
    else:
        shares = share_of(tree, field, start, stop, (inner.size, outer.size))
    if features is None or field is None:
        crossings = start + shares[:, None] * (stop - start)
        stands = [places for places, _ in _means(rings, crossings, inner, outer)]
        sharp = np.zeros(len(rings.corners), dtype=bool)
    else:
        shares = exact_shares(tree, field, start, stop, shares)
        points = start + shares[:, None] * (stop - start)
        normals = _normals(tree, field, gradient, points)
        means = _means(rings, points, inner, outer)
        sharp, stands = _sharpened(rings, points, normals, math.radians(features), means)
        shares = np.clip(shares, NEAREST, 1 - NEAREST)
        crossings = start + shares[:, None] * (stop - start)
    bend = _bend(tree, patches, rings, (start, stop, crossings), sharp)
    bent = uncrossed(bend, stands, patches, rings, stop - start)
    return Mesh(bent.points, bent.faces)


def _centres(leaves: Leaves) -> Places:
    """The centres of blocks, in cells."""
    return leaves.low + leaves.size[:, None] / 2


def _settled(tree: Tree, grading: Grading, merge: bool) -> tuple[Tree, Patches]:
    """The graded tree with its contacts joined by whole blocks, and the rectangles of its boundary."""
    tree = graded(tree, grading)
    while True:
        patches, touched = merged_patches(tree) if merge else graded_patches(tree, grading)
        joined = join_contacts(tree) if touched else tree
        if joined == tree:
            return tree, patches
        tree = graded(joined, grading)


def _flat(tree: Tree, rings: Rings) -> Mesh:
    from export.meshing.rings_kernels import flat_strips

    places = rings.corners.astype(np.float64)
    faces = np.empty((len(rings.ring) - 2 * len(rings.turns), 3), dtype=np.int32)
    flat_strips(rings.starts, rings.ring, rings.turns, places, faces)
    return Mesh(np.array(tree.origin) + places * tree.cell_size, faces)


def _means(
    rings: Rings, crossings: Float[np.ndarray, "patches 3"], inner: Leaves, outer: Leaves
) -> list[tuple[Places, Float[np.ndarray, " _vertices"]]]:
    """The means of the crossings around each vertex, in cells, and how far they may be from the corner.

    Beside blocks of one size s that is s/2. Beside several, the least s and the largest S, it is first S/2,
    which holds all means; then half of that, and so on; at last s^2/(2 S): the way between the centres of two
    such blocks passes that near to the sides of their square.
    """
    from export.meshing.bending_kernels import kept_near, means

    count = len(rings.corners)
    places = np.zeros((count, 3))
    smallest, largest = np.zeros(count, dtype=np.int64), np.zeros(count, dtype=np.int64)
    means(rings.starts, rings.ring, crossings, inner.size, outer.size, places, smallest, largest)
    least, reach = smallest * (smallest / (2 * largest)), largest / 2
    result = []
    while True:
        kept = places.copy()
        kept_near(rings.corners, reach * (1 - NEAREST), kept)
        result.append((kept, reach * (1 - NEAREST)))
        if (reach == least).all():
            return result
        reach = np.maximum(reach / 2, least)


def _normals(tree: Tree, field: Field, gradient: Gradient | None, points: Places) -> Places:
    """The normals of the surface at crossings, 0 for those beside cells that were joined or filled up."""
    normals = normals_at(tree, field, gradient, points)
    normals[np.abs(field_at(tree, field, points)) > NEAREST] = 0
    return normals


def _sharpened(
    rings: Rings,
    points: Places,
    normals: Places,
    angle: float,
    means: list[tuple[Places, Float[np.ndarray, " _vertices"]]],
) -> tuple[Bool[np.ndarray, " _vertices"], list[Places]]:
    """Which vertices have a bend above the angle, and the means with these put where their planes meet."""
    count = len(rings.corners)
    squares, offsets = squares_of_vertices(rings.starts, rings.ring, count)
    sharp = bends(offsets, squares, normals) > angle
    vertex = np.repeat(np.arange(count), np.diff(offsets))
    facing = (normals[squares] != 0).any(axis=1)
    stands, last = [], np.zeros(count)
    for mean, reach in means:
        moved = sharp & (reach != last)
        used = facing & moved[vertex]
        places = np.where(sharp[:, None] & ~moved[:, None], stands[-1], mean) if stands else mean.copy()
        places[moved] = meeting_places(
            (np.cumsum(moved) - 1)[vertex[used]],
            points[squares[used]],
            normals[squares[used]],
            rings.corners[moved].astype(np.float64),
            reach[moved],
            angle,
        )
        stands.append(places)
        last = reach
    return sharp, stands


def _bend(
    tree: Tree,
    patches: Patches,
    rings: Rings,
    ways: tuple[Places, Places, Places],
    sharp: Bool[np.ndarray, " _vertices"],
) -> Callable[[Places], Bent]:
    """What bends rectangles to given vertices: two triangles for each, or a fan round its crossing."""
    from export.meshing.bending_kernels import bent_triangles, chosen

    start, stop, crossings = ways
    rows, sides = np.arange(len(start), dtype=np.int32), np.diff(rings.starts)
    where = rings.starts, rings.ring, patches.axis, patches.out, start, stop

    def bend(places: Places) -> Bent:
        choice = np.empty(len(start), dtype=np.uint8)
        triangles, centres = chosen(*where, places, sharp, MARGIN, choice)
        every = np.concatenate([places, np.empty((centres, 3))])
        faces = np.empty((triangles, 3), dtype=np.int32)
        bent_triangles(rings.starts, rings.ring, crossings, choice, len(places), every, faces)
        points = np.array(tree.origin) + every * tree.cell_size
        return Bent(points, faces, np.repeat(rows, np.where(choice < 2, 2, sides)))

    return bend
