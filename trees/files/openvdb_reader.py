"""The active voxels and tiles of an OpenVDB file, formats 222 to 224: masks only, no values.

Every length is compared with the file before anything is read, so a hostile file costs no more than its size.
"""

import struct
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool, Int64, UInt8

from trees.errors import DamagedFile, TreeError
from trees.files.openvdb_nodes import LEAF, LOWER, MAGIC, UPPER

WIDTHS = {"float": 4, "double": 8, "int32": 4, "int64": 8, "bool": 1}
# How many doubles each kind of transform has, and where among them translation and scale are.
MAPS = {
    "UniformScaleMap": (15, None, 0),
    "ScaleMap": (15, None, 0),
    "UniformScaleTranslateMap": (18, 0, 3),
    "ScaleTranslateMap": (18, 0, 3),
    "TranslationMap": (3, 0, None),
}


@dataclass(frozen=True)
class Grid:
    """Leaves with their masks [x, y, z], and tiles, by side, as low corners in voxels; the rest is white."""

    facts: dict[str, str]
    place: tuple[float, ...]
    pitch: float
    leaves: Int64[np.ndarray, "leaves 3"]
    masks: Bool[np.ndarray, "leaves 512"]
    tiles: dict[int, Int64[np.ndarray, "_tiles 3"]]


class Bytes:
    """The bytes of a file, in order."""

    def __init__(self, data: bytes):
        self.data, self.at = data, 0

    def raw(self, count: int) -> bytes:
        if not 0 <= count <= len(self.data) - self.at:
            raise DamagedFile(f"{count} bytes are needed at {self.at} of {len(self.data)}")
        self.at += count
        return self.data[self.at - count : self.at]

    def take(self, form: str) -> Any:
        found = struct.unpack("<" + form, self.raw(struct.calcsize("<" + form)))
        return found[0] if len(found) == 1 else found

    def text(self) -> str:
        return self.raw(self.take("I")).decode("utf-8", "replace")

    def facts(self) -> dict[str, str]:
        """Metadata: the texts among them."""
        found = {}
        for _ in range(self.take("I")):
            key, kind, value = self.text(), self.text(), self.text()
            if kind == "string":
                found[key] = value
        return found

    def mask(self, side: int) -> Bool[np.ndarray, " _places"]:
        octets = np.frombuffer(self.raw(2 ** (3 * side - 3)), np.uint8)
        return np.unpackbits(octets, bitorder="little").astype(bool)

    def skip_values(self, active: int, every: int, width: int, stored: int, compression: int) -> None:
        """Pass by the values of an inner node: see `io::readCompressedValues` of OpenVDB.

        A value has `width` bytes, but `stored` in the array, for that may have half floats: then an empty
        array has no length before it.
        """
        kind = self.take("B")
        if kind > 6:
            raise DamagedFile(f"a node whose values are of kind {kind}, at {self.at}: there are 0 to 6")
        self.raw(width * {2: 1, 4: 1, 5: 2}.get(kind, 0))
        if kind in (3, 4, 5):
            self.raw(every // 8)
        count = active if compression & 2 and kind != 6 else every
        if count == 0 and stored < width:
            return
        self.raw(abs(self.take("q")) if compression & 5 else count * stored)


def read_grid(data: bytes, name: str | None) -> Grid:
    """The grid of this name, or the first. Raises `DamagedFile`, and `TreeError` for grids of other kinds."""
    file = Bytes(data)
    if len(data) < 8 or file.take("q") != MAGIC:
        raise DamagedFile("it does not begin as an OpenVDB file does")
    version = file.take("IIIB")
    if not 222 <= version[0] <= 224 or version[3] != 1:
        raise DamagedFile(
            f"OpenVDB format {version[0]}, offsets {version[3]}: 222 to 224 with offsets are read"
        )
    file.raw(36)
    file.facts()
    kind, start, end = _find(file, name)
    plain = kind.removesuffix("_HalfFloat")
    width = WIDTHS.get(plain.removeprefix("Tree_").removesuffix("_5_4_3"), 0)
    if not width or not (plain.startswith("Tree_") and plain.endswith("_5_4_3")):
        raise TreeError(f"a grid {kind}: Tree_*_5_4_3 of {', '.join(WIDTHS)} are read")
    if not file.at <= start <= end <= len(data):
        raise DamagedFile(f"a grid from {start} to {end} in {len(data)} bytes")
    return _grid(Bytes(data[:end]), start, width, width if kind == plain else 2)


def _find(file: Bytes, name: str | None) -> tuple[str, int, int]:
    """Kind, begin and end of the grid of this name."""
    names = []
    for _ in range(file.take("I")):
        names.append(file.text().split("\x1e")[0])
        kind, parent, (start, _, end) = file.text(), file.text(), file.take("qqq")
        if name is None or names[-1] == name:
            if parent:
                raise TreeError(f"grid {names[-1]!r} is an instance of {parent!r}: ask for that one")
            return kind, start, end
        if not file.at <= end <= len(file.data):
            raise DamagedFile(f"grid {names[-1]!r} ends at {end} of {len(file.data)}")
        file.at = end
    raise TreeError(f"no grid {name!r}: there are {', '.join(map(repr, names)) or 'none'}")


def _grid(file: Bytes, start: int, width: int, stored: int) -> Grid:
    file.at = start
    compression = file.take("I")
    facts = file.facts()
    place, pitch = _transform(file)
    if file.take("I") != 1:
        raise DamagedFile("a grid of several buffers")
    file.raw(width)
    tiles: dict[int, list[Int64[np.ndarray, "_tiles 3"]]] = {8: [], 128: [], 4096: []}
    count, children = file.take("II")
    for _ in range(count):
        corner = np.array([file.take("iii")], dtype=np.int64)
        file.raw(width)
        if (corner & 4095).any():
            raise DamagedFile(f"a tile of 4096 voxels at {corner.tolist()}")
        if file.take("B"):
            tiles[4096].append(corner)
    leaves: list[Int64[np.ndarray, "_leaves 3"]] = []
    masks: list[UInt8[np.ndarray, "_leaves 64"]] = []

    def inner(corner: Int64[np.ndarray, "3"], side: int, step: int) -> Int64[np.ndarray, "_children 3"]:
        child, value = file.mask(side), file.mask(side)
        if (child & value).any():
            raise DamagedFile(f"a node with a child and a tile in one place, before {file.at}")
        file.skip_values(int(value.sum()), len(value), width, stored, compression)
        tiles[2**step].append(_corners(corner, value, side, step))
        return _corners(corner, child, side, step)

    for _ in range(children):
        root = np.array(file.take("iii"), dtype=np.int64)
        if (root & 4095).any():
            raise DamagedFile(f"a node of 4096 voxels at {root.tolist()}")
        for block in inner(root, UPPER, LEAF + LOWER):
            found = inner(block, LOWER, LEAF)
            leaves.append(found)
            masks.append(np.frombuffer(file.raw(64 * len(found)), np.uint8).reshape(-1, 64))
    octets = np.concatenate([np.zeros((0, 64), np.uint8), *masks])
    none = np.zeros((0, 3), dtype=np.int64)
    return Grid(
        facts,
        place,
        pitch,
        np.concatenate([none, *leaves]),
        np.unpackbits(octets, axis=1, bitorder="little").astype(bool),
        {side: np.concatenate([none, *corners]) for side, corners in tiles.items()},
    )


def _corners(
    corner: Int64[np.ndarray, "3"], mask: Bool[np.ndarray, " places"], side: int, step: int
) -> Int64[np.ndarray, "_set 3"]:
    places = np.flatnonzero(mask)
    within = np.stack([places >> 2 * side, places >> side, places], axis=1) & (2**side - 1)
    return corner + (within << step)


def _transform(file: Bytes) -> tuple[tuple[float, ...], float]:
    """Where index (0, 0, 0) lies, and the pitch."""
    kind = file.text()
    if kind not in MAPS:
        raise TreeError(f"a grid placed by {kind}: {', '.join(MAPS)} are read")
    count, shift, scale = MAPS[kind]
    numbers = file.take(f"{count}d")
    place = (0.0,) * 3 if shift is None else numbers[shift : shift + 3]
    pitches = (1.0,) * 3 if scale is None else numbers[scale : scale + 3]
    if not np.isfinite([*place, *pitches]).all() or pitches[0] <= 0 or len(set(pitches)) > 1:
        raise TreeError(f"voxels of {pitches} at {place}: one positive, finite pitch is needed")
    return tuple(place), pitches[0]
