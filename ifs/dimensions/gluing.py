"""Whether two systems are glued alike: then one attractor is a space of parameters of the other."""

from dataclasses import dataclass
from itertools import combinations
from typing import Literal

import numpy as np
from jaxtyping import Float

from ifs.certificates.bounds import sample
from ifs.dimensions.spans import configurations
from ifs.orbits import addresses
from ifs.shape import Shape

_SAME = 1e-9

Word = tuple[str, ...]
Address = tuple[Word, Word]
"""A word, then a word repeated for ever."""


@dataclass(frozen=True)
class Gluing:
    """How the second system keeps the gluing of the first.

    `broken` holds the equations of the first that fail in the second, each with the distance (mm) of its two
    sides there; `numeric` those that the second does not state but that hold for its numbers; `extra` those
    that the second states beyond.
    """

    kind: Literal["strong", "weak", "none"]
    broken: tuple[tuple[str, float], ...]
    numeric: tuple[str, ...]
    extra: tuple[str, ...]


def gluing(first: Shape, second: Shape) -> Gluing:
    """Compare the points that have two addresses, as the automata state them at the first subdivision.

    `H(phi(s)) = phi'(s)` maps the first attractor to the second when every double address of the first is one
    of the second ("les memes conditions de raccord"); it is one to one when the second has no others
    ("fortes"). Taken here: *strong* where both automata state the same equations between addresses; *weak*
    where all of the first hold in the second, but some only for these matrices and control points (to 9
    digits), or the second states more; *none* where one fails, or the pieces have other labels. Cells
    correspond as the labels lead to them. Only boundaries that are points are compared; points that touch
    without being stated are not looked for. Raises `ValueError` where the first states no gluing of points.
    Source: Gentil 2010, 3.3.2.

    >>> from ifs.shape import shape
    >>> from subdivision.schemes import de_rham
    >>> gluing(shape("takagi-curve"), shape(de_rham(1 / 3))).kind
    'strong'
    """
    broken: list[tuple[str, float]] = []
    numeric: list[str] = []
    extra: list[str] = []
    control = configurations(second.system, second.control)
    pairs = [(first.automaton.shape, second.automaton.shape)]
    stated = 0
    for one, other in pairs:
        table = first.automaton.cells[one].subdivision
        opposite = second.automaton.cells[other].subdivision
        if set(table) != set(opposite):
            missing = sorted(set(table) ^ set(opposite))
            broken.append((f"{one!r} and {other!r} differ in the labels {', '.join(missing)}", float("inf")))
            continue
        pairs.extend(p for label in table if (p := (table[label], opposite[label])) not in pairs)
        own, theirs = _equations(first, one), _equations(second, other)
        stated += len(own)
        extra.extend(_text(other, pair) for pair in sorted(theirs - own))
        for pair in sorted(own - theirs):
            points = [_point(second, other, control[other], address) for address in pair]
            distance = float(np.linalg.norm(points[0] - points[1]))
            if distance <= _SAME * float(np.ptp(second.control, axis=0).max()):
                numeric.append(_text(other, pair))
            else:
                broken.append((_text(other, pair), distance))
    if not stated and not broken:
        raise ValueError(f"{first.name!r} states no gluing of points: give it boundaries and adjacencies")
    kind = "none" if broken else "weak" if numeric or extra else "strong"
    return Gluing(kind, tuple(broken), tuple(numeric), tuple(extra))


def vertex_address(shape: Shape, cell: str, boundary: str) -> Address | None:
    """The address of a boundary point of a cell, followed through the incidences; None where they end.

    >>> from ifs.shape import shape
    >>> vertex_address(shape("koch-curve"), "edge", "right")
    ((), ('3',))
    """
    found = addresses.vertex_address(shape, cell, (boundary,))
    return None if found is None else (found.word, found.repeat)


def _equations(shape: Shape, cell: str) -> set[tuple[Address, Address]]:
    """The pairs of addresses that the automaton says are one point, at the first subdivision of a cell."""
    cells = shape.automaton.cells
    classes: dict[Word, list[Address]] = {}
    place = shape.topology.subdivided(cell).place
    for label, target in cells[cell].subdivision.items():
        for path, border in cells[target].boundary.items():
            if not shape.topology.is_point(border.cell):
                continue
            found = vertex_address(shape, target, path)
            if found is not None:
                word, repeat = found
                address = _shortest((label, *word), repeat)
                classes.setdefault(place[label, path][0], []).append(address)
    return {(one, other) for found in classes.values() for one, other in combinations(sorted(set(found)), 2)}


def _shortest(word: Word, repeat: Word) -> Address:
    """The same address with the shortest repeated part and the shortest word before it."""
    for length in range(1, len(repeat) + 1):
        if len(repeat) % length == 0 and repeat == repeat[:length] * (len(repeat) // length):
            repeat = repeat[:length]
            break
    while word and word[-1] == repeat[-1]:
        word, repeat = word[:-1], (repeat[-1], *repeat[:-1])
    return word, repeat


def _text(cell: str, pair: tuple[Address, Address]) -> str:
    sides = (" ".join((*word, f"({' '.join(repeat)})*")) for word, repeat in pair)
    return f"{cell}: {' = '.join(sides)}"


def _point(
    shape: Shape, cell: str, control: Float[np.ndarray, "points dim"], address: Address
) -> Float[np.ndarray, "dim"]:
    """The point of an address, by following it until the pieces are points."""
    word, repeat = address
    columns = sample(shape.system)
    size = float(np.abs(control).max(initial=0.0))
    letters = list(word)
    for k in range(5000):
        label = letters[k] if k < len(letters) else repeat[(k - len(letters)) % len(repeat)]
        state = shape.system.states[cell]
        place = state.labels.index(label)
        control, cell = state.operators[place].T @ control, state.targets[place]
        if k >= len(letters) and np.ptp(control, axis=0).max(initial=0.0) <= 1e-15 * size:
            break
    return columns[cell] @ control
