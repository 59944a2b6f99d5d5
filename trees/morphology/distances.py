"""The distance transform: how far the cells of a box are from the set, exactly."""

import math
from collections.abc import Sequence
from fractions import Fraction

import numpy as np
from jaxtyping import Int, Integer

from trees.doors import wholes
from trees.errors import TooManyPieces, TreeError
from trees.morphology.elements import Ball, Box, Diamond, Element
from trees.morphology.filters import dilation
from trees.morphology.tiles import BATCH_WORDS, rows_of, slots, tiled, window
from trees.morton import keys_of_cells
from trees.tree import Tree

METRICS = {"euclidean": 0, "d1": 1, "d-infinity": 2}
ELEMENTS: dict[str, type[Element]] = {"euclidean": Ball, "d1": Diamond, "d-infinity": Box}
MAX_CELLS = 2**30


def distances(
    tree: Tree,
    low: Sequence[int] | None = None,
    high: Sequence[int] | None = None,
    metric: str = "euclidean",
    limit: float | None = None,
) -> Integer[np.ndarray, "..."]:
    """How far the cells x, `low <= x < high`, are from the nearest black cell, centre to centre, in cells.

    With the metric "euclidean" it is the square, `min sum (x_i - y_i)^2` over black y; with "d1" `sum |x_i
    - y_i|`, with "d-infinity" `max |x_i - y_i|`: integers. Where nothing black is nearer than or at
    `limit`, it is -1. The box may reach out of the cube; without `low` and `high` it is the cube. One axis
    after the other, by lower envelopes (Meijster, Roerdink and Hesselink 2000; Felzenszwalb and
    Huttenlocher 2012). Memory is that of the box, wider by the limit on all sides as far as the cube goes:
    4 or 8 bytes a cell.

    Raises `TreeError` where the box is empty or of another dimension or the metric is none of these,
    `TooManyPieces` above 2^30 cells.

    >>> from trees import from_points
    >>> distances(from_points([[1, 0], [3, 3]], bits=2)).tolist()
    [[1, 2, 5, 9], [0, 1, 4, 4], [1, 2, 2, 1], [4, 4, 1, 0]]
    >>> distances(from_points([[1, 0]], bits=2), (0, 0), (2, 3), "d1", limit=2).tolist()
    [[1, 2, -1], [0, 1, 2]]
    """
    if metric not in METRICS:
        raise TreeError(f"metric {metric!r}: one of {', '.join(METRICS)} is needed")
    try:
        limit = None if limit is None else float(limit)
    except (TypeError, ValueError, OverflowError):
        raise TreeError(f"a limit of {limit!r}: a number is needed") from None
    if limit is not None and not limit >= 0:
        raise TreeError(f"a limit of {limit}: one not below 0 is needed")
    box = _box(tree, low, high)
    around = _window(tree, box, limit)
    found = _transformed(tree, around, box, METRICS[metric])
    squared = metric == "euclidean"
    far = found.max(initial=0) + 1 if limit is None or math.isinf(limit) else _whole(limit, squared) + 1
    return np.where((found >= min(far, _far(found.dtype))), -1, found).astype(found.dtype)


def within(tree: Tree, radius: float, metric: str = "euclidean", grow: bool = False) -> Tree:
    """The cells at most `radius` cells from the set: a level set of the distance, which is a dilation.

    Errors are those of `dilation`; `TreeError` where the metric is none of those of `distances`.

    >>> from trees import from_points
    >>> len(within(from_points([[4, 4]], bits=3), 2, "d1"))
    13
    """
    if metric not in ELEMENTS:
        raise TreeError(f"metric {metric!r}: one of {', '.join(METRICS)} is needed")
    return dilation(tree, ELEMENTS[metric](radius), grow)


def _box(
    tree: Tree, low: Sequence[int] | None, high: Sequence[int] | None
) -> tuple[tuple[int, ...], tuple[int, ...]]:
    lows = (0,) * tree.dimension if low is None else tuple(wholes(low, "low"))
    highs = (2**tree.bits,) * tree.dimension if high is None else tuple(wholes(high, "high"))
    if len(lows) != tree.dimension or len(highs) != tree.dimension:
        raise TreeError(f"a box from {lows} to {highs} for a tree of dimension {tree.dimension}")
    for axis, (a, b) in enumerate(zip(lows, highs, strict=True)):
        if a >= b:
            raise TreeError(f"axis {axis}: a box from {a} to {b} holds no cell")
    return lows, highs


def _window(tree: Tree, box: tuple, limit: float | None) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """The box, as far as it must be known: wider by the limit within the cube."""
    side = 2**tree.bits
    reach = 2**64 if limit is None else math.floor(min(limit, 2.0**64))
    lows = tuple(min(a, max(a - reach, 0)) for a in box[0])
    highs = tuple(max(b, min(b + reach, side)) for b in box[1])
    cells = math.prod(b - a for a, b in zip(lows, highs, strict=True))
    if cells > MAX_CELLS:
        raise TooManyPieces(cells, MAX_CELLS)
    return lows, highs


def _transformed(tree: Tree, around: tuple, box: tuple, metric: int) -> Integer[np.ndarray, "..."]:
    from trees.morphology import distance_kernels as kernels

    shape = tuple(b - a for a, b in zip(*around, strict=True))
    largest = sum(n**2 for n in shape)
    dtype = np.int32 if largest < _far(np.dtype(np.int32)) else np.int64
    array = np.full(math.prod(shape), _far(np.dtype(dtype)), dtype=dtype)
    _lay_out(tree, around, shape, array)
    for axis in reversed(range(len(shape))):
        before, after = math.prod(shape[:axis]), math.prod(shape[axis + 1 :])
        kernels.one_axis(array, before, shape[axis], after, metric, _far(array.dtype))
    inner = tuple(slice(a - w, b - w) for a, b, w in zip(*box, around[0], strict=True))
    return array.reshape(shape)[inner]


def _lay_out(tree: Tree, around: tuple, shape: tuple, array: Int[np.ndarray, " cells"]) -> None:
    from trees.morphology import distance_kernels as kernels

    tiles = tiled(tree)
    edge, side = tiles.layout.edge, 2**tree.bits
    ranges = [range(max(a, 0) // edge, -(-min(b, side) // edge)) for a, b in zip(*around, strict=True)]
    count = math.prod(map(len, ranges))
    alone = window(tiles.layout, (0,) * tree.dimension)
    batch = max(1, BATCH_WORDS // tiles.layout.count)
    for first in range(0, count, batch):
        numbers = np.arange(first, min(first + batch, count))
        cells = np.stack(np.unravel_index(numbers, tuple(map(len, ranges))), axis=1)
        cells = cells + np.array([r.start for r in ranges])
        places, greys = slots(tiles, keys_of_cells(cells, tiles.some.bits), alone, False)
        kernels.lay_out(
            rows_of(tiles, greys),
            places[:, 0].copy(),
            cells * edge,
            edge,
            np.array(around[0]),
            np.array(shape),
            _far(array.dtype),
            array,
        )


def _far(dtype: np.dtype) -> int:
    """More than any distance stored as this type, and small enough to add to one."""
    return 2**30 if dtype.itemsize == 4 else 2**61


def _whole(limit: float, squared: bool) -> int:
    return math.floor(Fraction(limit) ** 2) if squared else math.floor(limit)
