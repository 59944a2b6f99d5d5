"""Triangles between curves: Bezier triangles, and Sierpinski's.

A triangle has the corners a, b and c and the sides `ab`, `bc` and `ca`, each running to the next corner.
Sub-triangles 0, 1 and 2 keep a corner; 3 is the middle one, turned by 180 degrees, its corner a between b
and c. Two triangles see a common side from its two ends, which a symmetry of the side reverses;
triangles that turn the other way round are glued as well, since all mirrors are declared.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from math import sqrt

import subdivision
from automata import Automaton, Boundary, Cell, Equation, Symmetry
from automata.automaton import Word
from automata.description import selection
from subdivision.schemes.building import Amount, coefficients, exact
from subdivision.schemes.curves import bezier

MOST_DEGREE = 10
SIZE = 90.0

Place = tuple[int, ...]
"""Where a control point is: whole coordinates in a lattice of triangles."""

_HALF = Fraction(1, 2)
SIDES = ("ab", "bc", "ca")
_KEPT = {"ab": ("0", "1"), "bc": ("1", "2"), "ca": ("2", "0")}
_MIDDLE = {"0": "bc", "1": "ca", "2": "ab"}


def bezier_triangle(degree: int) -> Automaton:
    """The Bezier triangle of a degree d, 1 to 10, by de Casteljau's subdivision into four.

    `(d+1)(d+2)/2` control points (i, j, k), i + j + k = d, row after row from side `ab` to corner c:
    (d, 0, 0), (d-1, 1, 0) … (0, 0, d). Point (i, j, k) of a sub-triangle with corners A, B and C is the
    polar form at A, B and C, taken i, j and k times: its column holds the coefficients of the polynomial
    `A^i B^j C^k`, A, B and C being linear in x, y and z. The sides are Bezier curves, the cells of
    `bezier(d)`. Raises `ValueError` for a degree out of range.

    >>> import subdivision
    >>> [subdivision.solve(bezier_triangle(d)).degrees_of_freedom for d in (1, 2, 3)]
    [0, 6, 23]
    """
    if not 1 <= degree <= MOST_DEGREE:
        raise ValueError(f"the degree is 1 to {MOST_DEGREE}, found {degree}")
    places = [(degree - j - k, j, k) for k in range(degree + 1) for j in range(degree + 1 - k)]
    steps = range(degree + 1)
    rows = {
        "ab": [(degree - n, n, 0) for n in steps],
        "bc": [(0, degree - n, n) for n in steps],
        "ca": [(n, 0, degree - n) for n in steps],
    }
    rotate = moved(places, lambda p: (p[2], p[0], p[1]))
    mirror = moved(places, lambda p: (p[1], p[0], p[2]))
    sides = {side: numbered(places, row) for side, row in rows.items()}
    cell = triangle(len(places), sides, rotate, mirror, ("mirror",), ("mirror",))
    curve = bezier(degree)
    values = {**curve.values}
    for label, corners in (
        ("0", ((1, 0, 0), (_HALF, _HALF, 0), (_HALF, 0, _HALF))),
        ("3", ((0, _HALF, _HALF), (_HALF, 0, _HALF), (_HALF, _HALF, 0))),
    ):
        columns = {number: _polar(corners, place, places) for number, place in enumerate(places)}
        values |= coefficients("triangle", label, columns)
    control = tuple(
        spot(j / degree, k / degree, SIZE * (1 - (i * i + j * j + k * k) / degree**2)) for i, j, k in places
    )
    cells = {"triangle": cell, **curve.cells}
    return Automaton(f"Bezier triangle of degree {degree}", "triangle", cells, values, control=control)


def _polar(
    corners: Sequence[Sequence[Fraction | int]], place: Place, places: Sequence[Place]
) -> list[Fraction]:
    """The coefficients of the product of linear forms, each taken as often as `place` says."""
    product: dict[Place, Fraction] = {(0, 0, 0): Fraction(1)}
    for corner, times in zip(corners, place, strict=True):
        for _ in range(times):
            longer: dict[Place, Fraction] = {}
            for (i, j, k), value in product.items():
                for grown, weight in zip(((i + 1, j, k), (i, j + 1, k), (i, j, k + 1)), corner, strict=True):
                    longer[grown] = longer.get(grown, Fraction(0)) + weight * value
            product = longer
    return [product.get(place, Fraction(0)) for place in places]


def sierpinski_triangle(curve: Automaton | None = None, inner: Amount = _HALF) -> Automaton:
    """Sierpinski's triangle between three curves of one kind, by default straight lines.

    `curve` is an automaton of one kind of edge with m control points and two pieces, between vertices of
    one point, such as `bezier(d)` or `takagi(w)`. The triangle depends on the `3(m-1)` points of its sides,
    counted from corner a around it. The outer sides of the three pieces are halves of the sides. The inner
    side of piece 0 goes from the joint M of `ab` to the joint N of `ca`; with P_j the points of `bc` and
    t = j/(m-1), its point j is `(1-t) M + t N + inner (P_j - (1-t) P_0 - t P_{m-1})`: that side made smaller.

    The rotation is declared, and the mirror if the curve has one. With straight sides nothing is left open.
    Otherwise the inner points are free: `replace(found, values={})` has 6 degrees of freedom for
    `takagi()`, 3 for the curve and 3 for the inner point. Raises `ValueError` for other curves,
    `subdivision.Undetermined` for one whose parameters have no values.

    >>> import subdivision
    >>> [[str(x) for x in row] for row in subdivision.solve(sierpinski_triangle()).numbers()["triangle"]["0"]]
    [['1', '1/2', '1/2'], ['0', '1/2', '0'], ['0', '0', '1/2']]
    """
    curve = bezier(1) if curve is None else curve
    edge = curve.cells[curve.shape]
    _check_sides(curve, edge)
    scale = exact(inner, "inner")
    last = edge.points - 1
    count = 3 * last
    sides = {
        side: tuple((start * last + n) % count for n in range(last + 1)) for start, side in enumerate(SIDES)
    }
    rotate = tuple((n + last) % count for n in range(count))
    mirror = tuple((last - n) % count for n in range(count)) if "mirror" in edge.symmetry else None
    cell = triangle(count, sides, rotate, mirror, None, ("mirror",), (curve.shape, *edge.subdivision))
    joint = [row[-1] for row in subdivision.solve(curve).numbers()[curve.shape][next(iter(edge.subdivision))]]
    columns = {last + n: _shrunk(sides, joint, n, scale) for n in range(1, last)}
    values = {**curve.values, **coefficients("triangle", "0", columns)}
    control = tuple(point for turn in range(3) for point in _side_points(curve, turn))
    cells = {"triangle": cell, **curve.cells}
    name = f"Sierpinski triangle of {curve.name}"
    return replace(curve, name=name, shape="triangle", cells=cells, values=values, control=control)


def _check_sides(curve: Automaton, edge: Cell) -> None:
    ends = {label: (end.cell, curve.cells[end.cell].points) for label, end in edge.boundary.items()}
    alike = set(ends) == {"left", "right"} and len(set(ends.values())) == 1
    pieces = list(edge.subdivision.values())
    if not alike or ends["left"][1] != 1 or pieces != [edge.name] * 2:
        raise ValueError(
            f"{curve.name!r} cannot be a side: expected an edge of 2 such edges, and one kind of vertex of 1 "
            f"point as 'left' and 'right'; found the pieces {pieces}, the ends {ends}"
        )
    if "triangle" in curve.cells:
        raise ValueError(f"{curve.name!r} has a cell 'triangle' already: give that one another name")


def _shrunk(
    sides: Mapping[str, Sequence[int]], joint: Sequence[Fraction], n: int, scale: Fraction
) -> list[Fraction]:
    """Point n of the inner side of piece 0."""
    side = sides["bc"]
    t = Fraction(n, len(side) - 1)
    column = [Fraction(0)] * (3 * len(side) - 3)
    for weight, row in ((1 - t, sides["ab"]), (t, sides["ca"])):
        for point, value in zip(row, joint, strict=True):
            column[point] += weight * value
    for point, weight in ((side[n], scale), (side[0], -scale * (1 - t)), (side[-1], -scale * t)):
        column[point] += weight
    return column


def _side_points(curve: Automaton, turn: int) -> list[tuple[float, float]]:
    """The control points of a side but its last one, the curve bulging outwards."""
    count = curve.cells[curve.shape].points
    given = [complex(n) for n in range(count)]
    if curve.control is not None and all(len(point) == 2 for point in curve.control):
        given = [complex(x, y) for x, y in curve.control]
    corners = [complex(*spot(*at, 0)[:2]) for at in ((0, 0), (1, 0), (0, 1))]
    start, end = corners[turn], corners[(turn + 1) % 3]
    placed = [
        start + (end - start) * ((z - given[0]) / (given[-1] - given[0])).conjugate() for z in given[:-1]
    ]
    return [(z.real, z.imag) for z in placed]


def triangle(
    points: int,
    sides: Mapping[str, Sequence[int]],
    rotate: Sequence[int],
    mirror: Sequence[int] | None,
    across: Word | None,
    backward: Word,
    edge: Sequence[str] = ("edge", "0", "1"),
) -> Cell:
    """A triangle of three pieces, or of four when sides are glued to the middle one, seen `across`.

    `sides` selects the points of the sides, `rotate` and `mirror` permute the points. The latter exchanges a
    and b; sides are seen through `backward` then. `edge` is the cell of a side, and its two pieces.
    """
    name, first, second = edge
    labels = ("0", "1", "2") if across is None else ("0", "1", "2", "3")
    middle = {"3": ("3", "rotate")} if across is not None else {}
    turn = {"0": ("1", "rotate"), "1": ("2", "rotate"), "2": ("0", "rotate"), **middle}
    symmetry = {"rotate": Symmetry(tuple(rotate), turn, {"ab": ("bc",), "bc": ("ca",), "ca": ("ab",)})}
    if mirror is not None:
        images = {"0": "1", "1": "0", **{label: label for label in labels[2:]}}
        symmetry["mirror"] = Symmetry(
            tuple(mirror),
            {label: (image, "mirror") for label, image in images.items()},
            {"ab": ("ab", *backward), "bc": ("ca", *backward), "ca": ("bc", *backward)},
        )
    incidence = [
        ((side, half), (piece, side))
        for side, pieces in _KEPT.items()
        for half, piece in zip((first, second), pieces, strict=True)
    ]
    adjacency = [
        ((piece, side), ("3", side, *across)) for piece, side in _MIDDLE.items() if across is not None
    ]
    return Cell(
        "triangle",
        points,
        dict.fromkeys(labels, "triangle"),
        {side: Boundary(name, selection(tuple(chosen), points)) for side, chosen in sides.items()},
        symmetry,
        equations("triangle", "incidence", incidence),
        equations("triangle", "adjacency", adjacency),
    )


def equations(cell: str, kind: str, sides: Sequence[tuple[Word, Word]]) -> tuple[Equation, ...]:
    """The constraints of a cell, from their two sides."""
    return tuple(
        Equation(left, right, f"{' '.join(left)} = {' '.join(right)}", ("cells", cell, kind, i))
        for i, (left, right) in enumerate(sides)
    )


def moved(places: Sequence[Place], move: Callable[[Place], Place]) -> tuple[int, ...]:
    """The permutation of places by a map of the lattice."""
    return numbered(places, map(move, places))


def numbered(places: Sequence[Place], chosen: Iterable[Place]) -> tuple[int, ...]:
    """The numbers of some places in a list."""
    return tuple(places.index(place) for place in chosen)


def spot(along: float, across: float, height: float) -> tuple[float, float, float]:
    """A point over an equilateral triangle, by its coordinates from corner a towards b and c."""
    return SIZE * (along + across / 2), SIZE * sqrt(3) / 2 * across, height
