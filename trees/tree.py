"""The value: a set of cells of a cube of any dimension, in one of three forms."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, UInt64

from trees.bricks import Bricks, Flat, brick_mask, bricks_of_flat, check_bricks, form_of_bricks
from trees.cube import Cube
from trees.doors import Rows, cell_rows, point_rows, whole, wholes
from trees.errors import KeyTooWide, TreeError
from trees.morton import cell_of_key, cells_of_keys, check_widths, keys_of_cells
from trees.shared import Shared, bricks_of_shared, check_depth, holds_cell, holds_cells, shared_of_bricks


@dataclass(frozen=True, eq=False, repr=False)
class Tree:
    """A set of the `2^(dimension * bits)` cells of a cube (Guye 1988, II): immutable, hashable, canonical.

    It is kept as `Bricks`, sorted words of 64 cells, as `Flat` words where most of them differ, or as a
    `Shared` binary tree, equal subtrees kept once: bricks for sets of any kind, the shared form for
    self-similar ones and for cells of more than 64 bits in all. Each is canonical, and conversions are
    exact: trees of equal cube, bits and set are equal, however they were built and kept. `compact`
    chooses the smallest form.

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
    form: Bricks | Flat | Shared

    def __post_init__(self):
        object.__setattr__(self, "bits", whole(self.bits, "bits"))
        check_depth(self.dimension, self.bits)
        if self.form.depth != self.depth:
            raise TreeError(f"{self.form.depth} levels for {self.dimension} axes of {self.bits} bits")

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

    @cached_property
    def as_bricks(self) -> Bricks:
        """The set as words. Raises `KeyTooWide` above 64 levels, `TooManyPieces` above 2^28 entries."""
        if isinstance(self.form, Bricks):
            return self.form
        if isinstance(self.form, Flat):
            return bricks_of_flat(self.form)
        if self.depth > 64:
            raise KeyTooWide(self.dimension, self.bits)
        return bricks_of_shared(self.form)

    @cached_property
    def as_shared(self) -> Shared:
        """The set as a binary tree with shared nodes. Raises `TooManyPieces` above 2^28 nodes."""
        return self.form if isinstance(self.form, Shared) else shared_of_bricks(self.as_bricks)

    @property
    def starts(self) -> UInt64[np.ndarray, " entries"]:
        """The first brick of each entry of `as_bricks`."""
        return self.as_bricks.starts

    @property
    def words(self) -> UInt64[np.ndarray, " entries"]:
        """The word of each entry of `as_bricks`."""
        return self.as_bricks.words

    @property
    def lengths(self) -> UInt64[np.ndarray, " entries"]:
        """How many bricks each entry of `as_bricks` stands for."""
        return self.as_bricks.lengths

    @property
    def bricks(self) -> int:
        """How many bricks the cube has."""
        return 2 ** max(self.depth - 6, 0)

    @property
    def nbytes(self) -> int:
        """The memory of the form in which the set is kept."""
        return self.form.nbytes

    @property
    def count(self) -> int:
        """How many cells are black."""
        return self.form.count

    @property
    def measure(self) -> float:
        """The k-dimensional volume of the set, in mm^k."""
        return self.count * self.cell_size**self.dimension

    def holds_cells(self, cells: Rows) -> Bool[np.ndarray, "cells"]:
        """Which cells, given by integer coordinates, are in the set; those outside the cube are not.

        Raises `TreeError` where the coordinates are no integers, or not one an axis.
        """
        rows = cell_rows(cells, self.dimension)
        # No integer of an array reaches 2^64.
        inside = ((rows >= 0) & (rows <= np.uint64(2 ** min(self.bits, 64) - 1))).all(axis=1)
        found = np.zeros(len(rows), dtype=bool)
        found[inside] = self._holds_inside(rows[inside].astype(np.uint64))
        return found

    def holds(self, points: Rows) -> Bool[np.ndarray, "points"]:
        """Which points, in mm, lie in a black cell; cells are half-open, all outside the cube is white.

        Raises `TreeError` where the points have not one coordinate an axis.
        """
        from trees.reals import MOST_BITS, cells_of_points, exact_cells

        rows = point_rows(points, self.dimension)
        low, high = np.array(self.origin), np.array(self.cube.ends)
        inside = ((rows >= low) & (rows < high)).all(axis=1)
        found = np.zeros(len(rows), dtype=bool)
        if self.bits > MOST_BITS:
            cells = exact_cells(rows[inside], self.cube, self.bits)
            found[inside] = [holds_cell(self.as_shared, cell, self.bits) for cell in cells]
        else:
            found[inside] = self._holds_inside(cells_of_points(rows[inside], self.cube, self.bits))
        return found

    def at(self, bits: int) -> "Tree":
        """The set at another precision: exact where finer; where coarser, every cell that meets the set."""
        from trees.runs import at_bits

        return at_bits(self, bits)

    def _holds_inside(self, cells: UInt64[np.ndarray, "_cells dim"]) -> Bool[np.ndarray, " _cells"]:
        if isinstance(self.form, Shared) and self.bits > 64:
            return np.array([holds_cell(self.form, cell, self.bits) for cell in cells.tolist()], dtype=bool)
        if isinstance(self.form, Shared):
            return holds_cells(self.form, np.ascontiguousarray(cells), self.bits)
        keys = keys_of_cells(cells, self.bits)
        entry = np.searchsorted(self.starts, keys >> np.uint64(6), side="right") - 1
        return (self.words[entry] >> (keys & np.uint64(63))) & np.uint64(1) == 1

    def _check_axes(self, axes: int) -> None:
        if axes != self.dimension:
            raise TreeError(f"points of {axes} coordinates for a tree of dimension {self.dimension}")

    def __contains__(self, cell: object) -> bool:
        numbers = wholes(cell, "no cell:")
        self._check_axes(len(numbers))
        if any(not 0 <= x < 2**self.bits for x in numbers):
            return False
        if self.bits > 64:
            return holds_cell(self.as_shared, numbers, self.bits)
        return bool(self.holds_cells(np.array([numbers], dtype=np.uint64))[0])

    def __len__(self) -> int:
        return self.count

    def __bool__(self) -> bool:
        return self.count > 0

    def __iter__(self) -> Iterator[tuple[int, ...]]:
        from trees.runs import black_runs, wide_runs

        if isinstance(self.form, Shared):
            runs = wide_runs(self)
        else:
            lows, highs = black_runs(self)
            runs = zip(lows.tolist(), highs.tolist(), strict=True)
        for low, high in runs:
            if self.depth > 64 or high - low < 8:
                yield from (cell_of_key(key, self.dimension, self.bits) for key in range(low, high + 1))
                continue
            for first in range(low, high + 1, 4096):
                stop = min(first + 4096, high + 1)
                keys = np.uint64(first) + np.arange(stop - first, dtype=np.uint64)
                yield from map(tuple, cells_of_keys(keys, self.dimension, self.bits).tolist())

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Tree):
            return NotImplemented
        if self.cube != other.cube or self.bits != other.bits or self.count != other.count:
            return False
        if isinstance(self.form, Flat) and isinstance(other.form, Flat):
            return self.form.same(other.form)
        if not isinstance(self.form, Shared) and not isinstance(other.form, Shared):
            return self.as_bricks.same(other.as_bricks)
        return self.as_shared.same(other.as_shared)

    def __hash__(self) -> int:
        return hash((self.cube, self.bits, self.count))

    def __repr__(self) -> str:
        return (
            f"<Tree: dimension {self.dimension}, {self.bits} bits an axis, {self.count} cells, "
            f"cube of {self.size} at {self.origin}>"
        )

    def __reduce__(self):
        return Tree, (self.cube, self.bits, self.form)

    def __or__(self, other: "Tree") -> "Tree":
        return _combined(self, other, "or")

    def __and__(self, other: "Tree") -> "Tree":
        return _combined(self, other, "and")

    def __xor__(self, other: "Tree") -> "Tree":
        return _combined(self, other, "exclusive or")

    def __sub__(self, other: "Tree") -> "Tree":
        return _combined(self, other, "minus")

    def __invert__(self) -> "Tree":
        return self ^ _uniform(self.cube, self.bits, 1, isinstance(self.form, Shared))


def of_bricks(
    cube: Cube, bits: int, starts: UInt64[np.ndarray, " entries"], words: UInt64[np.ndarray, " entries"]
) -> Tree:
    """The tree of bricks in canonical form: see `Bricks`. Raises `KeyTooWide` above 64 levels."""
    bits = whole(bits, "bits")
    check_widths(cube.dimension, bits)
    bricks = Bricks(cube.dimension * bits, starts, words)
    check_bricks(bricks)
    return Tree(cube, bits, form_of_bricks(bricks))


def empty(cube: Cube, bits: int) -> Tree:
    """The empty set; `full(cube, bits)` is the whole cube.

    >>> from trees import unit_cube
    >>> len(empty(unit_cube(3), bits=4))
    0
    """
    return _uniform(cube, bits, 0)


def full(cube: Cube, bits: int) -> Tree:
    """All cells of a cube.

    >>> from trees import unit_cube
    >>> len(full(unit_cube(3), bits=4))
    4096
    """
    return _uniform(cube, bits, 1)


def compact(tree: Tree) -> Tree:
    """The same set, in the form that takes less memory: see `Tree`.

    Raises `TooManyPieces` where the shared form has more than 2^28 nodes.

    >>> from trees import from_array
    >>> x, y = np.indices((256, 256))
    >>> sierpinski = from_array(x & y == 0)
    >>> compact(sierpinski).nbytes, sierpinski.nbytes, compact(sierpinski) == sierpinski
    (184, 2592, True)
    """
    if tree.depth > 64 or tree.as_shared.nbytes < tree.form.nbytes:
        return Tree(tree.cube, tree.bits, tree.as_shared)
    return tree


def _uniform(cube: Cube, bits: int, colour: int, shared: bool = False) -> Tree:
    bits = whole(bits, "bits")
    depth = cube.dimension * bits
    check_depth(cube.dimension, bits)
    if shared or depth > 64:
        none = np.zeros(0, dtype=np.uint32)
        return Tree(cube, bits, Shared(depth, colour, none, none))
    word = np.array([brick_mask(depth) * colour], dtype=np.uint64)
    return Tree(cube, bits, form_of_bricks(Bricks(depth, np.zeros(1, np.uint64), word)))


def _combined(a: Tree, b: object, operation: str) -> Tree:
    from trees.algebra import combine

    return combine(a, b, operation) if isinstance(b, Tree) else NotImplemented
