"""Lengths in millimetres against cells, the box of a set, and room around it."""

import math
from fractions import Fraction

import numpy as np
from jaxtyping import Int

from export.meshing.skin import EmptySolid
from trees import Cube, Tree, TreeError
from trees.leaves import leaf_runs
from trees.morton import cells_of_keys
from trees.runs import embed

NEAR = 1e-12
"""The share by which a length may miss a whole number of cells through rounding."""


class WrongLength(ValueError):
    """A length, volume or diameter out of range: `value`, under its `name`."""

    def __init__(self, name: str, value: float, need: str):
        self.name, self.value = name, value
        super().__init__(f"{name} is {value}: {need} is needed")


def check_solid(tree: Tree) -> None:
    """Raises `TreeError` where the tree is not of dimension 3, `EmptySolid` where no cell is black."""
    if tree.dimension != 3:
        raise TreeError(f"a tree of dimension {tree.dimension}: a part needs one of dimension 3")
    if not tree:
        raise EmptySolid("no cell is black: there is nothing to print")


def check_above(name: str, value: float) -> None:
    """Raises `WrongLength` unless the value is finite and above 0."""
    if not (math.isfinite(value) and value > 0):
        raise WrongLength(name, value, "a finite number above 0")


def check_not_below(name: str, value: float) -> None:
    """Raises `WrongLength` unless the value is finite and 0 or more."""
    if not (math.isfinite(value) and value >= 0):
        raise WrongLength(name, value, "a finite number of 0 or more")


def in_cells(tree: Tree, mm: float) -> float:
    """A length in cells, of which whole numbers survive rounding.

    >>> from trees import Cube, empty
    >>> in_cells(empty(Cube((0.0,) * 3, 0.2 * 8), bits=3), 0.6) >= 3
    True
    """
    return mm / tree.cell_size * (1 + NEAR)


def cells_up(tree: Tree, mm: float) -> int:
    """A length in whole cells, rounded up.

    >>> from trees import Cube, empty
    >>> cells_up(empty(Cube((0.0,) * 3, 0.2 * 8), bits=3), 0.6)
    3
    """
    return math.ceil(mm / tree.cell_size * (1 - NEAR))


def box_of(tree: Tree) -> Int[np.ndarray, "2 dim"]:
    """The first and the last cell of the smallest box around a set that is not empty.

    >>> from trees import from_points
    >>> box_of(from_points([[1, 2, 3], [2, 2, 0]], bits=2)).tolist()
    [[1, 2, 0], [2, 2, 3]]
    """
    first, last = leaf_runs(tree, tree.dimension)
    low = cells_of_keys(first, tree.dimension, tree.bits).min(axis=0)
    high = cells_of_keys(last, tree.dimension, tree.bits).max(axis=0)
    return np.array([low, high]).astype(np.int64)


def with_room(tree: Tree, cells: int) -> Tree:
    """The same set with at least so many white cells on all sides, in the same cube where it has them.

    Else the cube becomes one of about the same centre, `2^n` times as large, on the same grid; its corner in
    mm is rounded once. Raises `KeyTooWide` above 21 bits an axis.

    >>> from trees import from_points
    >>> with_room(from_points([[0, 1, 1]], bits=2), 1)
    <Tree: dimension 3, 3 bits an axis, 1 cells, cube of 2.0 at (-0.5, -0.5, -0.5)>
    """
    box, side = box_of(tree), 2**tree.bits
    if box[0].min() >= cells and box[1].max() + cells < side:
        return tree
    factor = 2
    while (factor - 1) * side // 2 < cells:
        factor *= 2
    shift = (factor - 1) * side // 2
    # Cells are the unit while the cube grows: corners are then whole numbers, or halves of the old cube.
    whole = Tree(Cube((0.0,) * 3, float(side)), tree.bits, tree.form)
    grown = embed(whole, Cube((-float(shift),) * 3, float(factor * side)))
    cell = Fraction(tree.size) / side
    corner = tuple(float(Fraction(x) - shift * cell) for x in tree.origin)
    return Tree(Cube(corner, tree.size * factor), grown.bits, grown.form)


def mm_of(tree: Tree, cells: np.ndarray) -> np.ndarray:
    """Corners of cells, or with halves their centres, in mm."""
    return np.array(tree.origin) + cells * tree.cell_size
