"""Thickening a set of voxels by a distance."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from scipy import spatial

from export.facets import Facets
from export.meshing.skin import EmptySolid, Field
from ifs import Mesh
from trees import Cube, Tree, from_morton, to_morton, to_points
from trees.morphology import Ball, Box, dilation, distances
from trees.morphology.filters import grown as cells_with_room

FARTHEST = 4  # pitches between voxels and the facets said to be of the same shape
BAND = 2  # how many voxels outside the surface the field is exact
EIGHT = np.indices((2, 2, 2)).reshape(3, 8).T
WINDOW = 2**24  # voxels of a box in which distances are looked up


@dataclass(frozen=True, eq=False)
class Solid:
    """Voxels, and the distance in mm from places to their surface: at most 0 in black voxels.

    `field` takes centres of voxels, `(n, 3)` in mm; see `export.meshing.skin`.
    """

    tree: Tree
    field: Field


@dataclass(frozen=True)
class _Swept:
    """What is swept over a set, of a radius in cells, and the metric of which it is the ball."""

    element: type[Ball] | type[Box]
    metric: str


_SWEPT = {"ball": _Swept(Ball, "euclidean"), "box": _Swept(Box, "d-infinity")}


def thicken(tree: Tree, distance: float, facets: Mesh | None = None, shape: str = "ball") -> Solid:
    """The solid within `distance` (mm) of a set of voxels, with its distance field.

    With the shape "ball" the distance is Euclidean; with "box" it is `max |x_i - y_i|`, so that a box with
    sides of `2 distance` is swept over the set, and walls that are not square to an axis get thicker. Without
    `facets` the solid is every voxel whose centre lies within `distance` of the centre of a set
    voxel. `facets` replaces the centres by a mesh of the shape itself (points, segments or
    triangles, mm, about as small as voxels): the surface then follows the shape instead of its
    voxels, and the set voxels themselves stay in whatever the distance. The field is
    `distance to the nearest facet - max(distance, pitch / 2)` (exact next to the surface, cut off
    at two pitches outside); so a smooth wall is about one pitch thick at least.

    The cube grows where the ball reaches out of it. The set is a dilation of words of voxels; distances
    are worked out where they are asked for, in boxes of at most 2^24 voxels. Facets cost about 200
    bytes each.

    Raises `EmptySolid` for an empty set, `ValueError` for a distance that is negative or not
    finite, for another shape, and for facets that are not finite or more than four pitches away from the
    voxels.

    >>> from trees import from_points
    >>> dot = from_points([[1, 1, 1]], bits=2)
    >>> thicken(dot, dot.cell_size).tree.count, thicken(dot, dot.cell_size, shape="box").tree.count
    (7, 27)
    """
    if shape not in _SWEPT:
        raise ValueError(f"sets are thickened by one of {', '.join(_SWEPT)}; found {shape!r}")
    if not (math.isfinite(distance) and distance >= 0):
        raise ValueError(f"the distance must be finite and not negative, not {distance} mm")
    if not tree:
        raise EmptySolid("no voxel is filled: there is nothing to thicken")
    level = max(distance / tree.cell_size, 0.5) * (1 + 1e-12)
    swept = _SWEPT[shape]
    if facets is None:
        return Solid(
            dilation(_with_room(tree, level), swept.element(level)), _around_centres(tree, level, swept)
        )
    return _around_facets(tree, level, _near(tree, facets, swept))


def _with_room(tree: Tree, radius: float) -> Tree:
    """The tree in a cube with room for a ball of a radius in voxels on all sides.

    The cube grows in units of voxels, in which its corners are exact; in mm they are rounded once.
    """
    cells = Tree(Cube((0.0,) * 3, 2.0**tree.bits), tree.bits, tree.form)
    grown = cells_with_room(cells, Ball(radius))
    corner = np.array(tree.origin) + np.array(grown.origin) * tree.cell_size
    return Tree(Cube(tuple(corner.tolist()), grown.size * tree.cell_size), grown.bits, grown.form)


@dataclass(frozen=True, eq=False)
class _Near:
    """The facets of a shape, and how many pitches their distances may differ from those of centres."""

    facets: Facets
    drift: float
    swept: _Swept


def _near(tree: Tree, mesh: Mesh, swept: _Swept) -> _Near:
    if not np.isfinite(mesh.vertices).all():
        raise ValueError("the vertices of the facets must be finite numbers of millimetres")
    facets, centres = Facets(mesh), _centres(tree)
    to_facets = float(facets.distance(centres).max())
    to_centres = float(spatial.KDTree(centres).query(mesh.points_3d(), workers=-1)[0].max())
    drift = max(to_facets, to_centres + facets.longest) / tree.cell_size
    if drift > FARTHEST:
        raise ValueError(f"facets and voxels differ by {drift:.3g} pitches ({FARTHEST} allowed)")
    return _Near(facets, drift, swept)


def _around_facets(tree: Tree, level: float, near: _Near) -> Solid:
    """Voxels that are nearer to the facets than the level for certain, and of the rest those that are."""
    farthest = level + near.drift + 0.01
    wide = _with_room(tree, farthest)
    element = near.swept.element
    inner = dilation(wide, element(max(level - near.drift - 0.01, 0.0)))
    ring = dilation(wide, element(farthest)) - inner
    field = _to_facets(tree, level, near)
    chosen = from_morton(to_morton(ring)[field(_centres(ring)) <= 0], ring.cube, ring.bits)
    return Solid(inner | chosen, field)


def _to_facets(tree: Tree, level: float, near: _Near) -> Field:
    cells_of = _cells_of(tree)

    def field(places: Float[np.ndarray, "places 3"]) -> Float[np.ndarray, " places"]:
        over = near.facets.distance(places, near.swept.metric) / tree.cell_size - level
        over[(over > 0) & tree.holds_cells(cells_of(places))] = 0
        return np.minimum(over, BAND) * tree.cell_size

    return field


def _cells_of(tree: Tree) -> Callable[[Float[np.ndarray, "_n 3"]], Int[np.ndarray, "_n 3"]]:
    origin, pitch = np.array(tree.origin), tree.cell_size
    return lambda places: np.rint((places - origin) / pitch - 0.5).astype(np.int64)


def _around_centres(tree: Tree, level: float, swept: _Swept) -> Field:
    """Exact at the centres of voxels; at their corners, the centres of larger blocks, the mean of eight."""
    origin, pitch = np.array(tree.origin), tree.cell_size

    def at_cells(cells: Int[np.ndarray, "_n 3"]) -> Float[np.ndarray, " _n"]:
        found = _distances(tree, cells, level + BAND, swept.metric)
        steps = np.sqrt(np.maximum(found, 0)) if swept.metric == "euclidean" else found
        return np.minimum(np.where(found < 0, np.inf, steps) - level, BAND) * pitch

    def field(places: Float[np.ndarray, "places 3"]) -> Float[np.ndarray, " places"]:
        units = (places - origin) / pitch - 0.5
        cells = np.rint(units).astype(np.int64)
        corner = np.abs(units - cells).max(axis=1, initial=0) > 0.25
        result = np.empty(len(places))
        result[~corner] = at_cells(cells[~corner])
        if corner.any():
            around = np.floor(units[corner]).astype(np.int64)[:, None] + EIGHT
            result[corner] = at_cells(around.reshape(-1, 3)).reshape(-1, 8).mean(axis=1)
        return result

    return field


def _distances(
    tree: Tree, cells: Int[np.ndarray, "cells 3"], limit: float, metric: str
) -> Int[np.ndarray, " cells"]:
    """Distances of cells from the set, squared ones if Euclidean, -1 beyond the limit; box by box."""
    found = np.full(len(cells), -1, dtype=np.int64)
    waiting = [np.arange(len(cells))] if len(cells) else []
    while waiting:
        part = waiting.pop()
        low, high = cells[part].min(axis=0), cells[part].max(axis=0) + 1
        if math.prod((high - low).tolist()) > WINDOW:
            axis = int(np.argmax(high - low))
            left = cells[part, axis] < (low[axis] + high[axis]) // 2
            waiting += [part[left], part[~left]]
            continue
        box = distances(tree, low.tolist(), high.tolist(), metric, limit)
        found[part] = box[tuple((cells[part] - low).T)]
    return found


def _centres(tree: Tree) -> Float[np.ndarray, "cells 3"]:
    """The centres of the black voxels, mm."""
    return np.array(tree.origin) + (to_points(tree) + 0.5) * tree.cell_size
