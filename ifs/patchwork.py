"""Many pieces over one set of control points, glued where they use the same ones."""

from collections.abc import Iterator, Mapping

import numpy as np
from jaxtyping import Int, Real

from automata.symmetry import inverse
from automata.topology import Topology, embedding
from ifs.complex import Complex, Seen
from ifs.system import System

Rows = Int[np.ndarray, "_cells _points"]


class NotASelection(ValueError):
    """A boundary whose embedding mixes control points, so that no set of points names it."""

    def __init__(self, cell: str, label: str):
        self.cell = cell
        self.label = label
        super().__init__(
            f"the boundary {label!r} of cell {cell!r} is no selection of control points: pieces over common "
            "control points can be glued only along selections"
        )


def patchwork(
    topology: Topology,
    system: System,
    control: Real[np.ndarray, "control dim"],
    patches: Mapping[str, Rows],
) -> Complex:
    """The complex of pieces of several cells that draw on common control points.

    `control` is `(control, dim)` in millimetres; `patches[cell]` is `(pieces, points)`, the numbers of the
    control points of each piece. Two boundary cells of the same kind are one where they depend on the same
    control points in the same order, or in an order that a symmetry of that kind makes the same.
    Coordinates play no part. `refined` and `draw` go on from here.

    Raises `NotASelection`, and `ValueError` for an unknown cell, point numbers out of
    range, rows of the wrong length, or a cell that is at once a piece and a boundary.

    >>> import ifs
    >>> curve = ifs.shape("corner-cutting")
    >>> square = np.array([[0.0, 0], [9, 0], [9, 9], [0, 9]])
    >>> ring = np.array([[0, 1, 2], [1, 2, 3], [2, 3, 0], [3, 0, 1]])
    >>> closed = patchwork(curve.topology, curve.system, square, {"edge": ring})
    >>> ifs.draw(ifs.refined(closed, 2)).vertices.shape
    (16, 2)
    """
    control = np.asarray(control, dtype=float)
    _validate(topology, system, control, patches)
    rows: dict[str, Rows] = {}
    boundary: dict[str, dict[str, Seen]] = {}
    waiting: dict[str, list[tuple[str, str, Rows]]] = {}
    for cell in _from_large_to_small(topology):
        if cell in patches:
            if cell in waiting:
                raise ValueError(f"cell {cell!r} is a piece and also the boundary of another piece")
            rows[cell] = np.asarray(patches[cell], dtype=np.int64)
        elif cell in waiting:
            rows[cell] = _identified(topology, cell, waiting[cell], boundary)
        else:
            continue
        for label, border in topology.automaton.cells[cell].boundary.items():
            chosen = _selected(topology, cell, label)
            waiting.setdefault(border.cell, []).append((cell, label, rows[cell][:, chosen]))
    pieces = {cell: control[rows[cell]] for cell in patches}
    return Complex(topology, system, {cell: len(found) for cell, found in rows.items()}, boundary, pieces)


def _identified(
    topology: Topology,
    cell: str,
    parts: list[tuple[str, str, Rows]],
    boundary: dict[str, dict[str, Seen]],
) -> Rows:
    """The distinct cells among boundaries, and in `boundary` which one each of them is."""
    canonical, turns = _least_turned(topology, cell, np.concatenate([part for _, _, part in parts]))
    distinct, numbers = np.unique(canonical, axis=0, return_inverse=True)
    numbers = numbers.reshape(-1)
    start = 0
    for parent, label, part in parts:
        span = slice(start, start + len(part))
        boundary.setdefault(parent, {})[label] = Seen(numbers[span], turns[span])
        start += len(part)
    return distinct


def _least_turned(topology: Topology, cell: str, rows: Rows) -> tuple[Rows, Int[np.ndarray, "_cells"]]:
    """Each row turned by the symmetry that makes it lexicographically least: `row[j] = least[turn[j]]`."""
    least = rows.copy()
    turns = np.zeros(len(rows), dtype=np.int64)
    for number, element in enumerate(topology.groups.elements[cell]):
        turned = rows[:, list(inverse(element))]
        differs = turned != least
        first = differs.argmax(axis=1)
        index = np.arange(len(rows))
        less = differs.any(axis=1) & (turned[index, first] < least[index, first])
        least[less], turns[less] = turned[less], number
    return least, turns


def _from_large_to_small(topology: Topology) -> Iterator[str]:
    """The cells, each before the cells of its boundaries."""
    cells = topology.automaton.cells
    rest = dict.fromkeys(cells)
    while rest:
        borders = {border.cell for cell in rest for border in cells[cell].boundary.values()}
        for cell in [cell for cell in rest if cell not in borders]:
            del rest[cell]
            yield cell


def _selected(topology: Topology, cell: str, label: str) -> list[int]:
    columns = embedding(topology.automaton, cell, (label,))
    if any(len(column) != 1 or column[0][1] != 1 for column in columns):
        raise NotASelection(cell, label)
    return [column[0][0] for column in columns]


def _validate(
    topology: Topology, system: System, control: np.ndarray, patches: Mapping[str, np.ndarray]
) -> None:
    if control.ndim != 2 or not np.isfinite(control).all():
        raise ValueError("control points are rows of finite numbers of millimetres")
    for cell, found in patches.items():
        if cell not in system.states:
            raise ValueError(f"there is no cell {cell!r}; there are {', '.join(system.states)}")
        points = topology.automaton.cells[cell].points
        if np.ndim(found) != 2 or np.shape(found)[1] != points:
            raise ValueError(f"a piece of cell {cell!r} has {points} control points, found {np.shape(found)}")
        wrong = np.argwhere((np.asarray(found) < 0) | (np.asarray(found) >= len(control)))
        if len(wrong):
            raise ValueError(f"piece {wrong[0][0]} of cell {cell!r} names a control point that is not there")
