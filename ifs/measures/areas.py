"""The area that a curve encloses with its chord, exactly, though the curve be a fractal."""

from collections.abc import Sequence
from fractions import Fraction
from itertools import combinations, pairwise

import numpy as np
from jaxtyping import Real

from ifs.certificates.convergence import require_contraction
from ifs.measures.chains import Chain, Column, chains, end_columns
from ifs.measures.operators import Number, Operators, Rows, operators
from ifs.measures.polynomials import solved
from ifs.shape import Shape

Form = dict[tuple[int, int], Number]
"""An alternating form by its entries (j, k) with j < k."""

_ONE = 1 - 1e-12


class NoArea(ValueError):
    """The areas of the polygons inscribed in a curve do not settle: pieces keep as much area as the whole."""


def area_form(shape: Shape) -> Rows:
    """The numbers W with `area = 1/2 sum_(j<k) W_jk (c_j x c_k)` between a curve and its chord.

    c_j are the control points (mm). In difference coordinates, with L_i the linear part of piece i, s_i = -1
    where the curve runs through the piece backwards, and Q the form of the polygon of the joints,
    `W_x = sum_i s_i L_i W_y L_i^T + Q_x`: linear equations, with one solution as long as the map
    `W -> sum s_i L_i W L_i^T` has spectral radius below 1; it is then the limit of the inscribed polygons,
    counterclockwise positive when run from start to end. W is alternating, and its rows sum to 0. Entries are
    Fractions where the operators are.

    Raises `NoChain`, `NoArea`, `NotContracting` or `Undecided`.

    >>> from ifs.shape import shape
    >>> [[str(x) for x in row] for row in area_form(shape("koch-curve"))]
    [['0', '3/5', '-3/5'], ['-3/5', '0', '3/5'], ['3/5', '-3/5', '0']]
    """
    require_contraction(shape.system)
    found, table = chains(shape), operators(shape)
    joints = {cell: _joints(shape, table, cell, chain) for cell, chain in found.items()}
    unknowns = [
        (cell, pair)
        for cell in found
        for pair in combinations(range(shape.automaton.cells[cell].points - 1), 2)
    ]
    place = {unknown: k for k, unknown in enumerate(unknowns)}
    rows: list[dict[int, Number]] = [{} for _ in unknowns]
    constants: list[Number] = []
    polygon = {cell: _polygon(columns) for cell, columns in joints.items()}
    for k, (cell, pair) in enumerate(unknowns):
        constants.append(polygon[cell].get(pair, Fraction(0)))
        for label, forward in found[cell].links:
            target, operator = table[cell][label]
            linear = _linear(operator)
            for (a, b), at in ((other, place[target, other]) for c, other in unknowns if c == target):
                minor = linear[pair[0]][a] * linear[pair[1]][b] - linear[pair[0]][b] * linear[pair[1]][a]
                if minor:
                    rows[k][at] = rows[k].get(at, Fraction(0)) + (minor if forward else -minor)
    _require_settling(shape, rows)
    values = dict(zip(unknowns, solved(rows, constants), strict=True))
    return _full(
        {pair: value for (cell, pair), value in values.items() if cell == shape.automaton.shape},
        shape.automaton.cells[shape.automaton.shape].points,
    )


def area(shape: Shape, control: Real[np.ndarray, "points dim"] | None = None) -> Number:
    """The signed area, in mm^2, between a plane curve and its chord.

    It is positive where the curve and its chord back go counterclockwise around it; of a closed curve it is
    the area enclosed, each part counted as often as the curve winds around it. `control` replaces the control
    points. The result is a Fraction where the operators are rational (of control points as the binary
    fractions that they are). Raises as `area_form` does, and `ValueError` for control points that are not in
    a plane.

    >>> from ifs.shape import shape
    >>> str(area(shape("takagi-curve"), np.array([[0, 0], [1, 1], [2, 0]])))
    '-2'
    """
    points = shape.control if control is None else control
    if points.shape != (len(shape.control), 2):
        raise ValueError(
            f"an area needs {len(shape.control)} control points of the plane, rows (x, y); "
            f"got an array of shape {points.shape}"
        )
    form = area_form(shape)
    rows = [[Fraction(float(x)) for x in row] for row in points]
    total: Number = Fraction(0)
    for j, k in combinations(range(len(rows)), 2):
        total += form[j][k] * (rows[j][0] * rows[k][1] - rows[j][1] * rows[k][0])
    return total / 2


def swept_area(shape: Shape, control: Real[np.ndarray, "points dim"] | None = None) -> Number:
    """The signed area, in mm^2, that the segment from the origin to the curve sweeps: `1/2 int x dy - y dx`.

    It adds up along curves that follow one another; around a closed one it is the area enclosed.
    Arguments and errors as in `area`.

    >>> from ifs.shape import shape
    >>> str(swept_area(shape("koch-curve"), np.array([[0, 1], [2, 2], [4, 1]])))
    '-16/5'
    """
    own = area(shape, control)
    points = shape.control if control is None else control
    rows = [[Fraction(float(x)) for x in row] for row in points]
    start, end = (
        [sum((w * row[d] for w, row in zip(column, rows, strict=True)), Fraction(0)) for d in range(2)]
        for column in end_columns(shape, operators(shape), shape.automaton.shape)
    )
    return own + (start[0] * end[1] - start[1] * end[0]) / 2


def _joints(shape: Shape, table: Operators, cell: str, chain: Chain) -> list[Column]:
    """The ends of the pieces in the order of the curve, from its start to its end."""
    result = [end_columns(shape, table, cell)[0]]
    for label, forward in chain.links:
        target, operator = table[cell][label]
        far = end_columns(shape, table, target)[1 if forward else 0]
        result.append(
            tuple(sum((x * w for x, w in zip(row, far, strict=True)), Fraction(0)) for row in operator)
        )
    return result


def _polygon(columns: Sequence[Column]) -> Form:
    """Twice the area of a closed polygon as an alternating form in differences to the last control point."""
    form: Form = {}
    for here, there in pairwise([*columns, columns[0]]):
        for j, k in combinations(range(len(here) - 1), 2):
            value = here[j] * there[k] - here[k] * there[j]
            form[j, k] = form.get((j, k), Fraction(0)) + value
    return form


def _linear(operator: Rows) -> list[list[Number]]:
    return [[x - row[-1] for x in row[:-1]] for row in operator[:-1]]


def _require_settling(shape: Shape, rows: Sequence[dict[int, Number]]) -> None:
    matrix = np.zeros((len(rows), len(rows)))
    for k, row in enumerate(rows):
        for at, value in row.items():
            matrix[k, at] = float(value)
    radius = float(np.abs(np.linalg.eigvals(matrix)).max(initial=0.0)) if len(rows) else 0.0
    if radius >= _ONE:
        raise NoArea(
            f"the areas under the polygons inscribed in {shape.name!r} do not settle: areas of pieces sum to "
            f"{radius:.12g} times that of the whole, which must be below 1"
        )


def _full(form: Form, points: int) -> Rows:
    rows: list[list[Number]] = [[Fraction(0)] * points for _ in range(points)]
    for (j, k), value in form.items():
        for a, b, sign in ((j, k, 1), (k, points - 1, 1), (points - 1, j, 1)):
            rows[a][b] += sign * value
            rows[b][a] -= sign * value
    return tuple(tuple(row) for row in rows)
