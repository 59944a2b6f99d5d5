"""Deflate (RFC 1951) whose bytes depend on what is packed alone: on no library, machine or number of threads.

Blocks of a megabyte are packed each by itself, so that several threads can share them.
"""

import os
import zlib
from collections import deque
from collections.abc import Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor

import numpy as np

BLOCK = 1 << 20
THREADS = 4


def deflated(pieces: Iterable[bytes]) -> Iterator[bytes]:
    """The pieces as one deflate stream; how they are cut does not matter.

    >>> packed = b"".join(deflated([b"to be, ", b"or not to be"]))
    >>> zlib.decompress(packed, wbits=-15), packed == b"".join(deflated([b"to be, or not to be"]))
    (b'to be, or not to be', True)
    """
    blocks = _blocks(pieces)
    first = next(blocks, None)
    second = next(blocks, None)
    if first is not None:
        if second is None:
            yield _packed(first)
        else:
            yield from _in_threads(first, second, blocks)
    yield b"\3\0"


def zlib_stream(content: bytes) -> bytes:
    """Bytes in the format of zlib (RFC 1950), as PNG has them.

    >>> zlib.decompress(zlib_stream(b"level"))
    b'level'
    """
    return b"\x78\x01" + b"".join(deflated([content])) + zlib.adler32(content).to_bytes(4, "big")


def _blocks(pieces: Iterable[bytes]) -> Iterator[bytes]:
    """The same bytes in blocks of one size, the last one shorter."""
    waiting: list[bytes] = []
    size = 0
    for piece in pieces:
        waiting.append(piece)
        size += len(piece)
        if size >= BLOCK:
            whole = b"".join(waiting)
            end = size - size % BLOCK
            for start in range(0, end, BLOCK):
                yield whole[start : start + BLOCK]
            waiting, size = [whole[end:]], size - end
    if size:
        yield b"".join(waiting)


def _in_threads(first: bytes, second: bytes, blocks: Iterator[bytes]) -> Iterator[bytes]:
    count = min(os.cpu_count() or 1, THREADS)
    running: deque[Future[bytes]] = deque()
    with ThreadPoolExecutor(count) as threads:
        running.extend(threads.submit(_packed, block) for block in (first, second))
        for block in blocks:
            running.append(threads.submit(_packed, block))
            if len(running) > 2 * count:
                yield running.popleft().result()
        while running:
            yield running.popleft().result()


def _packed(block: bytes) -> bytes:
    from export.formats import deflate_kernels as kernels

    data = np.frombuffer(block, dtype=np.uint8)
    tokens = np.empty(len(data), dtype=np.uint32)
    out = np.empty(2 * len(data) + 1024, dtype=np.uint8)
    used = kernels.block(data, len(data), tokens, out)
    return out[:used].tobytes()
