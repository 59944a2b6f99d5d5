"""Dilation, erosion, opening and closing by boxes and balls."""

from fractions import Fraction

from trees.cube import Cube
from trees.morphology.elements import Element, cell_of, reach
from trees.morphology.spread import spread
from trees.runs import embed
from trees.tree import Tree


def dilation(tree: Tree, element: Element, grow: bool = False) -> Tree:
    """The cells that the element, put at a black cell, covers; outside the cube all is white.

    `X + E = {x + e : x in X, e in E}`. What leaves the cube is lost, unless `grow` is set: the cube then
    becomes one of the same centre, `2^n` times as large, that has room for all (see `grown`).

    Raises `TreeError` where a box has another number of radii than the tree has axes, `KeyTooWide` where
    the larger cube has too many cells, `TooManyPieces` where the element is too large for windows of 2^26
    words.

    >>> from trees import from_points
    >>> from trees.morphology.elements import Ball
    >>> len(dilation(from_points([[3, 3]], bits=3), Ball(2)))
    13
    """
    tree = grown(tree, element) if grow else tree
    return spread(tree, element, outside=False)


def erosion(tree: Tree, element: Element, outside: bool = False) -> Tree:
    """The cells where the element fits into the set: `X - E = {x : x + E in X}`.

    Outside the cube all is white, as it is to `scipy.ndimage`, or with `outside` black. It is the
    complement of the dilation of the complement. Errors are those of `dilation`.

    >>> from trees import from_array
    >>> import numpy as np
    >>> from trees.morphology.elements import Box
    >>> whole = from_array(np.ones((8, 8), dtype=bool))
    >>> len(erosion(whole, Box(1))), len(erosion(whole, Box(1), outside=True))
    (36, 64)
    """
    return ~spread(~tree, element, outside=not outside)


def opening(tree: Tree, element: Element) -> Tree:
    """What the element covers where it fits: the dilation of the erosion, a subset; all is white outside.

    Errors are those of `dilation`.

    >>> from trees import from_points
    >>> from trees.morphology.elements import Box
    >>> wall = from_points([[x, y] for x in range(3) for y in range(3)] + [[3, 1]], bits=3)
    >>> list(wall - opening(wall, Box(1)))
    [(3, 1)]
    """
    return dilation(erosion(tree, element), element)


def closing(tree: Tree, element: Element, grow: bool = False) -> Tree:
    """The set with all gaps filled that the element does not fit into: the erosion of the dilation.

    Without `grow`, what leaves the cube in between is lost, and with it cells near the cube's faces, as in
    `scipy.ndimage`; with it, the result holds the set. Errors are those of `dilation`.

    >>> from trees import from_points
    >>> from trees.morphology.elements import Box
    >>> list(closing(from_points([[2], [4]], bits=3), Box(1)))
    [(2,), (3,), (4,)]
    """
    return erosion(dilation(tree, element, grow), element)


def grown(tree: Tree, element: Element) -> Tree:
    """The same set in a cube of the same centre, `2^n` times as large: with room for the element.

    A tree of one cell grows to one side by a cell more than to the other. Raises `KeyTooWide` where the
    cube has too many cells, `Misaligned` where its corner is no floating-point number.

    >>> from trees import from_points
    >>> from trees.morphology.elements import Box
    >>> grown(from_points([[0, 0]], bits=2), Box(3))
    <Tree: dimension 2, 4 bits an axis, 1 cells, cube of 4.0 at (-1.5, -1.5)>
    """
    need, cells, size = max(reach(element, tree.dimension, cell_of(tree))), 2**tree.bits, Fraction(tree.size)
    factor = 1
    while (room := (factor - 1) * cells // 2) < need:
        factor *= 2
    corner = [Fraction(x) - room * size / cells for x in tree.origin]
    cube = Cube(tuple(float(x) for x in corner), float(factor * size))
    return embed(tree, cube)
