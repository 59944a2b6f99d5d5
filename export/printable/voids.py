"""Trapped voids: found, and filled."""

from export.printable.frame import check_solid
from export.printable.regions import Region, regions
from trees import Tree
from trees.topology import fill_holes, holes

# Black cells that touch at an edge or a corner only are joined there: nothing flows between them.
CLOSED = "d-infinity"


def voids(tree: Tree) -> tuple[Region, ...]:
    """The trapped voids of a part, from the largest on: white cells with no way out across faces.

    A way through an edge or a corner only counts as closed, as it is once contacts are joined. All beyond
    the cube is outside. Volumes are exact.

    Raises `EmptySolid` for the empty set, `TreeError` where the tree is not of dimension 3.

    >>> from trees import full, from_points, unit_cube
    >>> solid = full(unit_cube(3), bits=2)
    >>> [region.centre for region in voids(solid - from_points([[1, 1, 1]], bits=2))]
    [(0.375, 0.375, 0.375)]
    """
    check_solid(tree)
    return regions(holes(tree, CLOSED))


def filled(tree: Tree) -> tuple[Tree, tuple[Region, ...]]:
    """The part with all its voids filled, and the regions that were; errors are those of `voids`.

    >>> from trees import full, from_points, unit_cube
    >>> solid = full(unit_cube(3), bits=2)
    >>> filled(solid - from_points([[1, 1, 1]], bits=2))[0] == solid
    True
    """
    found = voids(tree)
    return (fill_holes(tree, CLOSED) if found else tree), found
