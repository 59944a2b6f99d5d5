"""The normalised tree: a set in its own frame, at a size of its own."""

import numpy as np

from trees.cells import from_array
from trees.cube import Cube
from trees.doors import real, whole
from trees.errors import TooManyPieces, TreeError
from trees.leaves import leaves
from trees.measures.frame import Frame, principal_frame
from trees.morton import check_widths
from trees.tree import Tree

UNITS = ("inertia", "volume")
MAX_DEPTH = 30
AT_ONCE = 2**18


def normalised(
    tree: Tree,
    bits: int,
    unit: str = "inertia",
    reach: float = 4.0,
    frame: Frame | None = None,
    clip: bool = False,
) -> Tree:
    """The set centred, turned to its principal frame and scaled ("arbre propre", Guye 1988, VI.1).

    The result stands in the cube `[-reach, reach)^k` of `2^bits` cells an axis: lengths have no unit
    any more. One is the largest standard deviation `s_1` with `unit="inertia"`, `volume^(1/k)` with "volume".
    (The source divides by `s_1^2`, which is no length; its annex takes `1 / (6 s_1)`, a cube of `reach` 3.)
    A convex body reaches at most `sqrt(k (k + 2))` standard deviations on each axis, below 4 up to k = 3.

    A cell is black where its centre falls into the set. So the normalised trees of images of one set
    under similarities differ only along the boundary, where the frame is unique (see `Frame`), and up to
    the symmetries of the set where its own symmetries leave the frame open. `frame` gives another frame:
    one of `frame.alternatives()`.

    Raises `TreeError` for the empty set, an unknown unit, a reach of 0 or less, and for a set that reaches
    farther, unless `clip` cuts it; `TooManyPieces` above 2^30 cells.

    >>> from trees import from_array
    >>> bar = from_array(np.indices((16, 16))[0] < 4)
    >>> normal = normalised(bar, bits=7)
    >>> normal.dimension, abs(normal.measure / 12 - 0.25) < 0.02
    (2, True)
    """
    bits, reach = whole(bits, "bits"), real(reach, "reach")
    check_widths(tree.dimension, bits)
    if unit not in UNITS:
        raise TreeError(f"unit {unit!r}: one of {', '.join(UNITS)} is needed")
    if not reach > 0:
        raise TreeError(f"a reach of {reach}: a positive number is needed")
    if tree.dimension * bits > MAX_DEPTH:
        raise TooManyPieces(2 ** (tree.dimension * bits), 2**MAX_DEPTH)
    frame = frame or principal_frame(tree)
    length = frame.variances[0] ** 0.5 if unit == "inertia" else tree.measure ** (1 / tree.dimension)
    if not clip:
        _check_reach(tree, frame, length, reach)
    side = 2**bits
    axes = np.indices((side,) * tree.dimension, dtype=np.int32).reshape(tree.dimension, -1)
    black = np.empty(axes.shape[1], dtype=bool)
    for first in range(0, axes.shape[1], AT_ONCE):
        part = axes[:, first : first + AT_ONCE].T
        centres = ((part + 0.5) * (2 / side) - 1) * (reach * length)
        black[first : first + AT_ONCE] = tree.holds(centres @ frame.axes + frame.centroid)
    cube = Cube((-float(reach),) * tree.dimension, 2 * float(reach))
    return from_array(black.reshape((side,) * tree.dimension), cube)


def _check_reach(tree: Tree, frame: Frame, length: float, reach: float) -> None:
    boxes = leaves(tree, binary=True)
    middles, halves = (boxes.lows + boxes.highs) / 2 - frame.centroid, (boxes.highs - boxes.lows) / 2
    farthest = float((abs(middles @ frame.axes.T) + halves @ abs(frame.axes.T)).max()) / length
    if farthest > reach:
        raise TreeError(
            f"the set reaches {farthest:.4g} units from its centroid along an axis of inertia, "
            f"beyond {reach}: give a larger reach, or clip=True to cut it"
        )
