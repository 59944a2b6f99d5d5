"""Walls that are too thin and gaps that are too tight: their places, and what sets them right."""

import math
from dataclasses import dataclass

from export.printable.frame import check_above, check_solid, in_cells, with_room
from export.printable.regions import Region, regions_of
from trees import Tree, empty
from trees.morphology import Ball, Box, dilation, erosion


@dataclass(frozen=True)
class Narrow:
    """The limit in mm, and the places below it, from the largest on."""

    limit: float
    places: tuple[Region, ...]


def thin_walls(tree: Tree, mm: float) -> tuple[Tree, Narrow]:
    """The cells of walls thinner than `mm`, and their places.

    They are what the opening by a Ball of radius `r = mm / 2` in cells takes away, less what it takes
    from corners: cells within `(sqrt(3) - 1) r + 1/2` steps, rounded up (across faces, edges and corners,
    inside the part), from where the Ball fits. That is as deep as the corner of a cube is; sharper
    edges are thin walls, and ribs lower than that are not seen. A slab of n cells is thick enough from
    `n = 2 floor(r) + 1` on: one of even thickness needs a cell more than `mm`, and one that passes may be
    less than a cell too thin. `tree.at(tree.bits + 1)` halves this error.

    Raises `WrongLength` for a limit that is not above 0, `EmptySolid` for the empty set, `TreeError` where
    the tree is not of dimension 3, `KeyTooWide` where the cube has no room for the Ball.

    >>> from trees import from_points
    >>> slab = from_points([[x, y, 3] for x in range(8) for y in range(8)], bits=3)
    >>> thin_walls(slab, 3 / 8)[0] == slab, thin_walls(slab, 1 / 8)[0].count
    (True, 0)
    """
    check_solid(tree)
    check_above("the least wall in mm", mm)
    found = _narrow(tree, in_cells(tree, mm / 2), outside=False)
    return found, Narrow(mm, regions_of(found))


def least_wall(tree: Tree, most_mm: float) -> float:
    """The largest whole number of cells, as a length in mm, of which no wall is thinner; at most `most_mm`.

    It is 1 cell at least, and for slabs that many or one less: see `thin_walls`, whose errors are raised.

    >>> from trees import from_points
    >>> slab = from_points([[x, y, z] for x in range(8) for y in range(8) for z in (3, 4, 5)], bits=3)
    >>> least_wall(slab, 1.0)
    0.375
    """
    check_solid(tree)
    check_above("the most that is looked for, in mm", most_mm)
    good, bad = 1, max(int(in_cells(tree, most_mm)), 1) + 1
    while bad - good > 1:
        middle = (good + bad) // 2
        good, bad = (good, middle) if _narrow(tree, middle / 2, outside=False) else (middle, bad)
    return good * tree.cell_size


def walls_at_least(tree: Tree, mm: float) -> tuple[Tree, Narrow]:
    """The part with its thin walls made `mm` thick, and the places where they were: see `thin_walls`.

    A Ball of radius `mm / 2` in cells is put at the centres of the largest balls that fit there: a wall grows
    on both sides alike. `thin_walls` of the result finds nothing. Nothing is taken away; the cube grows
    where it has no room. Errors are those of `thin_walls`.

    >>> from trees import from_points
    >>> slab = from_points([[x, y, 3] for x in range(8) for y in range(8)], bits=3)
    >>> thick, report = walls_at_least(slab, 3 / 8)
    >>> sorted({z for _, _, z in thick if thick.bits == 4}), len(report.places)
    ([6, 7, 8], 1)
    """
    thin, report = thin_walls(tree, mm)
    if not thin:
        return tree, report
    radius = in_cells(tree, mm / 2)
    wide = with_room(tree, int(radius) + 1)
    return wide | _thickening(wide, _narrow(wide, radius, outside=False), radius), report


def tight_gaps(tree: Tree, mm: float) -> tuple[Tree, Narrow]:
    """The white cells of gaps narrower than `mm`, and their places: thin walls of the complement.

    They are what the closing by a Ball of radius `mm / 2` in cells adds, less what it adds in corners; slots
    and bores count like gaps between two parts, and so do trapped voids. Depths that are not seen,
    errors and what is raised are as in `thin_walls`. The tree of cells may have a larger cube.

    >>> from trees import from_points
    >>> plates = from_points([[x, y, z] for x in range(8) for y in range(8) for z in (0, 1, 3, 4)], bits=3)
    >>> tight_gaps(plates, 3 / 8)[0].measure >= 6 * 6 / 8**3
    True
    """
    check_solid(tree)
    check_above("the least gap in mm", mm)
    radius = in_cells(tree, mm / 2)
    wide = with_room(tree, 2 * int(radius) + 2)
    found = _narrow(~wide, radius, outside=True)
    return found, Narrow(mm, regions_of(found))


def gaps_at_least(tree: Tree, mm: float) -> tuple[Tree, Narrow]:
    """The part with its tight gaps filled, and the places where they were: see `tight_gaps`.

    Filled again until none is left: the result has none. Errors are those of `tight_gaps`.

    >>> from trees import from_points
    >>> plates = from_points([[x, y, z] for x in range(8) for y in range(8) for z in (0, 1, 3, 4)], bits=3)
    >>> closed, report = gaps_at_least(plates, 3 / 8)
    >>> tight_gaps(closed, 3 / 8)[1].places, len(report.places)
    ((), 1)
    """
    found, report = tight_gaps(tree, mm)
    while found:
        # The complement of the larger cube is that of the part: no rounding of corners comes in.
        tree = found | with_room(tree, 2 * int(in_cells(tree, mm / 2)) + 2)
        found, _ = tight_gaps(tree, mm)
    return tree, report


def _narrow(tree: Tree, radius: float, outside: bool) -> Tree:
    """What an opening takes away, without corners; outside the cube all is white, or black."""
    fits = erosion(tree, Ball(radius), outside)
    opened = dilation(fits, Ball(radius))
    rest = tree - opened
    steps = _corner(radius)
    seeds = rest - _reached(opened, tree, steps)
    return _reached(seeds, rest, steps + 1)


def _corner(radius: float) -> int:
    """How many steps a right-angled corner reaches beyond the ball in it; half a cell for staircases."""
    return math.ceil((math.sqrt(3) - 1) * radius + 0.5) if radius >= 1 else 0


def _reached(start: Tree, inside: Tree, steps: int) -> Tree:
    """The cells of a set that so many steps inside of it lead to."""
    found = start & inside
    for _ in range(steps):
        wider = dilation(found, Box(1)) & inside
        if wider.count == found.count:
            return found
        found = wider
    return found


def _thickening(tree: Tree, thin: Tree, radius: float) -> Tree:
    """Balls about the centres of the largest balls inside thin walls, the largest first."""
    added, rest = empty(tree.cube, tree.bits), thin
    for reach in range(int(radius), -1, -1):
        centres = erosion(tree, Ball(reach)) & thin & dilation(rest, Ball(reach))
        if centres:
            added |= dilation(centres, Ball(radius))
            rest -= _reached(dilation(centres, Ball(reach)), tree, _corner(reach))
        if not rest:
            break
    return added
