"""One level of the unfolded automaton: sub-cells, boundaries, and which of their paths meet.

Source: Gentil 2010, section 4.3.1, figure 4.10, "Le déroulement de l'automate".
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

from automata.automaton import Automaton, Word
from automata.symmetry import Permutation
from automata.topology import Topology


@dataclass(frozen=True)
class Node:
    """A cell at the end of a path from the unfolded cell; the empty path is that cell itself."""

    path: Word
    cell: str


@dataclass(frozen=True)
class Arrow:
    """A label that continues a path: into a sub-cell ("subdivision") or onto a boundary ("boundary")."""

    start: Word
    end: Word
    kind: Literal["subdivision", "boundary"]

    @property
    def label(self) -> str:
        return self.end[-1]


@dataclass(frozen=True)
class Pair:
    """Two paths that are the same cell: `left = right symmetry`.

    "incidence": a sub-cell of a boundary is a boundary of a sub-cell. "adjacency": two sub-cells share
    a boundary. `symmetry` holds the names of symmetries that follow the right path, none as a rule.
    """

    left: Word
    right: Word
    kind: Literal["incidence", "adjacency"]
    symmetry: Word


@dataclass(frozen=True)
class Unfolding:
    """One cell, its sub-cells and boundaries, their boundaries and sub-cells, and the pairs among these."""

    cell: str
    nodes: tuple[Node, ...]
    arrows: tuple[Arrow, ...]
    pairs: tuple[Pair, ...]


def unfolding(automaton: Automaton, cell: str | None = None) -> Unfolding:
    """The unfolding of a cell, the shape's if none is named, by one level.

    The pairs are those that the stated constraints, the symmetries and coinciding embeddings bring about, so
    that a pair which only follows from others is here too. Raises `AutomatonError` for gluing that does not
    fit, `KeyError` for an unknown cell.

    >>> import automata
    >>> found = unfolding(automata.read("corner-cutting"))
    >>> [" ".join(pair.left) + " = " + " ".join(pair.right) for pair in found.pairs]
    ['left s = 0 left', 'right s = 1 right', '0 right = 1 left']
    """
    name = automaton.shape if cell is None else cell
    topology = Topology(automaton)
    arrows = tuple(_arrows(automaton, name))
    nodes = (Node((), name), *(Node(arrow.end, automaton.end(name, arrow.end)) for arrow in arrows))
    return Unfolding(name, nodes, arrows, tuple(_pairs(automaton, topology, name, nodes)))


def _arrows(automaton: Automaton, cell: str) -> Iterator[Arrow]:
    """The first level, then the second: sub-cells of boundaries and boundaries of sub-cells."""
    here = automaton.cells[cell]
    yield from (Arrow((), (label,), "boundary") for label in here.boundary)
    yield from (Arrow((), (label,), "subdivision") for label in here.subdivision)
    for label, boundary in here.boundary.items():
        inner = automaton.cells[boundary.cell].subdivision
        yield from (Arrow((label,), (label, sub), "subdivision") for sub in inner)
    for label, target in here.subdivision.items():
        outer = automaton.cells[target].boundary
        yield from (Arrow((label,), (label, side), "boundary") for side in outer)


def _pairs(automaton: Automaton, topology: Topology, cell: str, nodes: tuple[Node, ...]) -> Iterator[Pair]:
    place = topology.subdivided(cell).place
    own = automaton.cells[cell].boundary
    classes: dict[Word, list[Word]] = {}
    for node in nodes:
        if len(node.path) == 2:
            classes.setdefault(place[node.path][0], []).append(node.path)
    for kind in ("incidence", "adjacency"):
        for paths in classes.values():
            inherited = [path for path in paths if path[0] in own]
            inner = [path for path in paths if path[0] not in own]
            if kind == "incidence" and inherited:
                chosen = [(inherited[0], path) for path in inner]
            elif kind == "adjacency" and not inherited:
                chosen = list(pairwise(inner))
            else:
                continue
            for left, right in chosen:
                turn = _between(place[left][1], place[right][1])
                yield Pair(left, right, kind, _named(automaton, automaton.end(cell, left), turn))


def _between(left: Permutation, right: Permutation) -> Permutation:
    """The element g with `left path = right path g`, both given as `class element`."""
    inverse = [0] * len(right)
    for i, image in enumerate(right):
        inverse[image] = i
    return tuple(inverse[i] for i in left)


def _named(automaton: Automaton, cell: str, element: Permutation) -> Word:
    """A shortest product of the cell's symmetries that is the element."""
    identity = tuple(range(len(element)))
    known = automaton.cells[cell].symmetry
    found: dict[Permutation, Word] = {identity: ()}
    queue = [identity]
    for product in queue:
        if product == element:
            break
        for name, symmetry in known.items():
            longer = tuple(product[i] for i in symmetry.points)
            if longer not in found:
                found[longer] = (*found[product], name)
                queue.append(longer)
    return found.get(element, ())
