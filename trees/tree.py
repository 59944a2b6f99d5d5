"""The value: a set of cells of a cube of any dimension, kept as bricks."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Real, UInt64

from trees.cube import Cube
from trees.errors import TreeError
from trees.morton import cells_of_keys, check_widths, keys_of_cells

FULL = 2**64 - 1


@dataclass(frozen=True, eq=False, repr=False)
class Tree:
    """A set of the `2^(dimension * bits)` cells of a cube (Guye 1988, II): immutable, hashable, canonical.

    The binary tree halves one axis after the other. Its lowest six levels are one 64-bit word, a
    brick: brick i holds the cells of Morton keys `64 i` to `64 i + 63`, cell `64 i + b` in bit b. Words that
    repeat are written once: `words[j]` is that of all bricks from `starts[j]` to before
    `starts[j + 1]`, so a large full or empty region is one entry. Neighbouring entries differ; a set
    has therefore one form, and trees of equal cube, bits and set are equal, however they were built.
    A tree of fewer than 64 cells uses the low bits of one word.

    `a | b`, `a & b`, `a ^ b`, `a - b` and `~a` are those of sets (see `trees.algebra`); `cell in tree`,
    `len(tree)` and `for cell in tree` speak of black cells, in Morton order. `len` raises OverflowError
    from 2^63 cells on; `count` does not.

    >>> from trees import from_points
    >>> tree = from_points([[3, 0], [3, 1], [2, 0], [2, 1]], bits=2)
    >>> len(tree), (2, 1) in tree, (0, 0) in tree
    (4, True, False)
    >>> tree
    <Tree: dimension 2, 2 bits an axis, 4 cells, cube of 1.0 at (0.0, 0.0)>
    """

    cube: Cube
    bits: int
    starts: UInt64[np.ndarray, " entries"]
    words: UInt64[np.ndarray, " entries"]

    def __post_init__(self):
        check_widths(self.dimension, self.bits)
        for name in ("starts", "words"):
            array = np.array(getattr(self, name), dtype=np.uint64)
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        _check_canonical(self)

    @property
    def dimension(self) -> int:
        """How many axes."""
        return self.cube.dimension

    @property
    def origin(self) -> tuple[float, ...]:
        """The low corner of the reference cube, in mm."""
        return self.cube.origin

    @property
    def size(self) -> float:
        """The edge of the reference cube, in mm."""
        return self.cube.size

    @property
    def depth(self) -> int:
        """Levels of the binary tree, and bits of a key: `dimension * bits`."""
        return self.dimension * self.bits

    @property
    def cell_size(self) -> float:
        """The edge of a cell, in mm."""
        return self.size / 2**self.bits

    @property
    def bricks(self) -> int:
        """How many bricks the cube has."""
        return 2 ** max(self.depth - 6, 0)

    @property
    def lengths(self) -> UInt64[np.ndarray, " entries"]:
        """How many bricks each entry stands for."""
        return np.diff(self.starts, append=np.uint64(self.bricks))

    @property
    def count(self) -> int:
        """How many cells are black."""
        ones = np.bitwise_count(self.words).astype(np.uint64)
        high, low = self.lengths >> np.uint64(29), self.lengths & np.uint64(2**29 - 1)
        return (int((ones * high).sum()) << 29) + int((ones * low).sum())

    @property
    def measure(self) -> float:
        """The k-dimensional volume of the set, in mm^k."""
        return self.count * self.cell_size**self.dimension

    def holds_cells(self, cells: Real[np.ndarray, "cells dim"]) -> Bool[np.ndarray, "cells"]:
        """Which cells, given by integer coordinates, are in the set; those outside the cube are not."""
        if not np.issubdtype(cells.dtype, np.integer):
            raise TreeError(f"cells have integer coordinates, not {cells.dtype}: ask `holds` for points")
        self._check_axes(cells.shape[1])
        inside = ((cells >= 0) & (cells <= np.uint64(2**self.bits - 1))).all(axis=1)
        found = np.zeros(len(cells), dtype=bool)
        found[inside] = self._holds_keys(keys_of_cells(cells[inside], self.bits))
        return found

    def holds(self, points: Real[np.ndarray, "points dim"]) -> Bool[np.ndarray, "points"]:
        """Which points, in mm, lie in a black cell; cells are half-open, all outside the cube is white."""
        from trees.reals import cells_of_points

        self._check_axes(points.shape[1])
        points = points.astype(np.float64)
        low, high = np.array(self.origin), np.array(self.cube.ends)
        inside = ((points >= low) & (points < high)).all(axis=1)
        found = np.zeros(len(points), dtype=bool)
        found[inside] = self._holds_keys(
            keys_of_cells(cells_of_points(points[inside], self.cube, self.bits), self.bits)
        )
        return found

    def at(self, bits: int) -> "Tree":
        """The set at another precision: exact where finer; where coarser, every cell that meets the set."""
        from trees.runs import at_bits

        return at_bits(self, bits)

    def _holds_keys(self, keys: UInt64[np.ndarray, " _keys"]) -> Bool[np.ndarray, " _keys"]:
        entry = np.searchsorted(self.starts, keys >> np.uint64(6), side="right") - 1
        return (self.words[entry] >> (keys & np.uint64(63))) & np.uint64(1) == 1

    def _check_axes(self, axes: int) -> None:
        if axes != self.dimension:
            raise TreeError(f"points of {axes} coordinates for a tree of dimension {self.dimension}")

    def __contains__(self, cell: tuple) -> bool:
        numbers = [int(x) for x in cell]
        if any(number != x for number, x in zip(numbers, cell, strict=True)):
            raise TreeError(f"{cell} is no cell, for cells are integers: ask `holds` for points in mm")
        self._check_axes(len(numbers))
        if any(not 0 <= x < 2**self.bits for x in numbers):
            return False
        return bool(self.holds_cells(np.array([numbers], dtype=np.uint64))[0])

    def __len__(self) -> int:
        return self.count

    def __bool__(self) -> bool:
        return len(self.words) > 1 or bool(self.words[0])

    def __iter__(self) -> Iterator[tuple[int, ...]]:
        from trees.runs import black_runs

        lows, highs = black_runs(self)
        for low, high in zip(lows.tolist(), highs.tolist(), strict=True):
            for first in range(low, high + 1, 4096):
                stop = min(first + 4096, high + 1)
                keys = np.uint64(first) + np.arange(stop - first, dtype=np.uint64)
                yield from map(tuple, cells_of_keys(keys, self.dimension, self.bits).tolist())

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Tree):
            return NotImplemented
        return (
            self.cube == other.cube
            and self.bits == other.bits
            and np.array_equal(self.starts, other.starts)
            and np.array_equal(self.words, other.words)
        )

    def __hash__(self) -> int:
        return hash((self.cube, self.bits, self.starts.tobytes(), self.words.tobytes()))

    def __repr__(self) -> str:
        return (
            f"<Tree: dimension {self.dimension}, {self.bits} bits an axis, {self.count} cells, "
            f"cube of {self.size} at {self.origin}>"
        )

    def __reduce__(self):
        return Tree, (self.cube, self.bits, self.starts, self.words)

    def __or__(self, other: "Tree") -> "Tree":
        return _combined(self, other, "or")

    def __and__(self, other: "Tree") -> "Tree":
        return _combined(self, other, "and")

    def __xor__(self, other: "Tree") -> "Tree":
        return _combined(self, other, "exclusive or")

    def __sub__(self, other: "Tree") -> "Tree":
        return _combined(self, other, "minus")

    def __invert__(self) -> "Tree":
        return Tree(self.cube, self.bits, self.starts, self.words ^ np.uint64(brick_mask(self.depth)))


def brick_mask(depth: int) -> int:
    """The word with all bits that a tree of this depth uses."""
    return 2 ** (2 ** min(depth, 6)) - 1


def empty(cube: Cube, bits: int) -> Tree:
    """The empty set; `~empty(cube, bits)` is the whole cube.

    >>> from trees import unit_cube
    >>> len(empty(unit_cube(3), bits=4)), len(~empty(unit_cube(3), bits=4))
    (0, 4096)
    """
    return Tree(cube, bits, np.zeros(1, np.uint64), np.zeros(1, np.uint64))


def _combined(a: Tree, b: object, operation: str) -> Tree:
    from trees.algebra import combine

    return combine(a, b, operation) if isinstance(b, Tree) else NotImplemented


def _check_canonical(tree: Tree) -> None:
    starts, words = tree.starts, tree.words
    if starts.ndim != 1 or starts.shape != words.shape or starts.size == 0 or starts[0] != 0:
        raise TreeError("starts and words are needed in equal number, the first start 0")
    if starts.size > 1 and not (starts[1:] > starts[:-1]).all():
        entry = int(np.argmin(starts[1:] > starts[:-1])) + 1
        raise TreeError(f"start {entry} is not above the one before")
    if int(starts[-1]) >= tree.bricks:
        raise TreeError(f"brick {int(starts[-1])} of a tree of {tree.bricks} bricks")
    if starts.size > 1 and (words[1:] == words[:-1]).any():
        entry = int(np.argmax(words[1:] == words[:-1])) + 1
        raise TreeError(f"word {entry} repeats the one before")
    if int(words[0]) & ~brick_mask(tree.depth):
        raise TreeError(f"word {int(words[0]):#x} has bits beyond the {2**tree.depth} cells of the tree")
