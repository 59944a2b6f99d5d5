"""The unknown entries of an automaton's operators, and the operators as matrices of affine forms."""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

from automata import Automaton
from automata.automaton import Rows, Word
from automata.expression import Number
from subdivision.form import ONE, Columns, Form, constant


class Entry(NamedTuple):
    """One entry of an operator; its text is `cell.label[row,column]`."""

    cell: str
    label: str
    row: int
    column: int

    def __str__(self) -> str:
        return f"{self.cell}.{self.label}[{self.row},{self.column}]"


@dataclass(frozen=True)
class Unknowns:
    """The unknowns of an automaton in the order in which they are named: the shape's operators first, each by
    columns. `operators` holds the matrices, `(cell, label)` to columns of forms."""

    entries: tuple[Entry, ...]
    operators: dict[tuple[str, str], Columns]

    def diagonal(self, unknown: int) -> bool:
        entry = self.entries[unknown]
        return entry.row == entry.column


def unknowns(automaton: Automaton) -> Unknowns:
    """Number the entries of every operator and lay out the known embeddings and symmetries."""
    entries: list[Entry] = []
    operators: dict[tuple[str, str], Columns] = {}
    for cell in _in_order(automaton):
        for label, target in cell.subdivision.items():
            columns: Columns = []
            for column in range(automaton.cells[target].points):
                start = len(entries)
                entries.extend(Entry(cell.name, label, row, column) for row in range(cell.points))
                columns.append({row: {start + row: Fraction(1)} for row in range(cell.points)})
            operators[cell.name, label] = columns
        for label, boundary in cell.boundary.items():
            operators[cell.name, label] = _columns(boundary.matrix)
        for label, symmetry in cell.symmetry.items():
            operators[cell.name, label] = [{row: ONE} for row in symmetry.points]
    return Unknowns(tuple(entries), operators)


def with_given(automaton: Automaton, table: Unknowns) -> Unknowns:
    """The same with the entries that the description gives as constants in place of unknowns."""
    operators = dict(table.operators)
    for cell in automaton.cells.values():
        for label, rows in cell.matrices.items():
            operators[cell.name, label] = [
                {row: form for row, line in enumerate(rows) if (form := _entry(line[j], column[row]))}
                for j, column in enumerate(operators[cell.name, label])
            ]
    return Unknowns(table.entries, operators)


def _entry(given, unknown: Form) -> Form:
    return constant(given.value) if isinstance(given, Number) else unknown


def _in_order(automaton: Automaton) -> Iterator:
    reachable = automaton.reachable()
    yield from (automaton.cells[name] for name in reachable)
    yield from (cell for name, cell in automaton.cells.items() if name not in reachable)


def _columns(rows: Rows) -> Columns:
    return [
        {row: constant(_known(line[column])) for row, line in enumerate(rows) if _known(line[column])}
        for column in range(len(rows[0]))
    ]


def _known(entry) -> Fraction:
    if not isinstance(entry, Number):
        raise NotImplementedError("embeddings are given as numbers")
    return entry.value


def factors(automaton: Automaton, cell: str, word: Word, table: Unknowns) -> list[Columns]:
    """The matrices of a path, from the left."""
    result = []
    for label in word:
        result.append(table.operators[cell, label])
        target = automaton.target(cell, label)
        assert target is not None
        cell = target
    return result
