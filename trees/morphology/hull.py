"""The digital convex hull: cells whose centres lie in the convex hull of the black centres."""

import itertools

import numpy as np
from jaxtyping import Int, UInt64

from trees.cells import from_points, to_array, to_points
from trees.errors import TooManyPieces
from trees.morphology.halfspaces import HalfSpaces, half_spaces
from trees.morphology.tiles import layout
from trees.morton import cells_of_keys
from trees.runs import tree_of_runs
from trees.tree import Tree, of_bricks

MAX_TILES = 2**22
GRID_BITS = 21


def convex_hull(tree: Tree) -> Tree:
    """The cells whose centres lie in the convex hull of the black centres, its boundary included.

    The hull is the intersection of half-spaces `n x <= b` with integers n and b; scipy (Qhull) finds the
    facets in floating point, and their normals, and that all black cells lie behind them, are worked out
    in integers. Cells on a line, in a plane, and so on, have the hull they have there. The empty set is
    its own hull.

    Raises `TreeError` where integers of 62 bits do not hold the normals, or where the facets of Qhull are not
    those of the hull (both on very fine grids), `TooManyPieces` where more than 2^22 tiles are on the
    boundary.

    >>> from trees import from_points
    >>> list(convex_hull(from_points([[0, 0], [2, 2], [3, 0]], bits=2)))
    [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (3, 0), (2, 2)]
    """
    if not tree:
        return tree
    return _filled(half_spaces(_outer_cells(tree), 2**tree.bits), tree)


def _outer_cells(tree: Tree) -> Int[np.ndarray, "cells dim"]:
    """Some black cells, all vertices of the hull among them.

    A cell with black cells strictly beyond it in each orthant is no vertex. Coarse cells tell which
    regions consist of such cells; of what is left, the ends of each line of cells along an axis are
    enough.
    """
    bits = min(GRID_BITS // tree.dimension, tree.bits)
    if 0 < bits < tree.bits:
        grid = to_array(tree.at(bits))
        cells = np.argwhere(grid & ~_surrounded(grid))
        tree = tree & from_points(cells, bits, tree.cube)
    cells = to_points(tree).astype(np.int64)
    for axis in range(tree.dimension):
        others = [a for a in range(tree.dimension) if a != axis]
        cells = cells[np.lexsort([cells[:, axis], *(cells[:, a] for a in others)])]
        new = (cells[1:, others] != cells[:-1, others]).any(axis=1)
        cells = cells[np.append(True, new) | np.append(new, True)]
    return cells


def _surrounded(grid: np.ndarray) -> np.ndarray:
    """The cells with black cells strictly beyond on all axes, in each of the `2^k` orthants."""
    found = np.ones_like(grid)
    for signs in itertools.product((1, -1), repeat=grid.ndim):
        flip = tuple(slice(None, None, sign) for sign in signs)
        beyond = np.pad(grid[flip], [(1, 0)] * grid.ndim)[(slice(-1),) * grid.ndim]
        for axis in range(grid.ndim):
            beyond = np.logical_or.accumulate(beyond, axis=axis)
        found &= beyond[flip]
    return found


def _filled(spaces: HalfSpaces, tree: Tree) -> Tree:
    """The cells in all half-spaces: tiles inside at once, those on the boundary row by row."""
    from trees.morphology import hull_kernels as kernels

    found = layout(tree.dimension, tree.bits)
    keys = np.zeros(1, dtype=np.uint64)
    inside = []
    for level in range(tree.bits - found.side + 1):
        if len(keys) > MAX_TILES:
            raise TooManyPieces(len(keys), MAX_TILES)
        if level:
            steps = np.arange(2**tree.dimension, dtype=np.uint64)
            keys = ((keys[:, None] << np.uint64(tree.dimension)) | steps).ravel()
        meets, holds = _sorted_out(spaces, keys, tree, level)
        inside.append((keys[holds], tree.depth - level * tree.dimension))
        keys = keys[meets & ~holds]
    corners = cells_of_keys(keys, tree.dimension, tree.bits - found.side).astype(np.int64) << found.side
    starts, words = kernels.hull_tiles(
        spaces.normals,
        spaces.limits,
        keys,
        corners,
        found.edge,
        found.count,
        np.uint64(found.shift),
        found.tables,
        np.uint64(tree.bricks),
    )
    new = np.append(True, words[1:] != words[:-1])
    return of_bricks(tree.cube, tree.bits, starts[new], words[new]) | _blocks(inside, tree)


def _sorted_out(
    spaces: HalfSpaces, keys: UInt64[np.ndarray, " _boxes"], tree: Tree, level: int
) -> tuple[np.ndarray, np.ndarray]:
    """Which branches of a level the half-spaces may meet, and which they hold."""
    edge = 2 ** (tree.bits - level)
    lows = cells_of_keys(keys, tree.dimension, level).astype(np.int64) * edge
    meets, holds = np.ones(len(keys), dtype=bool), np.ones(len(keys), dtype=bool)
    for normal, limit in zip(spaces.normals, spaces.limits, strict=True):
        least = lows @ normal + (edge - 1) * np.minimum(normal, 0).sum()
        meets &= least <= limit
        holds &= least + (edge - 1) * abs(normal).sum() <= limit
    return meets, holds


def _blocks(inside: list[tuple[UInt64[np.ndarray, " _blocks"], int]], tree: Tree) -> Tree:
    lows = [keys << np.uint64(depth) if depth < 64 else keys for keys, depth in inside]
    highs = [low | np.uint64(2**depth - 1) for low, (_, depth) in zip(lows, inside, strict=True)]
    low, high = np.concatenate(lows), np.concatenate(highs)
    order = np.argsort(low)
    return tree_of_runs((low[order], high[order]), tree.cube, tree.bits)
