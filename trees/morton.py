"""Morton keys: the bits of a cell's coordinates, one axis after the other."""

import numpy as np
from jaxtyping import Integer, UInt64

from trees.doors import whole
from trees.errors import KeyTooWide, TreeError


def check_widths(dimension: int, bits: int) -> None:
    """Raises `KeyTooWide` where a key of `dimension * bits` bits does not fit 64."""
    if whole(dimension, "dimension") < 1 or whole(bits, "bits") < 0:
        raise TreeError(f"dimension {dimension} and {bits} bits an axis: at least 1 and 0 are needed")
    if dimension * bits > 64:
        raise KeyTooWide(dimension, bits)


def check_cells(cells: Integer[np.ndarray, "cells dim"], bits: int) -> None:
    """Raises `TreeError` where a coordinate is outside `[0, 2^bits)`, or above 64 bits an axis."""
    if not 0 <= whole(bits, "bits") <= 64:
        raise TreeError(f"{bits} bits an axis: 0 to 64 are possible for cells")
    outside = (cells < 0) | (cells > np.uint64(2**bits - 1))
    if outside.any():
        row, axis = np.argwhere(outside)[0].tolist()
        raise TreeError(
            f"point {row}: coordinate {cells[row, axis]} on axis {axis} is outside 0 to {2**bits - 1}, "
            f"what {bits} bits hold"
        )


def keys_of_cells(cells: Integer[np.ndarray, "cells dim"], bits: int) -> UInt64[np.ndarray, "cells"]:
    """The Morton keys of cells with coordinates in `[0, 2^bits)`.

    Axis 0 has the highest bit of each level: the tree halves it first (Guye 1988, III.1).

    >>> keys_of_cells(np.array([[0, 0], [0, 1], [1, 0], [3, 3]]), bits=2).tolist()
    [0, 1, 2, 15]
    """
    from trees import kernels

    check_widths(cells.shape[1], bits)
    check_cells(cells, bits)
    return kernels.interleave(np.ascontiguousarray(cells, dtype=np.uint64), bits)


def cell_of_key(key: int, dimension: int, bits: int) -> tuple[int, ...]:
    """The cell of one Morton key of any width.

    >>> cell_of_key(2**70 + 1, dimension=2, bits=36)
    (0, 34359738369)
    """
    digits = format(key, f"0{dimension * bits}b") if bits else ""
    return tuple(int(digits[axis::dimension] or "0", 2) for axis in range(dimension))


def cells_of_keys(
    keys: UInt64[np.ndarray, "cells"], dimension: int, bits: int
) -> UInt64[np.ndarray, "cells dim"]:
    """The cells of Morton keys: the inverse of `keys_of_cells`.

    >>> cells_of_keys(np.array([2, 15], dtype=np.uint64), dimension=2, bits=2).tolist()
    [[1, 0], [3, 3]]
    """
    from trees import kernels

    check_widths(dimension, bits)
    return kernels.separate(keys, dimension, bits)
