"""The file of a tree: written whole or not at all, refused when damaged.

Little-endian: the mark `2KTREE`, the version (uint16), dimension and bits (uint32 each), the number of
entries (uint64), origin and size (float64), starts, words (uint64), and the SHA-256 of all before.
"""

import hashlib
import os
import struct
import tempfile
from pathlib import Path

import numpy as np

from trees.cube import Cube
from trees.errors import DamagedFile, TreeError
from trees.tree import Tree

MARK = b"2KTREE"
VERSION = 1
HEAD = struct.Struct("<6sHIIQ")
CHECKSUM = 32


def to_bytes(tree: Tree) -> bytes:
    """The bytes of the file; equal trees give equal bytes.

    >>> from trees import from_points
    >>> tree = from_points([[1, 0]], bits=1)
    >>> from_bytes(to_bytes(tree)) == tree
    True
    """
    head = HEAD.pack(MARK, VERSION, tree.dimension, tree.bits, len(tree.words))
    frame = struct.pack(f"<{tree.dimension + 1}d", *tree.origin, tree.size)
    body = head + frame + tree.starts.astype("<u8").tobytes() + tree.words.astype("<u8").tobytes()
    return body + hashlib.sha256(body).digest()


def from_bytes(data: bytes) -> Tree:
    """The tree of these bytes. Raises `DamagedFile` where they are not those of a tree."""
    if len(data) < HEAD.size + CHECKSUM or data[: len(MARK)] != MARK:
        raise DamagedFile(f"{len(data)} bytes that do not begin as a tree does, with {MARK.decode()}")
    _, version, dimension, bits, entries = HEAD.unpack_from(data)
    if version != VERSION:
        raise DamagedFile(f"a tree file of version {version}: version {VERSION} is read here")
    needed = HEAD.size + 8 * (dimension + 1) + 16 * entries + CHECKSUM
    if len(data) != needed:
        raise DamagedFile(f"{len(data)} bytes, and the header speaks of {needed}")
    if hashlib.sha256(data[:-CHECKSUM]).digest() != data[-CHECKSUM:]:
        raise DamagedFile("the checksum does not agree: the file was changed or cut")
    *origin, size = struct.unpack_from(f"<{dimension + 1}d", data, HEAD.size)
    offset = HEAD.size + 8 * (dimension + 1)
    starts, words = np.frombuffer(data, "<u8", 2 * entries, offset).reshape(2, entries)
    try:
        return Tree(Cube(tuple(origin), size), bits, starts, words)
    except TreeError as error:
        raise DamagedFile(f"no tree has these contents: {error}") from error


def write_tree(tree: Tree, path: str | os.PathLike[str]) -> None:
    """Write the file; an older file of that name stays whole until the new one is."""
    target = Path(path)
    handle, name = tempfile.mkstemp(prefix=f".{target.name}.", suffix=".part", dir=target.parent)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(to_bytes(tree))
        umask = os.umask(0)
        os.umask(umask)
        os.chmod(name, 0o666 & ~umask)
        os.replace(name, target)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise


def read_tree(path: str | os.PathLike[str]) -> Tree:
    """Read a file of `write_tree`. Raises `DamagedFile`, which names the path."""
    try:
        return from_bytes(Path(path).read_bytes())
    except DamagedFile as error:
        raise DamagedFile(f"{os.fspath(path)}: {error}") from error
