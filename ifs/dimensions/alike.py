"""Automata that are glued alike: the same labels, and the same boundaries shared, cell by cell.

Points may differ in number and operators in value. What counts is that an address means the same place in all
of them, so that points found at one address can be combined. Source: Gentil 2010, §5.1.2.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

import subdivision
from automata import Automaton
from automata.automaton import Cell, Word
from automata.expression import Number
from automata.topology import Topology

Matrix = Sequence[Sequence[Fraction]]
Cells = tuple[str, ...]
"""One cell of each automaton."""


class DifferentGluing(ValueError):
    """Two automata that are not glued alike; `cells` names the cell of each, `word` what is different."""

    def __init__(self, names: tuple[str, str], cells: tuple[str, str], word: str, difference: str):
        self.names = names
        self.cells = cells
        self.word = word
        super().__init__(
            f"{names[0]!r} and {names[1]!r} are not glued alike: at cells {cells[0]!r} and {cells[1]!r}, "
            f"{difference}. Shapes are mixed address by address, which needs the same labels and equations"
        )


@dataclass(frozen=True)
class Factor:
    """One of several automata, with its gluing and all its matrices as exact numbers by cell and label."""

    topology: Topology
    matrices: Mapping[str, Mapping[str, Matrix]]

    @property
    def automaton(self) -> Automaton:
        return self.topology.automaton

    @property
    def name(self) -> str:
        return self.automaton.name

    def cell(self, name: str) -> Cell:
        return self.automaton.cells[name]


def factor(automaton: Automaton) -> Factor:
    """The gluing and the exact matrices of an automaton.

    Raises `subdivision.Undetermined` for parameters without a value.
    """
    topology = Topology(automaton)
    solved = subdivision.solve(automaton).numbers()
    matrices = {}
    for name, cell in topology.automaton.cells.items():
        known = {
            label: [[entry.value for entry in row if isinstance(entry, Number)] for row in end.matrix]
            for label, end in cell.boundary.items()
        }
        matrices[name] = {**known, **solved[name]}
    return Factor(topology, matrices)


def alike(factors: Sequence[Factor]) -> tuple[Cells, ...]:
    """The cells that correspond, one tuple for each combination that an address or a boundary meets.

    The first tuple holds the shapes. Raises `DifferentGluing` with the first label, or pair of paths, that
    one automaton has (or glues) and another has not.

    >>> from subdivision.schemes import bezier, takagi
    >>> alike([factor(bezier(2)), factor(takagi())])
    (('edge', 'edge'), ('vertex', 'vertex'))
    """
    found: list[Cells] = [tuple(one.automaton.shape for one in factors)]
    for cells in found:
        for other in range(1, len(factors)):
            _require_labels(factors[0], cells[0], factors[other], cells[other])
        first = factors[0].cell(cells[0])
        for label in (*first.subdivision, *first.boundary):
            after = tuple(_target(one, cell, label) for one, cell in zip(factors, cells, strict=True))
            if after not in found:
                found.append(after)
    for cells in found:
        for other in range(1, len(factors)):
            _require_partition(factors[0], cells[0], factors[other], cells[other])
    return tuple(found)


def _target(one: Factor, cell: str, label: str) -> str:
    target = one.automaton.target(cell, label)
    assert target is not None
    return target


def _require_labels(one: Factor, cell: str, other: Factor, facing: str) -> None:
    names, cells = (one.name, other.name), (cell, facing)
    for kind, what in (("subdivision", "sub-cell"), ("boundary", "boundary")):
        mine, theirs = getattr(one.cell(cell), kind), getattr(other.cell(facing), kind)
        for label in (*mine, *theirs):
            if label not in mine or label not in theirs:
                has, lacks = names if label in mine else names[::-1]
                difference = f"{has!r} has the {what} {label!r}, which {lacks!r} lacks"
                raise DifferentGluing(names, cells, label, difference)


def _require_partition(one: Factor, cell: str, other: Factor, facing: str) -> None:
    """The same paths name the same boundaries after one subdivision."""
    mine, theirs = (f.topology.subdivided(c).place for f, c in ((one, cell), (other, facing)))
    names = (one.name, other.name)
    for place, missing, has, lacks in ((mine, theirs, *names), (theirs, mine, *names[::-1])):
        for word, (standing, _) in place.items():
            if word not in missing or missing[word][0] != missing[standing][0]:
                text = f"{' '.join(word)} = {' '.join(standing)}"
                raise DifferentGluing(
                    names, (cell, facing), text, f"{text!r} holds in {has!r} and not in {lacks!r}"
                )


def same_partition(place: Mapping[Word, tuple], other: Mapping[Word, tuple]) -> bool:
    """Whether two gluings of the same paths make the same of them one."""
    pairs = {(found[0], other[word][0]) for word, found in place.items()}
    return len(pairs) == len({a for a, _ in pairs}) == len({b for _, b in pairs})
