"""Trees seen along an axis: shadows, depth maps, and the cells that are not hidden."""

import numpy as np
from jaxtyping import Int, UInt64

from trees.cells import from_morton
from trees.errors import TooManyPieces
from trees.geometry.sections import check_flat, without, without_axis
from trees.leaves import leaf_runs
from trees.morton import cells_of_keys, keys_of_cells
from trees.runs import tree_of_runs
from trees.tree import Tree, empty

MAX_COLUMNS = 2**28


def project(tree: Tree, axis: int) -> Tree:
    """The shadow along an axis: a column is black where any of its cells is; one dimension less.

    >>> from trees import from_points
    >>> list(project(from_points([[0, 1, 2], [3, 1, 2], [3, 0, 0]], bits=2), axis=0))
    [(0, 0), (1, 2)]
    """
    axis = check_flat(tree, axis)
    first, last = leaf_runs(tree, tree.dimension)
    lows, highs = without_axis(tree, axis, first), without_axis(tree, axis, last)
    if len(lows) == 0:
        return empty(without(tree.cube, axis), tree.bits)
    # Blocks are nested or apart: sorted, large ones first, those that end no later than one before are in it.
    order = np.lexsort((~highs, lows))
    lows, highs = lows[order], np.maximum.accumulate(highs[order])
    new = np.append(True, highs[1:] > highs[:-1])
    return tree_of_runs((lows[new], highs[new]), without(tree.cube, axis), tree.bits)


def depth_map(tree: Tree, axis: int, rising: bool = True) -> Int[np.ndarray, "..."]:
    """The coordinate on an axis of the first black cell of each column, -1 where there is none.

    An array of side `2^bits` on the other axes, in their order. The first is the lowest, seen from minus
    infinity; with `rising=False` the highest, seen from plus infinity. The low face of cell z stands at
    `origin + z cell_size` mm.

    Raises `TooManyPieces` above 2^28 columns.

    >>> from trees import from_points
    >>> tree = from_points([[0, 1], [0, 3], [2, 2]], bits=2)
    >>> depth_map(tree, axis=1).tolist(), depth_map(tree, axis=1, rising=False).tolist()
    ([1, -1, 2, -1], [3, -1, 2, -1])
    """
    k = tree.dimension
    heights = _heights(tree, axis, rising)
    levels = heights.reshape((2,) * ((k - 1) * tree.bits))
    order = [level * (k - 1) + other for other in range(k - 1) for level in range(tree.bits)]
    return levels.transpose(order).reshape((2**tree.bits,) * (k - 1))


def visible(tree: Tree, axis: int, rising: bool = True) -> Tree:
    """The black cells that are first in their column along an axis: hidden parts are left out.

    Seen from minus infinity, or with `rising=False` from plus infinity.

    >>> from trees import from_points
    >>> list(visible(from_points([[0, 1], [0, 3], [2, 2]], bits=2), axis=1))
    [(0, 1), (2, 2)]
    """
    axis, heights = check_flat(tree, axis), _heights(tree, axis, rising)
    seen = np.flatnonzero(heights >= 0)
    others = cells_of_keys(seen.astype(np.uint64), tree.dimension - 1, tree.bits)
    cells = np.insert(others, axis, heights[seen].astype(np.uint64), axis=1)
    return from_morton(keys_of_cells(cells, tree.bits), tree.cube, tree.bits)


def _heights(tree: Tree, axis: int, rising: bool) -> Int[np.ndarray, " columns"]:
    """The first coordinate of each column, columns in Morton order."""
    from trees.geometry import kernels

    axis = check_flat(tree, axis)
    columns = 2 ** (tree.depth - tree.bits)
    if columns > MAX_COLUMNS:
        raise TooManyPieces(columns, MAX_COLUMNS)
    first, last = leaf_runs(tree, tree.dimension)
    ends: UInt64[np.ndarray, " leaves"] = first if rising else last
    heights = cells_of_keys(ends, tree.dimension, tree.bits)[:, axis].astype(np.int64)
    lows, highs = without_axis(tree, axis, first), without_axis(tree, axis, last)
    return kernels.depths(lows, highs, heights, rising, -1, columns)
