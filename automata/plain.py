"""Affine maps as the automaton of one cell that subdivides into itself: a plain IFS."""

from collections.abc import Sequence
from fractions import Fraction

from automata.automaton import Automaton, Cell, Rows
from automata.expression import Number

CELL = "attractor"
MOST_MAPS = 4096

Vector = Sequence[Fraction]
AffineMap = tuple[Sequence[Vector], Vector]
"""The linear part, by rows, and the translation."""


def plain_automaton(
    name: str, maps: Sequence[AffineMap], control: Sequence[Sequence[float]] | None = None
) -> Automaton:
    """The plain IFS of some affine maps `x -> A x + b` of R^d, as an automaton of one cell.

    The cell depends on d + 1 points: the origin and the ends of the axes' unit vectors, which are the control
    points (mm) unless others are given. Labels count the maps from 0. Raises `ValueError` for no map, for
    over 4096, and for maps of different spaces, naming the map. Source: Gentil 2010, §3.3.1.

    >>> half = Fraction(1, 2)
    >>> halves = [([[half]], [Fraction(0)]), ([[half]], [half])]
    >>> [str(entry) for entry in plain_automaton("Segment", halves).cells[CELL].matrices["1"][0]]
    ['1/2', '0']
    """
    if not 1 <= len(maps) <= MOST_MAPS:
        raise ValueError(f"a plain IFS has 1 to {MOST_MAPS} maps, found {len(maps)}")
    dimension = len(maps[0][1])
    for number, (linear, shift) in enumerate(maps):
        if len(shift) != dimension or len(linear) != dimension or any(len(r) != dimension for r in linear):
            raise ValueError(f"map {number} is no map of R^{dimension}, as map 0 is")
    matrices = {str(i): barycentric(*each) for i, each in enumerate(maps)}
    cell = Cell(CELL, dimension + 1, dict.fromkeys(matrices, CELL), matrices=matrices)
    if control is None:
        control = frame(dimension)
    return Automaton(name, CELL, {CELL: cell}, control=tuple(tuple(float(x) for x in row) for row in control))


def barycentric(linear: Sequence[Vector], shift: Vector) -> Rows:
    """The operator of `x -> A x + b`: column 0 is the place of b, column i that of `A e_i + b`."""
    size = range(len(shift))
    columns = [list(shift)] + [[shift[i] + linear[i][j] for i in size] for j in size]
    full = [[1 - sum(column), *column] for column in columns]
    return tuple(tuple(Number(Fraction(column[i])) for column in full) for i in range(len(shift) + 1))


def frame(dimension: int) -> tuple[tuple[float, ...], ...]:
    """The origin and the ends of the axes' unit vectors, a row each."""
    axes = [tuple(float(i == j) for j in range(dimension)) for i in range(dimension)]
    return (tuple(0.0 for _ in range(dimension)), *axes)
