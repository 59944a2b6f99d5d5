"""What every curve scheme is made of: cells, their constraints, and coefficients as values of entries."""

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from math import isfinite

from automata import Automaton, Boundary, Cell, Equation, Symmetry
from automata.description import selection

Amount = int | float | Fraction
"""A number of a scheme; a float stands for the binary fraction that it is."""

Column = Sequence[int | Fraction]


def exact(amount: Amount, what: str) -> Fraction:
    """The amount as a fraction. Raises `ValueError` that says `what` it is for infinity and NaN."""
    if isinstance(amount, float) and not isfinite(amount):
        raise ValueError(f"{what} is a finite number, found {amount}")
    return Fraction(amount)


def vertex(points: int, name: str = "vertex", becomes: str | None = None, swap: bool = False) -> Cell:
    """A point of a curve: its sub-cell `s` is itself unless it `becomes` another; `swap` reverses it."""
    symmetry = {}
    if swap and points > 1:
        symmetry["swap"] = Symmetry(tuple(reversed(range(points))), {"s": ("s", "swap")}, {})
    return Cell(name, points, {"s": becomes or name}, symmetry=symmetry)


def edge(
    points: int,
    pieces: Sequence[str],
    left: tuple[str, int] = ("vertex", 1),
    right: tuple[str, int] = ("vertex", 1),
    name: str = "edge",
    mirror: bool = False,
) -> Cell:
    """A piece of curve between two vertices, its sub-cells numbered from 0 and joined end to end.

    `left` and `right` are the vertices and on how many control points, the first and the last ones, they
    depend. With `mirror` the curve is the same from both ends.
    """
    last = len(pieces) - 1
    chosen = {"left": tuple(range(left[1])), "right": tuple(range(points - right[1], points))}
    boundary = {
        label: Boundary(border, selection(chosen[label], points))
        for label, (border, _) in (("left", left), ("right", right))
    }
    symmetry = {}
    if mirror:
        swap = ("swap",) if left[1] > 1 else ()
        symmetry["mirror"] = Symmetry(
            tuple(reversed(range(points))),
            {str(i): (str(last - i), "mirror") for i in range(len(pieces))},
            {"left": ("right", *swap), "right": ("left", *swap)},
        )
    return Cell(
        name,
        points,
        {str(i): piece for i, piece in enumerate(pieces)},
        boundary,
        symmetry,
        (
            _equation(name, "incidence", 0, "left s = 0 left"),
            _equation(name, "incidence", 1, f"right s = {last} right"),
        ),
        tuple(_equation(name, "adjacency", i, f"{i} right = {i + 1} left") for i in range(last)),
    )


def _equation(cell: str, kind: str, number: int, text: str) -> Equation:
    left, right = (tuple(side.split()) for side in text.split("="))
    return Equation(left, right, text, ("cells", cell, kind, number))


def coefficients(cell: str, label: str, columns: Mapping[int, Column]) -> dict[str, Fraction]:
    """The entries of some columns of an operator, without the last row: columns sum to 1.

    >>> coefficients("edge", "0", {1: (Fraction(1, 4), Fraction(3, 4))})
    {'edge.0[0,1]': Fraction(1, 4)}
    """
    return {
        f"{cell}.{label}[{row},{number}]": Fraction(value)
        for number, column in columns.items()
        for row, value in enumerate(column[:-1])
    }


def scheme(
    name: str,
    cells: Iterable[Cell],
    values: Mapping[str, Fraction],
    control: Sequence[Sequence[float]] | None = None,
) -> Automaton:
    """The automaton of some cells, the first of which is the shape, with values for what is left open.

    Without `control` the control points are a zigzag.
    """
    table = {cell.name: cell for cell in cells}
    shape = next(iter(table.values()))
    if control is None:
        control = [(30.0 * i, 60.0 * (i % 2)) for i in range(shape.points)]
    points = tuple(tuple(float(x) for x in point) for point in control)
    return Automaton(name, shape.name, table, values, control=points)
