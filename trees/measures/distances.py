"""Distances: of cells by their common node, and of sets."""

import math

import numpy as np
from jaxtyping import Float, UInt64

from trees.algebra import aligned
from trees.cells import to_points
from trees.doors import Rows, cell_rows, real, whole
from trees.errors import TooManyPieces, TreeError
from trees.morton import keys_of_cells
from trees.runs import black_runs
from trees.tree import Tree

MAX_POINTS = 2**24


def cell_distance(a: Rows, b: Rows, bits: int, volume: float = 1.0) -> Float[np.ndarray, " cells"]:
    """The ultrametric of cells: `(2^h - 1) volume / 2^(k bits)`, h the height of the smallest common node.

    The node is one of the binary tree; `volume` is that of the cube. The distance is that of the keys
    farthest apart in the node; with ever more bits it becomes the measure of the node. It satisfies
    `d(x, z) <= max(d(x, y), d(y, z))`. (Guye 1988, II.7, gives the figures: at a precision of 1/8, 0 and 1/8
    are 1/8 apart, 3/8 and 4/8 are 7/8 apart. The measure of the node would be 1/4 and 1, and not 0 for
    equal cells.)

    Raises `TreeError` where the cells are no integers, outside the cube, or not as many on both sides.

    >>> cells = np.array([[0], [3], [2]])
    >>> cell_distance(cells, np.array([[1], [4], [5]]), bits=3).tolist()
    [0.125, 0.875, 0.875]
    """
    one, other, bits = cell_rows(a), cell_rows(b), whole(bits, "bits")
    if one.shape != other.shape:
        raise TreeError(f"cells of shapes {one.shape} and {other.shape}: cell by cell, as many are needed")
    differing = keys_of_cells(one, bits) ^ keys_of_cells(other, bits)
    depth, volume = one.shape[1] * bits, real(volume, "volume")
    return np.array(
        [_span(int(key).bit_length(), depth, volume) for key in differing.tolist()], dtype=np.float64
    )


def node_distance(a: Tree, b: Tree) -> float:
    """The Hausdorff distance of two sets for the ultrametric of `cell_distance`, in mm^k.

    `(2^h - 1)` cells, h the least height at which the same nodes of the binary tree meet both sets. It is
    an ultrametric on sets: `d(A, C) <= max(d(A, B), d(B, C))`. (Guye 1988, II.7, calls `distance`, the
    measure of the exclusive or, a Hausdorff distance and ultrametric; it is neither: for nothing, one
    cell and two cells it is 1, 1 and 2. It is a metric.) It is infinite where just one set is empty.

    Raises what `trees.algebra.aligned` raises.

    >>> from trees import from_points
    >>> node_distance(from_points([[0], [3]], bits=3), from_points([[1], [3]], bits=3))
    0.125
    """
    a, b = aligned(a, b)
    if bool(a) != bool(b):
        return math.inf
    one, other = black_runs(a), black_runs(b)
    low, high = 0, a.depth
    while low < high:
        middle = (low + high) // 2
        if _met(one, middle) == _met(other, middle):
            high = middle
        else:
            low = middle + 1
    return _span(low, a.depth, a.size**a.dimension)


def jaccard_distance(a: Tree, b: Tree) -> float:
    """`mu(A ^ B) / mu(A | B)`, from 0 for equal sets to 1 for disjoint ones; a metric; 0 for two empty sets.

    Raises what `trees.algebra.combine` raises.

    >>> from trees import from_points
    >>> jaccard_distance(from_points([[0, 0]], bits=1), from_points([[0, 0], [1, 1]], bits=1))
    0.5
    """
    a, b = aligned(a, b)
    one = (a ^ b).count
    either = (a.count + b.count + one) // 2
    return one / either if either else 0.0


def hausdorff_distance(a: Tree, b: Tree) -> float:
    """The Hausdorff distance, in mm, of the sets of the centres of the cells.

    The largest distance from a centre of one set to the nearest of the other. It is infinite where just one
    set is empty, 0 where both are. That of the cells as solids differs by at most half the diagonal of
    a cell.

    Raises `TooManyPieces` above 2^24 cells, and what `trees.algebra.aligned` raises.

    >>> from trees import from_points
    >>> hausdorff_distance(from_points([[0, 0], [3, 0]], bits=2), from_points([[0, 0]], bits=2))
    0.75
    """
    a, b = aligned(a, b)
    if bool(a) != bool(b):
        return math.inf
    for tree in (a, b):
        if tree.count > MAX_POINTS:
            raise TooManyPieces(tree.count, MAX_POINTS)
    return max(_reach(a - b, b), _reach(b - a, a)) * a.cell_size


def _span(height: int, depth: int, volume: float) -> float:
    return (2**height - 1) / 2**depth * volume


def _met(runs: tuple[UInt64[np.ndarray, " _runs"], UInt64[np.ndarray, " _runs"]], height: int) -> list[bytes]:
    """The nodes of `2^height` keys that meet the runs, as the longest runs of nodes."""
    if height == 64 or len(runs[0]) == 0:
        return [bytes(len(runs[0]) > 0)]
    lows, highs = (keys >> np.uint64(height) for keys in runs)
    apart = lows[1:] > highs[:-1] + np.uint64(1)
    return [lows[np.append(True, apart)].tobytes(), highs[np.append(apart, True)].tobytes()]


def _reach(new: Tree, old: Tree) -> float:
    """The largest distance, in cells, from a cell of `new` to the nearest of `old`."""
    from scipy.spatial import KDTree

    if not new:
        return 0.0
    centres, others = to_points(new), to_points(old)
    nearest = KDTree(others.astype(np.float64)).query(centres.astype(np.float64))[1]
    gaps = np.where(centres > others[nearest], centres - others[nearest], others[nearest] - centres)
    return math.sqrt(float((gaps.astype(np.float64) ** 2).sum(axis=1).max()))
