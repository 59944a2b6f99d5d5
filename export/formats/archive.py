"""Zip archives (PKWARE's APPNOTE 6.3) written entry by entry, the same bytes for the same entries."""

import contextlib
import struct
import zlib
from collections.abc import Callable, Iterable, Iterator
from typing import BinaryIO, NamedTuple

from export.formats.deflate import deflated

Add = Callable[..., None]

DATE = 0x21  # the first of January 1980, the first date a zip file can bear
LIMIT = 0xFFFFFFFF
FLAGS = 0x800  # names are UTF-8
UNIX = 3 << 8
MODE = 0o100644 << 16


class _Entry(NamedTuple):
    name: bytes
    stored: bool
    large: bool
    place: int
    checksum: int
    packed: int
    size: int


@contextlib.contextmanager
def zip_archive(file: BinaryIO) -> Iterator[Add]:
    """A function `add(name, pieces, stored=False, large=False)`; the table of entries is written at the end.

    `file` is empty and can be sought. Pieces are deflated as they come, unless `stored`. An entry that
    may have 4 GiB or more is `large`; `OverflowError` where one that is not grows beyond that. Every
    entry bears the same date.

    >>> import tempfile, zipfile
    >>> with tempfile.TemporaryFile() as file:
    ...     with zip_archive(file) as add:
    ...         add("a.txt", [b"one ", b"two"])
    ...     zipfile.ZipFile(file).read("a.txt")
    b'one two'
    """
    entries: list[_Entry] = []

    def add(name: str, pieces: Iterable[bytes], stored: bool = False, large: bool = False) -> None:
        entries.append(_write(file, name.encode(), pieces, stored, large))

    yield add
    _write_table(file, entries)


def _write(file: BinaryIO, name: bytes, pieces: Iterable[bytes], stored: bool, large: bool) -> _Entry:
    place = file.tell()
    file.write(_head(_Entry(name, stored, large, place, 0, 0, 0)))
    begin, checksum, size = file.tell(), 0, 0

    def counted() -> Iterator[bytes]:
        nonlocal checksum, size
        for piece in pieces:
            checksum = zlib.crc32(piece, checksum)
            size += len(piece)
            yield piece

    for piece in counted() if stored else deflated(counted()):
        file.write(piece)
    end = file.tell()
    entry = _Entry(name, stored, large, place, checksum, end - begin, size)
    if not large and max(size, end - begin) > LIMIT:
        raise OverflowError(f"the entry {name.decode()} of {size} bytes was not announced as large")
    file.seek(place)
    file.write(_head(entry))
    file.seek(end)
    return entry


def _common(entry: _Entry, version: int) -> bytes:
    sizes = (LIMIT, LIMIT) if entry.large else (entry.packed, entry.size)
    method = 0 if entry.stored else 8
    return struct.pack("<HHHHHIII", version, FLAGS, method, 0, DATE, entry.checksum, *sizes)


def _head(entry: _Entry) -> bytes:
    extra = struct.pack("<HHQQ", 1, 16, entry.size, entry.packed) if entry.large else b""
    head = b"PK\3\4" + _common(entry, 45 if entry.large else 20)
    return head + struct.pack("<HH", len(entry.name), len(extra)) + entry.name + extra


def _write_table(file: BinaryIO, entries: list[_Entry]) -> None:
    begin = file.tell()
    for entry in entries:
        wide = [entry.size, entry.packed] if entry.large else []
        wide += [entry.place] if entry.place >= LIMIT else []
        version = 45 if wide else 20
        extra = struct.pack(f"<HH{len(wide)}Q", 1, 8 * len(wide), *wide) if wide else b""
        file.write(b"PK\1\2" + struct.pack("<H", UNIX | version) + _common(entry, version))
        place = min(entry.place, LIMIT)
        file.write(struct.pack("<HHHHHII", len(entry.name), len(extra), 0, 0, 0, MODE, place))
        file.write(entry.name + extra)
    end = file.tell()
    count, size = len(entries), end - begin
    if count >= 0xFFFF or begin >= LIMIT or size >= LIMIT:
        file.write(b"PK\6\6" + struct.pack("<QHHIIQQQQ", 44, UNIX | 45, 45, 0, 0, count, count, size, begin))
        file.write(b"PK\6\7" + struct.pack("<IQI", 0, end, 1))
    few = min(count, 0xFFFF)
    file.write(b"PK\5\6" + struct.pack("<HHHHIIH", 0, 0, few, few, min(size, LIMIT), min(begin, LIMIT), 0))
