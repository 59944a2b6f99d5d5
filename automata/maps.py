"""A plain IFS, given as affine maps of the plane or of space, as an automaton of one cell."""

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction

from automata.automaton import Cell, Rows
from automata.document import Field
from automata.plain import barycentric

Matrix = list[list[Fraction]]

CELL = "attractor"
_QUARTERS = {Fraction(90 * i): turn for i, turn in enumerate(((1, 0), (0, 1), (-1, 0), (0, -1)))}
_KEYS = ("linear", "rotation", "scale", "translation")


def plain_ifs(field: Field) -> tuple[Cell, tuple[tuple[float, ...], ...]]:
    """The cell of a list of maps `x -> linear · rotation · scale · x + translation`, and its frame.

    In R^d the cell depends on d + 1 points: the origin and the ends of the axes' unit vectors, which
    are the control points unless others are given. A map x -> A x + b becomes the barycentric operator
    whose column 0 is the place of b and whose column i is that of A e_i + b.
    """
    entries = field.items("a list of [[maps]]")
    if not 1 <= len(entries) <= 4096:
        raise field.error("expected 1 to 4096 maps")
    maps = [entry.table(_KEYS, required=["translation"]) for entry in entries]
    dimension = len(maps[0]["translation"].items())
    if not 1 <= dimension <= 6:
        raise maps[0]["translation"].error("expected 1 to 6 coordinates")
    matrices = {str(i): _barycentric(entry, dimension) for i, entry in enumerate(maps)}
    subdivision = dict.fromkeys(matrices, CELL)
    frame = [[0.0] * dimension for _ in range(dimension + 1)]
    for axis in range(dimension):
        frame[axis + 1][axis] = 1.0
    cell = Cell(CELL, dimension + 1, subdivision, matrices=matrices)
    return cell, tuple(tuple(row) for row in frame)


def _barycentric(fields: Mapping[str, Field], dimension: int) -> Rows:
    linear = _identity(dimension)
    if "linear" in fields:
        linear = _linear(fields["linear"], dimension)
    if "rotation" in fields:
        linear = _product(linear, _rotation(fields["rotation"], dimension))
    if "scale" in fields:
        factors = _scale(fields["scale"], dimension)
        linear = [[entry * factors[j] for j, entry in enumerate(row)] for row in linear]
    shift = _vector(fields["translation"], dimension)
    return barycentric(linear, shift)


def _vector(field: Field, dimension: int) -> list[Fraction]:
    entries = field.items("a list of numbers")
    if len(entries) != dimension:
        raise field.error(f"expected {dimension} numbers, found {len(entries)}")
    return [entry.number() for entry in entries]


def _linear(field: Field, dimension: int) -> Matrix:
    rows = field.items("a list of rows")
    if len(rows) != dimension:
        raise field.error(f"expected {dimension} rows, found {len(rows)}")
    return [_vector(row, dimension) for row in rows]


def _scale(field: Field, dimension: int) -> list[Fraction]:
    if isinstance(field.value, list):
        return _vector(field, dimension)
    return [field.number()] * dimension


def _rotation(field: Field, dimension: int) -> Matrix:
    """Degrees in the plane; `{ axis = [x, y, z], angle = degrees }` in space (Rodrigues' formula)."""
    if dimension == 2:
        cosine, sine = _cosine_sine(field.number())
        return [[cosine, -sine], [sine, cosine]]
    if dimension != 3:
        raise field.error("rotations are for maps of the plane or of space; give 'linear' instead")
    fields = field.table(("axis", "angle"), required=("axis", "angle"))
    axis = _vector(fields["axis"], 3)
    length = math.hypot(*(float(x) for x in axis))
    if length == 0:
        raise fields["axis"].error("the axis of a rotation is not zero")
    x, y, z = (Fraction(float(entry) / length) for entry in axis)
    cosine, sine = _cosine_sine(fields["angle"].number())
    cross = [[Fraction(0), -z, y], [z, Fraction(0), -x], [-y, x, Fraction(0)]]
    outer = [[p * q for q in (x, y, z)] for p in (x, y, z)]
    unit = _identity(3)
    return [
        [cosine * unit[i][j] + sine * cross[i][j] + (1 - cosine) * outer[i][j] for j in range(3)]
        for i in range(3)
    ]


def _cosine_sine(degrees: Fraction) -> tuple[Fraction, Fraction]:
    """Exact for multiples of 90 degrees, else the nearest doubles."""
    quarter = _QUARTERS.get(degrees % 360)
    if quarter:
        return Fraction(quarter[0]), Fraction(quarter[1])
    angle = math.radians(float(degrees % 360))
    return Fraction(math.cos(angle)), Fraction(math.sin(angle))


def _identity(dimension: int) -> Matrix:
    return [[Fraction(int(i == j)) for j in range(dimension)] for i in range(dimension)]


def _product(left: Sequence[Sequence[Fraction]], right: Sequence[Sequence[Fraction]]) -> Matrix:
    size = len(right)
    return [
        [sum((row[k] * right[k][j] for k in range(size)), Fraction(0)) for j in range(size)] for row in left
    ]
