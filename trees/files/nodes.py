"""The body of kind "shared": the low and the high children of the grey nodes; summaries are not used."""

import numpy as np
from jaxtyping import UInt64

from trees.errors import DamagedFile, TreeError
from trees.files.layout import CHUNK, Head, Stored
from trees.shared import Shared, check_depth, check_nodes
from trees.tree import Tree


def head_of(tree: Tree) -> Head:
    """The head of the file of a tree that is kept as shared nodes."""
    shared = tree.as_shared
    return Head("shared", tree.cube, tree.bits, len(shared.lows), shared.root)


def summaries(tree: Tree) -> UInt64[np.ndarray, "chunks 4"]:
    """One row of zeros a chunk."""
    return np.zeros((-(-len(tree.as_shared.lows) // CHUNK), 4), dtype=np.uint64)


def tree_of(stored: Stored) -> Tree:
    """The whole tree, each chunk and the form of the nodes checked."""
    head = stored.head
    if stored.summaries.any():
        raise DamagedFile("summaries other than 0 in a body of shared nodes")
    lows, highs = np.empty(head.count, np.uint32), np.empty(head.count, np.uint32)
    for number in range(head.chunks):
        within = slice(number * CHUNK, (number + 1) * CHUNK)
        lows[within], highs[within] = stored.chunk(number)
    try:
        check_depth(head.cube.dimension, head.bits)
        shared = Shared(head.cube.dimension * head.bits, head.root, lows, highs)
        check_nodes(shared)
    except TreeError as error:
        raise DamagedFile(f"no tree has these contents: {error}") from error
    return Tree(head.cube, head.bits, shared)
