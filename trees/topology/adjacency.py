"""Which leaves and which cells touch (Guye 1988, V.1)."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Int, Int8, Real, UInt64

from trees.doors import wholes
from trees.errors import TooManyPieces, TreeError
from trees.leaves import leaf_runs
from trees.morton import check_widths, keys_of_cells
from trees.runs import MAX_RUNS
from trees.topology.metrics import D1, is_box
from trees.tree import Tree

WHITE, BLACK, GREY = 0, 1, 2
MAX_DIRECTIONS = 3**10

Vector = Real[np.ndarray, " dim"] | Sequence[int]


@dataclass(frozen=True)
class Neighbours:
    """The nodes that touch a leaf, one in each direction that stays within the cube.

    `directions` has entries -1, 0 and 1; a node of level l (0 is the root) starts at the cell of Morton key
    `keys` and has the edge `size / 2^l`; colours are 0 white, 1 black, 2 grey.
    """

    directions: Int8[np.ndarray, "nodes dim"]
    levels: Int[np.ndarray, " nodes"]
    keys: UInt64[np.ndarray, " nodes"]
    colours: Int8[np.ndarray, " nodes"]

    def __len__(self) -> int:
        return len(self.levels)


def adjacent_leaves(tree: Tree, metric: str = D1, binary: bool = False) -> Int[np.ndarray, "pairs 2"]:
    """The pairs of black leaves that touch, by their numbers in `leaves(tree, binary)`, each pair once.

    Rows are sorted, the smaller number first; `adjacent_leaves(~tree)` are those of white leaves. Found by
    one walk down pairs of nodes; the report's second procedure, where combinations of axes are left out, is
    d1.

    Raises `TooManyPieces` above 2^28 leaves or pairs, `TreeError` for another metric.

    >>> from trees import from_points
    >>> tree = from_points([[1, 1], [2, 0], [3, 0], [2, 1], [3, 1], [3, 2]], bits=2)
    >>> adjacent_leaves(tree).tolist()
    [[0, 1], [1, 2]]
    """
    from trees.topology import adjacency_kernels

    box = is_box(metric)
    first, last = leaf_runs(tree, 1 if binary else tree.dimension)
    levels = np.bitwise_count(last - first)
    total = adjacency_kernels.count_adjacent(first, levels, tree.depth, tree.dimension, box)
    if total > MAX_RUNS:
        raise TooManyPieces(total, MAX_RUNS)
    found = adjacency_kernels.adjacent(first, levels, tree.depth, tree.dimension, box, total)
    # Numbers of leaves have at most 28 bits: a pair is sorted as one integer.
    both = found[:, 0] << 28 | found[:, 1]
    both.sort()
    return np.stack([both >> 28, both & 2**28 - 1], axis=1)


def directions(dimension: int, metric: str = D1) -> Int8[np.ndarray, "directions dim"]:
    """The steps to the neighbours of a cell: `2 k` for d1, `3^k - 1` for d-infinity, in rising order.

    >>> directions(2).tolist(), len(directions(3, "d-infinity"))
    ([[-1, 0], [0, -1], [0, 1], [1, 0]], 26)
    """
    if not is_box(metric):
        unit = np.eye(dimension, dtype=np.int8)
        return np.concatenate([-unit, unit[::-1]])
    if dimension > 10:
        raise TooManyPieces(3**dimension - 1, MAX_DIRECTIONS)
    steps = [step for step in itertools.product((-1, 0, 1), repeat=dimension) if any(step)]
    return np.array(steps, dtype=np.int8)


def adjacent_cells(tree: Tree, cell: Vector, metric: str = D1) -> UInt64[np.ndarray, "cells dim"]:
    """The cells of the cube that touch a cell, black or white.

    >>> from trees import empty, unit_cube
    >>> adjacent_cells(empty(unit_cube(2), bits=2), np.array([0, 3])).tolist()
    [[0, 2], [1, 3]]
    """
    cell = _checked(tree, cell)
    steps = directions(tree.dimension, metric)
    inside = np.ones(len(steps), dtype=bool)
    start, last = cell, np.uint64(2**tree.bits - 1)
    inside &= ~((steps == -1) & (start == 0)).any(axis=1) & ~((steps == 1) & (start == last)).any(axis=1)
    return start + steps[inside].astype(np.int64).astype(np.uint64)


def adjacent_nodes(tree: Tree, cell: Vector, metric: str = D1) -> Neighbours:
    """In each direction the node that touches the leaf of this cell: a leaf of equal or larger size, or grey.

    The leaf is that of the 2^k-tree, of whatever colour. A node of the leaf's own size is grey where it is
    cut further: some of its leaves, all smaller, touch the leaf; `adjacent_leaves` lists them.

    Raises `TreeError` where the cell is outside the cube.

    >>> from trees import from_points
    >>> tree = from_points([[1, 1], [2, 0], [3, 0], [2, 1], [3, 1]], bits=2)
    >>> found = adjacent_nodes(tree, np.array([1, 1]))
    >>> found.directions.tolist(), found.levels.tolist(), found.colours.tolist()
    ([[-1, 0], [0, -1], [0, 1], [1, 0]], [2, 2, 1, 1], [0, 0, 0, 1])
    """
    cell = _checked(tree, cell)
    key = int(keys_of_cells(cell[None], tree.bits)[0])
    level = _leaf_level(tree, key)
    width = tree.bits - level
    start = (cell >> np.uint64(width)) if width < 64 else np.zeros_like(cell, np.uint64)
    rows = []
    for step in directions(tree.dimension, metric):
        moved = [int(x) + int(s) for x, s in zip(start, step, strict=True)]
        if not all(0 <= x < 2**level for x in moved):
            continue
        there = int(keys_of_cells(np.array([moved], dtype=np.uint64), level)[0]) << tree.dimension * width
        colour = _colour(tree, there, tree.dimension * width)
        found = level if colour == GREY else _leaf_level(tree, there)
        free = tree.dimension * (tree.bits - found)
        rows.append((step, found, there >> free << free, colour))
    return Neighbours(
        np.array([row[0] for row in rows], dtype=np.int8).reshape(-1, tree.dimension),
        np.array([row[1] for row in rows], dtype=np.int64),
        np.array([row[2] for row in rows], dtype=np.uint64),
        np.array([row[3] for row in rows], dtype=np.int8),
    )


def _checked(tree: Tree, cell: Vector) -> UInt64[np.ndarray, " dim"]:
    found = wholes(cell, "cell")
    if len(found) != tree.dimension:
        raise TreeError(f"a cell of {len(found)} coordinates for a tree of dimension {tree.dimension}")
    check_widths(tree.dimension, tree.bits)
    for axis, x in enumerate(found):
        if not 0 <= x < 2**tree.bits:
            raise TreeError(
                f"coordinate {x} on axis {axis}: an integer from 0 to {2**tree.bits - 1} is needed"
            )
    return np.array(found, dtype=np.uint64)


def _leaf_level(tree: Tree, key: int) -> int:
    level = tree.bits
    while level > 0:
        free = tree.dimension * (tree.bits - level + 1)
        if _colour(tree, key >> free << free, free) == GREY:
            break
        level -= 1
    return level


def _colour(tree: Tree, key: int, free: int) -> int:
    """The colour of the node of `2^free` cells from this key."""
    entry = int(np.searchsorted(tree.starts, np.uint64(key >> 6), side="right")) - 1
    word = int(tree.words[entry])
    if free >= 6 and tree.depth >= 6:
        full = 2**64 - 1
        end = int(tree.starts[entry + 1]) if entry + 1 < len(tree.starts) else tree.bricks
        if (key + (1 << free)) >> 6 > end:
            return GREY
    else:
        full = 2 ** (2**free) - 1
        word = (word >> (key & 63)) & full
    return WHITE if word == 0 else BLACK if word == full else GREY
