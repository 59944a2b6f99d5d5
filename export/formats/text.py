"""Tables of numbers as text, a piece at a time: what the bulk of a text format consists of."""

from collections.abc import Iterator, Sequence

import numpy as np
from jaxtyping import Float, Int

ROWS = 1 << 14  # turned into text at a time
MILLION = 1e6


def number_rows(words: Sequence[str], table: Int[np.ndarray, "rows columns"]) -> Iterator[bytes]:
    """Rows of whole numbers from 0 on, each after its word, and one word more at the end of the row.

    >>> b"".join(number_rows(["f ", " ", " ", ";"], np.array([[1, 2, 3], [40, 5, 6]])))
    b'f 1 2 3;f 40 5 6;'
    """
    for start in range(0, len(table), ROWS):
        yield _text(words, table[start : start + ROWS], False)


def length_rows(words: Sequence[str], table: Float[np.ndarray, "rows columns"]) -> Iterator[bytes]:
    """Rows of lengths (mm) below 10^12 in size, to the nearest millionth, as `number_rows` has them.

    >>> b"".join(length_rows(["<", ",", ">"], np.array([[1.5, -2.0], [1e-7, 0.25]])))
    b'<1.5,-2><0,0.25>'
    """
    for start in range(0, len(table), ROWS):
        yield _text(words, np.rint(table[start : start + ROWS] * MILLION), True)


def _text(words: Sequence[str], table: np.ndarray, millionths: bool) -> bytes:
    from export.formats import text_kernels as kernels

    raw = [word.encode() for word in words]
    ends = np.cumsum([0, *map(len, raw)])
    room = len(table) * (int(ends[-1]) + table.shape[1] * kernels.LONGEST)
    out = np.empty(room, dtype=np.uint8)
    numbers = np.ascontiguousarray(table, dtype=np.int64)
    used = kernels.rows(numbers, millionths, np.frombuffer(b"".join(raw), np.uint8), ends, out)
    return out[:used].tobytes()
