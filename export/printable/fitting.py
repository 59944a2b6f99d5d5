"""Whether a part fits a build volume, and how it must be turned."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from export.printable.frame import WrongLength, box_of, check_solid
from trees import Tree
from trees.geometry import permute, reflect

Turn = tuple[tuple[int, ...], ...]


@dataclass(frozen=True)
class Fit:
    """Whether a part fits, and turned how: `turn` is a matrix, coordinates x become `turn @ x`.

    `sides` are those of the part's bounding box in mm as it stands, `scale` is the factor at which the part,
    so turned, would just fit: 1 or more where it does.
    """

    fits: bool
    turn: Turn
    scale: float
    sides: tuple[float, ...]


class DoesNotFit(ValueError):
    """A part that is larger than the build volume of sides `room` in mm; `fit` says by how much."""

    def __init__(self, room: Sequence[float], fit: Fit, advice: str = ""):
        self.room, self.fit = tuple(room), fit
        sides, most = (" x ".join(f"{side:.5g}" for side in lengths) for lengths in (fit.sides, room))
        smaller = f"at {math.floor(100 * fit.scale):d} % of its size it would, turned well"
        super().__init__(f"the part is {sides} mm and does not fit into {most} mm: {advice or smaller}")


def turns() -> tuple[Turn, ...]:
    """The 24 rotations that take axes to axes, the one that turns nothing first.

    >>> len(set(turns())), turns()[0]
    (24, ((1, 0, 0), (0, 1, 0), (0, 0, 1)))
    """
    found = []
    for axes in itertools.permutations(range(3)):
        for signs in itertools.product((1, -1), repeat=3):
            matrix = np.zeros((3, 3), dtype=np.int64)
            matrix[range(3), axes] = signs
            if round(np.linalg.det(matrix)) == 1:
                found.append(tuple(tuple(row) for row in matrix.tolist()))
    return tuple(found)


def fits(tree: Tree, volume_mm: Sequence[float]) -> Fit:
    """Whether the bounding box of a part fits a build volume of three sides in mm, in one of 24 orientations.

    The first of `turns` in which it fits is taken, so none where it stands well; where it fits in none,
    that with the largest scale. The box is that of the cells, and sides may be equal: rounding of 1e-9 of
    a side is forgiven.

    Raises `WrongLength` for a side that is not above 0, `ValueError` where there are not three of them,
    `EmptySolid` for the empty set, `TreeError` where the tree is not of dimension 3.

    >>> from trees import from_points
    >>> rod = from_points([[0, 0, z] for z in range(4)], bits=2)
    >>> fits(rod, (1, 0.5, 0.5)).fits, fits(rod, (0.5, 0.5, 0.5)).scale
    (True, 0.5)
    """
    check_solid(tree)
    room = tuple(float(side) for side in volume_mm)
    if len(room) != 3:
        raise ValueError(f"a build volume of {len(room)} sides: 3 are needed")
    for axis, side in enumerate(room):
        if not (math.isfinite(side) and side > 0):
            raise WrongLength(f"side {axis} of the build volume in mm", side, "a finite number above 0")
    low, last = box_of(tree)
    sides = (last - low + 1) * tree.cell_size
    scales = [float(np.min(np.array(room) / (np.abs(np.array(turn)) @ sides))) for turn in turns()]
    good = [number for number, scale in enumerate(scales) if scale >= 1 - 1e-9]
    best = good[0] if good else int(np.argmax(scales))
    return Fit(bool(good), turns()[best], scales[best], tuple(sides.tolist()))


def turned(tree: Tree, turn: Turn) -> Tree:
    """The part turned about the middle of its cube by one of `turns`; exact.

    Raises `ValueError` for any other matrix, `TreeError` where the tree is not of dimension 3.

    >>> from trees import from_points
    >>> list(turned(from_points([[3, 0, 1]], bits=2), ((0, -1, 0), (1, 0, 0), (0, 0, 1))))
    [(3, 3, 1)]
    """
    check_solid(tree)
    if turn not in turns():
        raise ValueError(f"{turn} is none of the 24 rotations that take axes to axes: see turns()")
    matrix = np.array(turn)
    axes = np.abs(matrix).argmax(axis=1)
    moved = permute(tree, axes.tolist())
    moved = reflect(moved, np.flatnonzero(matrix.sum(axis=1) < 0).tolist())
    return Tree(tree.cube, tree.bits, moved.form)
