"""The curves that can be differentiated: one cell, cut into copies of itself from its start to its end."""

from dataclasses import dataclass
from functools import cached_property, reduce

import numpy as np
from jaxtyping import Float

from fld.error import NotACurve
from fld.scale import require_scale
from ifs import Box, Shape, bounds
from ifs.asked import require_shape
from ifs.system import Operator, System

Column = Float[np.ndarray, "points"]


@dataclass(frozen=True)
class Curve:
    """A curve as its pieces in the order in which it runs through them.

    `operators[k]` belongs to `labels[k]`; `control` is `(points, dim)` in millimetres.
    """

    cell: str
    labels: tuple[str, ...]
    operators: tuple[Operator, ...]
    control: Float[np.ndarray, "points dim"]
    system: System

    @cached_property
    def box(self) -> Box:
        """A barycentric box around the attractor, worked out when first asked for."""
        return bounds(self.system)[self.cell]

    def operator(self, word: tuple[str, ...]) -> Operator:
        """`T_w = T_w1 … T_wp`; the identity for the empty word."""
        parts = [self.operators[self.labels.index(label)] for label in word]
        return reduce(np.matmul, parts, np.eye(len(self.control)))


def curve(shape: Shape) -> Curve:
    """The curve that a shape is.

    Its boundary, in the order of the description, is its start and its end; the order of the pieces is
    read from the gluing, whatever their labels. Raises `NotACurve` when the boundary is not two points, when
    a sub-cell is another cell, and when the sub-cells do not form a chain (or run backwards in it);
    `OutOfScale` for control points too large or too small to compute with.

    >>> import ifs
    >>> curve(ifs.shape("koch-curve")).labels
    ('0', '1', '2', '3')
    """
    require_shape(shape)
    require_scale(shape.control)
    state = shape.system.states[shape.system.shape]
    boundary = tuple(shape.automaton.cells[state.name].boundary.items())
    if len(boundary) != 2 or not all(shape.topology.is_point(border.cell) for _, border in boundary):
        found = ", ".join(f"{label} = {border.cell}" for label, border in boundary) or "nothing"
        raise NotACurve(state.name, f"its boundary is {found}")
    foreign = [label for label, cell in zip(state.labels, state.targets, strict=True) if cell != state.name]
    if foreign:
        other = state.targets[state.labels.index(foreign[0])]
        raise NotACurve(state.name, f"sub-cell {foreign[0]!r} is a {other!r}")
    labels = _chain(shape, state.name, state.labels)
    operators = tuple(state.operators[state.labels.index(label)] for label in labels)
    return Curve(state.name, labels, operators, shape.control, shape.system)


def fixed_point(operator: Operator) -> Column:
    """The barycentric column with `T p = p` and coordinates that sum to 1."""
    size = len(operator)
    system = np.vstack([np.eye(size) - operator, np.ones(size)])
    return np.linalg.lstsq(system, np.eye(size + 1)[-1], rcond=None)[0]


def _chain(shape: Shape, cell: str, labels: tuple[str, ...]) -> tuple[str, ...]:
    """The sub-cells from the start of the curve to its end."""
    cells = shape.automaton.cells
    (start, first), (end, last) = cells[cell].boundary.items()
    place = shape.topology.subdivided(cell).place
    begins = {place[label, start][0]: label for label in labels}
    here = place[start, next(iter(cells[first.cell].subdivision))][0]
    goal = place[end, next(iter(cells[last.cell].subdivision))][0]
    found: list[str] = []
    while here in begins and begins[here] not in found:
        found.append(begins[here])
        here = place[found[-1], end][0]
    if len(found) != len(labels) or here != goal or len(labels) < 2:
        walked = " ".join(found) or "nothing"
        raise NotACurve(
            cell,
            f"walking from {start!r} by {end!r} to {start!r} passes {walked}, not all of {' '.join(labels)}",
        )
    return tuple(found)
