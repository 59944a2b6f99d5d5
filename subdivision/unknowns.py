"""The unknown entries of an automaton's operators, and the operators as matrices of affine forms."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

from automata import Automaton
from automata.automaton import Rows, Word
from subdivision.coefficients import is_number, open_parameters, reader
from subdivision.form import ONE, Columns, Form, constant, is_constant


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
    columns. `operators` holds the matrices, `(cell, label)` to columns of forms; `points` the sizes."""

    entries: tuple[Entry, ...]
    operators: dict[tuple[str, str], Columns]
    points: dict[str, int]

    def diagonal(self, unknown: int) -> bool:
        entry = self.entries[unknown]
        return entry.row == entry.column

    def selects(self, cell: str, label: str) -> bool:
        """Whether an embedding is known in numbers, which the description's reader has checked."""
        return all(
            is_constant(form) and all(is_number(value) for value in form.values())
            for column in self.operators[cell, label]
            for form in column.values()
        )


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
                columns.append({row: {start + row: 1} for row in range(cell.points)})
            operators[cell.name, label] = columns
        for label, symmetry in cell.symmetry.items():
            operators[cell.name, label] = [{row: ONE} for row in symmetry.points]
    read = reader(open_parameters(automaton))
    for cell in _in_order(automaton):
        for label, boundary in cell.boundary.items():
            operators[cell.name, label] = _embedding(cell.name, label, boundary.matrix, read, entries)
    points = {name: cell.points for name, cell in automaton.cells.items()}
    return Unknowns(tuple(entries), operators, points)


def _embedding(cell: str, label: str, rows: Rows, read: Callable, entries: list[Entry]) -> Columns:
    """The columns of an embedding; entries that are not given join the unknowns, after all others."""
    columns: Columns = []
    for j in range(len(rows[0])):
        column: dict[int, Form] = {}
        for i, row in enumerate(rows):
            given = row[j]
            if given is None:
                column[i] = {len(entries): 1}
                entries.append(Entry(cell, label, i, j))
            elif form := constant(read(given)):
                column[i] = form
        columns.append(column)
    return columns


def _in_order(automaton: Automaton) -> Iterator:
    reachable = automaton.reachable()
    yield from (automaton.cells[name] for name in reachable)
    yield from (cell for name, cell in automaton.cells.items() if name not in reachable)


def factors(automaton: Automaton, cell: str, word: Word, table: Unknowns) -> list[Columns]:
    """The matrices of a path, from the left."""
    result = []
    for label in word:
        result.append(table.operators[cell, label])
        target = automaton.target(cell, label)
        assert target is not None
        cell = target
    return result
