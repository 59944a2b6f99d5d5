"""Where black cells of a tree touch at an edge or a corner only: finding it and filling it up."""

import numpy as np
from jaxtyping import UInt64

from export.meshing.entries import brick_words, check_space, contact_blocks
from trees.tree import Tree, of_bricks

Keys = UInt64[np.ndarray, " _keys"]
OUTSIDE = np.uint64(2**64 - 1)


def has_contacts(tree: Tree) -> bool:
    """Whether black (or white) cells of space meet at an edge or a corner alone.

    >>> from trees import from_points
    >>> has_contacts(from_points([[0, 0, 0], [1, 1, 0]], bits=2))
    True
    """
    check_space(tree)
    return len(contact_blocks(tree)) > 0


def join_contacts(tree: Tree) -> Tree:
    """The tree with cells added until no two sheets of its boundary touch.

    Afterwards no two black cells, and no two white ones, meet at an edge or a corner alone. Corners are
    gone through in Morton order; at each in turn the fewest cells that help are added (of equally few, those
    on the low side), round after round, each around the bricks that the last one changed. Nothing is added
    out of the cube, and a set without contacts comes back as it is.

    Raises `TreeError` for a tree that is not of dimension 3.

    >>> from trees import from_points
    >>> join_contacts(from_points([[0, 0, 0], [1, 1, 0]], bits=2)).count
    3
    """
    check_space(tree)
    return join_at(tree, contact_blocks(tree))


def join_at(tree: Tree, blocks: Keys) -> Tree:
    """`join_contacts`, given the blocks that have contacts."""
    from export.meshing.contacts import CONTACT, REPAIR
    from export.meshing.joining_kernels import fill

    while len(blocks):
        near = beside(blocks, -1)
        bricks, places = np.unique(near, return_inverse=True)
        words = brick_words(tree, bricks)
        changed = fill(words, places.reshape(-1, 8), CONTACT, REPAIR)
        if not changed.any():
            break
        tree = tree | _tree_of_words(tree, bricks[changed], words[changed])
        blocks = np.unique(beside(bricks[changed], 1))
    return tree


def beside(blocks: Keys, step: int) -> UInt64[np.ndarray, "_keys 8"]:
    """A block and those one further, or one before, on x, y, z (bits 0, 1, 2 of the column).

    Before the first lie blocks that do not exist: their keys are above all others.
    """
    columns = [blocks]
    for o in range(1, 8):
        axis = o.bit_length() - 1
        columns.append(_moved(columns[o - (1 << axis)], axis, step))
    return np.stack(columns, axis=1)


def _moved(keys: Keys, axis: int, step: int) -> Keys:
    mask = np.uint64(0x4924924924924924 >> axis)
    if step > 0:
        return (((keys | ~mask) + np.uint64(1)) & mask) | (keys & ~mask)
    moved = (((keys & mask) - np.uint64(1)) & mask) | (keys & ~mask)
    return np.where((keys & mask == 0) | (keys == OUTSIDE), OUTSIDE, moved)


def _tree_of_words(tree: Tree, bricks: Keys, words: UInt64[np.ndarray, " _keys"]) -> Tree:
    """The tree of these bricks alone, in rising order."""
    starts = np.stack([bricks, bricks + np.uint64(1)], axis=1).ravel()
    both = np.stack([words, np.zeros_like(words)], axis=1).ravel()
    last = np.append(starts[:-1] != starts[1:], True) & (starts < np.uint64(tree.bricks))
    starts, both = np.append(np.uint64(0), starts[last]), np.append(np.uint64(0), both[last])
    if len(starts) > 1 and starts[1] == 0:
        starts, both = starts[1:], both[1:]
    new = np.append(True, both[1:] != both[:-1])
    return of_bricks(tree.cube, tree.bits, starts[new], both[new])
