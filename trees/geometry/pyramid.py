"""The coarser copies of a tree, with tables that find the word of a cell at once."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Int64, UInt64

from trees.errors import TooManyPieces
from trees.tree import Tree

MAX_ENTRIES = 2**28
LARGEST_TABLE = 2**22


class Pyramid(NamedTuple):
    """The trees `tree.at(0)` to `tree.at(bits)`, one after the other.

    Level b has the entries `starts[first[b]:first[b + 1]]`. Its bricks are cut into blocks of
    `2^shifts[b]`; the entry that holds the first brick of block i is `table[rows[b] + i]`.
    """

    starts: UInt64[np.ndarray, " _entries"]
    words: UInt64[np.ndarray, " _entries"]
    first: Int64[np.ndarray, " _levels"]
    table: Int64[np.ndarray, " _blocks"]
    rows: Int64[np.ndarray, " _rows"]
    shifts: UInt64[np.ndarray, " _rows"]


def pyramid(tree: Tree) -> Pyramid:
    """The pyramid of a tree: a cell of level b is black where any cell of the tree in it is.

    Raises `TooManyPieces` above 2^28 entries of all levels together.

    >>> from trees import from_points
    >>> pyramid(from_points([[3, 0]], bits=2)).words.tolist()
    [1, 4, 1024]
    """
    levels = [tree]
    for bits in range(tree.bits - 1, -1, -1):
        levels.append(levels[-1].at(bits))
        total = sum(len(level.words) for level in levels)
        if total > MAX_ENTRIES:
            raise TooManyPieces(total, MAX_ENTRIES)
    levels.reverse()
    tables, shifts = [], []
    for level in levels:
        room = min(LARGEST_TABLE, max(64, 4 * len(level.words)))
        shift = max(level.bricks.bit_length() - room.bit_length(), 0)
        heads = np.arange(level.bricks >> shift, dtype=np.uint64) << np.uint64(shift)
        found = np.searchsorted(level.starts, heads, side="right") - 1
        tables.append(np.append(found, len(level.starts) - 1).astype(np.int64))
        shifts.append(shift)
    sizes = np.cumsum([0] + [len(level.words) for level in levels])
    rows = np.cumsum([0] + [len(table) for table in tables])[:-1]
    return Pyramid(
        np.concatenate([level.starts for level in levels]),
        np.concatenate([level.words for level in levels]),
        sizes.astype(np.int64),
        np.concatenate(tables),
        rows.astype(np.int64),
        np.array(shifts, dtype=np.uint64),
    )
