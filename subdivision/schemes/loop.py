"""The regular patch of Loop's scheme, a triangle."""

from collections.abc import Sequence
from fractions import Fraction

from automata import Automaton, Boundary, Cell, Symmetry
from automata.description import selection
from subdivision.schemes.triangles import SIDES, SIZE, Place, equations, moved, numbered, spot, triangle

_CORNERS = ((0, 0), (1, 0), (0, 1))


def loop() -> Automaton:
    """The regular patch of Loop's scheme: the box spline of degree 4 over a triangle, on 12 points.

    A vertex depends on itself and its 6 neighbours, counterclockwise; an edge on its ends and their
    neighbours, 10 points; the triangle on its corners and theirs, row after row, the corners a, b and c
    being the points 4, 5 and 8. The constraints and all rotations and mirrors leave 2 degrees of freedom: the
    weight 1/16 of a neighbour in an old point, which keeps 5/8 of itself, and 3/8 of either end in the new
    point of an edge, which takes 1/8 of the points across. The limit of a vertex is `V/2 + E/12`, E being the
    sum of its neighbours. Source of the coefficients: C. Loop, Smooth Subdivision Surfaces Based on
    Triangles, 1987.

    >>> import subdivision
    >>> loop().reachable()
    ('triangle', 'edge', 'vertex')
    >>> subdivision.solve(loop()).degrees_of_freedom
    2
    """
    along, places = _star(_CORNERS[:2]), _star(_CORNERS)
    around = [_CORNERS[0], *(_turned((1, 0), n) for n in range(6))]
    sides = {
        side: numbered(places, (_framed(corner, 2 * n, place) for place in along))
        for n, (side, corner) in enumerate(zip(SIDES, _CORNERS, strict=True))
    }
    rotate = moved(places, lambda p: _framed((1, 0), 2, p))
    mirror = moved(places, lambda p: (1 - p[0] - p[1], p[1]))
    cells = {
        "triangle": triangle(len(places), sides, rotate, mirror, ("flip",), ("flip", "mirror")),
        "edge": _edge(along, around),
        "vertex": Cell("vertex", len(around), {"s": "vertex"}, symmetry=_turns(around)),
    }
    values = {"vertex.s[1,0]": Fraction(1, 16), "vertex.s[0,1]": Fraction(3, 8)}
    control = tuple(spot(x / 2, y / 2, SIZE / 3 if (x, y) in _CORNERS else 0.0) for x, y in places)
    return Automaton("Loop patch", "triangle", cells, values, control=control)


def _edge(places: Sequence[Place], around: Sequence[Place]) -> Cell:
    """The edge from (0, 0) to (1, 0); a vertex at either end is listed from the edge on."""
    size = len(places)
    boundary = {
        label: Boundary("vertex", selection(numbered(places, (_framed(*end, p) for p in around)), size))
        for label, end in (("left", ((0, 0), 0)), ("right", ((1, 0), 3)))
    }
    flip = Symmetry(
        moved(places, lambda p: (1 - p[0], -p[1])),
        {"0": ("1", "flip"), "1": ("0", "flip")},
        {"left": ("right",), "right": ("left",)},
    )
    mirror = Symmetry(
        moved(places, _mirrored),
        {"0": ("0", "mirror"), "1": ("1", "mirror")},
        {"left": ("left", "mirror"), "right": ("right", "mirror")},
    )
    return Cell(
        "edge",
        size,
        {"0": "edge", "1": "edge"},
        boundary,
        {"flip": flip, "mirror": mirror},
        equations("edge", "incidence", [(("left", "s"), ("0", "left")), (("right", "s"), ("1", "right"))]),
        equations("edge", "adjacency", [(("0", "right"), ("1", "left", "turn", "turn", "turn"))]),
    )


def _turns(around: Sequence[Place]) -> dict[str, Symmetry]:
    moves = {"turn": lambda p: _turned(p, 1), "mirror": _mirrored}
    return {name: Symmetry(moved(around, move), {"s": ("s", name)}, {}) for name, move in moves.items()}


def _star(corners: Sequence[Place]) -> list[Place]:
    """Some places and all their neighbours, row after row."""
    found = {_framed(corner, n, step) for corner in corners for n in range(6) for step in ((0, 0), (1, 0))}
    return sorted(found, key=lambda p: (p[1], p[0]))


def _turned(place: Place, times: int) -> Place:
    """A place turned about (0, 0) by 60 degrees, some times."""
    x, y = place
    for _ in range(times):
        x, y = -y, x + y
    return x, y


def _framed(origin: Place, turns: int, place: Place) -> Place:
    """A place turned about (0, 0), then moved with it to an origin."""
    x, y = _turned(place, turns)
    return origin[0] + x, origin[1] + y


def _mirrored(place: Place) -> Place:
    """A place on the other side of the line through (0, 0) and (1, 0)."""
    x, y = place
    return x + y, -y
