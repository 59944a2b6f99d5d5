"""The parameters of a description: names such as u and v that its numbers are expressions in."""

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction

from automata.automaton import Automaton, Boundary, Cell, Entry, Rows
from automata.error import AutomatonError
from automata.expression import Expression, ExpressionError, Number, names, substitute


def parameter_names(automaton: Automaton) -> tuple[str, ...]:
    """The parameters of a description: those with a value first, then those that expressions name.

    >>> import automata
    >>> parameter_names(automata.read("nonuniform-quadratic-spline"))
    ('u', 'v', 'w')
    """
    found = dict.fromkeys(automaton.parameters)
    for expression in _expressions(automaton):
        found.update(dict.fromkeys(sorted(names(expression))))
    return tuple(found)


def resolved(automaton: Automaton) -> Automaton:
    """The automaton with the values that are set for parameters by name among its `parameters`."""
    known = parameter_names(automaton)
    set_now = {k: v for k, v in automaton.values.items() if k in known and isinstance(v, Fraction)}
    return replace(automaton, parameters={**automaton.parameters, **set_now}) if set_now else automaton


def settled(automaton: Automaton) -> Automaton:
    """The automaton with every parameter that has a value replaced by it, in matrices and embeddings.

    A value set for a parameter by name (`values`) goes before the one that the description gives it.
    Raises `AutomatonError` where a denominator becomes zero.
    """
    automaton = resolved(automaton)
    parameters = automaton.parameters
    if not parameters:
        return automaton
    cells = {name: _settled(cell, parameters) for name, cell in automaton.cells.items()}
    values = {
        key: value if isinstance(value, Fraction) else _value(value, parameters, ("set", key))
        for key, value in automaton.values.items()
    }
    return replace(automaton, cells=cells, values=values)


def _settled(cell: Cell, parameters: Mapping[str, Fraction]) -> Cell:
    path = ("cells", cell.name)
    boundary = {
        label: Boundary(b.cell, _rows(b.matrix, parameters, (*path, "boundary", label, "matrix")))
        for label, b in cell.boundary.items()
    }
    matrices = {
        label: _rows(rows, parameters, (*path, "matrices", label)) for label, rows in cell.matrices.items()
    }
    return replace(cell, boundary=boundary, matrices=matrices)


def _rows(rows: Rows, parameters: Mapping[str, Fraction], path: tuple) -> Rows:
    if all(entry is None or isinstance(entry, Number) for row in rows for entry in row):
        return rows
    return tuple(
        tuple(_entry(entry, parameters, (*path, i, j)) for j, entry in enumerate(row))
        for i, row in enumerate(rows)
    )


def _entry(entry: Entry | None, parameters: Mapping[str, Fraction], path: tuple) -> Entry | None:
    if entry is None or isinstance(entry, Number):
        return entry
    try:
        return substitute(entry, parameters)
    except ZeroDivisionError:
        given = ", ".join(f"{name} = {parameters[name]}" for name in sorted(names(entry) & parameters.keys()))
        raise AutomatonError(f"division by zero in '{entry}' at {given}", path=path) from None
    except ExpressionError as error:
        raise AutomatonError(f"in '{entry}': {error}", path=path) from None


def _value(value: Expression, parameters: Mapping[str, Fraction], path: tuple) -> Fraction | Expression:
    found = _entry(value, parameters, path)
    assert found is not None
    return found.value if isinstance(found, Number) else found


def _expressions(automaton: Automaton):
    for cell in automaton.cells.values():
        tables = [b.matrix for b in cell.boundary.values()] + list(cell.matrices.values())
        for rows in tables:
            for row in rows:
                yield from (entry for entry in row if entry is not None and not isinstance(entry, Number))
    yield from (value for value in automaton.values.values() if not isinstance(value, Fraction))
