"""OpenVDB files, format 224: one grid of floats in the usual tree (root, 32^3, 16^3, leaves of 8^3).

The layout of the bytes is that of OpenVDB's own io and tree code; no library of it is needed here.
"""

import struct
import zlib
from collections.abc import Iterator, Mapping
from typing import BinaryIO

import numpy as np
from jaxtyping import Bool, Float, Float32, Int

_VERSION = (224, 10, 0)  # of the file format, and the library's that is named as its writer
_COMPRESSION = 1 | 2  # zip, and values outside the mask left out
_LEAF, _LOWER, _UPPER = 8, 16, 32  # children, or values, along a side
_BLOCK = _LEAF * _LOWER
_ROOT = _BLOCK * _UPPER
_NO_ID = b"00000000-0000-0000-0000-000000000000"


def write_grid(
    file: BinaryIO,
    values: Float[np.ndarray, "x y z"],
    origin: Float[np.ndarray, "3"],
    pitch: float,
    recipe: Mapping[str, str],
    name: str,
) -> None:
    """Write a fog volume. Voxels that hold 0 are left out: 0 is the background, the others are active.

    OpenVDB's samples lie at whole indices, so index (0, 0, 0) is placed at the centre of the first cell.
    """
    sparse = values.astype(np.float32)
    file.write(struct.pack("<qIIIB", 0x56444220, *_VERSION, 1) + _NO_ID)
    file.write(_metadata({}))
    file.write(struct.pack("<I", 1) + _string(name) + _string("Tree_float_5_4_3") + _string(""))
    place = file.tell()
    file.write(bytes(24))
    start = file.tell()
    file.write(struct.pack("<I", _COMPRESSION))
    facts = {"class": "fog volume", "name": name, "units": "mm"}
    file.write(_metadata(facts | {f"bcifs:{key}": value for key, value in recipe.items()}))
    file.write(_transform(origin + pitch / 2, pitch))
    file.write(struct.pack("<If", 1, 0.0))  # one buffer; the background
    roots = list(_filled(sparse, _ROOT))
    file.write(struct.pack("<II", 0, len(roots)))
    for corner in roots:
        _write_topology(file, sparse, corner)
    buffers = file.tell()
    for leaf in _leaves(sparse, roots):
        _write_leaf(file, leaf)
    end = file.tell()
    file.seek(place)
    file.write(struct.pack("<qqq", start, buffers, end))
    file.seek(end)


def _write_topology(
    file: BinaryIO, values: Float32[np.ndarray, "x y z"], corner: Int[np.ndarray, "3"]
) -> None:
    file.write(struct.pack("<iii", *corner.tolist()))
    upper = _part(values, corner, _ROOT)
    blocks = list(_filled(upper, _BLOCK))
    file.write(_inner(blocks, _BLOCK, _UPPER))
    for block in blocks:
        inside = _part(upper, block, _BLOCK)
        leaves = list(_filled(inside, _LEAF))
        file.write(_inner(leaves, _LEAF, _LOWER))
        for leaf in leaves:
            file.write(_bits(_whole_leaf(inside, leaf).ravel() != 0))


def _leaves(
    values: Float32[np.ndarray, "x y z"], roots: list[Int[np.ndarray, "3"]]
) -> Iterator[Float32[np.ndarray, "8 8 8"]]:
    for corner in roots:
        upper = _part(values, corner, _ROOT)
        for block in _filled(upper, _BLOCK):
            inside = _part(upper, block, _BLOCK)
            for leaf in _filled(inside, _LEAF):
                yield _whole_leaf(inside, leaf)


def _write_leaf(file: BinaryIO, leaf: Float32[np.ndarray, "8 8 8"]) -> None:
    active = leaf.ravel() != 0
    raw = leaf.ravel()[active].astype("<f4").tobytes()
    packed = zlib.compress(raw, 6)
    file.write(_bits(active) + b"\0")
    if len(packed) < len(raw):
        file.write(struct.pack("<q", len(packed)) + packed)
    else:
        file.write(struct.pack("<q", -len(raw)) + raw)


def _inner(children: list[Int[np.ndarray, "3"]], step: int, side: int) -> bytes:
    """The masks of an inner node, children and values, and its own values: none."""
    mask = np.zeros((side, side, side), dtype=np.bool_)
    mask[tuple(np.array(children).T // step)] = True
    return _bits(mask.ravel()) + bytes(side**3 // 8) + b"\0" + struct.pack("<q", 0)


def _filled(values: Float32[np.ndarray, "x y z"], step: int) -> Iterator[Int[np.ndarray, "3"]]:
    """The low corners of the cubes of `step` voxels that hold something, in the order of the tree."""
    for cube in np.ndindex(*(-(-size // step) for size in values.shape)):
        corner = np.array(cube, dtype=np.int64) * step
        if _part(values, corner, step).any():
            yield corner


def _part(
    values: Float32[np.ndarray, "_x _y _z"], corner: Int[np.ndarray, "3"], side: int
) -> Float32[np.ndarray, "_i _j _k"]:
    i, j, k = corner.tolist()
    return values[i : i + side, j : j + side, k : k + side]


def _whole_leaf(
    values: Float32[np.ndarray, "x y z"], corner: Int[np.ndarray, "3"]
) -> Float32[np.ndarray, "8 8 8"]:
    found = _part(values, corner, _LEAF)
    return np.pad(found, [(0, _LEAF - size) for size in found.shape])


def _bits(mask: Bool[np.ndarray, "n"]) -> bytes:
    return np.packbits(mask, bitorder="little").tobytes()


def _string(text: str) -> bytes:
    raw = text.encode("utf-8")
    return struct.pack("<I", len(raw)) + raw


def _metadata(texts: Mapping[str, str]) -> bytes:
    entries = [_string(key) + _string("string") + _string(value) for key, value in texts.items()]
    return struct.pack("<I", len(entries)) + b"".join(entries)


def _transform(place: Float[np.ndarray, "3"], pitch: float) -> bytes:
    """A uniform scale and a translation, with the inverses that the format keeps beside them."""
    same = [pitch] * 6 + [1 / pitch] * 3 + [1 / pitch**2] * 3 + [0.5 / pitch] * 3
    return _string("UniformScaleTranslateMap") + struct.pack("<18d", *place.tolist(), *same)
