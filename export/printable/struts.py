"""Struts between the components of a part: a minimum spanning tree of their distances."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from export.printable.frame import in_cells, mm_of, with_room
from trees import Tree, from_points, to_points
from trees.morphology import Ball, dilation
from trees.topology import Components, boundary


@dataclass(frozen=True)
class Strut:
    """From the centre of one cell to that of another, in mm."""

    start: tuple[float, ...]
    end: tuple[float, ...]
    length: float


@dataclass(frozen=True)
class _Link:
    """Two cells by their rows, and how far they are apart, in cells."""

    length: float
    first: int
    second: int


def linked(tree: Tree, found: Components, diameter_mm: float) -> tuple[Tree, tuple[Strut, ...]]:
    """The set with struts between its components; `found` knows them, and more that were dropped."""
    cells = to_points(boundary(tree)).astype(np.int64)
    labels = found.labels_of(cells)
    links = [_centred(cells, labels, link) for link in spanning_links(cells, labels)]
    radius = in_cells(tree, diameter_mm / 2)
    lines = np.concatenate([line(cells[link.first], cells[link.second]) for link in links])
    wide = with_room(tree, int(radius) + 1)
    shift = np.rint((np.array(tree.origin) - np.array(wide.origin)) / tree.cell_size).astype(np.int64)
    added = dilation(from_points(lines + shift, wide.bits, wide.cube), Ball(radius))
    return wide | added, tuple(_strut(tree, cells, link) for link in links)


def spanning_links(cells: Int[np.ndarray, "cells 3"], labels: Int[np.ndarray, " cells"]) -> list[_Link]:
    """The links of a minimum spanning tree of the components, whose distances are those of nearest cells.

    Each round links every group to the group nearest to it (Boruvka 1926). The cell of another group that
    is nearest is found bit by bit of the groups' numbers: two groups differ in some bit, so a k-d tree for
    each value of each bit is enough, whatever their sizes.

    >>> cells = np.array([[0, 0, 0], [3, 0, 0], [9, 0, 0]])
    >>> [link.length for link in spanning_links(cells, np.array([0, 1, 2]))]
    [3.0, 6.0]
    """
    _, group = np.unique(labels, return_inverse=True)
    links: list[_Link] = []
    while (count := int(group.max()) + 1) > 1:
        lengths, nearest = _nearest_of_others(cells.astype(np.float64), group, count)
        order = np.lexsort((nearest, lengths, group))
        leaders = order[np.append(True, group[order][1:] != group[order][:-1])]
        leaders = leaders[np.lexsort((leaders, lengths[leaders]))]
        parent = list(range(count))
        for first in leaders.tolist():
            second = int(nearest[first])
            one, other = _root(parent, int(group[first])), _root(parent, int(group[second]))
            if one != other:
                parent[one] = other
                links.append(_Link(float(lengths[first]), first, second))
        roots = np.array([_root(parent, number) for number in range(count)])
        _, group = np.unique(roots[group], return_inverse=True)
    return links


def _nearest_of_others(
    places: Float[np.ndarray, "cells 3"], group: Int[np.ndarray, " cells"], count: int
) -> tuple[Float[np.ndarray, " cells"], Int[np.ndarray, " cells"]]:
    """For each cell the nearest of another group, and how far it is."""
    from scipy.spatial import KDTree

    lengths = np.full(len(places), np.inf)
    nearest = np.zeros(len(places), dtype=np.int64)
    for bit in range((count - 1).bit_length()):
        side = (group >> bit) & 1 == 1
        for value in (True, False):
            mine, theirs = np.flatnonzero(side == value), np.flatnonzero(side != value)
            found = KDTree(places[theirs]).query(places[mine])
            length, at = np.asarray(found[0]), np.asarray(found[1])
            better = length < lengths[mine]
            lengths[mine[better]] = length[better]
            nearest[mine[better]] = theirs[at[better]]
    return lengths, nearest


def _centred(cells: Int[np.ndarray, "cells 3"], labels: Int[np.ndarray, " cells"], link: _Link) -> _Link:
    """A link as short between the same components, amid all that are: faces are linked at their middles."""
    from scipy.spatial import KDTree

    mine, theirs = (np.flatnonzero(labels == labels[row]) for row in (link.first, link.second))
    found = KDTree(cells[theirs]).query(cells[mine], distance_upper_bound=link.length + 1e-6)
    near = np.flatnonzero(np.isfinite(found[0]))
    places = cells[mine[near]]
    best = near[np.argmin(np.round(((places - places.mean(axis=0)) ** 2).sum(axis=1), 6))]
    return _Link(link.length, int(mine[best]), int(theirs[np.asarray(found[1])[best]]))


def _root(parent: list[int], number: int) -> int:
    while parent[number] != number:
        parent[number] = parent[parent[number]]
        number = parent[number]
    return number


def line(start: Int[np.ndarray, "3"], end: Int[np.ndarray, "3"]) -> Int[np.ndarray, "cells 3"]:
    """Cells along the segment between two centres, each across a face from the one before.

    >>> line(np.array([0, 0, 0]), np.array([2, 1, 0])).tolist()
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [2, 1, 0]]
    """
    steps = np.abs(end - start)
    axes = np.repeat(np.arange(3), steps)
    times = np.concatenate([(np.arange(n) + 0.5) / max(n, 1) for n in steps.tolist()])
    axes = axes[np.argsort(times, kind="stable")]
    moves = np.zeros((len(axes), 3), dtype=np.int64)
    moves[np.arange(len(axes)), axes] = np.sign(end - start)[axes]
    return np.concatenate([start[None], start + np.cumsum(moves, axis=0)])


def _strut(tree: Tree, cells: Int[np.ndarray, "_cells 3"], link: _Link) -> Strut:
    start, end = (mm_of(tree, cells[row] + 0.5).tolist() for row in (link.first, link.second))
    return Strut(tuple(start), tuple(end), link.length * tree.cell_size)
