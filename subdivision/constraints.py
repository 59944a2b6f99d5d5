"""Everything that an automaton requires of its operators, as groups of equations with the user's words."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import reduce

from automata import Automaton, Cell, Equation
from subdivision.coefficients import open_parameters, reader
from subdivision.form import CONSTANT, Columns, Form, Product, add, constant, difference, matmul
from subdivision.unknowns import Unknowns, factors


@dataclass(frozen=True)
class Constraint:
    """One statement about the operators: its words, and the forms that it makes zero."""

    text: str
    forms: tuple[Form, ...]


@dataclass(frozen=True)
class Statement:
    """An equation that multiplies unknowns with each other, so that it is linear only once some are known."""

    text: str
    cell: str
    equation: Equation

    def constraint(self, automaton: Automaton, operators: Unknowns) -> Constraint | None:
        """The linear constraint that it is with these operators, or None while it still is none."""
        try:
            return Constraint(self.text, tuple(_residual(automaton, self.cell, self.equation, operators)))
        except Product:
            return None


def constraints(automaton: Automaton, table: Unknowns) -> tuple[list[Constraint], list[Statement]]:
    """The linear constraints, and the equations that are not linear.

    Stated incidence and adjacency, what declared symmetries imply, given matrices, and unit column sums.
    """
    linear: list[Constraint] = []
    products: list[Statement] = []
    for cell in automaton.cells.values():
        for equation in (*cell.equations, *cell.coherence, *cell.symmetry_equations()):
            statement = Statement(f"{cell.name}: {equation.text}", cell.name, equation)
            found = statement.constraint(automaton, table)
            if found is None:
                products.append(statement)
            else:
                linear.append(found)
        linear.extend(_given(automaton, cell, table))
        linear.extend(_sums(cell, table))
    return linear, products


def _residual(automaton: Automaton, cell: str, equation: Equation, table: Unknowns) -> list[Form]:
    sides: list[Columns] = [
        reduce(matmul, factors(automaton, cell, word, table)) for word in (equation.left, equation.right)
    ]
    return difference(*sides)


def _given(automaton: Automaton, cell: Cell, table: Unknowns) -> Iterator[Constraint]:
    read = reader(open_parameters(automaton)) if cell.matrices else None
    for label, rows in cell.matrices.items():
        assert read is not None
        columns = table.operators[cell.name, label]
        forms = []
        for i, row in enumerate(rows):
            for j, entry in enumerate(row):
                if entry is not None:
                    forms.append(add(columns[j][i], constant(read(entry)), -1))
        yield Constraint(f"{cell.name}: the matrix given for {label}", tuple(forms))


def _sums(cell: Cell, table: Unknowns) -> Iterator[Constraint]:
    labels = [*cell.subdivision, *(label for label in cell.boundary if not table.selects(cell.name, label))]
    for label in labels:
        forms = []
        for column in table.operators[cell.name, label]:
            total: dict[int, object] = {CONSTANT: -1}
            for form in column.values():
                if len(form) == 1 and CONSTANT not in form:
                    total.update(form)
                else:
                    total = dict(add(total, form))
            forms.append(total)
        yield Constraint(f"{cell.name}: the columns of {label} sum to 1", tuple(f for f in forms if f))
