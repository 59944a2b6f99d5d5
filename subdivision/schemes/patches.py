"""The automaton of all the quadrangular patches of a subdivision surface.

What a patch becomes depends on what surrounds its four corners: how many patches meet there and, where a
scheme knows boundaries, creases or regions of other coefficients, which of its edges are of that sort. So the
states are: a face for each four corners, an edge for each pair, a vertex for each corner. A `Scheme` says
what corners there are, which control points they depend on and what these become; all else, the states that
are needed, their operators, which boundaries coincide and through which symmetry, is worked out here.
Source: Gentil 2010, §4.4.1-4.4.2.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Any, NamedTuple

from automata.automaton import Automaton, Boundary, Cell, Equation, Figure, Rows, Symmetry, Word
from automata.expression import Number

SIDES = ("bottom", "right", "top", "left")

Form = Mapping[int, Fraction]
"""A combination of control points: the weight of each."""

Point = Any
"""A control point of a star: its number, an array of numbers, or a `Form`; None where there is none."""

_ONE, _ZERO = Number(Fraction(1)), Number(Fraction(0))


class Star(NamedTuple):
    """A corner of a patch, and the points that it depends on, counterclockwise from one of its edges on.

    `corner` is what the scheme knows of the surroundings: equal corners behave alike.
    """

    corner: Any
    points: tuple[Point, ...]


Corners = tuple[Any, ...]


@dataclass(frozen=True)
class Scheme:
    """What tells one scheme of quadrangular patches from another.

    Only `vertex`, `edge` and `face` compute with points, and these are given combinations (`Form`).

    - `edges(corner)`: how many edges meet in a corner; `turned(star)`: the same star from the next edge on;
    - `stars(corners)`: the stars of a vertex, an edge or a face (1, 2 or 4 corners), with numbers as points,
      equal where two stars have a point in common; those of an edge begin at it, those of a face each at
      the side after its corner;
    - `in_face(star)`, `in_edge(a, b)`, `in_vertex(star)`: as much of the stars as a face, an edge or a vertex
      depends on;
    - `vertex(star)`: the star after a subdivision; `edge(a, b)`: the stars of the ends of the two edges;
      `face(stars)`: the stars of the corners of the four faces, face i beginning at corner i;
    - `text(corner)`: the corner in a few letters, and `order(corner)`: what corners are sorted by.
    """

    name: str
    edges: Callable[[Any], int]
    turned: Callable[[Star], Star]
    stars: Callable[[Corners], Sequence[Star]]
    in_face: Callable[[Star], Star]
    in_edge: Callable[[Star, Star], tuple[Star, Star]]
    in_vertex: Callable[[Star], Star]
    vertex: Callable[[Star], Star]
    edge: Callable[[Star, Star], Sequence[tuple[Star, Star]]]
    face: Callable[[Sequence[Star]], Sequence[Sequence[Star]]]
    text: Callable[[Any], str]
    order: Callable[[Any], Any]


class Seen(NamedTuple):
    """A cell as some stars show it: its corners, its points in its own order, and the star it begins with."""

    corners: Corners
    points: tuple[Point, ...]
    first: int


@dataclass(frozen=True)
class _State:
    """A cell with its sub-cells and boundaries; `symmetry` turns its points, where it can be turned."""

    corners: Corners
    size: int
    pieces: Mapping[str, Seen]
    boundary: Mapping[str, Seen]
    symmetry: tuple[int, ...] | None = None


def mixed(*terms: tuple[Fraction, Form]) -> Form:
    """A combination of combinations of points.

    >>> half = Fraction(1, 2)
    >>> mixed((half, {0: Fraction(1)}), (half, {1: Fraction(1)}))
    {0: Fraction(1, 2), 1: Fraction(1, 2)}
    """
    result: dict[int, Fraction] = {}
    for weight, form in terms:
        for point, value in form.items():
            result[point] = result.get(point, Fraction(0)) + weight * value
    return {point: value for point, value in result.items() if value}


def turned(scheme: Scheme, star: Star, times: int) -> Star:
    """A star from its edge `times` further on, counterclockwise."""
    for _ in range(times):
        star = scheme.turned(star)
    return star


def face_seen(scheme: Scheme, stars: Sequence[Star]) -> Seen:
    """The face between four stars; of its turns that one whose corners come last in order."""
    stars = [scheme.in_face(star) for star in stars]
    turns = [(*stars[i:], *stars[:i]) for i in range(len(stars))]
    first = max(range(4), key=lambda i: ([scheme.order(star.corner) for star in turns[i]], -i))
    return _seen(scheme, turns[first], first)


def edge_seen(scheme: Scheme, a: Star, b: Star) -> Seen:
    """The edge between two stars that both begin with it, from the corner that comes first in order."""
    stars = scheme.in_edge(a, b)
    first = 1 if scheme.order(stars[1].corner) < scheme.order(stars[0].corner) else 0
    return _seen(scheme, (stars[first], stars[1 - first]), first)


def vertex_seen(scheme: Scheme, star: Star) -> Seen:
    """The vertex of a star; of its turns that one which comes first in order."""
    star = scheme.in_vertex(star)
    turns = [turned(scheme, star, i) for i in range(max(scheme.edges(star.corner), 1))]
    first = min(range(len(turns)), key=lambda i: (scheme.order(turns[i].corner), i))
    return _seen(scheme, (turns[first],), first)


def _seen(scheme: Scheme, stars: Sequence[Star], first: int) -> Seen:
    corners = tuple(star.corner for star in stars)
    return Seen(corners, tuple(stars[i].points[k] for i, k in _places(scheme, corners)), first)


@cache
def _places(scheme: Scheme, corners: Corners) -> tuple[tuple[int, int], ...]:
    """Where each point of a cell is first met, by its number: the number of the star, and the place in it."""
    found: dict[int, tuple[int, int]] = {}
    for i, star in enumerate(scheme.stars(corners)):
        for k, point in enumerate(star.points):
            if point is not None:
                found.setdefault(point, (i, k))
    return tuple(found[point] for point in sorted(found))


def cell_name(scheme: Scheme, corners: Corners) -> str:
    """The name of a state: `face`, `edge` or `vertex`, and its corners."""
    kind = {1: "vertex", 2: "edge", 4: "face"}[len(corners)]
    return "-".join((kind, *(scheme.text(corner) for corner in corners)))


def automaton(scheme: Scheme, faces: Iterable[Corners], given: bool = True) -> Automaton:
    """The automaton of the patches with these corners, and of all that they become.

    The operators are `given`, exactly, or left open: then the coefficients are free, and `subdivision.solve`
    finds all that fit. The incidences and adjacencies are stated either way, so that solving proves them. The
    shape is the first face. Draw patches with `ifs.patchwork`.

    Raises `ValueError` for no faces.

    >>> from subdivision.schemes import catmull_clark
    >>> corners = (catmull_clark.ring(3),) * 4
    >>> sorted(automaton(catmull_clark.SCHEME, [corners]).cells)[:4]
    ['edge-3-3', 'edge-3-4', 'edge-4-4', 'face-3-3-3-3']
    """
    wanted = [face_seen(scheme, scheme.stars(corners)).corners for corners in faces]
    if not wanted:
        raise ValueError("a surface has at least one kind of patch")
    found = dict.fromkeys(sorted(wanted, key=lambda face: [scheme.order(corner) for corner in face]))
    states: dict[Corners, _State] = {}
    waiting = list(found)
    for corners in waiting:
        if corners in states:
            continue
        states[corners] = state = _BUILDERS[len(corners)](scheme, corners)
        waiting.extend(seen.corners for seen in (*state.pieces.values(), *state.boundary.values()))
    ordered = sorted(states, key=lambda corners: -len(corners))
    cells = [_Writer(scheme, states, states[corners]).cell(given) for corners in ordered]
    return Automaton(scheme.name, cells[0].name, {cell.name: cell for cell in cells})


# ---- states ------------------------------------------------------------------------------------------------


def _vertex(scheme: Scheme, corners: Corners) -> _State:
    (star,) = scheme.stars(corners)
    pieces = {"s": vertex_seen(scheme, scheme.vertex(_forms(star)))}
    symmetry = None
    for i in range(1, scheme.edges(star.corner)):
        other = turned(scheme, star, i)
        if other.corner == star.corner:
            symmetry = tuple(point for point in other.points if point is not None)
            break
    return _State(corners, _size([star]), pieces, {}, symmetry)


def _edge(scheme: Scheme, corners: Corners) -> _State:
    a, b = scheme.stars(corners)
    halves = scheme.edge(_forms(a), _forms(b))
    pieces = {str(i): edge_seen(scheme, *half) for i, half in enumerate(halves)}
    boundary = {"left": vertex_seen(scheme, a), "right": vertex_seen(scheme, b)}
    same = a.corner == b.corner
    symmetry = _seen(scheme, (b, a), 0).points if same else None
    return _State(corners, _size([a, b]), pieces, boundary, symmetry)


def _face(scheme: Scheme, corners: Corners) -> _State:
    stars = scheme.stars(corners)
    children = scheme.face([_forms(star) for star in stars])
    pieces = {str(i): face_seen(scheme, child) for i, child in enumerate(children)}
    boundary = {
        side: edge_seen(scheme, stars[i], scheme.turned(stars[(i + 1) % 4])) for i, side in enumerate(SIDES)
    }
    return _State(corners, _size(stars), pieces, boundary)


_BUILDERS: Mapping[int, Callable[[Scheme, Corners], _State]] = {1: _vertex, 2: _edge, 4: _face}


def _size(stars: Sequence[Star]) -> int:
    return len({point for star in stars for point in star.points if point is not None})


def _forms(star: Star) -> Star:
    return Star(star.corner, tuple(None if p is None else {p: Fraction(1)} for p in star.points))


# ---- cells -------------------------------------------------------------------------------------------------


class _Writer:
    """A state as a cell: names, matrices, and the equations with the symmetries that they need."""

    def __init__(self, scheme: Scheme, states: Mapping[Corners, _State], state: _State):
        self.scheme = scheme
        self.states = states
        self.state = state
        self.name = cell_name(scheme, state.corners)

    def cell(self, given: bool) -> Cell:
        state = self.state
        incidence, adjacency = self._pairs()
        matrices = {label: _matrix(state.size, piece.points) for label, piece in state.pieces.items()}
        return Cell(
            self.name,
            state.size,
            {label: cell_name(self.scheme, piece.corners) for label, piece in state.pieces.items()},
            {label: self._boundary(seen) for label, seen in state.boundary.items()},
            self._symmetry(),
            self._equations("incidence", incidence),
            self._equations("adjacency", adjacency),
            matrices if given else {},
            self._figure(),
        )

    def _boundary(self, seen: Seen) -> Boundary:
        return Boundary(
            cell_name(self.scheme, seen.corners),
            _matrix(self.state.size, [{point: Fraction(1)} for point in seen.points]),
        )

    def _figure(self) -> Figure | None:
        """Corners are met along the bottom first; the figure runs counterclockwise all the same."""
        if len(self.state.corners) != 4:
            return None
        backward = self.state.boundary["bottom"].first == 1
        return Figure("faces", (), ((1, 0, 3, 2),) if backward else ((0, 1, 2, 3),))

    def _pairs(self) -> tuple[list[tuple[Word, Word]], list[tuple[Word, Word]]]:
        """The paths that lead to one cell: incidences, and adjacencies."""
        pieces, boundary = self.state.pieces, self.state.boundary
        if len(self.state.corners) == 2:
            outer = [("left", "right")[piece.first != i] for i, piece in enumerate(pieces.values())]
            inner = [{"left": "right", "right": "left"}[end] for end in outer]
            return [(("left", "s"), ("0", outer[0])), (("right", "s"), ("1", outer[1]))], [
                (("0", inner[0]), ("1", inner[1]))
            ]
        if len(self.state.corners) == 1:
            return [], []
        incidence, adjacency = [], []
        for i, side in enumerate(SIDES):
            j = (i + 1) % 4
            near, far = ("1", "0") if boundary[side].first == 1 else ("0", "1")
            incidence += [((side, near), self._side(i, 0)), ((side, far), self._side(j, 3))]
            adjacency.append((self._side(i, 1), self._side(j, 2)))
        return incidence, adjacency

    def _side(self, piece: int, number: int) -> Word:
        """A side of a sub-face, counted from the one that begins at the old corner."""
        label = str(piece)
        return label, SIDES[(number - self.state.pieces[label].first) % 4]

    def _symmetry(self) -> dict[str, Symmetry]:
        points = self.state.symmetry
        if points is None:
            return {}
        name = _SYMMETRY[len(self.state.corners)]
        if len(self.state.corners) == 1:
            return {name: Symmetry(points, {"s": ("s", *self._between(points, ("s",), ("s",)))}, {})}
        pieces = {a: (b, *self._between(points, (a,), (b,))) for a, b in (("0", "1"), ("1", "0"))}
        ends = {a: (b, *self._between(points, (a,), (b,))) for a, b in (("left", "right"), ("right", "left"))}
        return {name: Symmetry(points, pieces, ends)}

    def _between(self, points: Sequence[int], path: Word, image: Word) -> Word:
        """The symmetry g with `S path = image g`, S the symmetry of this cell with these points."""
        own = _probes(self.state.size)
        moved = self._values(path, [own[point] for point in points])
        return self._turning(moved, self._values(image, own), self._end(path))

    def _equations(self, kind: str, pairs: Sequence[tuple[Word, Word]]) -> tuple[Equation, ...]:
        result = []
        own = _probes(self.state.size)
        for i, (left, right) in enumerate(pairs):
            turning = self._turning(self._values(left, own), self._values(right, own), self._end(left))
            text = f"{' '.join(left)} = {' '.join((*right, *turning))}"
            result.append(Equation(left, (*right, *turning), text, ("cells", self.name, kind, i)))
        return tuple(result)

    def _turning(self, left: Sequence[int], right: Sequence[int], end: Corners) -> Word:
        """The symmetry of a cell, as a word, through which one path to it sees it like the other."""
        symmetry = self.states[end].symmetry
        turn: tuple[int, ...] = tuple(range(len(right)))
        for times in range(len(right) + 1):
            if all(left[j] == right[turn[j]] for j in range(len(turn))):
                return (_SYMMETRY[len(end)],) * times
            if symmetry is None:
                break
            turn = tuple(symmetry[i] for i in turn)
        raise AssertionError(f"two paths to {cell_name(self.scheme, end)} in {self.name} do not agree")

    def _end(self, path: Word) -> Corners:
        state = self.state
        for label in path:
            state = self.states[(state.pieces.get(label) or state.boundary[label]).corners]
        return state.corners

    def _values(self, path: Word, own: Sequence[int]) -> list[int]:
        """The points of the cell at the end of a path, where those of this cell have the given values."""
        state, values = self.state, list(own)
        for label in path:
            if label in state.pieces:
                found = state.pieces[label]
                values = [
                    sum(_residue(w) * values[p] for p, w in form.items()) % _PRIME for form in found.points
                ]
            else:
                found = state.boundary[label]
                values = [values[p] for p in found.points]
            state = self.states[found.corners]
        return values


_PRIME = 2**61 - 1


def _probes(size: int) -> list[int]:
    """Values modulo a prime that tell points, and combinations of points, from each other."""
    return [pow(7, 40 + 11 * i, _PRIME) for i in range(size)]


@cache
def _residue(weight: Fraction) -> int:
    return weight.numerator * pow(weight.denominator, -1, _PRIME) % _PRIME


_SYMMETRY = {1: "turn", 2: "flip"}


def _matrix(size: int, columns: Sequence[Form]) -> Rows:
    return tuple(
        tuple(Number(column[row]) if row in column else _ZERO for column in columns) for row in range(size)
    )
