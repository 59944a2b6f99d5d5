"""The regions of a map of behaviours: members with equal facts, numbered, with words made from the facts."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Int

from fld.ends import KINDS
from fld.regions import CONTRACTS, Map

_JOINTS = (
    "smooth joints",
    "cusps at the joints",
    "corners at the joints",
    "no half-tangents at the joints",
)

Side = tuple[int, bool, bool]
"""Of one end: the kind, whether its direction needs more than its own points, whether no eigenvalue flips."""


@dataclass(frozen=True)
class Region:
    """One kind of behaviour, and its mirror image if it has one.

    `members` are those of the region itself, `mirrored` those in which start and end change places (the
    primed regions of the source), `joint` as in `Facts`, `own` the ends (0, 1, 2) whose half-tangent depends
    on the end's own control points alone, `alternates` whether both ends have a negative eigenvalue.
    `tangible` says whether ends have two points or more, so that tangents can be theirs at all.
    """

    number: int
    joint: int
    kinds: tuple[str, str]
    own: int
    alternates: bool
    tangible: bool
    members: Bool[np.ndarray, "members"]
    mirrored: Bool[np.ndarray, "members"]

    @property
    def joints(self) -> str:
        """What the joints are, in words."""
        return _JOINTS[self.joint]

    @property
    def words(self) -> tuple[str, ...]:
        """The facts in short phrases: joints, ends, signs.

        >>> from fld.regions import regions
        >>> named(regions("corner-cutting", "a", "b", resolution=20))[0].words
        ('smooth joints', 'both ends tangent to the control polygon')
        """
        ends = {
            0: "neither end tangent to the control polygon",
            1: "one end tangent to the control polygon",
            2: "both ends tangent to the control polygon",
        }
        phrases = [self.joints]
        if self.kinds == ("positive", "positive"):
            phrases += [ends[self.own]] if self.tangible else []
        else:
            phrases.append("dominant eigenvalues: " + ", ".join(self.kinds))
        if self.alternates:
            phrases.append("pieces turn over at every level")
        return tuple(phrases)


def named(found: Map) -> tuple[Region, ...]:
    """The regions of a map, numbered from 1: smooth joints before cusps before corners before none.

    Regions of an area come first; those without, lines on which members degenerate, after them (corner
    cutting with a + b = 1 draws straight segments, whose joints are smooth).

    Two members are in one region when they agree in the joints, in the kinds of the dominant eigenvalues, in
    how many ends have half-tangents of their own, and in whether both ends have a negative eigenvalue; up
    to exchanging start and end. For corner cutting these are the five regions of figure 4.14. The one left of
    each mirrored pair has the start on the polygon (3), or the negative eigenvalue at the start (2).
    """
    facts = found.facts
    good = facts.verdict == CONTRACTS
    sides = [
        np.column_stack([facts.start_kind, ~facts.start_own, ~facts.start_flips]),
        np.column_stack([facts.end_kind, ~facts.end_own, ~facts.end_flips]),
    ]
    codes, inverse = np.unique(np.column_stack([facts.joint, *sides])[good], axis=0, return_inverse=True)
    groups: dict[tuple, list[tuple[int, bool]]] = {}
    for place, code in enumerate(codes.tolist()):
        key, mirrored = _group(code)
        groups.setdefault(key, []).append((place, mirrored))
    numbers = inverse.ravel()
    where = np.flatnonzero(good)
    made = [_region(key, groups[key], numbers, where, len(good)) for key in sorted(groups)]
    made.sort(key=lambda region: not _is_wide(found, region))
    automaton = found.family.shape.automaton
    borders = automaton.cells[automaton.shape].boundary.values()
    tangible = any(automaton.cells[border.cell].points > 1 for border in borders)
    return tuple(replace(region, number=number, tangible=tangible) for number, region in enumerate(made, 1))


def _is_wide(found: Map, region: Region) -> bool:
    """Whether the region covers four fields around some corner: lines of degenerate members do not."""
    grid = found.grid(region.members | region.mirrored)
    return bool((grid[1:, 1:] & grid[1:, :-1] & grid[:-1, 1:] & grid[:-1, :-1]).any())


def _group(code: Sequence[int]) -> tuple[tuple, bool]:
    """The key of a region, in the order of its numbers, and whether start and end changed places."""
    joint, *rest = code
    start, last = tuple(rest[:3]), tuple(rest[3:])
    first, second = sorted((start, last))
    alternates = not first[2] and not second[2]
    return (joint, first[0], second[0], first[1] + second[1], alternates), last < start


def _region(
    key: tuple,
    codes: Sequence[tuple[int, bool]],
    numbers: Int[np.ndarray, "good"],
    where: Int[np.ndarray, "good"],
    count: int,
) -> Region:
    members = []
    for wanted in (False, True):
        mask = np.zeros(count, bool)
        mask[where[np.isin(numbers, [place for place, mirrored in codes if mirrored == wanted])]] = True
        members.append(mask)
    joint, one, other, foreign, alternates = key
    plain, mirrored = members if members[0].any() else members[::-1]
    return Region(0, joint, (KINDS[one], KINDS[other]), 2 - foreign, alternates, True, plain, mirrored)
