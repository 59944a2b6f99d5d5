"""The order of Peano and Hilbert: cells and leaves along a curve whose steps cross one face each.

The curve of `bits` bits visits all cells of the cube, from (0, ..., 0) to (2^bits - 1, 0, ..., 0). Without
its last `dimension` bits, the place of a cell is that of its parent on the coarser curve, so every node of
the 2^k-tree is one interval of the curve. (J. Skilling, "Programming the Hilbert curve", AIP Conference
Proceedings 707, 2004; his pass over the lowest bits, which changes nothing, is left out.)
"""

from collections.abc import Iterator

import numpy as np
from jaxtyping import UInt64

from trees.doors import Rows, cell_rows, numbers, whole
from trees.errors import TreeError
from trees.leaves import leaf_runs
from trees.morton import cells_of_keys, check_widths, keys_of_cells
from trees.runs import Runs
from trees.tree import Tree

CHUNK = 4096


def hilbert_indices(cells: Rows, bits: int) -> UInt64[np.ndarray, "cells"]:
    """The places on the curve, from 0, of cells with integer coordinates in `[0, 2^bits)`.

    Raises `KeyTooWide` where `dim * bits > 64`, `TreeError` with the row where a coordinate is outside.

    >>> hilbert_indices(np.array([[0, 0], [0, 1], [1, 1], [1, 0]]), bits=1).tolist()
    [0, 1, 2, 3]
    """
    rows, bits = cell_rows(cells), whole(bits, "bits")
    return hilbert_of_morton(keys_of_cells(rows, bits), rows.shape[1], bits)


def cells_of_hilbert(indices: Rows, dimension: int, bits: int) -> UInt64[np.ndarray, "cells _dim"]:
    """The cells at these places of the curve: the inverse of `hilbert_indices`.

    Raises `TreeError` with the row of a place outside `[0, 2^(dimension * bits))`.

    >>> cells_of_hilbert(np.arange(4), dimension=2, bits=1).tolist()
    [[0, 0], [0, 1], [1, 1], [1, 0]]
    """
    indices, dimension, bits = numbers(indices, "places"), whole(dimension, "dimension"), whole(bits, "bits")
    check_widths(dimension, bits)
    if not np.issubdtype(indices.dtype, np.integer):
        raise TreeError(f"places on the curve are integers, not {indices.dtype}")
    outside = (indices < 0) | (indices > np.uint64(2 ** (dimension * bits) - 1))
    if outside.any():
        row = int(np.argmax(outside))
        raise TreeError(
            f"place {row} is {indices[row]}: one from 0 to {2 ** (dimension * bits) - 1} is needed"
        )
    return cells_of_keys(morton_of_hilbert(indices.astype(np.uint64), dimension, bits), dimension, bits)


def hilbert_of_morton(
    keys: UInt64[np.ndarray, " keys"], dimension: int, bits: int
) -> UInt64[np.ndarray, " keys"]:
    """The places on the curve of cells with these Morton keys.

    >>> hilbert_of_morton(np.array([0, 1, 3, 2], dtype=np.uint64), dimension=2, bits=1).tolist()
    [0, 1, 2, 3]
    """
    from trees import hilbert_kernels

    check_widths(dimension, bits)
    return hilbert_kernels.indices(keys, dimension, bits)


def morton_of_hilbert(
    indices: UInt64[np.ndarray, " keys"], dimension: int, bits: int
) -> UInt64[np.ndarray, " keys"]:
    """The Morton keys of the cells at these places of the curve: the inverse of `hilbert_of_morton`.

    >>> morton_of_hilbert(np.arange(4, dtype=np.uint64), dimension=2, bits=1).tolist()
    [0, 1, 3, 2]
    """
    from trees import hilbert_kernels

    check_widths(dimension, bits)
    return hilbert_kernels.keys(indices, dimension, bits)


def hilbert_runs(tree: Tree) -> Runs:
    """First and last places of the longest runs of black cells along the curve, in rising order.

    Raises `TooManyPieces` where the tree has more than 2^28 leaves.

    >>> from trees import from_points
    >>> lows, highs = hilbert_runs(from_points([[0, 1], [1, 1]], bits=1))
    >>> lows.tolist(), highs.tolist()
    ([1], [2])
    """
    first, last = leaf_runs(tree, tree.dimension)
    within = last - first
    lows = hilbert_of_morton(first, tree.dimension, tree.bits) & ~within
    order = np.argsort(lows)
    lows, highs = lows[order], (lows | within)[order]
    apart = lows[1:] - highs[:-1] > 1
    return lows[np.append(True, apart)[: len(lows)]], highs[np.append(apart, True)[: len(lows)]]


def hilbert_cells(tree: Tree) -> Iterator[tuple[int, ...]]:
    """The black cells along the curve; `for cell in tree` gives them in Morton order.

    Raises `TooManyPieces` where the tree has more than 2^28 leaves.

    >>> from trees import empty, unit_cube
    >>> list(hilbert_cells(~empty(unit_cube(2), bits=1)))
    [(0, 0), (0, 1), (1, 1), (1, 0)]
    """
    lows, highs = hilbert_runs(tree)
    for low, high in zip(lows.tolist(), highs.tolist(), strict=True):
        for first in range(low, high + 1, CHUNK):
            places = np.uint64(first) + np.arange(min(CHUNK, high + 1 - first), dtype=np.uint64)
            yield from map(tuple, cells_of_hilbert(places, tree.dimension, tree.bits).tolist())
