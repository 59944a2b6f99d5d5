"""The boundary: cells that touch cells of the other colour."""

import numpy as np

from trees.errors import TooManyPieces, TreeError
from trees.runs import MAX_RUNS
from trees.topology.metrics import D1, is_box
from trees.topology.pieces import pieces
from trees.tree import Tree, of_bricks


def boundary(tree: Tree, metric: str = D1, side: str = "inner") -> Tree:
    """The black cells that touch a white one ("inner"), or the white cells that touch a black one ("outer").

    What lies beyond the reference cube is white, and no part of the outer boundary. Only the bricks at the
    surface of a black block are visited.

    Raises `TooManyPieces` above 2^28 bricks, `TreeError` for another metric or side.

    >>> from trees import empty, unit_cube
    >>> full = ~empty(unit_cube(2), bits=3)
    >>> len(boundary(full)), len(boundary(full, side="outer"))
    (28, 0)
    >>> len(boundary(full - boundary(full), side="outer"))
    24
    """
    from trees.topology import boundary_kernels, piece_kernels

    box = is_box(metric)
    if side not in ("inner", "outer"):
        raise TreeError(f"side {side!r}: inner or outer is needed")
    cut = pieces(tree if side == "inner" else ~tree)
    outside = 0 if side == "outer" else 2 if box else 1
    shape = (cut.starts, cut.words, cut.levels, cut.top, cut.low, box, outside)
    none = np.empty(0, dtype=np.uint64)
    _, count = boundary_kernels.boundary(*shape, none, none, cut.layout)
    if count > MAX_RUNS:
        raise TooManyPieces(count, MAX_RUNS)
    bricks, shell = (np.empty(max(count, 1), dtype=np.uint64) for _ in range(2))
    marks, count = boundary_kernels.boundary(*shape, bricks, shell, cut.layout)
    starts = np.concatenate([cut.starts[marks != 0], bricks[:count]])
    words = np.concatenate([marks[marks != 0], shell[:count]])
    order = np.argsort(starts, kind="stable")
    levels = np.zeros(len(starts), dtype=np.uint8)
    total = np.uint64(tree.bricks)
    return of_bricks(tree.cube, tree.bits, *piece_kernels.entries(starts[order], words[order], levels, total))
