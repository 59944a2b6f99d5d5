"""Voxels that cover an attractor, with a certificate of both distances."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from export.voxels.estimate import Budget, Prediction, fitted
from export.voxels.frame import TOLERANCE, Frame, Model, Subject, frame_around, in_grid, subject
from export.voxels.lattice import NotOnLattice, lattice_tree
from export.voxels.level import at_depth
from export.voxels.piece_walk import walked
from trees import Tree

Progress = Callable[[str, float], None]

WAYS = ("auto", "walk", "lattice")
LARGE = 1 << 21
"""Voxels of a grid from which on the lattice is tried first."""


@dataclass(frozen=True, eq=False)
class Cover:
    """Voxels that cover a shape, and how well: a bound of the Hausdorff distance of the two, in mm.

    Every point of the attractor is within `outer` of a closed black voxel (0: it lies in one), and every
    point of a black voxel within `inner` of the attractor. The grid has `size` voxels from the origin of the
    tree on, of which the longest side was to have `asked`: a budget may have made them fewer. `pieces` were
    seen, by the `way` "walk" or "lattice".
    """

    tree: Tree
    outer: float
    inner: float
    size: tuple[int, int, int]
    asked: int
    way: str
    pieces: int
    prediction: Prediction | None = None

    @property
    def distance(self) -> float:
        """A bound of the Hausdorff distance between the attractor and the black voxels, in mm."""
        return max(self.outer, self.inner)

    @property
    def resolution(self) -> int:
        """Voxels along the longest side."""
        return max(self.size)

    @property
    def pitch(self) -> float:
        """The side of a voxel, in mm."""
        return self.tree.cell_size


def voxelise(
    model: Model,
    resolution: int | None = None,
    *,
    pitch: float | None = None,
    depth: int | None = None,
    part: float = 1.0,
    snap: float = TOLERANCE,
    way: str = "auto",
    budget: Budget | None = None,
    progress: Progress | None = None,
    predicted: Callable[[Prediction], None] | None = None,
) -> Cover:
    """The voxels that the pieces of a shape meet, as a tree of three axes whose cube says where they stand.

    The model is a shape of one to three coordinates, of any system (mixed or restricted ones too), or the
    patches of a surface or complex. The longest side of its bounding box has `resolution` voxels, or voxels
    have the side `pitch` (mm); the box is in the middle of the grid, a plane shape in that of one layer.

    Pieces are subdivided until their certified box lies in one voxel, or all its sides are at most `part`
    voxels: then the voxels that it meets become black, so that `inner <= sqrt(3) (1 + part)` pitches. Smaller
    parts give fewer voxels and take longer. A box that reaches over the face of a voxel by at most `snap`
    pitches does not fill the one behind: `outer` is that far, at corners, plus an estimate of rounding. With
    `snap=0` boxes are widened by that estimate, and `outer` is 0: then lattice fractals have a layer of
    voxels around them.

    With `depth` it is what the pieces at exactly that level draw, as a solid, that is covered. Where their
    cells have a stated figure that is a segment, a polygon or has faces, this solid figure takes the place of
    the attractor: the bounding box is its own, and `outer` and `inner` are distances from it
    (`export.voxels.level.level_of` says how figures are filled). Elsewhere the boxes of the pieces are filled
    (the sponge at level n), and `inner`, from the attractor, counts with their diagonal.

    "walk" goes through all pieces, depth first, and leaves out those whose voxels are black; grids of over
    2^30 voxels are filled in blocks, so that memory is in proportion to the result. "lattice" works out each
    arrangement of pieces in a box once (`export.voxels.lattice`), which is exact (`outer` is then rounding of
    the grid alone); "auto" takes it for large grids where it is quick, else walks. Both give the same voxels.

    `progress("voxels", share)` is told from time to time, first with 0 and at last with 1: the share of the
    addresses that is behind, in which the labels of a cell count alike (the lattice tells the two ends only).
    An exception that it raises ends the work and leaves nothing. A budget is compared with a prediction first
    (`export.voxels.estimate`); `predicted` is told that prediction, of the resolution that is then used,
    also where there is no budget.

    Raises `TypeError` for what is no shape or number, `ValueError` for numbers out of range and a shape that
    is a single point, `OverBudget`, `TooFine` below the precision of doubles, `NotOnLattice` where that way
    is asked for, `NotContracting` or `Undecided`, `GridTooLarge`, `trees.TooManyPieces`.

    >>> import ifs
    >>> found = voxelise(ifs.shape("menger-sponge"), 27)
    >>> found.tree.count, found.tree.cell_size, found.distance < 2 * 3**0.5 * 2.0001
    (8000, 2.0, True)
    """
    _check(depth, part, snap, way)
    pieces, depth = at_depth(subject(model), model, depth)
    frame = frame_around(pieces, resolution, pitch)
    asked = max(frame.size)
    prediction = None
    if budget is not None or predicted is not None:
        frame, prediction = fitted(pieces, frame, budget or Budget(), depth)
    if predicted is not None and prediction is not None:
        predicted(prediction)
    tell = progress or (lambda stage, share: None)
    tell("voxels", 0.0)
    cover = _covered(pieces, frame, asked, (depth, part, snap, way), prediction, tell)
    tell("voxels", 1.0)
    return cover


def _check(depth: int | None, part: float, snap: float, way: str) -> None:
    if depth is not None and depth < 0:
        raise ValueError(f"the depth is 0 or more, found {depth}")
    if not 1 / 64 <= part <= 1:
        raise ValueError(f"the part of a voxel is from 1/64 to 1, found {part}")
    if not 0 <= snap <= 1e-3:
        raise ValueError(f"boxes snap to the faces of voxels over 0 to 0.001 pitches, found {snap}")
    if way not in WAYS:
        raise ValueError(f"the way is one of {', '.join(WAYS)}; found {way!r}")


def _covered(
    found: Subject,
    frame: Frame,
    asked: int,
    options: tuple[int | None, float, float, str],
    prediction: Prediction | None,
    tell: Progress,
) -> Cover:
    depth, part, snap, way = options
    diagonal = math.sqrt(3) * frame.pitch
    large = math.prod(frame.size) >= LARGE
    if way == "lattice" or (way == "auto" and snap > 0 and large and depth is None):
        try:
            tree, reach = lattice_tree(found, frame, part, depth, patient=way == "lattice")
        except NotOnLattice:
            if way == "lattice":
                raise
        else:
            inner = diagonal + reach * frame.pitch + frame.rounding
            return Cover(tree, frame.rounding, inner, frame.size, asked, "lattice", 0, prediction)
    done = walked(in_grid(found, frame), frame, part, depth, snap, lambda share, _: tell("voxels", share))
    over = (snap + done.rounding) * diagonal if snap else 0.0
    inner = diagonal + (done.reach + 2 * done.rounding) * frame.pitch + (snap + done.rounding) * diagonal
    return Cover(done.tree, over, inner, frame.size, asked, "walk", done.pieces, prediction)
