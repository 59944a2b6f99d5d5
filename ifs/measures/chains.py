"""Curves as chains of pieces: in which order, and which way round, a curve runs through its sub-cells."""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from automata.topology import Topology, embedding
from ifs.measures.moments import barycentric_moments
from ifs.measures.operators import Number, Operators
from ifs.shape import Shape

Column = tuple[Number, ...]


class NoChain(ValueError):
    """A cell that is no curve from one point to another through pieces that join end to end."""


@dataclass(frozen=True)
class Chain:
    """The two ends of a curve (labels of its boundary), and its pieces with whether they run forwards."""

    start: str
    end: str
    links: tuple[tuple[str, bool], ...]


def chains(shape: Shape) -> Mapping[str, Chain]:
    """The chains of the shape's cell and of all cells that its pieces are.

    Raises `NoChain` for a boundary that is not two points, and for pieces that do not join end to end.

    >>> from ifs.shape import shape
    >>> chains(shape("koch-curve"))["edge"].links
    (('0', True), ('1', True), ('2', True), ('3', True))
    """
    names = [shape.automaton.shape]
    for name in names:
        targets = shape.automaton.cells[name].subdivision.values()
        names.extend(target for target in dict.fromkeys(targets) if target not in names)
    ends = {name: _ends(shape.topology, name) for name in names}
    return {name: _chain(shape.topology, name, ends) for name in names}


def end_columns(shape: Shape, operators: Operators, cell: str) -> tuple[Column, Column]:
    """The start and the end of a curve in barycentric coordinates: `B c`, c the point that the vertex is.

    >>> from ifs.measures.operators import operators
    >>> from ifs.shape import shape
    >>> curve = shape("corner-cutting")
    >>> [str(x) for x in end_columns(curve, operators(curve), "edge")[0]]
    ['1/2', '1/2', '0']
    """
    start, end = (_column(shape, operators, cell, label) for label in _ends(shape.topology, cell))
    return start, end


def _ends(topology: Topology, cell: str) -> tuple[str, str]:
    boundary = topology.automaton.cells[cell].boundary
    if len(boundary) != 2 or not all(topology.is_point(border.cell) for border in boundary.values()):
        found = ", ".join(f"{label} = {border.cell}" for label, border in boundary.items()) or "nothing"
        raise NoChain(f"cell {cell!r} is no curve between two points: its boundary is {found}")
    start, end = boundary
    return start, end


def _chain(topology: Topology, cell: str, ends: Mapping[str, tuple[str, str]]) -> Chain:
    cells = topology.automaton.cells
    place = topology.subdivided(cell).place
    start, end = ends[cell]
    here, goal = (
        place[label, next(iter(cells[cells[cell].boundary[label].cell].subdivision))][0]
        for label in (start, end)
    )
    nodes = {
        label: tuple(place[label, side][0] for side in ends[target])
        for label, target in cells[cell].subdivision.items()
    }
    links: list[tuple[str, bool]] = []
    while len(links) < len(nodes):
        left = {label: pair for label, pair in nodes.items() if label not in dict(links)}
        label = next((label for label, pair in left.items() if here in pair), None)
        if label is None:
            break
        forward = left[label][0] == here
        links.append((label, forward))
        here = left[label][1 if forward else 0]
    if len(links) != len(nodes) or here != goal:
        walked = " ".join(label for label, _ in links) or "nothing"
        raise NoChain(
            f"cell {cell!r}: walking from {start!r} to {end!r} passes {walked}, not all of "
            f"{' '.join(nodes)} in a chain; state which ends of which pieces are adjacent"
        )
    return Chain(start, end, tuple(links))


def _column(shape: Shape, operators: Operators, cell: str, label: str) -> Column:
    vertex = shape.automaton.cells[cell].boundary[label].cell
    used = [vertex]
    for name in used:
        used.extend(target for target, _ in operators[name].values() if target not in used)
    table = barycentric_moments({name: operators[name] for name in used}, 1)[vertex]
    width = shape.automaton.cells[vertex].points
    known = [table[tuple(int(k == j) for k in range(width - 1))] for j in range(width - 1)]
    point = [*known, 1 - sum(known, Fraction(0))]
    column: list[Number] = [Fraction(0)] * shape.automaton.cells[cell].points
    for weight, entries in zip(point, embedding(shape.automaton, cell, (label,)), strict=True):
        for row, value in entries:
            column[row] += weight * value
    return tuple(column)
