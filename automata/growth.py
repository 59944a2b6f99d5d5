"""How the letters of an L-system grow: the displacement of each, relative to the others, in the limit."""

import cmath
import math
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from automata.error import AutomatonError
from automata.lsystem import DRAWING, MOVING, LSystem, Symbols

_LONGEST_PERIOD = 12  # levels after which turns repeat, at most
_SETTLING = 64  # levels before they do
_ROUNDS = 4000
_STILL = 1e-14
_CLOSE = 1e-12
_NOTHING = 1e-9
_SLOW = 1.02  # growth by which a letter is taken to stay bounded, or to grow like a polynomial
_LATE = 400

_Turns = dict[str, tuple[int, bool]]
_Ways = dict[str, complex]


class NotACurveSystem(AutomatonError):
    """An L-system that is no curve made by rewriting edges, and why."""


@dataclass(frozen=True)
class Step:
    """A letter met by the turtle: its heading, in parts of a full turn, and whether turns are exchanged."""

    letter: str
    heading: int
    mirrored: bool


@dataclass(frozen=True)
class Growth:
    """The turtle's ways at p + 1 levels that follow each other, p the period of the turning of letters.

    `ways[j][a]` is the way along letter a at the j-th of them, as a complex number, all in one unit; letters
    that are points in the limit are missing. `steps[j][a]` are the letters of the rule of a, j from 1, as the
    turtle meets them when a stands at level j and they at level j - 1; `axiom` those of the axiom at level p,
    all without letters that are points. `visible` are the letters that draw something at all late levels.
    """

    ways: tuple[Mapping[str, complex], ...]
    steps: tuple[Mapping[str, tuple[Step, ...]], ...]
    axiom: tuple[Step, ...]
    visible: frozenset[str]


def growth(system: LSystem) -> Growth:
    """How the letters of an L-system grow, late.

    With `d_a(n)` the turtle's way along the n-th rewriting of letter a and h_k the heading of the k-th
    letter b_k of its rule, `d_a(n+1) = sum_k exp(2 pi i h_k / angle) d_{b_k}(n)`, conjugated where `!` has
    exchanged the turns. Headings repeat with the turning of letters, mostly at each level, every second one
    for Sierpinski's arrowhead. `d(n) / d_c(n)`, c the first letter of the axiom that grows, must settle.

    Raises `NotACurveSystem` (an `AutomatonError`) where the turning of letters does not repeat, nothing
    grows, letters grow at different rates, or a letter that grows ends where it starts.

    >>> from automata.lsystem import lsystem
    >>> found = growth(lsystem("Koch { Angle 6\\n Axiom F\\n F=F+F--F+F }"))
    >>> factor = found.ways[1]["F"] / found.ways[0]["F"]
    >>> round(factor.real, 12), len(found.steps[1]["F"])
    (3.0, 4)
    """
    letters = _letters(system)
    turns = _periodic_turns(system, letters)
    rates = _rates(system, letters)
    late = len(turns) - 1
    axiom = tuple(_steps(system.axiom, turns[late]))
    growing = [step.letter for step in axiom if rates[step.letter] > _SLOW]
    if not growing:
        raise _refused(system, "no letter of its axiom grows from level to level")
    steps = [{a: tuple(_steps(system.rule(a), turns[j - 1])) for a in letters} for j in range(1, late + 1)]
    ways = _limit(system, steps, growing[0])
    largest = [abs(level[growing[0]]) for level in ways]
    points = {a for a in letters if any(abs(w[a]) < _NOTHING * m for w, m in zip(ways, largest, strict=True))}
    for a in letters:
        if rates[a] > _SLOW and a in points:
            _refuse_point(system, a, rates, growing[0])
    mirrored = any(s.mirrored for level in steps for rule in level.values() for s in rule)
    turned = ways[-1][growing[0]] / ways[0][growing[0]]
    if mirrored and abs(turned.imag) > _CLOSE * abs(turned):
        raise _refused(system, "'!' mirrors letters, but rewriting also turns the curve as a whole")
    kept = [a for a in letters if a not in points]
    lasting = [{a: tuple(s for s in level[a] if s.letter in kept) for a in kept} for level in steps]
    return Growth(
        tuple({a: level[a] for a in kept} for level in ways),
        ({}, *lasting),
        tuple(step for step in axiom if step.letter in kept),
        _visible(system, letters),
    )


def _letters(system: LSystem) -> tuple[str, ...]:
    """The letters that the axiom leads to, in the order in which they are met."""
    found = list(dict.fromkeys(s.letter for s in system.axiom if s.kind == "letter"))
    if not found:
        raise _refused(system, "its axiom has no letter")
    for letter in found:
        new = dict.fromkeys(s.letter for s in system.rule(letter) if s.kind == "letter")
        found += [each for each in new if each not in found]
    return tuple(found)


def _periodic_turns(system: LSystem, letters: tuple[str, ...]) -> list[_Turns]:
    """By how much each letter turns, and whether it exchanges turns, at the levels 0 to p of a period p."""
    history: list[_Turns] = [dict.fromkeys(letters, (0, False))]
    for level in range(1, _SETTLING):
        turns = {a: _turned(system.rule(a), history[-1], system.angle) for a in letters}
        earlier = [k for k in range(level) if history[k] == turns]
        if earlier and level - earlier[0] <= _LONGEST_PERIOD:
            period = level - earlier[0]
            first = next(k for k in range(earlier[0], level) if k % period == 0)
            repeated = [*history, turns, *history[earlier[0] + 1 :]]
            return repeated[first : first + period + 1]
        if earlier:
            break
        history.append(turns)
    raise _refused(system, f"the turning of its letters does not repeat within {_LONGEST_PERIOD} levels")


def _steps(symbols: Symbols, turns: _Turns) -> Iterator[Step]:
    heading, mirrored = 0, False
    for symbol in symbols:
        if symbol.kind == "letter":
            yield Step(symbol.letter, heading, mirrored)
            turn, reverses = turns[symbol.letter]
            heading += -turn if mirrored else turn
            mirrored ^= reverses
        elif symbol.kind == "turn":
            heading += -symbol.amount if mirrored else symbol.amount
        else:
            mirrored = not mirrored


def _turned(symbols: Symbols, turns: _Turns, angle: int) -> tuple[int, bool]:
    heading, mirrored = 0, False
    for symbol in symbols:
        if symbol.kind == "reversal":
            mirrored = not mirrored
            continue
        turn, reverses = turns[symbol.letter] if symbol.kind == "letter" else (symbol.amount, False)
        heading += -turn if mirrored else turn
        mirrored ^= reverses
    return heading % angle, mirrored


def unit(heading: int, angle: int) -> complex:
    """`exp(2 pi i heading / angle)`, exact for quarters of a turn."""
    quarters, rest = divmod(4 * (heading % angle), angle)
    if rest == 0:
        return (1, 1j, -1, -1j)[quarters]
    return cmath.rect(1, 2 * math.pi * (heading % angle) / angle)


def _limit(
    system: LSystem, steps: list[dict[str, tuple[Step, ...]]], first: str
) -> list[Mapping[str, complex]]:
    """The ways at the levels 0 to p of a late period, settled relative to that of the first letter."""
    rows = [_counted(level, system.angle) for level in steps]
    period: list[_Ways] = [{a: complex(a in MOVING) for a in steps[0]}]
    before: _Ways = {}
    still = 0
    for _ in range(_ROUNDS):
        period = [_scaled(system, period[-1])]
        for row in rows:
            period.append(_grown(row, period[-1]))
        reference = period[-1][first]
        if abs(reference) <= _NOTHING * max(map(abs, period[-1].values())):
            before, still = {}, 0
            continue
        relative = {f"{j}{a}": way / reference for j, level in enumerate(period) for a, way in level.items()}
        largest = max(map(abs, relative.values()))
        change = max((abs(relative[a] - before[a]) / largest for a in before), default=1.0)
        before, still = relative, still + 1 if change < _STILL else 0
        if still == 3 and abs(period[0][first]) < (1 - _CLOSE) * abs(reference):
            return list(period)
    reason = f"the letters grow at different rates, or {first!r} ends where it starts"
    raise _refused(system, f"{reason}: its displacements settle to no common scale")


def _scaled(system: LSystem, ways: _Ways) -> _Ways:
    largest = max(map(abs, ways.values()))
    if largest == 0:
        raise _refused(
            system,
            "its turtle never gets away: nothing moves it, or the net displacement of each rule is zero",
        )
    return {a: way / largest for a, way in ways.items()}


def _grown(row: Mapping[str, Mapping[tuple[str, bool], complex]], ways: _Ways) -> _Ways:
    return {
        a: sum((w * (ways[b].conjugate() if m else ways[b]) for (b, m), w in units.items()), 0j)
        for a, units in row.items()
    }


def _counted(steps: Mapping[str, tuple[Step, ...]], angle: int) -> dict[str, dict[tuple[str, bool], complex]]:
    """The sum of the headings' units for each letter of each rule, plain and mirrored."""
    found: dict[str, dict[tuple[str, bool], complex]] = {}
    for a, rule in steps.items():
        row: dict[tuple[str, bool], list[complex]] = {}
        for s in rule:
            row.setdefault((s.letter, s.mirrored), []).append(unit(s.heading, angle))
        found[a] = {
            key: complex(math.fsum(u.real for u in units), math.fsum(u.imag for u in units))
            for key, units in row.items()
        }
    return found


def _rates(system: LSystem, letters: tuple[str, ...]) -> dict[str, float]:
    """For each letter the factor by which the number of letters that it becomes grows, late."""
    rows = {a: Counter(s.letter for s in system.rule(a) if s.kind == "letter") for a in letters}
    total = dict.fromkeys(letters, 1)
    middle = total
    for level in range(_LATE):
        if level == _LATE // 2:
            middle = total
        total = {a: sum(n * total[b] for b, n in rows[a].items()) for a in letters}
    steps = _LATE - _LATE // 2
    return {
        a: math.exp((math.log(total[a]) - math.log(middle[a])) / steps) if total[a] else 0.0 for a in letters
    }


def _refuse_point(system: LSystem, letter: str, rates: Mapping[str, float], first: str) -> None:
    if rates[letter] < rates[first] / _SLOW:
        raise _refused(
            system,
            f"{letter!r} and {first!r} grow at different rates: {rates[letter]:.4g} and {rates[first]:.4g} "
            f"letters a level",
        )
    raise _refused(system, f"the net displacement of {letter!r} is zero: its ends would be one point")


def _visible(system: LSystem, letters: tuple[str, ...]) -> frozenset[str]:
    """The letters that lead to drawing ones at all late levels."""
    now = {a for a in letters if a in DRAWING}
    late: set[str] = set()
    for level in range(2 * len(letters)):
        now = {a for a in letters if any(s.letter in now for s in system.rule(a))}
        late |= now if level >= len(letters) else set()
    return frozenset(late)


def _refused(system: LSystem, why: str) -> NotACurveSystem:
    return NotACurveSystem(f"the L-system {system.name!r} is no curve that rewrites its edges: {why}")
