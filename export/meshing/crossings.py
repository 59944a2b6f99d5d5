"""Where a field changes sign between the centres of two blocks, and which way it grows there."""

from collections.abc import Callable

import numpy as np
from jaxtyping import Float, Int

from trees.tree import Tree

Field = Callable[[Float[np.ndarray, "points 3"]], Float[np.ndarray, " points"]]
Gradient = Callable[[Float[np.ndarray, "points 3"]], Float[np.ndarray, "points 3"]]
Edges = Int[np.ndarray, " _ways"] | int

CLEAR = 0.05  # a crossing keeps this share of the way from the centres on either side
JOINED = -0.5  # the field, in edges of blocks, where a black block has none: one filled to join, or to grade
BATCH = 2**18
STEP = 1e-4  # of central differences, in cells
ROUNDS = 60
EXACT = 1e-10  # in cells


def share_of(
    tree: Tree,
    field: Field,
    start: Float[np.ndarray, "ways 3"],
    stop: Float[np.ndarray, "ways 3"],
    edges: tuple[Edges, Edges] = (1, 1),
) -> Float[np.ndarray, " ways"]:
    """The place of the change of sign from the centre of a black block, 0, to that of a white one, 1.

    The field is taken to be linear between them; places are in cells, and so are the `edges` of the blocks.
    """
    low, high = field_at(tree, field, start), field_at(tree, field, stop)
    low = np.where(low > 0, JOINED * edges[0], low)
    high = np.maximum(np.where(np.isinf(high), 0.5 * edges[1], high), 0.0)
    level = high == low
    share = np.where(level, 0.5, -low / np.where(level, 1.0, high - low))
    return np.clip(share, CLEAR, 1 - CLEAR)


def exact_shares(
    tree: Tree,
    field: Field,
    start: Float[np.ndarray, "ways 3"],
    stop: Float[np.ndarray, "ways 3"],
    shares: Float[np.ndarray, " ways"],
) -> Float[np.ndarray, " ways"]:
    """The places where a field of any point changes sign on the way from `start` to `stop` (cells).

    False position with halved weights (the Illinois rule), until the field is below 1e-10 cells. Ways whose
    ends do not have different signs keep the share given.
    """
    low, high = field_at(tree, field, start), field_at(tree, field, stop)
    result = shares.copy()
    rows = np.flatnonzero((low <= 0) & (high > 0) & np.isfinite(high))
    a, b = np.zeros(len(rows)), np.ones(len(rows))
    low, high = low[rows], high[rows]
    last = np.zeros(len(rows), dtype=np.int64)
    for _ in range(ROUNDS):
        if not len(rows):
            break
        at = (a * high - b * low) / (high - low)
        value = field_at(tree, field, start[rows] + at[:, None] * (stop - start)[rows])
        result[rows] = at
        inside = value <= 0
        again = np.where(inside, 1, -1) == last
        low = np.where(inside, value, np.where(again, low / 2, low))
        high = np.where(inside, np.where(again, high / 2, high), value)
        a, b, last = np.where(inside, at, a), np.where(inside, b, at), np.where(inside, 1, -1)
        going = (np.abs(value) > EXACT) & (b - a > EXACT) & np.isfinite(value)
        rows, a, b, low, high, last = (one[going] for one in (rows, a, b, low, high, last))
    return result


def normals_at(
    tree: Tree, field: Field, gradient: Gradient | None, places: Float[np.ndarray, "_places 3"]
) -> Float[np.ndarray, "_places 3"]:
    """Unit vectors along the gradient at places in cells, 0 where there is none.

    Without a gradient they are central differences of the field over 1e-4 cells.
    """
    result = np.empty((len(places), 3))
    if gradient is None:
        for axis in range(3):
            step = np.zeros(3)
            step[axis] = STEP
            result[:, axis] = field_at(tree, field, places + step) - field_at(tree, field, places - step)
    else:
        for i in range(0, len(places), BATCH):
            result[i : i + BATCH] = _gradient(tree, gradient, places[i : i + BATCH])
    result[~np.isfinite(result).all(axis=1)] = 0
    lengths = np.linalg.norm(result, axis=1, keepdims=True)
    return np.divide(result, lengths, out=np.zeros_like(result), where=lengths > 0)


def field_at(
    tree: Tree, field: Field, places: Float[np.ndarray, "_places 3"]
) -> Float[np.ndarray, " _places"]:
    """The field at places in cells, in cells.

    Raises `ValueError` for one of another shape, with NaN or -inf.
    """
    values = np.empty(len(places))
    for i in range(0, len(places), BATCH):
        values[i : i + BATCH] = _values(tree, field, places[i : i + BATCH])
    return values


def _values(
    tree: Tree, field: Field, places: Float[np.ndarray, "_places 3"]
) -> Float[np.ndarray, " _places"]:
    points = np.array(tree.origin) + places * tree.cell_size
    values = np.asarray(field(points), dtype=np.float64)
    if values.shape != (len(points),):
        raise ValueError(f"the field gives shape {values.shape} for {len(points)} points: one number each")
    wrong = np.isnan(values) | (values == -np.inf)
    if wrong.any():
        where = int(np.argmax(wrong))
        raise ValueError(f"the field is {values[where]} at {points[where].tolist()} mm: give a distance")
    return values / tree.cell_size


def _gradient(
    tree: Tree, gradient: Gradient, places: Float[np.ndarray, "_places 3"]
) -> Float[np.ndarray, "_places 3"]:
    points = np.array(tree.origin) + places * tree.cell_size
    found = np.asarray(gradient(points), dtype=np.float64)
    if found.shape != points.shape:
        raise ValueError(
            f"the gradient gives shape {found.shape} for {len(points)} points: three numbers each"
        )
    return found
