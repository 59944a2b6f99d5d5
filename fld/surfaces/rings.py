"""A point seen from near: an operator that fixes it, and the pieces that this operator repeats for ever.

Let M fix a point c of an attractor, and let the ring be what M(attractor) leaves of it on one side of c, or
around it. Then the points there are c and `c + M^k (p - c)`, p in the ring, k = 0, 1, 2, ... So all that is
to be known near c is known from M and the ring, for curves, for corners of faces, and for cells that become
others before they come back.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from jaxtyping import Float

from fld.directions import Directions, closure, differences, visible
from ifs import Box, Undecided, bounds, sample
from ifs.system import Operator, System

_RANK = 1e-9

Span = Float[np.ndarray, "_directions _points"]

Piece = tuple[Operator, str]
"""A piece of a cell: the operator into the cell's space, and the cell that it is an image of."""


@dataclass(frozen=True)
class Ground:
    """A system, with what rings need of it: points, directions and boxes of the attractors of its cells.

    They are worked out when first asked for, with those of the cells that a cell becomes.
    """

    system: System
    _spans: dict[str, Span] = field(default_factory=dict, repr=False, compare=False)
    _boxes: dict[str, Box | None] = field(default_factory=dict, repr=False, compare=False)

    @cached_property
    def points(self) -> Mapping[str, Float[np.ndarray, "_points"]]:
        return sample(self.system)

    def box(self, cell: str) -> Box | None:
        """A box around the attractor of a cell; None where its convergence is undecided."""
        if cell not in self._boxes:
            names = self._reached(cell)
            part = System(cell, {name: self.system.states[name] for name in names})
            try:
                self._boxes.update(bounds(part))
            except Undecided:
                self._boxes.update(dict.fromkeys(names))
        return self._boxes[cell]

    def span(self, cell: str) -> Span:
        """The directions of differences of points of the attractor of a cell.

        The smallest spaces with `D_x` holding `T_i c_y - c_x` and `T_i D_y`, c a point of each attractor.
        """
        if cell not in self._spans:
            states = {name: self.system.states[name] for name in self._reached(cell)}
            found: dict[str, Span] = {name: np.zeros((0, state.points)) for name, state in states.items()}
            before = -1
            while before < (before := sum(map(len, found.values()))):
                found = {name: self._wider(name, found) for name in found}
            self._spans.update(found)
        return self._spans[cell]

    def _reached(self, cell: str) -> list[str]:
        found = [cell]
        for name in found:
            found += [
                target for target in dict.fromkeys(self.system.states[name].targets) if target not in found
            ]
        return found

    def _wider(self, name: str, found: Mapping[str, Span]) -> Span:
        state = self.system.states[name]
        pieces = list(zip(state.operators, state.targets, strict=True))
        frame = differences(state.points)
        return closure(self.rows(pieces, self.points[name], found) @ frame.T, []) @ frame

    def rows(
        self, pieces: Sequence[Piece], point: Float[np.ndarray, "points"], spans: Mapping[str, Span]
    ) -> Float[np.ndarray, "rows points"]:
        """Differences that span those between a point and the points of some pieces."""
        parts = [np.zeros((0, len(point)))]
        for operator, target in pieces:
            parts += [(operator @ self.points[target] - point)[None], spans[target] @ operator.T]
        return np.concatenate(parts)


@dataclass(frozen=True)
class Ring:
    """A point c of a cell, the operator M that fixes it, and the ring around it or on one side of it.

    All of this lies in the space of the cell `state`; `lead` are the operators that carry it into the cell
    that is drawn. `far` is a point of the ring, at the distance `reach` from c in the parameter of the drawn
    cell, and M shrinks distances in the parameter by `ratio` (NaN where it shrinks them unequally).
    `corners` are other points of the ring in order around c, for a face.
    """

    ground: Ground
    state: str
    lead: tuple[Operator, ...]
    cycle: Operator
    pieces: tuple[Piece, ...]
    point: Float[np.ndarray, "points"]
    far: Float[np.ndarray, "points"]
    reach: float
    ratio: float
    corners: tuple[Float[np.ndarray, "points"], ...] = ()
    places: tuple[tuple[float, float], ...] = ()

    def directions(
        self, control: Float[np.ndarray, "drawn dim"], size: float | None = None
    ) -> tuple[Directions, float]:
        """The directions of the ring that control points show at some level, and the logarithm of a scale.

        What the rows of the basis draw is in units of `exp(scale)` mm, so that long leads lose no digits.
        `size` is that of the control points, in mm, where they are what is left of larger ones.
        """
        spans = {cell: self.ground.span(cell) for _, cell in self.pieces}
        rows = self.ground.rows(self.pieces, self.point, spans)
        frame = differences(len(self.point))
        step = frame @ self.cycle.T @ frame.T
        basis = closure(rows @ frame.T, [step]) @ frame
        image, scale = _carried(self.lead, basis)
        return visible(basis, [self.cycle], drawn(control, image, size)), scale


def drawn(
    control: Float[np.ndarray, "points dim"], rows: Float[np.ndarray, "rows points"], size: float | None
) -> Float[np.ndarray, "rows dim"]:
    """What differences draw, in mm; 0 where it is nothing but rounding of control points of some size."""
    centred = control - control.mean(axis=0)
    found = rows @ centred
    small = np.linalg.norm(found) <= _RANK * np.linalg.norm(rows) * (size or np.linalg.norm(centred, 2))
    same = np.linalg.norm(centred) <= 1e-14 * np.linalg.norm(control)
    return found * 0.0 if small or same else found


def _carried(lead: Sequence[Operator], rows: np.ndarray) -> tuple[np.ndarray, float]:
    """`lead d` for differences d as rows, letter by letter, and the logarithm of the factor left out."""
    scale = 0.0
    for operator in reversed(lead):
        moved = rows @ operator.T
        moved = moved - moved.mean(axis=1, keepdims=True)
        size = float(np.linalg.norm(moved))
        if size <= _RANK * np.linalg.norm(operator, 2) * np.linalg.norm(rows):
            return moved * 0.0, 0.0
        rows, scale = moved / size, scale + float(np.log(size))
    return rows, scale
