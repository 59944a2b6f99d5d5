"""A few steps of linear algebra on fractions: products, echelon forms, inverses."""

from collections.abc import Sequence
from fractions import Fraction

Matrix = Sequence[Sequence[Fraction]]


def product(left: Matrix, right: Matrix) -> list[list[Fraction]]:
    """The product of two matrices."""
    columns = list(zip(*right, strict=True))
    return [
        [sum((a * b for a, b in zip(r, c, strict=True) if a and b), Fraction(0)) for c in columns]
        for r in left
    ]


def reduced(rows: Matrix, columns: int) -> tuple[list[list[Fraction]], list[int]]:
    """The reduced echelon form of a matrix, pivots sought in its first columns; and the pivots' columns.

    >>> reduced([[Fraction(2), Fraction(4)]], 1)[0]
    [[Fraction(1, 1), Fraction(2, 1)]]
    """
    work = [list(row) for row in rows]
    pivots: list[int] = []
    for column in range(columns):
        rank = len(pivots)
        found = next((i for i in range(rank, len(work)) if work[i][column]), None)
        if found is None:
            continue
        work[rank], work[found] = work[found], work[rank]
        pivot = work[rank][column]
        work[rank] = [entry / pivot for entry in work[rank]]
        for i, row in enumerate(work):
            factor = row[column]
            if i != rank and factor:
                work[i] = [a - factor * b if b else a for a, b in zip(row, work[rank], strict=True)]
        pivots.append(column)
    return work, pivots


def inverse(matrix: Matrix) -> list[list[Fraction]] | None:
    """The inverse of a square matrix; None where it has none."""
    size = len(matrix)
    joined = [[*row, *(Fraction(int(i == j)) for j in range(size))] for i, row in enumerate(matrix)]
    rows, pivots = reduced(joined, size)
    return [row[size:] for row in rows] if len(pivots) == size else None
