"""How the cells of a word lie along the axes, and how a word moves by one cell."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Int, UInt64

from trees.tree import Tree


class Layout(NamedTuple):
    """Masks and shifts of a word of the lowest levels, one row an axis; kernels take it as it is.

    A step along an axis with `steps` levels adds 1 to the bits of the axis within the index of the cell: one
    shift for each length of the carry. `masks[a, t]` are the cells that carry over t bits, and
    `shifts[a, t]` is how far their neighbours lie. `high[a]` is the index of the last cell on axis a,
    `low[a]` the word of the first cells, `inner[a]` that of all cells but the last ones. `full` is the word
    of all cells.
    """

    steps: Int[np.ndarray, " dim"]
    masks: UInt64[np.ndarray, "dim 6"]
    shifts: UInt64[np.ndarray, "dim 6"]
    high: UInt64[np.ndarray, " dim"]
    low: UInt64[np.ndarray, " dim"]
    inner: UInt64[np.ndarray, " dim"]
    full: np.uint64


def layout(tree: Tree) -> Layout:
    """The layout of the words of this tree.

    >>> from trees import from_points
    >>> layout(from_points([[0, 0, 0]], bits=4)).steps.tolist()
    [2, 2, 2]
    """
    dimension, used = tree.dimension, min(tree.depth, 6)
    index = np.arange(2**used, dtype=np.uint64)
    steps = np.zeros(dimension, dtype=np.int64)
    masks, shifts = (np.zeros((dimension, 6), dtype=np.uint64) for _ in range(2))
    high, low, inner = (np.zeros(dimension, dtype=np.uint64) for _ in range(3))
    for axis in range(dimension):
        places = [bit for bit in range(used) if dimension - 1 - bit % dimension == axis]
        steps[axis] = len(places)
        carried = 0
        for t, place in enumerate(places):
            carries = (index & np.uint64(carried | 1 << place)) == np.uint64(carried)
            masks[axis, t] = _word(carries)
            shifts[axis, t] = (1 << place) - carried
            carried |= 1 << place
        high[axis] = carried
        low[axis] = _word((index & np.uint64(carried)) == 0)
        inner[axis] = _word((index & np.uint64(carried)) != carried)
    return Layout(steps, masks, shifts, high, low, inner, _word(index == index))


def _word(chosen: np.ndarray) -> np.uint64:
    return np.uint64(sum(1 << bit for bit in np.flatnonzero(chosen).tolist()))
