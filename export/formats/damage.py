"""What a reader says of a file that it cannot read."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Int

AGAIN = "save it again from the program it comes from"


class Damaged(ValueError):
    """A file that is not what its ending says: where it breaks off, what was expected, and what to do."""

    def __init__(self, where: str, what: str, todo: str = AGAIN):
        self.where, self.what, self.todo = where, what, todo
        super().__init__(f"{where}: {what}; {todo}")


def shown(words: bytes | str, most: int = 40) -> str:
    """The beginning of what a file says, fit to be printed.

    >>> shown(b"facet  normal")
    "'facet  normal'"
    """
    text = words.decode("utf-8", "replace") if isinstance(words, bytes) else words
    text = "".join(letter if letter.isprintable() else "?" for letter in text[: most + 1])
    return repr(text if len(text) <= most else text[:most] + "...")


def fans(
    corners: Sequence[int] | np.ndarray, lengths: Int[np.ndarray, " faces"]
) -> Int[np.ndarray, "_triangles 3"]:
    """Polygons of these lengths, one after the other, as triangles around the first corner of each.

    >>> fans([0, 1, 2, 3, 4, 5, 6], np.array([4, 3])).tolist()
    [[0, 1, 2], [0, 2, 3], [4, 5, 6]]
    """
    flat = np.asarray(corners, dtype=np.int64)
    counts = np.maximum(lengths - 2, 0)
    first = np.repeat(np.cumsum(lengths) - lengths, counts)
    step = np.arange(int(counts.sum())) - np.repeat(np.cumsum(counts) - counts, counts)
    return np.column_stack([flat[first], flat[first + step + 1], flat[first + step + 2]])
