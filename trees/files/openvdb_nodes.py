"""OpenVDB files, format 224: one sparse grid of floats, from its leaves of 8^3 voxels and its tiles.

The tree of OpenVDB has a root, nodes of 32^3 and of 16^3 children, and leaves of 8^3 voxels. A child that is
uniform is a tile, a value without a node: a cube of 8, 128 or 4096 voxels. Here the background is 0 and a
tile is 1. The layout of the bytes is that of OpenVDB's own io and tree code; no library of it is needed.
"""

import hashlib
import struct
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import BinaryIO

import numpy as np
from jaxtyping import Bool, Float32, Int64

MAGIC, VERSION = 0x56444220, (224, 10, 0)  # of the file format, and the library's that is named as its writer
COMPRESSION = 1 | 2  # zip, and values outside the mask left out
LEAF, LOWER, UPPER = 3, 4, 5  # children along a side, as powers of 2
NO_ID = b"00000000-0000-0000-0000-000000000000"
HEAD = struct.pack("<qIIIB", MAGIC, *VERSION, 1) + NO_ID


@dataclass(frozen=True)
class Nodes:
    """Low corners of leaves and of tiles of 8, 128 and 4096 voxels a side, multiples of these sides, from 0.

    The masks say which voxels of a leaf are active, [x, y, z]; `values` are those of all active voxels, leaf
    after leaf in that order, None where all are 1. A cube stands in one array only.
    """

    leaves: Int64[np.ndarray, "leaves 3"]
    masks: Bool[np.ndarray, "leaves 8 8 8"]
    tiles_8: Int64[np.ndarray, "_eights 3"]
    tiles_128: Int64[np.ndarray, "_blocks 3"]
    tiles_4096: Int64[np.ndarray, "_roots 3"]
    values: Float32[np.ndarray, " _active"] | None = None


def write_nodes(
    file: BinaryIO, nodes: Nodes, place: tuple[float, ...], pitch: float, facts: Mapping[str, str], name: str
) -> None:
    """Write the grid; index (0, 0, 0), the centre of the first voxel, lies at `place`, in mm.

    `facts` are metadata of the grid. That of the file is the SHA-256 of all after it: see `SEAL`.
    """
    file.write(SEAL + NO_DIGEST)
    file.write(struct.pack("<I", 1) + string(name) + string("Tree_float_5_4_3") + string(""))
    offsets = file.tell()
    file.write(bytes(24))
    start = file.tell()
    file.write(struct.pack("<I", COMPRESSION) + metadata(facts))
    same = [pitch] * 6 + [1 / pitch] * 3 + [1 / pitch**2] * 3 + [0.5 / pitch] * 3
    file.write(string("UniformScaleTranslateMap") + struct.pack("<18d", *place, *same))
    file.write(struct.pack("<If", 1, 0.0))  # one buffer; the background
    keys = order_keys(nodes.leaves)
    order = np.argsort(keys)
    _write_topology(file, nodes, keys[order], order)
    buffers = file.tell()
    _write_buffers(file, nodes, order)
    end = file.tell()
    file.seek(offsets)
    file.write(struct.pack("<qqq", start, buffers, end))
    file.seek(len(SEAL + NO_DIGEST))
    digest = hashlib.file_digest(file, "sha256").hexdigest()  # pyright: ignore
    file.seek(len(SEAL))
    file.write(digest.encode())
    file.seek(end)


def order_keys(corners: Int64[np.ndarray, "nodes 3"]) -> Int64[np.ndarray, " nodes"]:
    """Numbers of cubes of 8 voxels in the order of the tree: 27 bits of the root's child, 15 and 12 below."""
    keys = np.zeros(len(corners), dtype=np.int64)
    for shift, bits in ((LEAF + LOWER + UPPER, 9), (LEAF + LOWER, UPPER), (LEAF, LOWER)):
        for axis in range(3):
            keys = (keys << bits) | ((corners[:, axis] >> shift) & (2**bits - 1))
    return keys


def _write_topology(
    file: BinaryIO, nodes: Nodes, leaves: Int64[np.ndarray, " leaves"], order: Int64[np.ndarray, " leaves"]
) -> None:
    eights, blocks = np.sort(order_keys(nodes.tiles_8)), np.sort(order_keys(nodes.tiles_128) >> 12)
    lowers = np.unique(np.concatenate([leaves, eights]) >> 12)
    uppers = np.unique(np.concatenate([lowers, blocks]) >> 15)
    file.write(struct.pack("<II", len(nodes.tiles_4096), len(uppers)))
    for corner in nodes.tiles_4096.tolist():
        file.write(struct.pack("<iiifB", *corner, 1.0, 1))
    masks = nodes.masks.reshape(-1, 512)
    for upper in uppers.tolist():
        corner = [(upper >> shift & 511) << 12 for shift in (18, 9, 0)]
        file.write(struct.pack("<iii", *corner))
        inside = _within(lowers, upper, 15)
        file.write(_inner(lowers[inside], blocks[_within(blocks, upper, 15)], UPPER))
        for lower in lowers[inside].tolist():
            children = _within(leaves, lower, 12)
            file.write(_inner(leaves[children], eights[_within(eights, lower, 12)], LOWER))
            file.write(np.packbits(masks[order[children]], axis=1, bitorder="little").tobytes())


def _within(keys: Int64[np.ndarray, " keys"], parent: int, bits: int) -> slice:
    begin, end = np.searchsorted(keys, [parent << bits, (parent + 1) << bits]).tolist()
    return slice(begin, end)


def _inner(children: Int64[np.ndarray, " children"], tiles: Int64[np.ndarray, " tiles"], side: int) -> bytes:
    """The masks of an inner node, children and values, and its tiles."""
    parts = []
    for keys in (children, tiles):
        mask = np.zeros(2 ** (3 * side), dtype=bool)
        mask[keys & (2 ** (3 * side) - 1)] = True
        parts.append(np.packbits(mask, bitorder="little").tobytes())
    return b"".join(parts) + b"\0" + packed(np.ones(len(tiles), dtype="<f4").tobytes())


def _write_buffers(file: BinaryIO, nodes: Nodes, order: Int64[np.ndarray, " leaves"]) -> None:
    flat = nodes.masks.reshape(-1, 512)
    counts = flat.sum(axis=1)
    ends = np.cumsum(counts)
    ones: dict[int, bytes] = {}
    for begin in range(0, len(order), 4096):
        chosen = order[begin : begin + 4096]
        masks = np.packbits(flat[chosen], axis=1, bitorder="little")
        for mask, count, end in zip(masks, counts[chosen].tolist(), ends[chosen].tolist(), strict=True):
            if nodes.values is not None:
                content = packed(nodes.values[end - count : end].astype("<f4").tobytes())
            else:
                content = ones.get(count) or ones.setdefault(count, packed(np.ones(count, "<f4").tobytes()))
            file.write(mask.tobytes() + b"\0" + content)


def packed(raw: bytes) -> bytes:
    """Bytes with their length before them, compressed where that is shorter."""
    small = zlib.compress(raw, 6)
    if len(small) < len(raw):
        return struct.pack("<q", len(small)) + small
    return struct.pack("<q", -len(raw)) + raw


def string(text: str) -> bytes:
    raw = text.encode("utf-8")
    return struct.pack("<I", len(raw)) + raw


def metadata(texts: Mapping[str, str]) -> bytes:
    entries = [string(key) + string("string") + string(value) for key, value in texts.items()]
    return struct.pack("<I", len(entries)) + b"".join(entries)


NO_DIGEST = b"0" * 64
# A file begins with this, and the SHA-256 of all after that, in hexadecimal digits.
SEAL = HEAD + metadata({"SHA-256": NO_DIGEST.decode()})[: -len(NO_DIGEST)]
