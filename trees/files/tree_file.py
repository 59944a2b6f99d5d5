"""The own file of a tree: written whole or not at all, refused when damaged. See `layout` for its bytes."""

import os

from trees.errors import DamagedFile
from trees.files import bricks, layout, nodes
from trees.files.whole import written_whole
from trees.shared import Shared
from trees.tree import Tree

# How each kind of body is read.
READERS = {"bricks": bricks.tree_of, "shared": nodes.tree_of}


def to_bytes(tree: Tree) -> bytes:
    """The bytes of the file; equal trees of one form give equal bytes. A shared tree stays shared.

    >>> from trees import from_points
    >>> tree = from_points([[1, 0]], bits=1)
    >>> from_bytes(to_bytes(tree)) == tree
    True
    """
    return b"".join(_parts(tree))


def from_bytes(data: bytes) -> Tree:
    """The tree of these bytes. Raises `DamagedFile` where they are not those of a tree."""
    return _tree(layout.opened(lambda offset, count: data[offset : offset + count], len(data)))


def write_tree(tree: Tree, path: str | os.PathLike[str]) -> None:
    """Write the file; an older file of that name stays whole until the new one is."""
    with written_whole(path) as unfinished, open(unfinished, "wb") as file:
        for part in _parts(tree):
            file.write(part)


def read_tree(path: str | os.PathLike[str]) -> Tree:
    """Read a file of `write_tree`, all of it: `map_tree` reads parts.

    Raises `DamagedFile`, which names the path, where any byte is wrong.
    """

    def read(offset: int, count: int) -> bytes:
        file.seek(offset)
        return file.read(count)

    with open(path, "rb") as file:
        try:
            return _tree(layout.opened(read, os.fstat(file.fileno()).st_size))
        except DamagedFile as error:
            raise DamagedFile(f"{os.fspath(path)}: {error}") from error


def _parts(tree: Tree):
    if isinstance(tree.form, Shared):
        shared = tree.form
        return layout.parts(nodes.head_of(tree), shared.lows, shared.highs, nodes.summaries(tree))
    return layout.parts(bricks.head_of(tree), tree.starts, tree.words, bricks.summaries(tree))


def _tree(stored: layout.Stored) -> Tree:
    if stored.head.kind not in READERS:
        raise DamagedFile(f"a body of kind {stored.head.kind}: {', '.join(READERS)} can be read")
    return READERS[stored.head.kind](stored)
