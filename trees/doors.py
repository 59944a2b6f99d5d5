"""What a user gives, turned into the numbers and arrays that are meant, or refused by a `TreeError`."""

import math
import operator
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from jaxtyping import Float, Integer, Real, Shaped

from trees.errors import TreeError

# Rows of numbers, one a cell or a point: an array, or lists of lists.
Rows = Real[np.ndarray, "..."] | Sequence[Any]


def whole(value: Any, name: str) -> int:
    """A Python integer from one of any kind, NumPy's too. Raises `TreeError` for all else.

    >>> whole(np.uint8(8), "bits")
    8
    """
    try:
        return operator.index(value)
    except TypeError:
        raise TreeError(f"{name} {value!r}: an integer is needed") from None


def wholes(values: Any, name: str, count: int | None = None) -> list[int]:
    """Python integers from a sequence; whole floats will do. Raises `TreeError`, also for another `count`.

    >>> wholes(np.array([1, 2]), "vector")
    [1, 2]
    """
    if not isinstance(values, Iterable):
        raise TreeError(f"{name} {values!r}: integers are needed")
    found, listed = [], list(values)
    for value in listed:
        rounded = isinstance(value, float | np.floating) and float(value).is_integer()
        if not rounded and not hasattr(value, "__index__"):
            raise TreeError(f"{name} {listed}: integers are needed{'' if count is None else f', {count}'}")
        found.append(int(value) if rounded else whole(value, name))
    if count is not None and len(found) != count:
        raise TreeError(f"{name} {listed}: integers are needed, {count} of them")
    return found


def real(value: Any, name: str) -> float:
    """A finite float. Raises `TreeError` for all else.

    >>> real(np.float32(0.5), "radius")
    0.5
    """
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        raise TreeError(f"{name} {_short(value)}: a number within the range of floats is needed") from None
    if not math.isfinite(number):
        raise TreeError(f"{name} {number}: finite numbers are needed")
    return number


def array_of(values: Any, name: str) -> Shaped[np.ndarray, "..."]:
    """An array. Raises `TreeError` where rows are of unequal lengths.

    >>> array_of([[1, 2]], "cells").shape
    (1, 2)
    """
    try:
        return np.asarray(values)
    except ValueError:
        raise TreeError(f"{name}: the rows are of unequal lengths") from None


def cell_rows(cells: Any, dimension: int | None = None) -> Integer[np.ndarray, "_cells _dim"]:
    """Cells by their integer coordinates, one a row. Raises `TreeError` for all else.

    >>> cell_rows([[1, 2]], 2).tolist()
    [[1, 2]]
    """
    rows = _rows(cells, "cells", dimension)
    if not np.issubdtype(rows.dtype, np.integer):
        raise TreeError(f"cells have integer coordinates, not {rows.dtype}: `holds` takes points in mm")
    return rows


def point_rows(points: Any, dimension: int | None = None) -> Float[np.ndarray, "_points _dim"]:
    """Points in mm, one a row. Raises `TreeError` for all else.

    >>> point_rows([[1, 2]], 2).tolist()
    [[1.0, 2.0]]
    """
    rows = _rows(points, "points", dimension)
    try:
        return rows.astype(np.float64)
    except (TypeError, ValueError, OverflowError):
        raise TreeError(f"points of {rows.dtype}: numbers are needed") from None


def numbers(values: Any, name: str) -> Shaped[np.ndarray, " _values"]:
    """A row of numbers. Raises `TreeError` for all else; without any, their type is uint64.

    >>> numbers([1, 2], "keys").tolist()
    [1, 2]
    """
    found = array_of(values, name)
    if found.ndim != 1:
        raise TreeError(f"{name} of shape {found.shape}: one row is needed")
    return found if found.size else np.zeros(0, dtype=np.uint64)


def _rows(values: Any, name: str, dimension: int | None) -> Shaped[np.ndarray, "_rows _dim"]:
    rows = array_of(values, name)
    if rows.size == 0 and rows.ndim in (1, 2):
        columns = dimension or 1 if rows.ndim == 1 else rows.shape[1]
        rows = np.zeros((len(rows), columns), dtype=np.uint64)
    if rows.ndim != 2 or rows.shape[1] == 0:
        raise TreeError(f"{name} of shape {rows.shape}: ({name}, dimension) is needed")
    if dimension is not None and rows.shape[1] != dimension:
        raise TreeError(f"{name} of {rows.shape[1]} coordinates for a tree of dimension {dimension}")
    return rows


def _short(value: object) -> str:
    text = repr(value) if not isinstance(value, int) or value.bit_length() < 1000 else "too large for a float"
    return text if len(text) < 80 else text[:77] + "..."
