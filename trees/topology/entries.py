"""The entries of a tree that are not white."""

import numpy as np
from jaxtyping import UInt64

from trees.tree import Tree


def black_entries(
    tree: Tree,
) -> tuple[UInt64[np.ndarray, " n"], UInt64[np.ndarray, " n"], UInt64[np.ndarray, " n"]]:
    """First bricks, bricks after the last, and words of the runs of equal words that hold black cells.

    >>> from trees import from_points
    >>> [array.tolist() for array in black_entries(from_points([[64]], bits=9))]
    [[1], [2], [1]]
    """
    ends = np.append(tree.starts[1:], np.uint64(tree.bricks))
    black = tree.words != 0
    return tree.starts[black], ends[black], tree.words[black]
