"""Trees that stay in their file: membership, counts and branches, for which only some chunks are read."""

import os
import weakref
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

import numpy as np
from jaxtyping import Bool, UInt64

from trees.bricks import brick_mask
from trees.cube import Cube
from trees.doors import Rows, cell_rows, point_rows, whole, wholes
from trees.errors import DamagedFile, Misaligned, TooManyPieces, TreeError
from trees.files import layout
from trees.files.bricks import Chunk, check_table, checked_chunk, count
from trees.morton import keys_of_cells
from trees.runs import MAX_RUNS
from trees.tree import Tree, of_bricks

HELD = 512  # chunks of 64 KiB that stay in memory


@dataclass(frozen=True, eq=False, repr=False)
class MappedTree:
    """A tree in a file, open for questions. `close()` it, or use it in a `with` statement.

    Its chunks are read and checked when a question needs them, and 512 of them, 32 MiB, are kept. Questions
    raise `DamagedFile` where a chunk is wrong or was cut off meanwhile; no answer comes from unchecked bytes.
    """

    cube: Cube
    bits: int
    count: int
    firsts: UInt64[np.ndarray, " chunks"]
    before: UInt64[np.ndarray, " chunks"]
    chunk: Callable[[int], Chunk]
    close: Callable[[], None]

    @property
    def dimension(self) -> int:
        """How many axes."""
        return self.cube.dimension

    @property
    def depth(self) -> int:
        """Bits of a key: `dimension * bits`."""
        return self.dimension * self.bits

    @property
    def cell_size(self) -> float:
        """The edge of a cell, in mm."""
        return self.cube.size / 2**self.bits

    @property
    def measure(self) -> float:
        """The k-dimensional volume of the set, in mm^k."""
        return self.count * self.cell_size**self.dimension

    def holds_cells(self, cells: Rows) -> Bool[np.ndarray, "cells"]:
        """Which cells, given by integer coordinates, are in the set; those outside the cube are not."""
        rows = cell_rows(cells, self.dimension)
        inside = ((rows >= 0) & (rows <= np.uint64(2**self.bits - 1))).all(axis=1)
        found = np.zeros(len(rows), dtype=bool)
        found[inside] = self._holds_keys(keys_of_cells(rows[inside], self.bits))
        return found

    def holds(self, points: Rows) -> Bool[np.ndarray, "points"]:
        """Which points, in mm, lie in a black cell; cells are half-open, all outside the cube is white."""
        from trees.reals import MOST_BITS, cells_of_points, exact_cells

        rows = point_rows(points, self.dimension)
        inside = ((rows >= np.array(self.cube.origin)) & (rows < np.array(self.cube.ends))).all(axis=1)
        found = np.zeros(len(rows), dtype=bool)
        if self.bits > MOST_BITS:
            cells = np.array(exact_cells(rows[inside], self.cube, self.bits), dtype=np.uint64)
            cells = cells.reshape(-1, self.dimension)
        else:
            cells = cells_of_points(rows[inside], self.cube, self.bits)
        found[inside] = self.holds_cells(cells)
        return found

    def count_in(self, level: int, cell: tuple[int, ...]) -> int:
        """The black cells of a branch: of cell `cell` in the grid of `2^level` cells an axis.

        It reads two chunks at most. Raises `TreeError` where there is no such branch.
        """
        first, depth = self._branch(level, cell)
        return self._below(first + 2**depth) - self._below(first)

    def branch(self, level: int, cell: tuple[int, ...]) -> Tree:
        """A branch as a tree of its own, whose cube is cell `cell` in the grid of `2^level` cells an axis.

        Raises `TreeError` where there is no such branch, `TooManyPieces` where it has more than 2^28
        entries, `Misaligned` where the corner of the cube is no floating-point number.
        """
        first, depth = self._branch(level, cell)
        cube = _cell_cube(self.cube, level, cell)
        low, high = first >> 6, max(first + 2**depth >> 6, (first >> 6) + 1)
        chunks = range(self._chunk_of(low), self._chunk_of(high - 1) + 1)
        if len(chunks) * layout.CHUNK > MAX_RUNS:
            raise TooManyPieces(len(chunks) * layout.CHUNK, MAX_RUNS)
        starts, words = (np.concatenate(part) for part in zip(*map(self.chunk, chunks), strict=True))
        begin, end = (
            int(np.searchsorted(starts, np.uint64(low), side="right")) - 1,
            int(np.searchsorted(starts, np.uint64(high - 1), side="right")),
        )
        starts = np.maximum(starts[begin:end], np.uint64(low)) - np.uint64(low)
        words = words[begin:end]
        if depth < 6:
            words = (words >> np.uint64(first & 63)) & np.uint64(brick_mask(depth))
        return of_bricks(cube, self.bits - level, starts, words)

    def whole(self) -> Tree:
        """All of it, in memory."""
        return self.branch(0, (0,) * self.dimension)

    def _holds_keys(self, keys: UInt64[np.ndarray, " _keys"]) -> Bool[np.ndarray, " _keys"]:
        bricks = keys >> np.uint64(6)
        which = np.searchsorted(self.firsts, bricks, side="right") - 1
        order = np.argsort(which, kind="stable")
        found = np.zeros(len(keys), dtype=bool)
        for asked in np.split(order, np.flatnonzero(np.diff(which[order])) + 1):
            if len(asked):
                starts, words = self.chunk(int(which[asked[0]]))
                word = words[np.searchsorted(starts, bricks[asked], side="right") - 1]
                found[asked] = (word >> (keys[asked] & np.uint64(63))) & np.uint64(1) == 1
        return found

    def _below(self, key: int) -> int:
        """How many black cells have a lower key."""
        if key == 2**self.depth:
            return self.count
        number = self._chunk_of(key >> 6)
        starts, words = self.chunk(number)
        end = int(np.searchsorted(starts, np.uint64(key >> 6), side="right"))
        lengths = np.diff(starts[:end], append=np.uint64(key >> 6))
        rest = int(words[end - 1]) & (2 ** (key & 63) - 1)
        return int(self.before[number]) + count(lengths, words[:end]) + rest.bit_count()

    def _chunk_of(self, brick: int) -> int:
        return int(np.searchsorted(self.firsts, np.uint64(brick), side="right")) - 1

    def _branch(self, level: int, cell: tuple[int, ...]) -> tuple[int, int]:
        """The first key of a branch, and its depth."""
        level, numbers = whole(level, "level"), wholes(cell, "cell")
        if not 0 <= level <= self.bits:
            raise TreeError(
                f"level {level} of a tree of {self.bits} bits an axis: one from 0 to these is needed"
            )
        self._check_axes(len(numbers))
        for axis, x in enumerate(numbers):
            if x not in range(2**level):
                raise TreeError(f"cell {cell}: {x} on axis {axis} is no number from 0 to {2**level - 1}")
        depth = self.dimension * (self.bits - level)
        return int(keys_of_cells(np.array([numbers], dtype=np.uint64), level)[0]) << depth, depth

    def _check_axes(self, axes: int) -> None:
        if axes != self.dimension:
            raise TreeError(f"cells of {axes} coordinates for a tree of dimension {self.dimension}")

    def __contains__(self, cell: object) -> bool:
        numbers = wholes(cell, "no cell:")
        self._check_axes(len(numbers))
        if any(not 0 <= x < 2**self.bits for x in numbers):
            return False
        return bool(self.holds_cells(np.array([numbers], dtype=np.uint64))[0])

    def __len__(self) -> int:
        return self.count

    def __enter__(self) -> "MappedTree":
        return self

    def __exit__(self, *_) -> None:
        self.close()

    def __repr__(self) -> str:
        return (
            f"<MappedTree: dimension {self.dimension}, {self.bits} bits an axis, {self.count} cells, "
            f"cube of {self.cube.size} at {self.cube.origin}>"
        )


def map_tree(path: str | os.PathLike[str]) -> MappedTree:
    """Open a file of `write_tree`, of any size, without reading it whole.

    Opening reads the head and the table, 64 bytes for each 64 KiB of the file, and checks them. Each chunk
    is checked when it is read: its SHA-256, its order, its canonical form, and its count. Chunks are copied
    out of the file, not read in a memory map, for a map of a file that someone cuts ends the process.

    A file of a shared tree, which `write_tree` writes of a tree kept so, cannot be read in parts: `read_tree`
    reads it whole.

    Raises `DamagedFile`, which names the path; `TreeError` for a file of a shared tree.

    >>> import tempfile
    >>> from trees import from_points, write_tree
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_tree(from_points([[1, 0], [3, 3]], bits=2), f"{folder}/a.tree")
    ...     with map_tree(f"{folder}/a.tree") as tree:
    ...         (1, 0) in tree, tree.count_in(1, (1, 1)), tree.branch(1, (1, 1))
    (True, 1, <Tree: dimension 2, 1 bits an axis, 1 cells, cube of 0.5 at (0.5, 0.5)>)
    """
    handle = os.open(path, os.O_RDONLY)
    try:
        stored = layout.opened(lambda offset, size: os.pread(handle, size, offset), os.fstat(handle).st_size)
        if stored.head.kind == "shared":
            raise TreeError(
                f"{os.fspath(path)} holds a shared tree, whose nodes are not in the order of cells: "
                "no part of it can be read alone, and `read_tree` reads it whole"
            )
        check_table(stored)
    except DamagedFile as error:
        os.close(handle)
        raise DamagedFile(f"{os.fspath(path)}: {error}") from error
    except BaseException:
        os.close(handle)
        raise

    @lru_cache(maxsize=HELD)
    def chunk(number: int) -> Chunk:
        if not closer.alive:
            raise TreeError(f"{os.fspath(path)} is closed")
        try:
            return checked_chunk(stored, number)
        except DamagedFile as error:
            raise DamagedFile(f"{os.fspath(path)}: {error}") from error

    closer = weakref.finalize(chunk, os.close, handle)
    low, high = stored.summaries[:, 2], stored.summaries[:, 3]
    before = np.cumsum(low) - low
    cells = (int((low >> np.uint64(32)).sum()) << 32) + int((low & np.uint64(2**32 - 1)).sum())
    cells += int(high.sum()) << 64
    head = stored.head
    return MappedTree(head.cube, head.bits, cells, stored.summaries[:, 0].copy(), before, chunk, closer)


def _cell_cube(cube: Cube, level: int, cell: tuple[int, ...]) -> Cube:
    size = Fraction(cube.size) / 2 ** whole(level, "level")
    exact = [Fraction(x) + size * int(i) for x, i in zip(cube.origin, cell, strict=True)]
    found = Cube(tuple(float(x) for x in exact), float(size))
    if [Fraction(x) for x in found.origin] != exact:
        raise Misaligned(
            f"cell {cell} of level {level} of {cube} has a corner that is no floating-point number"
        )
    return found
