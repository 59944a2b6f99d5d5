"""Structuring elements: boxes, Euclidean balls and balls of the metric d1, each a stack of rows."""

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from jaxtyping import Int

from trees.doors import real
from trees.errors import TooManyPieces, TreeError
from trees.tree import Tree

MAX_ROWS = 2**22
MAX_LENGTH = 2**40


@dataclass(frozen=True)
class Box:
    """The cells that differ by at most `radii` on each axis: one radius for all axes, or one an axis.

    Radii are in cells, or with `mm` in mm; of a radius that is no whole number of cells, the whole part
    counts.

    >>> rows(Box((1, 2)), 2, Fraction(1)).halves.tolist()
    [2, 2, 2]
    """

    radii: float | Sequence[float]
    mm: bool = False

    def __post_init__(self):
        if isinstance(self.radii, Iterable):
            radii = tuple(_radius(radius) for radius in self.radii)
        else:
            radii = _radius(self.radii)
        object.__setattr__(self, "radii", radii)


@dataclass(frozen=True)
class Ball:
    """The cells whose centres are at most `radius` away: `d_1^2 + ... + d_k^2 <= radius^2`, compared exactly.

    The radius is in cells, or with `mm` in mm. It is the float given that is squared: `math.sqrt(3)` is
    a little less than the root of 3 and leaves out the cell `(1, 1, 1)`; 1.7321 does not.

    >>> rows(Ball(2), 2, Fraction(1)).halves.tolist()
    [0, 0, 1, 1, 2]
    """

    radius: float
    mm: bool = False

    def __post_init__(self):
        object.__setattr__(self, "radius", _radius(self.radius))


@dataclass(frozen=True)
class Diamond:
    """The cells with `|d_1| + ... + |d_k| <= radius`, in cells, or with `mm` in mm.

    >>> rows(Diamond(2), 2, Fraction(1)).halves.tolist()
    [0, 0, 1, 1, 2]
    """

    radius: float
    mm: bool = False

    def __post_init__(self):
        object.__setattr__(self, "radius", _radius(self.radius))


Element = Box | Ball | Diamond


@dataclass(frozen=True)
class Rows:
    """Rows along the last axis: row i, at `offsets[i]` on the other axes, is `2 halves[i] + 1` cells long.

    Half-widths rise. The number of cells is odd: the element is its own mirror image.
    """

    offsets: Int[np.ndarray, "rows others"]
    halves: Int[np.ndarray, " rows"]

    @property
    def count(self) -> int:
        """How many cells."""
        return int((2 * self.halves + 1).sum())


def reach(element: Element, dimension: int, cell: Fraction) -> tuple[int, ...]:
    """How many cells an element of cells of this size, in mm, reaches on each axis.

    Raises `TreeError` where a box has another number of radii.

    >>> reach(Ball(2.5, mm=True), 2, Fraction(1, 2))
    (5, 5)
    """
    unit = Fraction(cell) if element.mm else Fraction(1)
    if not isinstance(element, Box):
        return (math.floor(Fraction(element.radius) / unit),) * dimension
    radii = element.radii if isinstance(element.radii, Sequence) else (element.radii,) * dimension
    if len(radii) != dimension:
        raise TreeError(f"a box of {len(radii)} radii for a tree of dimension {dimension}")
    return tuple(math.floor(Fraction(radius) / unit) for radius in radii)


def rows(element: Element, dimension: int, cell: Fraction) -> Rows:
    """The element as a stack of rows, for cells of this size in mm.

    Raises `TooManyPieces` above 2^22 rows, or rows of more than 2^40 cells.
    """
    radii = reach(element, dimension, cell)
    for total, most in (
        (math.prod(2 * radius + 1 for radius in radii[:-1]), MAX_ROWS),
        (2 * radii[-1] + 1, MAX_LENGTH),
    ):
        if total > most:
            raise TooManyPieces(total, most)
    total = math.prod(2 * radius + 1 for radius in radii[:-1])
    offsets = np.array(list(itertools.product(*(range(-r, r + 1) for r in radii[:-1]))), dtype=np.int64)
    offsets = offsets.reshape(total, dimension - 1)
    if isinstance(element, Box):
        return Rows(offsets, np.full(total, radii[-1]))
    if isinstance(element, Ball):
        ratio = Fraction(element.radius) / (Fraction(cell) if element.mm else 1)
        left = math.floor(ratio**2) - (offsets**2).sum(axis=1)
        halves = np.array([math.isqrt(n) if n >= 0 else -1 for n in left.tolist()])
    else:
        halves = radii[-1] - abs(offsets).sum(axis=1)
    order = np.argsort(halves, kind="stable")
    order = order[halves[order] >= 0]
    return Rows(offsets[order], halves[order])


def cell_of(tree: Tree) -> Fraction:
    """The edge of a cell of a tree in mm, exactly."""
    return Fraction(tree.size) / 2**tree.bits


def _radius(radius: float) -> float:
    """The radius as it is given, an integer or a float: it is compared exactly."""
    number = radius if isinstance(radius, int) else real(radius, "a radius of")
    if number < 0:
        raise TreeError(f"a radius of {radius}: a finite one, not below 0, is needed")
    return number
