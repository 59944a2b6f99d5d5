"""Everything that an automaton requires of its operators, as groups of equations with the user's words."""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce

from automata import Automaton, Cell, Equation
from automata.expression import Number
from subdivision.form import CONSTANT, Columns, Form, Product, difference, matmul
from subdivision.unknowns import Unknowns, factors, with_given


@dataclass(frozen=True)
class Constraint:
    """One statement about the operators: its words, and the forms that it makes zero."""

    text: str
    forms: tuple[Form, ...]


def constraints(automaton: Automaton, table: Unknowns) -> tuple[list[Constraint], list[str]]:
    """All constraints, and the texts of those that are not linear.

    Stated incidence and adjacency, what declared symmetries imply, given matrices, and unit column sums.
    """
    given = with_given(automaton, table)
    linear: list[Constraint] = []
    products: list[str] = []
    for cell in automaton.cells.values():
        for equation in (*cell.equations, *cell.symmetry_equations()):
            text = f"{cell.name}: {equation.text}"
            try:
                linear.append(Constraint(text, tuple(_residual(automaton, cell, equation, table))))
                continue
            except Product:
                pass
            try:
                linear.append(Constraint(text, tuple(_residual(automaton, cell, equation, given))))
            except Product:
                products.append(text)
        linear.extend(_given(cell, table))
        linear.extend(_sums(cell, table))
    return linear, products


def _residual(automaton: Automaton, cell: Cell, equation: Equation, table: Unknowns) -> list[Form]:
    sides: list[Columns] = [
        reduce(matmul, factors(automaton, cell.name, word, table)) for word in (equation.left, equation.right)
    ]
    return difference(*sides)


def _given(cell: Cell, table: Unknowns) -> Iterator[Constraint]:
    for label, rows in cell.matrices.items():
        columns = table.operators[cell.name, label]
        forms = []
        for i, row in enumerate(rows):
            for j, entry in enumerate(row):
                if isinstance(entry, Number):
                    forms.append({**columns[j][i], CONSTANT: -entry.value})
        text = f"{cell.name}: the matrix given for {label}"
        yield Constraint(text, tuple({k: v for k, v in form.items() if v} for form in forms))


def _sums(cell: Cell, table: Unknowns) -> Iterator[Constraint]:
    for label in cell.subdivision:
        columns = table.operators[cell.name, label]
        forms = tuple(
            {**{key: Fraction(1) for form in column.values() for key in form}, CONSTANT: Fraction(-1)}
            for column in columns
        )
        yield Constraint(f"{cell.name}: the columns of {label} sum to 1", forms)
