"""The median and other ranks: how many cells around a cell are black."""

from trees.doors import whole
from trees.errors import TreeError
from trees.morphology.elements import Element, cell_of, rows
from trees.morphology.spread import counted
from trees.tree import Tree


def median(tree: Tree, element: Element, outside: bool = False) -> Tree:
    """The cells around which the greater part of the element is black.

    An element has an odd number of cells, so there is no tie. Outside the cube all is white, or with
    `outside` black. Errors are those of `dilation`.

    >>> from trees import from_points
    >>> from trees.morphology.elements import Box
    >>> list(median(from_points([[1], [3], [4], [6]], bits=3), Box(1)))
    [(2,), (3,), (4,), (5,)]
    """
    found = rows(element, tree.dimension, cell_of(tree))
    return rank(tree, element, (found.count + 1) // 2, outside)


def rank(tree: Tree, element: Element, least: int, outside: bool = False) -> Tree:
    """The cells around which at least `least` cells of the element are black: 1 is the dilation.

    Raises `TreeError` where `least` is not from 1 to the number of cells of the element; else as `dilation`.

    >>> from trees import from_points
    >>> from trees.morphology.elements import Box
    >>> list(rank(from_points([[1], [3], [4], [6]], bits=3), Box(1), 1))
    [(0,), (1,), (2,), (3,), (4,), (5,), (6,), (7,)]
    """
    least, found = whole(least, "least"), rows(element, tree.dimension, cell_of(tree))
    if not 1 <= least <= found.count:
        raise TreeError(
            f"{least} black cells of an element of {found.count}: 1 to {found.count} are possible"
        )
    return counted(tree, element, found, least, outside)
