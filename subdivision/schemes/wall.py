"""Self-similar curves whose pieces are the segments of a polygonal line: walls of steps and crenels."""

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from math import sqrt

from automata import Automaton
from subdivision.schemes.building import Amount, coefficients, edge, exact, scheme, vertex

SIZE = 90.0

Place = tuple[Fraction, Fraction]


def wall(points: Sequence[Sequence[Amount]]) -> Automaton:
    """The curve that looks on each segment of a polygonal line as it does from (0, 0) to (1, 0).

    `points` are N + 1 >= 3 rows `(x, y)`, the first (0, 0), the last (1, 0); floats stand for the binary
    fractions that they are. With `z_k = x_k + i y_k`, piece k is the image of the curve by the similarity
    `z -> z_k + (z_{k+1} - z_k) z`. Control points: the two ends, 90 mm apart, and a point Q that stands half
    as high over the middle between them; Q gives the side on which the curve lies, and moving the three
    points deforms the curve affinely. The constraints leave `4N - 2` degrees of freedom, and half as many
    where the line is its own mirror image, which is then declared. Raises `ValueError` for other ends, and
    for a segment of length 0, or of 1 or more, naming it.

    >>> import subdivision
    >>> steps = wall([(0, 0), (0.5, 0), (0.5, 0.25), (1, 0.25), (1, 0)])
    >>> subdivision.solve(steps).degrees_of_freedom
    14
    """
    places = [_place(i, point) for i, point in enumerate(points)]
    if len(places) < 3 or places[0] != (0, 0) or places[-1] != (1, 0):
        raise ValueError(
            f"expected 3 or more points from (0, 0) to (1, 0), found {len(places)}: {list(points)}"
        )
    half = Fraction(1, 2)
    return similar_pieces("Wall", [(x, y / half) for x, y in places], half**2)


def menger_wall() -> Automaton:
    """Menger's wall: a crenel of a third, right, up, right, down and right, on each of its five segments.

    The source shows cavities with such a wall ("Menger niv. 1, 2"; Gentil 2010, §6.4, figure 6.13) and gives
    no formula: the crenel is our reading of a picture. Five pieces of a third of the length have the
    dimension log 5 / log 3. From the second level on, crenels of neighbours touch in points that are not
    glued. The constraints and the mirror leave 9 degrees of freedom.

    >>> import subdivision
    >>> subdivision.solve(menger_wall()).degrees_of_freedom
    9
    """
    third = Fraction(1, 3)
    crenel = [(0, 0), (third, 0), (third, third), (2 * third, third), (2 * third, 0), (1, 0)]
    return replace(wall(crenel), name="Menger wall")


def similar_pieces(name: str, points: Sequence[tuple[Amount, Amount]], square: Fraction) -> Automaton:
    """The curve of `wall` for points `x + i h y` with `h^2 = square`; Q is `1/2 + i h`.

    All coefficients are rational where x, y and the square are, even if h is not.
    """
    places = [(Fraction(x), Fraction(y)) for x, y in points]
    pieces = len(places) - 1
    mirror = all((1 - x, y) == back for (x, y), back in zip(places, reversed(places), strict=True))
    values: dict[str, Fraction] = {}
    for k in range((pieces + 1) // 2 if mirror else pieces):
        (x, y), after = places[k : k + 2]
        dx, dy = after[0] - x, after[1] - y
        length = dx**2 + square * dy**2
        if not 0 < length < 1:
            raise ValueError(f"segment {k} is longer than 0 and shorter than 1, found {sqrt(length):g}")
        apex = (x + dx / 2 - square * dy, y + dx + dy / 2)
        columns = {} if k == 0 else {0: _weights((x, y))}
        columns |= {1: _weights(apex), 2: _weights(after)}
        values |= coefficients("edge", str(k), columns)
    cells = (edge(3, ("edge",) * pieces, mirror=mirror), vertex(1))
    control = ((0, 0), (SIZE / 2, SIZE * sqrt(square)), (SIZE, 0))
    return scheme(name, cells, values, control)


def _weights(place: Place) -> tuple[Fraction, Fraction, Fraction]:
    """A place in terms of the ends and Q."""
    x, y = place
    return 1 - x - y / 2, y, x - y / 2


def _place(number: int, point: Sequence[Amount]) -> Place:
    if len(point) != 2:
        raise ValueError(f"point {number} has x and y, found {list(point)}")
    return exact(point[0], f"x of point {number}"), exact(point[1], f"y of point {number}")
