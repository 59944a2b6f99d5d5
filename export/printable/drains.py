"""Drain holes: a straight way out of each trapped void."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int

from export.printable.frame import check_above, check_solid, in_cells, mm_of, with_room
from export.printable.regions import Region, regions
from export.printable.voids import CLOSED
from trees import Tree, from_points, to_points
from trees.topology import boundary, holes


@dataclass(frozen=True)
class Drain:
    """A hole from a cell of a void to one outside, centre to centre in mm, along an axis: 0, 1 or 2."""

    void: Region
    start: tuple[float, ...]
    end: tuple[float, ...]
    axis: int
    length: float


@dataclass(frozen=True, eq=False)
class _Ways:
    """The nearest cell outside along an axis, up or down, from some cells of voids; in cells."""

    rows: Int[np.ndarray, " ways"]
    axes: Int[np.ndarray, " ways"]
    ends: Int[np.ndarray, " ways"]


def drained(tree: Tree, diameter_mm: float) -> tuple[Tree, tuple[Drain, ...]]:
    """The part with a straight hole from each of its voids to the outside, and the holes, one a void.

    The hole follows the shortest way parallel to an axis; of equally short ones that nearest to the void's
    centre of gravity. It ends in the first cell from which there is a way out already, and may pass other
    voids. It is a stack of discs of radius `diameter_mm / 2` in cells about a line of cells, from centre to
    centre: its diameter is right within one cell, and at least one cell. On a slanted face it has its
    full diameter as far as its axis goes. No void is left.

    Raises `WrongLength` for a diameter that is not above 0, and what `voids` raises.

    >>> from trees import full, from_points, unit_cube
    >>> solid = full(unit_cube(3), bits=3) - from_points([[2, 3, 4]], bits=3)
    >>> tree, (drain,) = drained(solid, 0.1)
    >>> drain.axis, drain.length, solid.count - tree.count
    (0, 0.375, 2)
    """
    check_solid(tree)
    check_above("the diameter in mm", diameter_mm)
    wide = with_room(tree, 1)
    found = holes(wide, CLOSED)
    if not len(found):
        return tree, ()
    places = regions(found)
    trapped = found.tree_of(range(len(found)))
    inner = to_points(boundary(trapped)).astype(np.int64)
    outer = to_points(boundary(wide, side="outer") - trapped).astype(np.int64)
    ways = _ways(inner, outer)
    void = found.labels_of(inner)[ways.rows]
    starts, ends = inner[ways.rows], inner[ways.rows]
    ends[np.arange(len(ends)), ways.axes] = ways.ends
    lengths = np.abs(ends - starts).sum(axis=1)
    centres = np.array([place.centre for place in places])[void]
    aside = np.round(((mm_of(wide, starts + 0.5) - centres) / wide.cell_size) ** 2, 6)
    aside[np.arange(len(aside)), ways.axes] = 0
    order = np.lexsort((ends.sum(axis=1) < starts.sum(axis=1), ways.axes, aside.sum(axis=1), lengths, void))
    best = order[np.append(True, void[order][1:] != void[order][:-1])]
    radius = in_cells(tree, diameter_mm / 2)
    holed = [_cylinder(starts[row], ends[row], int(ways.axes[row]), radius) for row in best.tolist()]
    cells = np.concatenate(holed)
    cells = cells[((cells >= 0) & (cells < 2**wide.bits)).all(axis=1)]
    rows = zip(places, mm_of(wide, starts[best] + 0.5), mm_of(wide, ends[best] + 0.5), best, strict=True)
    return wide - from_points(cells, wide.bits, wide.cube), tuple(
        Drain(place, tuple(a.tolist()), tuple(b.tolist()), int(ways.axes[row]), float(abs(b - a).max()))
        for place, a, b, row in rows
    )


def _ways(inner: Int[np.ndarray, "_inner 3"], outer: Int[np.ndarray, "_outer 3"]) -> _Ways:
    """All ways from inner cells along the axes to the first outer cell on their line.

    The first cell outside on such a line touches the part, so it is one of the outer cells.
    """
    rows, axes, ends = [], [], []
    side = int(max(inner.max(), outer.max())) + 1
    for axis in range(3):
        one, other = (a for a in range(3) if a != axis)
        out = np.sort((outer[:, one] * side + outer[:, other]) * side + outer[:, axis])
        line = inner[:, one] * side + inner[:, other]
        at = np.searchsorted(out, line * side + inner[:, axis])
        for place in (at, at - 1):
            inside = (place >= 0) & (place < len(out))
            hit = out[np.where(inside, place, 0)]
            here = np.flatnonzero(inside & (hit // side == line))
            rows.append(here)
            axes.append(np.full(len(here), axis))
            ends.append(hit[here] % side)
    return _Ways(np.concatenate(rows), np.concatenate(axes), np.concatenate(ends))


def _cylinder(
    start: Int[np.ndarray, "3"], end: Int[np.ndarray, "3"], axis: int, radius: float
) -> Int[np.ndarray, "cells 3"]:
    """The cells of discs about a line of cells."""
    reach = int(radius)
    steps = np.arange(-reach, reach + 1)
    first, second = (offsets.ravel() for offsets in np.meshgrid(steps, steps, indexing="ij"))
    near = first**2 + second**2 <= radius**2
    along = np.arange(min(start[axis], end[axis]), max(start[axis], end[axis]) + 1)
    one, other = (a for a in range(3) if a != axis)
    cells = np.empty((int(near.sum()), len(along), 3), dtype=np.int64)
    cells[..., axis] = along
    cells[..., one] = (start[one] + first[near])[:, None]
    cells[..., other] = (start[other] + second[near])[:, None]
    return cells.reshape(-1, 3)
