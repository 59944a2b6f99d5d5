"""Parameters of a piece: where its sub-pieces lie in the unit interval, square or triangle.

A curve piece runs over [0, 1]. A quadrangle is the unit square, its corners in order at (0, 0), (1, 0),
(1, 1) and (0, 1); a triangle has its corners at (0, 0), (1, 0) and (0, 1). The sub-pieces are placed by the
gluing alone: the parts of a side are equally long, and a vertex born inside lies at the mean of its
neighbours. That gives n by n squares and n^2 triangles their usual places.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from jaxtyping import Float

from automata.automaton import Word
from automata.topology import Topology
from ifs.drawing import corner_paths

_FINEST = 1000  # the largest denominator of a parameter of a vertex
_NEAR = 1e-9

REFERENCE: Mapping[int, tuple[tuple[float, ...], ...]] = {
    2: ((0.0,), (1.0,)),
    3: ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)),
    4: ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)),
}
"""The parameters of the corners of a curve, a triangle and a quadrangle."""

Parameters = Float[np.ndarray, "_directions"]


class NotParametrised(ValueError):
    """A cell whose pieces are no curves, triangles or quadrangles cut into the like."""

    def __init__(self, cell: str, reason: str):
        self.cell = cell
        super().__init__(f"cell {cell!r} has no parameters: {reason}")


@dataclass(frozen=True)
class Side:
    """The side of a face from corner k to the next: the boundary label, its cell, and whether it runs so."""

    label: str
    cell: str
    forward: bool


@dataclass(frozen=True)
class Part:
    """A sub-piece: its parameters t lie at `origin + axes @ t` in its parent.

    `corners` are the vertices at its corners, as the parent's words for them.
    """

    cell: str
    origin: Parameters
    axes: Float[np.ndarray, "_directions _directions"]
    corners: tuple[Word, ...]


@dataclass(frozen=True)
class Frame:
    """The corners of a cell, as boundary paths in order around it, its sides and its sub-pieces.

    `kept[k]` says which sub-piece has corner k, and which corner it is there. `vertices` gives the
    parameters of every vertex of the sub-pieces.
    """

    corners: tuple[Word, ...]
    sides: tuple[Side, ...]
    parts: tuple[Part, ...]
    kept: tuple[tuple[int, int], ...]
    vertices: Mapping[Word, Parameters]

    @property
    def reference(self) -> Float[np.ndarray, "corners directions"]:
        return np.array(REFERENCE[len(self.corners)])


def frames(topology: Topology, cells: Iterable[str]) -> Mapping[str, Frame]:
    """The frames of the given cells, of all that they become, and of their sides.

    The corners come in the order in which `draw` lists them. Raises `NotParametrised` for cells that are no
    curves, triangles or quadrangles, or whose sub-pieces are not placed by an affine map.

    >>> from ifs.shape import shape
    >>> found = frames(shape("catmull-clark-patch").topology, ["face"])["face"]
    >>> [part.origin.tolist() for part in found.parts]
    [[0.0, 0.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]]
    """
    result: dict[str, Frame] = {}
    waiting = list(cells)
    while waiting:
        cell = waiting.pop()
        if cell in result:
            continue
        corners = _corners(topology, cell)
        sides = _sides(topology, cell, corners) if len(corners) > 2 else ()
        for side in sides:
            if side.cell not in result:
                result |= frames(topology, [side.cell])
        result[cell] = _frame(topology, cell, corners, sides, result)
        waiting.extend(topology.automaton.cells[cell].subdivision.values())
    return result


def _corners(topology: Topology, cell: str) -> tuple[Word, ...]:
    corners = corner_paths(topology, cell)
    if len(corners) not in REFERENCE:
        raise NotParametrised(cell, f"it has {len(corners)} corners; 2, 3 or 4 are read")
    figure = topology.automaton.cells[cell].figure
    if (
        len(corners) > 2
        and figure
        and len(figure.faces) == 1
        and sorted(figure.faces[0]) == list(range(len(corners)))
    ):
        return tuple(corners[i] for i in figure.faces[0])
    return corners


def _sides(topology: Topology, cell: str, corners: tuple[Word, ...]) -> tuple[Side, ...]:
    coincident = topology.coincident(cell)
    found: dict[tuple[Word, Word], Side] = {}
    for label, border in topology.automaton.cells[cell].boundary.items():
        inner = corner_paths(topology, border.cell)
        if len(inner) == 2:
            first, last = (coincident[label, *path][0] for path in inner)
            found[first, last] = Side(label, border.cell, True)
            found[last, first] = Side(label, border.cell, False)
    pairs = list(zip(corners, (*corners[1:], corners[0]), strict=True))
    if any(pair not in found for pair in pairs):
        raise NotParametrised(cell, "its sides, from corner to corner, are not among its boundaries")
    return tuple(found[pair] for pair in pairs)


def _frame(
    topology: Topology,
    cell: str,
    corners: tuple[Word, ...],
    sides: tuple[Side, ...],
    known: Mapping[str, Frame],
) -> Frame:
    place = topology.subdivided(cell).place
    ends = [place[*path, *_only(topology, topology.automaton.end(cell, path))][0] for path in corners]
    reference = np.array(REFERENCE[len(corners)])
    fixed = dict(zip(ends, reference, strict=True))
    for k, side in enumerate(sides):
        start, end = reference[k], reference[(k + 1) % len(corners)]
        for word, (t,) in known[side.cell].vertices.items():
            if 0 < t < 1:
                fixed[place[side.label, *word][0]] = start + (t if side.forward else 1 - t) * (end - start)
    subdivision = topology.automaton.cells[cell].subdivision
    faces = {
        label: tuple(place[label, *path][0] for path in _corners(topology, target))
        for label, target in subdivision.items()
    }
    vertices = _placed(cell, fixed, list(faces.values()))
    parts = tuple(_part(cell, subdivision[label], face, vertices) for label, face in faces.items())
    kept = tuple(_keeper(cell, end, parts) for end in ends)
    return Frame(corners, sides, parts, kept, vertices)


def _only(topology: Topology, vertex: str) -> tuple[str, ...]:
    return tuple(topology.automaton.cells[vertex].subdivision)


def _placed(
    cell: str, fixed: dict[Word, Parameters], faces: list[tuple[Word, ...]]
) -> dict[Word, Parameters]:
    """The parameters of all vertices: those not fixed lie at the mean of their neighbours."""
    names = list(dict.fromkeys([*fixed, *(word for face in faces for word in face)]))
    number = {word: i for i, word in enumerate(names)}
    joined = np.zeros((len(names), len(names)))
    for face in faces:
        for one, other in zip(face, (*face[1:], face[0]), strict=True):
            joined[number[one], number[other]] = joined[number[other], number[one]] = 1
    inside = np.arange(len(fixed), len(names))
    result = np.zeros((len(names), len(next(iter(fixed.values())))))
    result[: len(fixed)] = list(fixed.values())
    if len(inside):
        laplacian = np.diag(joined.sum(axis=1)) - joined
        try:
            solved = np.linalg.solve(
                laplacian[np.ix_(inside, inside)], joined[inside, : len(fixed)] @ result[: len(fixed)]
            )
        except np.linalg.LinAlgError:
            raise NotParametrised(cell, "some sub-pieces do not hang together with its sides") from None
        result[inside] = [[_simple(value) for value in row] for row in solved]
    return dict(zip(names, result, strict=True))


def _simple(value: float) -> float:
    return float(Fraction(value).limit_denominator(_FINEST))


def _part(cell: str, target: str, face: tuple[Word, ...], vertices: Mapping[Word, Parameters]) -> Part:
    corners = np.stack([vertices[word] for word in face])
    reference = np.array(REFERENCE[len(face)])
    if reference.shape[1] != corners.shape[1]:
        raise NotParametrised(cell, f"it is cut into {target!r}, of another dimension")
    spanning = [corners[1], corners[-1]][: corners.shape[1]]
    axes = np.stack([corner - corners[0] for corner in spanning], axis=1)
    if np.abs(corners[0] + reference @ axes.T - corners).max() > _NEAR or abs(np.linalg.det(axes)) < _NEAR:
        raise NotParametrised(cell, f"a sub-piece {target!r} is no affine image of a whole one")
    return Part(target, corners[0], axes, face)


def _keeper(cell: str, end: Word, parts: tuple[Part, ...]) -> tuple[int, int]:
    found = [(i, part.corners.index(end)) for i, part in enumerate(parts) if end in part.corners]
    if len(found) != 1:
        raise NotParametrised(cell, f"{len(found)} sub-pieces meet at one of its corners; 1 is read")
    return found[0]
