"""The automaton of all the patches of a subdivision surface, whatever the valences of their corners.

A patch has four corners. At each corner some number of patches meet, its *valence*: 4 where the surface is
regular. What a patch becomes depends on its four valences alone, so the states are: a face for each four
valences, an edge for each pair, a vertex for each valence. A subdivision leaves each patch with one of the
old corners, and with three new ones that are regular. Catmull and Clark's scheme and Doo and Sabin's differ
only in which control points a corner depends on and in the coefficients: that is what a `Scheme` holds.
Source: Gentil 2010, §4.4.1-4.4.2.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from automata.automaton import Automaton, Boundary, Cell, Equation, Figure, Rows, Symmetry
from automata.expression import Number

REGULAR = 4
SIDES = ("bottom", "right", "top", "left")

Star = Sequence[Any]
"""The points that a corner depends on, from one of its edges on and counterclockwise around it."""

Form = Mapping[int, Fraction]
"""A combination of control points: the weight of each."""

Valences = tuple[int, int, int, int]

_ONE, _ZERO = Number(Fraction(1)), Number(Fraction(0))


@dataclass(frozen=True)
class Scheme:
    """What tells one scheme of quadrangular patches from another.

    Points may be numbers, arrays of numbers or combinations of points; only `vertex`, `edge` and `face`
    compute with them, and these take combinations (`Form`). The star of a corner is listed from an edge on.

    - `turned(star)`: the same star from the next edge on, counterclockwise;
    - `edge_row(a, b)`: the points of an edge, from the stars of its two ends, each from that edge on;
    - `face_row(stars)`: the points of a face, from the stars of its corners, each from the side after it on;
    - `local_stars(valences)`: the stars of a vertex, an edge or a face (1, 2 or 4 valences) as numbers of its
      own points;
    - `vertex(star)`: the star after a subdivision; `edge(a, b)`: the stars of the ends of the two edges;
      `face(stars)`: the stars of the corners of the four faces, face i beginning at corner i.
    """

    name: str
    turned: Callable[[Star], Star]
    edge_row: Callable[[Star, Star], Star]
    face_row: Callable[[Sequence[Star]], Star]
    local_stars: Callable[[Sequence[int]], Sequence[Sequence[int]]]
    vertex: Callable[[Star], Star]
    edge: Callable[[Star, Star], Sequence[tuple[Star, Star]]]
    face: Callable[[Sequence[Star]], Sequence[Sequence[Star]]]


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


def canonical(valences: Valences) -> tuple[Valences, int]:
    """The valences of a patch from the corner that stands first in its state, and which corner that is.

    Regular corners come last, so that a patch with one extraordinary corner begins there.

    >>> canonical((4, 4, 3, 4))
    ((3, 4, 4, 4), 2)
    """
    a, b, c, d = valences
    turns: list[Valences] = [(a, b, c, d), (b, c, d, a), (c, d, a, b), (d, a, b, c)]
    best = max(turns, key=lambda found: [(n != REGULAR, n) for n in found])
    return best, turns.index(best)


def face_name(valences: Sequence[int]) -> str:
    """The name of the state of a patch."""
    return "face-" + "-".join(map(str, valences))


def automaton(scheme: Scheme, kinds: Iterable[Valences]) -> Automaton:
    """The automaton of the patches with these valences at their corners, and of all that they become.

    It has a face state for each kind, and for (n, 4, 4, 4) where a corner has valence n; its operators are
    given, exactly, and the incidences and adjacencies are stated, so that `subdivision.solve` proves them.
    The shape is the first kind. Draw patches with `ifs.patchwork`.

    Raises `ValueError` for no kinds, or a valence below 3.

    >>> from subdivision.schemes import catmull_clark
    >>> sorted(automaton(catmull_clark.SCHEME, [(3, 3, 3, 3)]).cells)[:4]
    ['edge-3-3', 'edge-3-4', 'edge-4-4', 'face-3-3-3-3']
    """
    wanted = sorted({canonical(kind)[0] for kind in kinds})
    if not wanted:
        raise ValueError("a surface has at least one kind of patch")
    if min(map(min, wanted)) < 3:
        raise ValueError(f"at least 3 patches meet at a corner, found the valences {min(wanted, key=min)}")
    valences = sorted({n for kind in wanted for n in kind} | {REGULAR})
    children = {canonical((n, REGULAR, REGULAR, REGULAR))[0] for n in valences}
    faces = [*wanted, *sorted(children - set(wanted))]
    sides = (zip(kind, (*kind[1:], kind[0]), strict=True) for kind in faces)
    pairs = sorted({(min(pair), max(pair)) for side in sides for pair in side})
    cells = [_face(scheme, kind) for kind in faces]
    cells = [*cells, *(_edge(scheme, *pair) for pair in pairs), *(_vertex(scheme, n) for n in valences)]
    return Automaton(scheme.name, cells[0].name, {cell.name: cell for cell in cells})


def _vertex(scheme: Scheme, n: int) -> Cell:
    (star,) = scheme.local_stars([n])
    size = len(star)
    symmetry = {"turn": Symmetry(tuple(scheme.turned(star)), {"s": ("s", "turn")}, {})}
    operator = _operator(size, scheme.vertex(_points(star)))
    return Cell(_vertex_name(n), size, {"s": _vertex_name(n)}, symmetry=symmetry, matrices={"s": operator})


def _vertex_name(n: int) -> str:
    return f"vertex-{n}"


def _edge_name(a: int, b: int) -> str:
    return f"edge-{min(a, b)}-{max(a, b)}"


def _edge(scheme: Scheme, a: int, b: int) -> Cell:
    """The edge between corners of valences a <= b; it runs from the left end, a, to the right one."""
    left, right = scheme.local_stars([a, b])
    name, size = _edge_name(a, b), len(scheme.edge_row(left, right))
    halves = scheme.edge(_points(left), _points(right))
    # A half runs from its end of lower valence to the other one, and like the whole edge if both are regular.
    ends = [(a, halves[0]), (b, halves[1])]
    backward = [a > REGULAR, b < REGULAR]
    rows = [
        scheme.edge_row(*(half[::-1] if back else half))
        for (_, half), back in zip(ends, backward, strict=True)
    ]
    outer = ["right" if backward[0] else "left", "left" if backward[1] else "right"]
    inner = [_other(end) for end in outer]
    path = ("cells", name)
    incidence = [f"left s = 0 {outer[0]}", f"right s = 1 {outer[1]}"]
    flip = Symmetry(
        tuple(scheme.edge_row(right, left)),
        {"0": ("1", "flip"), "1": ("0", "flip")} if a == REGULAR else {"0": ("1",), "1": ("0",)},
        {"left": ("right",), "right": ("left",)},
    )
    return Cell(
        name,
        size,
        {"0": _edge_name(a, REGULAR), "1": _edge_name(REGULAR, b)},
        {"left": _selection(_vertex_name(a), left, size), "right": _selection(_vertex_name(b), right, size)},
        {"flip": flip} if a == b else {},
        _equations(incidence, (*path, "incidence")),
        _equations([f"0 {inner[0]} = 1 {inner[1]} turn turn"], (*path, "adjacency")),
        {str(i): _operator(size, row) for i, row in enumerate(rows)},
    )


def _other(end: str) -> str:
    return "left" if end == "right" else "right"


def _face(scheme: Scheme, valences: Valences) -> Cell:
    stars = scheme.local_stars(valences)
    name, size = face_name(valences), len(scheme.face_row(stars))
    children = scheme.face([_points(star) for star in stars])
    child_names = [face_name((n, REGULAR, REGULAR, REGULAR)) for n in valences]
    boundary, incidence, adjacency = {}, [], []
    for i, side in enumerate(SIDES):
        j = (i + 1) % 4
        a, b = valences[i], valences[j]
        ends = (stars[i], turned(scheme, stars[j], 1))
        backward = a > b
        row = scheme.edge_row(*(ends[::-1] if backward else ends))
        boundary[side] = _selection(_edge_name(a, b), row, size)
        # The part of a side next to a regular corner runs as the side does, in a sub-face counterclockwise.
        near, far = ("1", "0") if backward else ("0", "1")
        incidence.append(f"{side} {near} = {i} bottom{_flip(backward and a == REGULAR)}")
        incidence.append(f"{side} {far} = {j} left{_flip(backward and b == REGULAR)}")
        adjacency.append(f"{i} right = {j} top flip")
    path = ("cells", name)
    return Cell(
        name,
        size,
        {str(i): child for i, child in enumerate(child_names)},
        boundary,
        {},
        _equations(incidence, (*path, "incidence")),
        _equations(adjacency, (*path, "adjacency")),
        {str(i): _operator(size, scheme.face_row(child)) for i, child in enumerate(children)},
        # Corners are met along the bottom first; the figure runs counterclockwise whichever way that goes.
        Figure("faces", (), ((1, 0, 3, 2),) if valences[0] > valences[1] else ((0, 1, 2, 3),)),
    )


def _flip(wanted: bool) -> str:
    return " flip" if wanted else ""


def _points(star: Star) -> list[Form]:
    return [{point: Fraction(1)} for point in star]


def _operator(size: int, columns: Star) -> Rows:
    numbers = [[column.get(row, 0) for column in columns] for row in range(size)]
    return tuple(tuple(Number(Fraction(value)) if value else _ZERO for value in row) for row in numbers)


def _selection(cell: str, chosen: Star, size: int) -> Boundary:
    return Boundary(
        cell, tuple(tuple(_ONE if point == row else _ZERO for point in chosen) for row in range(size))
    )


def _equations(texts: Sequence[str], path: tuple[str | int, ...]) -> tuple[Equation, ...]:
    sides = [text.split(" = ") for text in texts]
    return tuple(
        Equation(tuple(left.split()), tuple(right.split()), text, (*path, i))
        for i, ((left, right), text) in enumerate(zip(sides, texts, strict=True))
    )
