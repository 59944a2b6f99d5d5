"""Hollowing: a shell of a given wall."""

from dataclasses import dataclass

from export.printable.frame import cells_up, check_above, check_solid
from export.printable.regions import Region, regions
from trees import Tree
from trees.morphology import Ball, erosion
from trees.topology import components


@dataclass(frozen=True)
class Hollow:
    """The wall in mm, in whole cells, and the cavities that were taken out, from the largest on."""

    wall: float
    cavities: tuple[Region, ...]


def hollowed(tree: Tree, wall_mm: float) -> tuple[Tree, Hollow]:
    """The part less its erosion by a Ball of `wall_mm`, in cells and rounded up to whole ones.

    Walls parallel to the axes are at least `wall_mm` thick, and less than one cell thicker; slanted ones are
    right within one cell. Cavities are trapped: `drained` opens them. A part nowhere twice as thick as its
    wall stays as it is, and has no cavities.

    Raises `WrongLength` for a wall that is not above 0, `EmptySolid` for the empty set, `TreeError` where the
    tree is not of dimension 3.

    >>> from trees import full, unit_cube
    >>> tree, report = hollowed(full(unit_cube(3), bits=3), 0.25)
    >>> tree.count, report.cavities[0].volume
    (448, 0.125)
    """
    check_solid(tree)
    check_above("the wall in mm", wall_mm)
    cells = cells_up(tree, wall_mm)
    wall = cells * tree.cell_size
    if cells >= 2 ** (tree.bits - 1) + 1:
        return tree, Hollow(wall, ())
    inside = erosion(tree, Ball(cells))
    return (tree - inside if inside else tree), Hollow(wall, regions(components(inside)))
