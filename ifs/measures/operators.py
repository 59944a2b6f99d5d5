"""The operators of a shape as exact fractions, where its automaton gives them."""

from collections.abc import Mapping
from fractions import Fraction

import numpy as np

import subdivision
from ifs.shape import Shape

Number = Fraction | float
Rows = tuple[tuple[Number, ...], ...]
Operators = Mapping[str, Mapping[str, tuple[str, Rows]]]
"""Cell, then label, to the target cell and the operator by rows."""

_SAME = 1e-12


def operators(shape: Shape) -> Operators:
    """The operators of all cells that the shape needs: Fractions from its constraints where it has them.

    A shape whose system was changed after it was made has them as floats.

    >>> from ifs.shape import shape
    >>> target, rows = operators(shape("corner-cutting"))["edge"]["0"]
    >>> target, [str(x) for x in rows[0]]
    ('edge', ['3/4', '1/4', '0'])
    """
    cells = shape.automaton.cells
    names = [name for name in shape.automaton.reachable() if name in shape.system.states]
    exact = _solved(shape)
    result: dict[str, dict[str, tuple[str, Rows]]] = {}
    for name in names:
        state = shape.system.states[name]
        result[name] = {}
        for label, operator in zip(state.labels, state.operators, strict=True):
            rows = exact.get(name, {}).get(label)
            same = rows is not None and np.abs(np.array(rows, dtype=float) - operator).max() <= _SAME
            plain = tuple(tuple(float(x) for x in row) for row in operator)
            result[name][label] = (cells[name].subdivision[label], rows if same and rows else plain)
    return result


def _solved(shape: Shape) -> Mapping[str, Mapping[str, subdivision.Exact]]:
    try:
        return subdivision.solve(shape.automaton).numbers()
    except (subdivision.Undetermined, subdivision.WrongValue):
        return {}
