"""L-systems that rewrite edges as controlled IFS: a cell for each letter, glued end to end."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from automata.automaton import Automaton, Boundary, Cell, Equation, Rows
from automata.expression import Number
from automata.growth import Growth, NotACurveSystem, Step, growth, unit
from automata.lsystem import LSystem, lsystem

SIZE = 90.0
MOST_PIECES = 20_000

_SQUARES = (Fraction(1, 4), Fraction(3, 4))
_LARGEST_DENOMINATOR = 1000
_CLOSE = 1e-12

Place = tuple[Fraction, Fraction]
"""`x + i h y` as (x, y)."""


@dataclass(frozen=True)
class _Piece:
    """A letter's curve laid from `start` to `end`, seen in a mirror or not."""

    cell: str
    start: complex
    end: complex
    mirrored: bool


def lsystem_automaton(text: str, name: str | None = None, source: str | None = None) -> Automaton:
    """The limit curve of an L-system of a Fractint `.l` text: `curve_of(lsystem(text, name, source))`.

    >>> koch = lsystem_automaton("Koch { Angle 6\\n Axiom F\\n F=F+F--F+F }")
    >>> [str(entry.value) for entry in koch.cells["F"].matrices["1"][2]]
    ['1/3', '0', '1/3']
    """
    return curve_of(lsystem(text, name, source))


def curve_of(system: LSystem) -> Automaton:
    """The limit curve of an L-system that rewrites edges, as a controlled IFS.

    Each letter a whose displacement v_a grows is a cell of three points, its ends 0 and 1 and `Q = 1/2 + i h`
    beside the middle. The k-th letter b of its rule, met by the turtle at the heading h_k, is a piece: the
    similarity `z -> p_k + g_k z` with `g_k = exp(2 pi i h_k / angle) v_b / v_a`, v_b one level below v_a,
    p_k the sum of the g before it; `!` mirrors the piece first. Pieces that follow each other share a vertex.
    Where turns repeat every p levels only, the levels have cells of their own (`F`, `F1`, …) unless these
    are equal, and the curve is the limit of the levels 0, p, 2p, … Letters that stay short become points and
    are left out (the F of Hilbert's curve); letters that never draw are gaps. An axiom of several letters is
    a cell `axiom` of its own, in the frame of its first letter; where it closes, the curve is glued to its
    start. The first letter is 90 mm long, in the direction of its heading.

    Coefficients are exact where h = 1/2 or h = sqrt(3)/2 makes them fractions of denominators up to 1000
    (recognised within 1e-12), else the nearest doubles; the constraints hold exactly in either case. Pieces
    that cross or touch elsewhere are not glued. Raises what `growth` raises, and `NotACurveSystem` for a rule
    that starts or ends with a gap, or that draws nothing.
    """
    found = growth(system)
    drawn = _merged({key: _pieces(system, found, *key) for key in _keys(found)})
    first = next((step for step in found.axiom if step.letter in found.visible), None)
    if first is None:
        raise _refused(system, "nothing of it is drawn at late levels")
    axiom = _axiom_pieces(system, found, first)
    reached = _reached(drawn, axiom)
    whole = [axiom, *(drawn[letter] for letter in reached)]
    if sum(len(pieces) for pieces in whole) > MOST_PIECES:
        raise _refused(system, f"its rules have over {MOST_PIECES} letters")
    for letter in reached:
        _require_ends(system, letter, drawn[letter])
    places, square = _recognised(whole)
    height = float(square) ** 0.5
    table = {letter: _cell(letter, drawn[letter], places, square) for letter in reached}
    shape = axiom[0].cell
    if len(axiom) > 1:
        shape = "axiom"
        table = {shape: _axiom(axiom, places, square)} | table
    table["vertex"] = Cell("vertex", 1, {"s": "vertex"}, matrices={"s": ((Number(Fraction(1)),),)})
    turn, half = unit(first.heading, system.angle), complex(0.5, -height if first.mirrored else height)
    corners = [SIZE * turn * corner for corner in (0j, half, 1 + 0j)]
    control = tuple((corner.real, corner.imag) for corner in corners)
    return Automaton(system.name, shape, table, control=control)


def _keys(found: Growth) -> list[tuple[str, int]]:
    """The letters that draw, at each level of the period, the last one (which the axiom has) first."""
    levels = range(len(found.ways) - 1, 0, -1)
    return [(letter, level) for level in levels for letter in found.ways[0] if letter in found.visible]


def _name(letter: str, level: int, found: Growth) -> str:
    return letter if level in (0, len(found.ways) - 1) else f"{letter}{level}"


def _pieces(system: LSystem, found: Growth, letter: str, level: int) -> tuple[str, tuple[_Piece, ...]]:
    """The name and the visible pieces of a letter at a level of the period, in its own frame."""
    steps, whole = found.steps[level][letter], found.ways[level][letter]
    pieces = _laid(system, found, steps, level - 1)
    framed = [replace(piece, start=piece.start / whole, end=piece.end / whole) for piece in pieces]
    return _name(letter, level, found), tuple(framed)


def _axiom_pieces(system: LSystem, found: Growth, first: Step) -> tuple[_Piece, ...]:
    """The visible pieces of the axiom in the frame of the first of them."""
    pieces = _laid(system, found, found.axiom, len(found.ways) - 1)
    origin, whole = pieces[0].start, pieces[0].end - pieces[0].start
    result = []
    for piece in pieces:
        start, end = (piece.start - origin) / whole, (piece.end - origin) / whole
        if first.mirrored:
            start, end = start.conjugate(), end.conjugate()
        result.append(_Piece(piece.cell, start, end, piece.mirrored != first.mirrored))
    return tuple(result)


def _laid(system: LSystem, found: Growth, steps: Sequence[Step], level: int) -> list[_Piece]:
    """The visible letters one after the other, each as long as it is at a level."""
    at, pieces = 0j, []
    for step in steps:
        way = found.ways[level][step.letter]
        after = at + unit(step.heading, system.angle) * (way.conjugate() if step.mirrored else way)
        if step.letter in found.visible:
            pieces.append(_Piece(_name(step.letter, level, found), at, after, step.mirrored))
        at = after
    return pieces


def _merged(
    named: Mapping[tuple[str, int], tuple[str, tuple[_Piece, ...]]],
) -> dict[str, tuple[_Piece, ...]]:
    """The pieces of each name; a name of another level than the last stands for an equal one before it."""
    drawn = dict(named.values())
    classes = dict.fromkeys(drawn, 0)
    while True:
        keys = {name: _key(pieces, classes) for name, pieces in drawn.items()}
        numbers = {key: number for number, key in enumerate(dict.fromkeys(keys.values()))}
        found = {name: numbers[key] for name, key in keys.items()}
        if len(numbers) == len(set(classes.values())):
            break
        classes = found
    standing: dict[int, str] = {}
    for name in drawn:
        standing.setdefault(classes[name], name)
    return {
        name: tuple(replace(piece, cell=standing[classes[piece.cell]]) for piece in pieces)
        for name, pieces in drawn.items()
    }


def _key(pieces: tuple[_Piece, ...], classes: Mapping[str, int]) -> tuple:
    digits = 11
    return tuple(
        (
            classes[p.cell],
            p.mirrored,
            *(round(x, digits) + 0.0 for x in (p.start.real, p.start.imag, p.end.real, p.end.imag)),
        )
        for p in pieces
    )


def _reached(drawn: dict[str, tuple[_Piece, ...]], axiom: tuple[_Piece, ...]) -> list[str]:
    reached = list(dict.fromkeys(piece.cell for piece in axiom))
    for letter in reached:
        reached += [c for c in dict.fromkeys(piece.cell for piece in drawn[letter]) if c not in reached]
    return reached


def _require_ends(system: LSystem, letter: str, pieces: tuple[_Piece, ...]) -> None:
    if not pieces:
        raise _refused(system, f"the rule of {letter!r} draws nothing")
    if abs(pieces[0].start) > _CLOSE or abs(pieces[-1].end - 1) > _CLOSE:
        raise _refused(system, f"the rule of {letter!r} starts or ends with letters that only move")


def _recognised(whole: Sequence[Sequence[_Piece]]) -> tuple[dict[complex, Place], Fraction]:
    """The ends of all pieces as (x, y), and the square of h: fractions if one of two h makes them so."""
    ends = {end for pieces in whole for piece in pieces for end in (piece.start, piece.end)}
    for square in _SQUARES:
        height = float(square) ** 0.5
        found = {z: (_fraction(z.real), _fraction(z.imag / height)) for z in ends}
        if all(x is not None and y is not None for x, y in found.values()):
            return {z: (x or Fraction(0), y or Fraction(0)) for z, (x, y) in found.items()}, square
    rounded = {}
    for z in ends:
        near = next((end for end in (0, 1) if abs(z - end) <= _CLOSE), None)
        rounded[z] = (
            (Fraction(z.real), Fraction(2 * z.imag)) if near is None else (Fraction(near), Fraction(0))
        )
    return rounded, _SQUARES[0]


def _fraction(value: float) -> Fraction | None:
    found = Fraction(value).limit_denominator(_LARGEST_DENOMINATOR)
    return found if abs(float(found) - value) <= _CLOSE else None


def _cell(name: str, pieces: tuple[_Piece, ...], places: dict[complex, Place], square: Fraction) -> Cell:
    """A letter's cell: it runs from its point 0 to its point 2."""
    ends = {"left": _column((Fraction(0), Fraction(0))), "right": _column((Fraction(1), Fraction(0)))}
    incidence = ("left s = 0 left", f"right s = {len(pieces) - 1} right")
    return _chain(name, pieces, places, square, ends, incidence)


def _axiom(pieces: tuple[_Piece, ...], places: dict[complex, Place], square: Fraction) -> Cell:
    """The cell of an axiom of several letters: closed, or from its first point to its last."""
    last = len(pieces) - 1
    if abs(pieces[-1].end - pieces[0].start) <= _CLOSE:
        places = places | {pieces[-1].end: places[pieces[0].start]}
        return _chain("axiom", pieces, places, square, {}, (), (f"{last} right = 0 left",))
    ends = {"left": _column(places[pieces[0].start]), "right": _column(places[pieces[-1].end])}
    incidence = ("left s = 0 left", f"right s = {last} right")
    return _chain("axiom", pieces, places, square, ends, incidence)


def _chain(
    name: str,
    pieces: tuple[_Piece, ...],
    places: dict[complex, Place],
    square: Fraction,
    ends: dict[str, Rows],
    incidence: tuple[str, ...],
    closing: tuple[str, ...] = (),
) -> Cell:
    matrices, joints, joined = {}, [], [(places[piece.start], places[piece.end]) for piece in pieces]
    for k, piece in enumerate(pieces):
        if k and abs(piece.start - pieces[k - 1].end) <= _CLOSE:
            joints.append(f"{k - 1} right = {k} left")
            joined[k] = (joined[k - 1][1], joined[k][1])
    for k, piece in enumerate(pieces):
        matrices[str(k)] = _operator(*joined[k], piece.mirrored, square)
    return Cell(
        name,
        3,
        {str(k): piece.cell for k, piece in enumerate(pieces)},
        {label: Boundary("vertex", rows) for label, rows in ends.items()},
        incidence=_equations(name, "incidence", incidence),
        adjacency=_equations(name, "adjacency", (*joints, *closing)),
        matrices=matrices,
    )


def _operator(start: Place, end: Place, mirrored: bool, square: Fraction) -> Rows:
    """The similarity that takes 0 to the start and 1 to the end: the images of 0, Q and 1 by columns."""
    (x, y), dx, dy = start, end[0] - start[0], end[1] - start[1]
    side = -1 if mirrored else 1
    beside = (x + dx / 2 - side * square * dy, y + dy / 2 + side * dx)
    columns = [_weights(place) for place in (start, beside, end)]
    return tuple(tuple(Number(column[row]) for column in columns) for row in range(3))


def _column(place: Place) -> Rows:
    return tuple((Number(weight),) for weight in _weights(place))


def _weights(place: Place) -> tuple[Fraction, Fraction, Fraction]:
    """A place in terms of 0, `Q = 1/2 + i h` and 1."""
    x, y = place
    return 1 - x - y / 2, y, x - y / 2


def _equations(cell: str, kind: str, texts: Sequence[str]) -> tuple[Equation, ...]:
    found = []
    for number, text in enumerate(texts):
        left, right = (tuple(side.split()) for side in text.split("="))
        found.append(Equation(left, right, text, ("cells", cell, kind, number)))
    return tuple(found)


def _refused(system: LSystem, why: str) -> NotACurveSystem:
    return NotACurveSystem(f"the L-system {system.name!r} is no curve that rewrites its edges: {why}")
