"""The layout of a tree file, version 2: a head, a table of chunks, two arrays; all parts 64-byte aligned.

| bytes | what |
|---|---|
| 64 | the mark `2KTREE`, version (uint16); kind, dimension, bits, entries a chunk (uint32 each); entries of
|    | an array, length of the file, root (uint64 each); zeros |
| 8 (dimension + 1) | origin and size (float64) |
| 64 a chunk | the SHA-256 of the chunk in both arrays, and its summary (4 uint64; see `bricks`) |
| 64 | the SHA-256 of all before, and zeros |
| | the first array, then the second |

Numbers are little-endian. Zeros fill each part up to a multiple of 64 bytes. A chunk is 4096 entries of both
arrays. Opening a file reads up to the first array and checks all of that; each chunk is checked when it is
first read. So a file is read in parts, no part of it unchecked, and the arrays can be mapped into memory.
"""

import hashlib
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Shaped, UInt64

from trees.cube import Cube
from trees.errors import DamagedFile, TreeError

MARK, VERSION, CHUNK, ALIGNMENT, DIGEST = b"2KTREE", 2, 4096, 64, 32
HEAD = struct.Struct("<6sHIIIIQQQ16x")
# Each kind of body: its number in the file, and the type of both its arrays.
KINDS = {"bricks": (1, "<u8"), "shared": (2, "<u4")}


@dataclass(frozen=True)
class Head:
    """What a file says before its arrays: of what kind they are, and how long each is.

    The root belongs to the kind: 0 for bricks.
    """

    kind: str
    cube: Cube
    bits: int
    count: int
    root: int = 0

    @property
    def chunks(self) -> int:
        return -(-self.count // CHUNK)

    @property
    def table(self) -> int:
        """Where the table of chunks begins."""
        return aligned(HEAD.size) + aligned(8 * (self.cube.dimension + 1))

    @property
    def arrays(self) -> tuple[int, int]:
        """Where the two arrays begin."""
        first = self.table + ALIGNMENT * (self.chunks + 1)
        return first, first + aligned(self.count * self.dtype.itemsize)

    @property
    def length(self) -> int:
        """The bytes of the whole file."""
        return 2 * self.arrays[1] - self.arrays[0]

    @property
    def dtype(self) -> np.dtype:
        return np.dtype(KINDS[self.kind][1])

    def pack(self) -> bytes:
        """The bytes before the table."""
        kind = KINDS[self.kind][0]
        numbers = (kind, self.cube.dimension, self.bits, CHUNK, self.count, self.length, self.root)
        frame = struct.pack(f"<{self.cube.dimension + 1}d", *self.cube.origin, self.cube.size)
        return padded(HEAD.pack(MARK, VERSION, *numbers)) + padded(frame)


@dataclass(frozen=True)
class Stored:
    """An opened file: its head and its table, already checked, and how to read the rest."""

    head: Head
    digests: list[bytes]
    summaries: UInt64[np.ndarray, "chunks 4"]
    read: Callable[[int, int], bytes]

    def chunk(self, number: int) -> tuple[Shaped[np.ndarray, " entries"], Shaped[np.ndarray, " entries"]]:
        """The entries of a chunk in both arrays, once their checksum is found right."""
        begin, width = number * CHUNK, self.head.dtype.itemsize
        count = min(CHUNK, self.head.count - begin)
        parts = [self.read(offset + begin * width, count * width) for offset in self.head.arrays]
        if checksum(*parts) != self.digests[number]:
            raise DamagedFile(f"chunk {number} of {self.head.chunks}: the checksum does not agree")
        first, second = (np.frombuffer(part, self.head.dtype) for part in parts)
        return first, second


def parts(
    head: Head,
    first: Shaped[np.ndarray, " entries"],
    second: Shaped[np.ndarray, " entries"],
    summaries: UInt64[np.ndarray, "chunks 4"],
) -> Iterator[bytes]:
    """The bytes of a file, in order."""
    table = head.pack()
    for number, summary in enumerate(summaries.astype("<u8")):
        within = slice(number * CHUNK, (number + 1) * CHUNK)
        digest = checksum(*(array[within].astype(head.dtype).tobytes() for array in (first, second)))
        table += digest + summary.tobytes()
    yield table
    yield padded(checksum(table))
    for array in (first, second):
        for begin in range(0, head.count, CHUNK):
            yield padded(array[begin : begin + CHUNK].astype(head.dtype).tobytes())


def opened(read: Callable[[int, int], bytes], length: int) -> Stored:
    """The file of this length whose bytes `read(offset, count)` gives.

    Nothing is believed before it is compared with the length of the file. Raises `DamagedFile`.
    """
    head = _head(read, length)
    size = head.arrays[0]
    data = read(0, size)
    end = size - ALIGNMENT
    if padded(checksum(data[:end])) != data[end:]:
        raise DamagedFile("the checksum of the head does not agree: the file was changed or cut")
    if head.pack() != data[: head.table]:
        raise DamagedFile("the head holds what no tree has")
    for offset in head.arrays:
        end = offset + head.count * head.dtype.itemsize
        if any(read(end, -end % ALIGNMENT)):
            raise DamagedFile(f"bytes other than 0 after the array that ends at {end}")
    rows = np.frombuffer(data, np.uint8, ALIGNMENT * head.chunks, head.table).reshape(-1, ALIGNMENT)
    digests = [row.tobytes() for row in rows[:, :DIGEST]]
    summaries = np.ascontiguousarray(rows[:, DIGEST:]).view("<u8").astype(np.uint64)
    return Stored(head, digests, summaries, read)


def _head(read: Callable[[int, int], bytes], length: int) -> Head:
    if length < HEAD.size or (data := read(0, HEAD.size))[: len(MARK)] != MARK:
        raise DamagedFile(f"{length} bytes that do not begin as a tree does, with {MARK.decode()}")
    _, version, number, dimension, bits, chunk, count, stated, root = HEAD.unpack(data)
    kinds = {code: name for name, (code, _) in KINDS.items()}
    if version != VERSION or chunk != CHUNK or number not in kinds:
        raise DamagedFile(
            f"a tree file of version {version}, kind {number}, {chunk} entries a chunk: "
            f"version {VERSION}, kinds {', '.join(map(str, kinds))} and {CHUNK} are read here"
        )
    if not 1 <= dimension <= 64 or (count < 1 and kinds[number] == "bricks"):
        raise DamagedFile(f"a tree of dimension {dimension} and {count} entries")
    plain = Head(kinds[number], Cube((0.0,) * dimension, 1.0), bits, count, root)
    if not plain.length == stated == length:
        raise DamagedFile(
            f"{length} bytes; the head says {stated}, and its {count} entries need {plain.length}"
        )
    try:
        frame = read(aligned(HEAD.size), 8 * (dimension + 1))
        *origin, size = struct.unpack(f"<{dimension + 1}d", frame)
        return Head(plain.kind, Cube(tuple(origin), size), bits, count, root)
    except TreeError as error:
        raise DamagedFile(f"no tree has this head: {error}") from error


def checksum(*parts: bytes) -> bytes:
    """The SHA-256 of these bytes in a row."""
    found = hashlib.sha256()
    for part in parts:
        found.update(part)
    return found.digest()


def aligned(size: int) -> int:
    """The next multiple of 64.

    >>> aligned(64), aligned(65)
    (64, 128)
    """
    return -(-size // ALIGNMENT) * ALIGNMENT


def padded(data: bytes) -> bytes:
    return data + bytes(-len(data) % ALIGNMENT)
