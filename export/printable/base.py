"""A flat base under a part."""

from dataclasses import dataclass

import numpy as np

from export.printable.frame import (
    box_of,
    cells_up,
    check_above,
    check_not_below,
    check_solid,
    in_cells,
    mm_of,
    with_room,
)
from trees import Tree, from_points, to_points
from trees.geometry import project, translate
from trees.morphology import Ball, convex_hull, dilation

FOOTPRINTS = ("hull", "rectangle")


@dataclass(frozen=True)
class Base:
    """The box of a base, low to high in mm, its area in mm^2, and that of the part's cells on it."""

    low: tuple[float, ...]
    high: tuple[float, ...]
    area: float
    contact: float


def with_base(
    tree: Tree, height_mm: float, margin_mm: float = 0.0, *, footprint: str = "hull"
) -> tuple[Tree, Base]:
    """The part on a base of a height below its lowest cells (z is up), joined to these across faces.

    The footprint is what meets the convex hull of the part's shadow ("hull"), or its bounding rectangle,
    wider on all sides by a Ball of `margin_mm` in cells: right within one cell. The height is rounded up to
    whole cells. Components that do not reach the lowest layer of cells stay apart: see `islands`. The cube
    grows where it has no room for the base.

    Raises `WrongLength` for a height that is not above 0 or a margin below 0, `ValueError` for another
    footprint, `EmptySolid` for the empty set, `TreeError` where the tree is not of dimension 3.

    >>> from trees import from_points
    >>> tree, base = with_base(from_points([[1, 1, 2], [2, 2, 2]], bits=2), 0.25, footprint="rectangle")
    >>> tree.count, base.area, base.contact
    (6, 0.25, 0.125)
    """
    if footprint not in FOOTPRINTS:
        raise ValueError(f"the footprint is one of {', '.join(FOOTPRINTS)}; found {footprint!r}")
    check_solid(tree)
    check_above("the height in mm", height_mm)
    check_not_below("the margin in mm", margin_mm)
    layers, margin = cells_up(tree, height_mm), in_cells(tree, margin_mm)
    wide = with_room(tree, max(layers, int(margin)))
    floor = int(box_of(wide)[0, 2])
    shadow = project(wide, 2)
    shadow = _hull(shadow) if footprint == "hull" else _rectangle(shadow)
    flat = to_points(dilation(shadow, Ball(margin))).astype(np.int64)
    cells = np.column_stack([flat, np.full(len(flat), floor - layers)])
    base = _extruded(from_points(cells, wide.bits, wide.cube), layers)
    low, last = box_of(base)
    square = tree.cell_size**2
    contact = int(wide.holds_cells(cells + np.array([0, 0, layers])).sum()) * square
    corners = (tuple(mm_of(wide, corner).tolist()) for corner in (low, last + 1))
    return wide | base, Base(*corners, area=len(flat) * square, contact=contact)


def _hull(shadow: Tree) -> Tree:
    """The cells that meet the hull of the cells, not of their centres: a base is then of one piece."""
    return convex_hull(shadow.at(shadow.bits + 1)).at(shadow.bits)


def _rectangle(shadow: Tree) -> Tree:
    (left, front), (right, back) = box_of(shadow).tolist()
    grid = np.meshgrid(np.arange(left, right + 1), np.arange(front, back + 1), indexing="ij")
    return from_points(np.stack(grid, axis=-1).reshape(-1, 2), shadow.bits, shadow.cube)


def _extruded(layer: Tree, layers: int) -> Tree:
    """So many copies of a layer of cells, one above the other."""
    found, done = layer, 1
    while done < layers:
        step = min(done, layers - done)
        found, done = found | translate(found, [0, 0, step]), done + step
    return found
