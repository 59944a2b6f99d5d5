"""Addresses of points: a word of labels, then another one repeated for ever."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

from ifs.shape import Shape
from ifs.system import System

MOST_LABELS = 200

Word = tuple[str, ...]

_REPEATED = re.compile(r"([^()]*)\(([^()]*)\)\*\s*")


@dataclass(frozen=True)
class Address:
    """`word`, then `repeat` for ever; in normal form, so that equal infinite words compare equal.

    The normal form repeats no shorter word, and `word` does not end as `repeat` does. Made by `address`.
    """

    word: Word
    repeat: Word

    def __str__(self) -> str:
        return " ".join((*self.word, f"({' '.join(self.repeat)})*"))

    def after(self, count: int) -> "Address":
        """What follows the first labels."""
        rest = [self.label(k) for k in range(count, max(count, len(self.word)))]
        turn = max(count - len(self.word), 0) % len(self.repeat)
        return address(rest, self.repeat[turn:] + self.repeat[:turn])

    def label(self, place: int) -> str:
        """The label at a place, counted from 0."""
        if place < len(self.word):
            return self.word[place]
        return self.repeat[(place - len(self.word)) % len(self.repeat)]


class UnknownLabel(ValueError):
    """A label in an address that the cell reached there does not have; `labels` are those it has."""

    def __init__(self, label: str, place: int, cell: str, labels: Word):
        self.label = label
        self.place = place
        self.cell = cell
        self.labels = labels
        super().__init__(
            f"unknown label {label!r} at place {place + 1} of the address: cell {cell!r} is reached there, "
            f"whose labels are {', '.join(labels)}"
        )


def address(word: Sequence[str], repeat: Sequence[str]) -> Address:
    """The address of a word and what repeats after it, in normal form. Raises `ValueError` for no repeat.

    >>> str(address(["1", "0"], ["1", "0", "1", "0"]))
    '(1 0)*'
    """
    ahead, cycle = list(word), list(repeat)
    if not cycle:
        raise ValueError("an address repeats at least one label, as in '1 (0)*'")
    size = len(cycle)
    period = next(p for p in range(1, size + 1) if size % p == 0 and cycle[:p] * (size // p) == cycle)
    cycle = cycle[:period]
    while ahead and ahead[-1] == cycle[-1]:
        cycle.insert(0, cycle.pop())
        ahead.pop()
    return Address(tuple(ahead), tuple(cycle))


def split_address(text: str) -> tuple[Word, Word]:
    """The word and the repeated word of a text such as `"0"`, `"1 0"` or `"0 1 (1 0)*"`, as they stand.

    Without `( )*` the last label repeats. Raises `ValueError` for an empty text, for parentheses elsewhere,
    and for more than 200 labels; `TypeError` for what is no text.

    >>> split_address("1 0 0")
    (('1', '0'), ('0',))
    """
    if not isinstance(text, str):
        raise TypeError(f"an address is a text such as '0', '1 0' or '1 (0 1)*'; found {text!r}")
    match = _REPEATED.fullmatch(text.strip())
    if match:
        word, repeat = match[1].split(), match[2].split()
    else:
        labels = text.split()
        word, repeat = labels[:-1], labels[-1:]
    if not repeat:
        raise ValueError(f"the address {text[:80]!r} must repeat one label or more, as in '0 1 (1 0)*'")
    if len(word) + len(repeat) > MOST_LABELS:
        count = len(word) + len(repeat)
        raise ValueError(f"the address has {count} labels; at most {MOST_LABELS} can be followed")
    if not match and any("(" in label or ")" in label for label in (*word, *repeat)):
        raise ValueError(f"the address {text[:80]!r} has parentheses elsewhere than in a last part '(…)*'")
    return tuple(word), tuple(repeat)


def parse_address(text: str) -> Address:
    """The address that a text such as `"0"`, `"1 0"` or `"0 1 (1 0)*"` states; see `split_address`.

    >>> str(parse_address("0 1 0 (1 0)*")), str(parse_address("1 0 0"))
    ('(0 1)*', '1 (0)*')
    """
    return address(*split_address(text))


@dataclass(frozen=True)
class Path:
    """An address as a path of cells: `word` leads from the start to `cell`, and `cycle` from there back."""

    word: Word
    cell: str
    cycle: Word


def path_of(system: System, where: Address, start: str | None = None) -> Path:
    """The path of an address from a cell, that of the shape unless another is given.

    Where the repeated word leads to another cell than it left, it is gone through until a cell comes again.
    Raises `UnknownLabel`, naming the place, the cell and the labels it has.

    >>> from ifs.shape import shape
    >>> path_of(shape("koch-curve").system, parse_address("1 (0 3)*"))
    Path(word=('1',), cell='edge', cycle=('0', '3'))
    """
    cell = system.shape if start is None else start
    for place, label in enumerate(where.word):
        cell = _next(system, cell, label, place)
    met: list[str] = []
    taken: list[str] = []
    while cell not in met:
        met.append(cell)
        for label in where.repeat:
            cell = _next(system, cell, label, len(where.word) + len(taken))
            taken.append(label)
    before = met.index(cell) * len(where.repeat)
    return Path((*where.word, *taken[:before]), cell, tuple(taken[before:]))


def _next(system: System, cell: str, label: str, place: int) -> str:
    state = system.states[cell]
    if label not in state.labels:
        raise UnknownLabel(label, place, cell, state.labels)
    return state.targets[state.labels.index(label)]


def vertex_address(shape: Shape, cell: str, corner: Word) -> Address | None:
    """An address, from a cell, of the point that a path of boundaries leads to, such as `("left",)`.

    The point is a boundary of a sub-piece again: its first label is that of the first such piece, and so on
    until a cell and a corner come again. None where the gluing does not say which sub-piece has the point.
    Raises `ValueError` for a corner that is no point.

    >>> from ifs.shape import shape
    >>> str(vertex_address(shape("koch-curve"), "edge", ("right",)))
    '(3)*'
    """
    topology = shape.topology
    if not topology.is_point(topology.automaton.end(cell, corner)):
        raise ValueError(f"the boundary {' '.join(corner)!r} of cell {cell!r} is no point")
    met: list[tuple[str, Word]] = []
    labels: list[str] = []
    while (cell, corner) not in met:
        met.append((cell, corner))
        end = topology.automaton.cells[topology.automaton.end(cell, corner)]
        place = topology.subdivided(cell).place
        standing = place[(*corner, next(iter(end.subdivision)))][0]
        subdivision = topology.automaton.cells[cell].subdivision
        found = [word for word, (other, _) in place.items() if other == standing and word[0] in subdivision]
        if not found:
            return None
        label, *rest = min(found, key=lambda word, order=list(subdivision): (order.index(word[0]), len(word)))
        labels.append(label)
        cell, corner = subdivision[label], tuple(rest)
    before = met.index((cell, corner))
    return address(labels[:before], labels[before:])


@dataclass(frozen=True)
class Joint:
    """A point of a cell where several of its sub-pieces meet: an address through each of these."""

    cell: str
    addresses: tuple[Address, ...]


def joints(shape: Shape, cell: str | None = None) -> tuple[Joint, ...]:
    """The points where sub-pieces of a cell meet (double and multiple points), by the automaton's gluing.

    Each has the addresses that go through the pieces meeting there, in the order of the labels: `0 (1)*` and
    `1 (0)*` for the joint of two halves of a curve. Points that only coincide for these matrices and control
    points, without being glued, are not seen. The cell is that of the shape unless another is given.

    >>> from ifs.shape import shape
    >>> [[str(a) for a in joint.addresses] for joint in joints(shape("sierpinski-triangle"))]
    [['0 (1)*', '1 (0)*'], ['0 (2)*', '2 (0)*'], ['1 (2)*', '2 (1)*']]
    """
    name = shape.topology.automaton.shape if cell is None else cell
    cells = shape.topology.automaton.cells
    if name not in cells:
        raise ValueError(f"there is no cell {name!r}; there are {', '.join(cells)}")
    subdivision = cells[name].subdivision
    classes: dict[Word, list[Word]] = {}
    for word, (standing, _) in shape.topology.subdivided(name).place.items():
        if word[0] in subdivision and shape.topology.is_point(shape.topology.automaton.end(name, word)):
            classes.setdefault(standing, []).append(word)
    found = []
    for words in classes.values():
        seen: dict[str, Address] = {}
        for label, *corner in sorted(words, key=lambda word: (list(subdivision).index(word[0]), len(word))):
            own = vertex_address(shape, subdivision[label], tuple(corner)) if label not in seen else None
            if own is not None:
                seen[label] = address((label, *own.word), own.repeat)
        if len(seen) > 1:
            found.append(Joint(name, tuple(seen.values())))
    return tuple(sorted(found, key=lambda joint: [str(a) for a in joint.addresses]))


def twins(shape: Shape, where: Address) -> tuple[Address, ...]:
    """The other addresses of the same point, by the gluing: those of the joints that lie on its way.

    Empty where the point is no joint. An address is followed through its word and one period; where a corner
    has several addresses inside one piece, one of them is given.

    >>> from ifs.shape import shape
    >>> [str(other) for other in twins(shape("koch-curve"), parse_address("2 1 (0)*"))]
    ['2 0 (3)*']
    """
    path = path_of(shape.system, where)
    cell, found = shape.system.shape, []
    ahead = (*path.word, *path.cycle)
    for place, label in enumerate(ahead):
        rest = where.after(place)
        for joint in joints(shape, cell):
            if rest in joint.addresses:
                others = [a for a in joint.addresses if a != rest]
                found += [address((*ahead[:place], *a.word), a.repeat) for a in others]
        cell = _next(shape.system, cell, label, place)
    return tuple(dict.fromkeys(a for a in found if a != where))
