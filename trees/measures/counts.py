"""How many nodes of each level meet a set, and the dimension that these counts give."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from trees.doors import whole
from trees.errors import TreeError
from trees.node_counts import level_counts
from trees.shared import Shared
from trees.tree import Tree


@dataclass(frozen=True)
class BoxDimension:
    """`value` is the slope of `log2 counts[b]` over b from `first` to `last`.

    `residual` is the largest deviation from the fitted line: where it is r, each count is within a factor
    `2^r` of the fitted power.
    """

    value: float
    first: int
    last: int
    counts: tuple[int, ...]
    residual: float


def node_counts(tree: Tree) -> tuple[int, ...]:
    """How many nodes of edge `size / 2^b` meet the set, for b from 0 to `bits`: grey and black ones.

    These are the counts of the cells of `tree.at(b)`, in one pass over the words, or over the nodes
    of a shared tree, of any number of levels.

    >>> from trees import from_points
    >>> node_counts(from_points([[0, 0], [0, 1], [3, 3]], bits=2))
    (1, 2, 3)
    """
    from trees.measures import kernels

    if isinstance(tree.form, Shared):
        return tuple(level_counts(tree.form)[:: tree.dimension])
    shifts = np.arange(tree.bits + 1) * tree.dimension
    counts = kernels.occupied(tree.starts, tree.words, np.uint64(tree.bricks), shifts).tolist()
    # 2^64, the cells of a full cube of depth 64, is 0 in 64 bits.
    return tuple(count or 2**64 * bool(tree) for count in counts[::-1])


def box_dimension(tree: Tree, first: int | None = None, last: int | None = None) -> BoxDimension:
    """The box-counting dimension seen between two levels: the least-squares slope of `log2 N(b)` over b.

    `N(b)` counts the nodes of edge `size / 2^b` that meet the set; `first` is 1 and `last` `bits` unless
    given. For a set covered at its finest cells the last levels count the cover, not the set.

    Raises `TreeError` for the empty set and for fewer than two levels.

    >>> from trees import from_points
    >>> cells = [[x, y] for x in range(32) for y in range(32) if x & y == 0]
    >>> round(box_dimension(from_points(cells, bits=5)).value, 6)
    1.584963
    """
    first = 1 if first is None else whole(first, "first")
    last = tree.bits if last is None else whole(last, "last")
    if not 0 <= first < last <= tree.bits:
        raise TreeError(f"levels {first} to {last}: two levels or more from 0 to {tree.bits} are needed")
    if not tree:
        raise TreeError("the empty set has no box dimension: give a tree with black cells")
    counts = node_counts(tree)
    logs = np.log2(np.array(counts[first : last + 1], dtype=np.float64))
    slope, residual = _line(logs)
    return BoxDimension(slope, first, last, counts, residual)


def _line(values: Float[np.ndarray, " levels"]) -> tuple[float, float]:
    """Slope and largest deviation of the line of least squares."""
    steps = np.arange(len(values)) - (len(values) - 1) / 2
    slope = float(steps @ values / (steps @ steps))
    return slope, float(np.abs(values - values.mean() - slope * steps).max())
