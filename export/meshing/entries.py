"""The entries of a tree of space as the walk over its boundary reads them."""

import numpy as np
from jaxtyping import Int, UInt64

from trees.bricks import Flat
from trees.errors import TreeError
from trees.tree import Tree

Keys = UInt64[np.ndarray, " _keys"]
Index = tuple[Int[np.ndarray, " _blocks"], UInt64[np.ndarray, "_groups 3"], Int[np.ndarray, " _slots"]]

MAX_TRIANGLES = 2**30  # of which 32 bits number all vertices, with one more for each square


def check_space(tree: Tree) -> None:
    """Raises `TreeError` where the tree is not of dimension 3."""
    if tree.dimension != 3:
        raise TreeError(f"a tree of dimension {tree.dimension}: a boundary surface needs one of dimension 3")


def entries(tree: Tree) -> tuple[Keys, Keys, int]:
    """Starts and words of the bricks, and the bits of bricks an axis, at least 2.

    Where the tree has a word for every brick there are no starts. What a small cube lacks is white.
    """
    if tree.bits < 4:
        starts = np.append(tree.starts, np.uint64(tree.bricks))
        return starts, np.append(tree.words, np.uint64(0)), 2
    if isinstance(tree.form, Flat):
        return np.zeros(0, dtype=np.uint64), tree.form.words, tree.bits - 2
    return tree.starts, tree.words, tree.bits - 2


def contact_blocks(tree: Tree) -> Keys:
    """The keys of the blocks of corners in which two sheets of the boundary touch."""
    from export.meshing.blocks import collected

    return collected(*entries(tree), 1)[1]


def indexed(rows: UInt64[np.ndarray, "blocks 6"]) -> Index:
    """The first vertex of each block, the groups of blocks and their slots: see `numbering.index`."""
    from export.meshing.numbering import groups_of, index

    groups = np.empty((groups_of(rows), 3), dtype=np.uint64)
    slots = np.full(1 << (2 * len(groups)).bit_length(), -1, dtype=np.int32)
    bases = np.empty(len(rows), dtype=np.int32)
    index(rows, bases, groups, slots)
    return bases, groups, slots


def brick_words(tree: Tree, bricks: Keys) -> UInt64[np.ndarray, " _keys"]:
    """The words of these bricks, 0 for keys outside the cube."""
    starts, words, top = entries(tree)
    inside = bricks < np.uint64(8**top)
    entry = np.where(inside, bricks, np.uint64(0))
    if len(starts):
        entry = np.searchsorted(starts, entry, side="right") - 1
    return np.where(inside, words[entry], np.uint64(0))
