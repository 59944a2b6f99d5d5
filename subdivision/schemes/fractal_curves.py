"""Fractal curves by their control points: Takagi, Koch, Cesaro, Hilbert, and interpolation.

All vertices depend on one control point. Where a curve is the same from both ends, a mirror says so, and only
the operators of the first half have coefficients. Coefficients are exact; irrational heights belong to the
control points.
"""

from collections.abc import Sequence
from fractions import Fraction
from math import cos, radians

from automata import Automaton
from subdivision.schemes.building import Amount, coefficients, edge, exact, scheme, vertex
from subdivision.schemes.wall import SIZE, similar_pieces


def takagi(w: Amount = Fraction(1, 2)) -> Automaton:
    """Takagi's curve `sum w^n s(2^n t)`, s(t) the distance to the nearest integer.

    Control points: the two ends and the point M between them. With `bump = M - (P_0 + P_2)/2`, each half has
    as its middle point the middle of its ends plus w times the bump, so that column 1 of `T_0` is
    `(1-w, 1+2w, -w)/2`. w = 1/4 is a parabola, w = 1/2 Takagi's own. The constraints and the mirror leave 3
    degrees of freedom. Raises `ValueError` unless |w| < 1.

    >>> import subdivision
    >>> [str(x) for x in subdivision.solve(takagi()).numbers()["edge"]["0"][2]]
    ['0', '-1/4', '0']
    """
    w = exact(w, "w")
    if abs(w) >= 1:
        raise ValueError(f"the curve is bounded for -1 < w < 1, found {float(w):g}")
    columns = {1: ((1 - w) / 2, (1 + 2 * w) / 2, -w / 2), 2: (0, 1, 0)}
    cells = (edge(3, ("edge", "edge"), mirror=True), vertex(1))
    control = ((0, 0), (SIZE / 2, SIZE / 2), (SIZE, 0))
    return scheme("Takagi curve", cells, coefficients("edge", "0", columns), control)


def koch() -> Automaton:
    """Von Koch's curve: Cesaro's with base angles of 60 degrees, whose pieces have a third of the length.

    >>> import subdivision
    >>> [str(x) for x in subdivision.solve(koch()).numbers()["edge"]["0"][0]]
    ['1', '2/3', '2/3']
    """
    return _tent("Koch curve", Fraction(1, 3))


def cesaro(angle: Amount) -> Automaton:
    """Cesaro's curve: four equal pieces, the middle two rising to an apex at base angles in degrees.

    Each piece has `r = 1 / (2 + 2 cos(angle))` of the length, and the apex is `sqrt(r - 1/4)` high over an
    axis of length 1. Control points: the two ends and the apex A; in them all coefficients are rational in r:
    the joints are `((1-r) P_0 + r P_2, A, …)`, the apexes of the first pieces `(1-r) P_0 + r A` and
    `r P_0 + (1-r) A`. The constraints and the mirror leave 7 degrees of freedom. 60 degrees are Koch's curve,
    90 a right triangle filled. Raises `ValueError` unless 0 < angle <= 90.

    >>> import subdivision
    >>> subdivision.solve(cesaro(85)).degrees_of_freedom
    7
    """
    if not 0 < angle <= 90:
        raise ValueError(f"the angle is over 0 and up to 90 degrees, found {angle}")
    known = {60.0: Fraction(1, 3), 90.0: Fraction(1, 2)}
    ratio = known.get(float(angle)) or Fraction(1 / (2 + 2 * cos(radians(angle))))
    return _tent("Cesaro curve", ratio)


def _tent(name: str, r: Fraction) -> Automaton:
    points = [(0, 0), (r, 0), (Fraction(1, 2), 1), (1 - r, 0), (1, 0)]
    return similar_pieces(name, points, r - Fraction(1, 4))


def hilbert() -> Automaton:
    """Hilbert's curve through a quadrilateral from corner 0 to corner 3, the corners counted around it.

    A quarter is found by halving the sides; the quarters at the two ends are turned, so that each begins
    where the one before it ends. The constraints and the mirror leave 16 degrees of freedom.

    >>> import subdivision
    >>> subdivision.solve(hilbert()).degrees_of_freedom
    16
    """
    corner = [tuple(Fraction(i == j) for i in range(4)) for j in range(4)]

    def middle(*numbers: int) -> tuple[Fraction, ...]:
        return tuple(
            sum(rows, Fraction(0)) / len(numbers) for rows in zip(*(corner[n] for n in numbers), strict=True)
        )

    centre = middle(0, 1, 2, 3)
    first = {1: middle(0, 3), 2: centre, 3: middle(0, 1)}
    second = {1: corner[1], 2: middle(1, 2), 3: centre}
    values = coefficients("edge", "0", first) | coefficients("edge", "1", second)
    cells = (edge(4, ("edge",) * 4, mirror=True), vertex(1))
    return scheme("Hilbert curve", cells, values, ((0, 0), (0, SIZE), (SIZE, SIZE), (SIZE, 0)))


def interpolation(points: Sequence[Sequence[Amount]], scales: Sequence[Amount]) -> Automaton:
    """The affine fractal interpolation function through given points, with a vertical scale for each gap.

    `points` are N + 1 rows `(x, y)` or `(x, y, z…)` in millimetres, N >= 2, x increasing; `scales` are N
    numbers d_i with |d_i| < 1; zeros give the polygon. All points are control points. With
    `t_j = (x_j - x_0) / (x_N - x_0)`, piece i (from 1) takes P_j to
    `(1-t_j) P_{i-1} + t_j P_i + d_i (P_j - (1-t_j) P_0 - t_j P_N)`: only abscissas enter the coefficients, so
    the other coordinates may be moved afterwards. The constraints leave `N (N^2-1)` degrees of freedom.
    Raises `ValueError` for wrong numbers of points or scales, x not increasing, or a scale of 1 or more.
    Source: Gentil 2010, figures 4.4 to 4.6 (Barnsley's functions).

    >>> import subdivision
    >>> subdivision.solve(interpolation([(0, 0), (40, 50), (90, 0)], [0.25, 0.5])).degrees_of_freedom
    6
    """
    pieces = len(points) - 1
    if pieces < 2 or len(scales) != pieces:
        raise ValueError(f"expected 3 or more points and a scale for each gap, found {len(points)} points "
                         f"and {len(scales)} scales")  # fmt: skip
    x = [exact(point[0], f"x of point {i}") for i, point in enumerate(points)]
    for i in range(pieces):
        if x[i] >= x[i + 1]:
            raise ValueError(f"x increases from point to point; point {i + 1} has {points[i + 1][0]} after "
                             f"{points[i][0]}")  # fmt: skip
    values: dict[str, Fraction] = {}
    for i, scale in enumerate(scales):
        d = exact(scale, f"scale {i}")
        if abs(d) >= 1:
            raise ValueError(f"scale {i} is between -1 and 1, found {scale}")
        times = [(at - x[0]) / (x[-1] - x[0]) for at in x]
        values |= coefficients("edge", str(i), {j: _image(i, j, t, d, pieces) for j, t in enumerate(times)})
    cells = (edge(pieces + 1, ("edge",) * pieces), vertex(1))
    control = [[float(value) for value in point] for point in points]
    return scheme("Fractal interpolation", cells, values, control)


def _image(piece: int, point: int, t: Fraction, d: Fraction, last: int) -> list[Fraction]:
    column = [Fraction(0)] * (last + 1)
    for row, weight in ((piece, 1 - t), (piece + 1, t), (point, d), (0, -d * (1 - t)), (last, -d * t)):
        column[row] += weight
    return column
