"""The entries of a tree of space as the walk over its boundary reads them."""

import numpy as np
from jaxtyping import UInt64

from trees.errors import TreeError
from trees.tree import Tree

Keys = UInt64[np.ndarray, " _keys"]


def check_space(tree: Tree) -> None:
    """Raises `TreeError` where the tree is not of dimension 3."""
    if tree.dimension != 3:
        raise TreeError(f"a tree of dimension {tree.dimension}: a boundary surface needs one of dimension 3")


def entries(tree: Tree) -> tuple[Keys, Keys, int]:
    """Starts and words of the bricks, and the bits of bricks an axis, at least 1.

    A cube of one brick or less is one of eight bricks, seven of them white.
    """
    if tree.bits > 2:
        return tree.starts, tree.words, tree.bits - 2
    return np.arange(2, dtype=np.uint64), np.append(tree.words, np.uint64(0)), 1


def contact_blocks(tree: Tree) -> Keys:
    """The keys of the blocks of corners in which two sheets of the boundary touch."""
    from export.meshing.blocks import collected

    return collected(*entries(tree), 1)[1]


def brick_words(tree: Tree, bricks: Keys) -> UInt64[np.ndarray, " _keys"]:
    """The words of these bricks, 0 for keys outside the cube."""
    starts, words, top = entries(tree)
    inside = bricks < np.uint64(8**top)
    entry = np.searchsorted(starts, np.where(inside, bricks, np.uint64(0)), side="right") - 1
    return np.where(inside, words[entry], np.uint64(0))
