"""Polynomials in a few variables as tables, and the linear equations between their expectations."""

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction

import numpy as np

from ifs.measures.operators import Number

Exponent = tuple[int, ...]
Polynomial = dict[Exponent, Number]


def exponents(variables: int, degree: int) -> Iterator[Exponent]:
    """The exponents of all monomials of one degree, the first variable's highest first.

    >>> list(exponents(2, 2))
    [(2, 0), (1, 1), (0, 2)]
    """
    if variables == 0:
        if degree == 0:
            yield ()
        return
    if variables == 1:
        yield (degree,)
        return
    for first in range(degree, -1, -1):
        yield from ((first, *rest) for rest in exponents(variables - 1, degree - first))


def affine_form(row: Sequence[Number]) -> Polynomial:
    """`sum_j row_j p_j` for coordinates p that sum to 1, in all of them but the last.

    >>> affine_form([3, 1])
    {(0,): 1, (1,): 2}
    """
    count = len(row) - 1
    form = {(0,) * count: row[-1]} if row[-1] else {}
    for j in range(count):
        if row[j] != row[-1]:
            form[tuple(int(k == j) for k in range(count))] = row[j] - row[-1]
    return form


def times(one: Polynomial, other: Polynomial) -> Polynomial:
    """The product of two polynomials."""
    result: Polynomial = {}
    for a, x in one.items():
        for b, y in other.items():
            key = tuple(i + j for i, j in zip(a, b, strict=True))
            result[key] = result.get(key, 0) + x * y
    return result


class Powers:
    """Products of powers of given polynomials, each worked out once, when first asked for."""

    def __init__(self, forms: Sequence[Polynomial], variables: int):
        self._forms = forms
        self._found: dict[Exponent, Polynomial] = {(0,) * len(forms): {(0,) * variables: 1}}

    def __call__(self, exponent: Exponent) -> Polynomial:
        if exponent not in self._found:
            j = next(k for k, power in enumerate(exponent) if power)
            lower = tuple(power - (k == j) for k, power in enumerate(exponent))
            self._found[exponent] = times(self(lower), self._forms[j])
        return self._found[exponent]


def solved(rows: Sequence[Mapping[int, Number]], constants: Sequence[Number]) -> list[Number]:
    """The u with `u = rows u + constants`: exact when all numbers are rational, else in double precision.

    Raises `ZeroDivisionError` when 1 is an eigenvalue of the rows.

    >>> solved([{0: Fraction(1, 2)}], [Fraction(1, 3)])
    [Fraction(2, 3)]
    """
    count = len(rows)
    if all(
        isinstance(x, int | Fraction) for row in (*rows, dict(enumerate(constants))) for x in row.values()
    ):
        return _solved_exactly(rows, constants)
    matrix = np.eye(count)
    for i, row in enumerate(rows):
        for j, x in row.items():
            matrix[i, j] -= float(x)
    try:
        return [float(x) for x in np.linalg.solve(matrix, np.array([float(x) for x in constants]))]
    except np.linalg.LinAlgError:
        raise ZeroDivisionError("1 is an eigenvalue") from None


def _solved_exactly(rows: Sequence[Mapping[int, Number]], constants: Sequence[Number]) -> list[Number]:
    """Elimination on sparse rows, each pivot the shortest row that holds its column."""
    count = len(rows)
    left: list[dict[int, Fraction]] = []
    for i, row in enumerate(rows):
        line = {j: -Fraction(x) for j, x in row.items() if x}
        line[i] = line.get(i, Fraction(0)) + 1
        line[count] = Fraction(constants[i])
        left.append({j: x for j, x in line.items() if x})
    done: dict[int, dict[int, Fraction]] = {}
    for column in range(count):
        holding = [k for k, line in enumerate(left) if column in line]
        if not holding:
            raise ZeroDivisionError("1 is an eigenvalue")
        pivot = left.pop(min(holding, key=lambda k: len(left[k])))
        scale = pivot[column]
        pivot = {j: x / scale for j, x in pivot.items()}
        for line in left:
            factor = line.pop(column, None)
            if factor is None:
                continue
            for j, x in pivot.items():
                if j != column:
                    value = line.get(j, Fraction(0)) - factor * x
                    if value:
                        line[j] = value
                    else:
                        line.pop(j, None)
        done[column] = pivot
    result: list[Number] = [Fraction(0)] * count
    for column in reversed(range(count)):
        pivot = done[column]
        result[column] = pivot.get(count, Fraction(0)) - sum(
            (x * result[j] for j, x in pivot.items() if j not in (column, count)), Fraction(0)
        )
    return result
