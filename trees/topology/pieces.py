"""A tree as pieces: one word, or a black block of aligned words, the white ones left out."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import UInt8, UInt64

from trees.errors import TooManyPieces
from trees.runs import MAX_RUNS
from trees.topology.layout import Layout, layout
from trees.tree import Tree


@dataclass(frozen=True)
class Pieces:
    """Piece i holds the `2^levels[i]` bricks from brick `starts[i]`; its level is 0 unless it is all black.

    `top` is the level of the root and `low` counts the levels within a brick.
    """

    starts: UInt64[np.ndarray, " pieces"]
    words: UInt64[np.ndarray, " pieces"]
    levels: UInt8[np.ndarray, " pieces"]
    top: int
    low: int
    layout: Layout

    def __len__(self) -> int:
        return len(self.starts)


def pieces(tree: Tree) -> Pieces:
    """The pieces of a tree, in Morton order.

    Raises `TooManyPieces` above 2^28.

    >>> from trees import empty, unit_cube
    >>> pieces(~empty(unit_cube(3), bits=9)).levels.tolist()
    [21]
    """
    from trees.topology import piece_kernels

    lay = layout(tree)
    ends = np.append(tree.starts[1:], np.uint64(tree.bricks))
    count = piece_kernels.count_pieces(tree.starts, ends, tree.words, lay.full)
    if count > MAX_RUNS:
        raise TooManyPieces(int(count), MAX_RUNS)
    found = piece_kernels.cut(tree.starts, ends, tree.words, lay.full, int(count))
    return Pieces(*found, max(tree.depth - 6, 0), min(tree.depth, 6), lay)
