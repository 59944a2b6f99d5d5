"""The leaves of the trees: the largest black cubes, or boxes of the binary tree."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int, UInt64

from trees.errors import TooManyPieces, TreeError
from trees.morton import cells_of_keys, check_widths
from trees.node_counts import black_blocks
from trees.runs import MAX_RUNS, black_runs
from trees.shared import Shared
from trees.tree import Tree


@dataclass(frozen=True)
class Leaves:
    """Leaves in order: the level of each (0 is the root), first Morton key, and corners in mm."""

    levels: Int[np.ndarray, " leaves"]
    keys: UInt64[np.ndarray, " leaves"]
    lows: Float[np.ndarray, "leaves dim"]
    highs: Float[np.ndarray, "leaves dim"]

    def __len__(self) -> int:
        return len(self.levels)


def leaves(tree: Tree, binary: bool = False, order: str = "morton") -> Leaves:
    """The black leaves of the 2^k-tree, or with `binary` those of the binary tree that emulates it.

    The leaves of a 2^k-tree are cubes of edge `size / 2^level`; those of the binary tree are halved on one
    axis after the other, so a level is one halving. `leaves(~tree)` are the white ones.

    The order is "morton", or "hilbert": along the curve of `trees.hilbert`, on which each cube is an
    interval. Boxes of the binary tree are not, so these have Morton order alone.

    Raises `TooManyPieces` above 2^28 leaves, `KeyTooWide` above 64 levels, `TreeError` for another order.

    >>> from trees import from_points
    >>> tree = from_points([[1, 1], [2, 0], [3, 0], [2, 1], [3, 1]], bits=2)
    >>> leaves(tree).levels.tolist(), leaves(tree).lows.tolist()
    ([2, 1], [[0.25, 0.25], [0.5, 0.0]])
    """
    if order not in ("morton", "hilbert") or (binary and order == "hilbert"):
        raise TreeError(f"order {order!r}: 'morton' is needed, or, for cubes, 'hilbert'")
    step = 1 if binary else tree.dimension
    first, last = leaf_runs(tree, step)
    if order == "hilbert":
        from trees.hilbert import hilbert_of_morton

        along = np.argsort(hilbert_of_morton(first, tree.dimension, tree.bits))
        first, last = first[along], last[along]
    depths = np.bitwise_count(last - first).astype(np.int64)
    levels = (tree.depth - depths) // step
    cells = cells_of_keys(first, tree.dimension, tree.bits).astype(np.float64)
    ends = cells_of_keys(last, tree.dimension, tree.bits).astype(np.float64) + 1
    origin = np.array(tree.origin)
    return Leaves(levels, first, origin + cells * tree.cell_size, origin + ends * tree.cell_size)


def leaf_runs(tree: Tree, step: int) -> tuple[UInt64[np.ndarray, " leaves"], UInt64[np.ndarray, " leaves"]]:
    """First and last keys of the largest black blocks of `2^(step n)` keys, in Morton order."""
    from trees import kernels

    if isinstance(tree.form, Shared):
        check_widths(tree.dimension, tree.bits)
        return black_blocks(tree.form, step, MAX_RUNS)
    lows, highs = black_runs(tree)
    total = kernels.count_blocks(lows, highs, step, tree.depth)
    if total > MAX_RUNS:
        raise TooManyPieces(total, MAX_RUNS)
    return kernels.blocks(lows, highs, step, tree.depth, total)
