"""Families of operators as text and as data."""

import re
from collections.abc import Sequence
from typing import Any

from subdivision.coefficients import Scalar, is_number, text_of
from subdivision.form import CONSTANT, Form
from subdivision.solution import Forms, Solution

_EXPONENT = re.compile(r"[eE]\d")
"""The beginning of a name that would continue a number before it: 2e1 is twenty."""


def expression(form: Form, names: Sequence[str]) -> str:
    """An affine form as text that the description's grammar reads back: `1 - a - 2b`, `a/2`, `3/16`.

    >>> expression({0: Fraction(-1, 2), CONSTANT: Fraction(1)}, ["a"])
    '1 - a/2'
    """
    if not form:
        return "0"
    terms = []
    for key in sorted(form):
        coefficient = form[key]
        name = "" if key == CONSTANT else names[key]
        negative = is_number(coefficient) and coefficient < 0
        body = _term(-coefficient if negative else coefficient, name)
        terms.append(f" {'-' if negative else '+'} {body}" if terms else ("-" if negative else "") + body)
    return "".join(terms)


def _term(coefficient: Scalar, name: str) -> str:
    if not is_number(coefficient):
        text = text_of(coefficient)
        return f"({text})*{name}" if name else text
    if not name:
        return str(coefficient)
    numerator = "" if coefficient.numerator == 1 else str(coefficient.numerator)
    denominator = "" if coefficient.denominator == 1 else f"/{coefficient.denominator}"
    between = "*" if numerator and _EXPONENT.match(name) else ""
    return f"{numerator}{between}{name}{denominator}"


def matrix_text(rows: Forms, names: Sequence[str]) -> str:
    """A matrix in aligned columns, a line each row, between brackets.

    >>> print(matrix_text((({CONSTANT: Fraction(1)}, {}),), []))
    [ 1  0 ]
    """
    cells = [[expression(form, names) for form in row] for row in rows]
    widths = [max(len(row[j]) for row in cells) for j in range(len(cells[0]))]
    lines = ("  ".join(text.rjust(width) for text, width in zip(row, widths, strict=True)) for row in cells)
    return "\n".join(f"[ {line} ]" for line in lines)


def as_text(solution: Solution) -> str:
    """The degrees of freedom, the free parameters and every operator."""
    names = [parameter.name for parameter in solution.parameters]
    count = solution.degrees_of_freedom
    lines = [f"{solution.automaton.name}: {count} degree{'' if count == 1 else 's'} of freedom", ""]
    if solution.notes:
        lines += [*(f"  {note}" for note in solution.notes), ""]
    values = solution.automaton.values
    for parameter in solution.free:
        given = values.get(parameter.name, values.get(str(parameter.entry)))
        note = f"    (the file sets {given})" if given is not None else ""
        lines.append(f"  {parameter.name} = {parameter.entry}{note}")
    if solution.free:
        lines.append("")
    for cell, table in solution.operators.items():
        for label, rows in table.items():
            lines += [f"{cell}.{label} =", matrix_text(rows, names), ""]
    return "\n".join(lines).rstrip() + "\n"


def as_data(solution: Solution) -> dict[str, Any]:
    """The same as plain data, ready for JSON.

    `notes` says which cells are one, `degrees_of_freedom` is an integer, `parameters` the names of
    the free ones, `entries` the entry of each,
    `matrices` cell, then label, then rows of expressions as texts.
    """
    names = [parameter.name for parameter in solution.parameters]
    return {
        "name": solution.automaton.name,
        "notes": list(solution.notes),
        "degrees_of_freedom": solution.degrees_of_freedom,
        "parameters": [parameter.name for parameter in solution.free],
        "entries": {parameter.name: str(parameter.entry) for parameter in solution.free},
        "matrices": {
            cell: {
                label: [[expression(form, names) for form in row] for row in rows]
                for label, rows in table.items()
            }
            for cell, table in solution.operators.items()
        },
    }
