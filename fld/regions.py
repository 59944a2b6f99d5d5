"""Maps of behaviour: how the curves of a two-parameter family converge, start, end and join.

Source: Gentil 2010, section 4.3.1, "Cartographie des comportements différentiels", figures 4.12, 4.14, 4.15.
Three corrections to its text, for corner cutting with c = 1 - a - b:

- "1 - a - b dominates both operators" is `1 - 2a - b > 0 and 1 - a - 2b > 0`; one sentence has < twice.
- The condition |a|, |b|, |c| < 1 is necessary for convergence, not sufficient (`ifs.certificates.verdicts`).
- That the dominant eigenvalue is positive follows from |b| < 1 by c^2 - a^2 = (1 - b)(1 - 2a - b): where c
  dominates T_0, also c > a; where a does, also a > c.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from os import PathLike

import numpy as np
from jaxtyping import Bool, Float, Int

from automata import Automaton
from automata.topology import embedding as columns_of
from fld.curve import curve
from fld.ends import End, end, fixed_points, meeting
from ifs.asked import shown
from ifs.certificates.family import Family, family
from ifs.certificates.verdicts import Verdicts, verdicts

CONTRACTS, DIVERGES, UNDECIDED = range(3)
SMOOTH, CUSP, CORNER, NONE = range(4)


@dataclass(frozen=True)
class Facts:
    """What is known of each member of a family, one number a member.

    `verdict` is 0 contracts (proven), 1 does not contract (proven), 2 undecided; `alone` whether each
    operator alone has eigenvalues below 1. Where it contracts, `start` and `end` tell of the ends, and
    `joint` is 0 where the half-tangents at every joint continue each other, 1 where they are collinear and
    some turn back (a cusp), 2 where some are not collinear, 3 where some side has no half-tangent: each
    for all control points alike. The rest of the members have NaN and 0 there.
    """

    verdict: Int[np.ndarray, "members"]
    alone: Bool[np.ndarray, "members"]
    witness: Int[np.ndarray, "members"]
    words: tuple[tuple[str, ...], ...]
    start_kind: Int[np.ndarray, "members"]
    end_kind: Int[np.ndarray, "members"]
    start_own: Bool[np.ndarray, "members"]
    end_own: Bool[np.ndarray, "members"]
    start_flips: Bool[np.ndarray, "members"]
    end_flips: Bool[np.ndarray, "members"]
    joint: Int[np.ndarray, "members"]


@dataclass(frozen=True)
class Map:
    """The facts on a grid of the parameter plane: row 0 lowest y, column 0 lowest x.

    `x` and `y` hold the middles of the grid's columns and rows, `ranges` what they cover, `labels` the
    sub-cells along the curve.
    """

    family: Family
    labels: tuple[str, ...]
    x: Float[np.ndarray, "columns"]
    y: Float[np.ndarray, "rows"]
    ranges: tuple[tuple[float, float], tuple[float, float]]
    facts: Facts

    def grid(self, values: np.ndarray) -> np.ndarray:
        """One fact as `(rows, columns)`."""
        return values.reshape(len(self.y), len(self.x))


def regions(
    source: Automaton | str | PathLike[str],
    x: str,
    y: str,
    *,
    x_range: tuple[float, float] = (-1.0, 1.0),
    y_range: tuple[float, float] = (-1.0, 1.0),
    resolution: int = 200,
    report: Callable[[float], None] = lambda done: None,
) -> Map:
    """The behaviour of the curves of a family over the plane of two parameters or entries x and y.

    The plane is cut into `resolution` x `resolution` fields, each judged at its middle. Raises
    `fld.NotACurve`, what `family.family` raises, and `ValueError` for an empty range or no fields.

    >>> found = regions("corner-cutting", "a", "b", resolution=10)
    >>> int((found.facts.verdict == CONTRACTS).sum()), found.labels
    (43, ('0', '1'))
    """
    for name, (low, high) in ((x, x_range), (y, y_range)):
        if not -1e6 <= low < high <= 1e6:
            raise ValueError(f"the range of {name}, {low:g} to {high:g}, must rise and stay within 1e6")
    if not 1 <= resolution <= 2000:
        raise ValueError(f"resolution {resolution}: expected 1 to 2000 fields a side")
    whole = family(source, x, y)
    middles = (np.arange(resolution) + 0.5) / resolution
    xs, ys = (low + (high - low) * middles for low, high in (x_range, y_range))
    places = np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 2)
    facts = classify(whole, places, report)
    return Map(whole, curve(whole.shape).labels, xs, ys, (x_range, y_range), facts)


def classify(
    whole: Family, places: Float[np.ndarray, "members 2"], report: Callable[[float], None] = lambda done: None
) -> Facts:
    """The facts of the members of a family at some places of its parameter plane.

    The joint after piece k compares `-T_k v_end` with `T_(k+1) v_start`, v the directions into the curve, as
    barycentric columns: control points do not matter. Raises `fld.NotACurve`.

    >>> from ifs.certificates.family import family
    >>> facts = classify(family("corner-cutting", "a", "b"), np.array([[0.25, 0.25], [0.4, 0.4]]))
    >>> facts.joint.tolist(), facts.start_own.tolist()
    ([0, 2], [True, False])
    """
    if not isinstance(whole, Family):
        raise TypeError(f"expected a family of ifs.certificates.family, found {shown(whole)}")
    state = whole.shape.system.states[whole.shape.system.shape]
    chain = curve(whole.shape).labels
    operators = whole.members(places)[:, [state.labels.index(label) for label in chain]]
    found = verdicts(operators[..., :-1, :-1] - operators[..., :-1, -1:], report)
    good = np.flatnonzero(found.contracts)
    start, last = _ends(whole, operators[good])
    joint = _joints(operators[good], start, last)
    return _facts(found, chain, good, start, last, joint)


def _ends(whole: Family, operators: Float[np.ndarray, "members labels points points"]) -> tuple[End, End]:
    first, last = operators[:, 0], operators[:, -1]
    begin, finish = fixed_points(first), fixed_points(last)
    left, right = (_embedding(whole, label) for label in list(_cell(whole).boundary)[:2])
    return end(first, finish, left), end(last, begin, right)


def _joints(
    operators: Float[np.ndarray, "members labels points points"], start: End, last: End
) -> Int[np.ndarray, "members"]:
    """The worst of all joints; a start or end whose eigenvalue is negative has no half-tangent."""
    starts = np.where((start.kind == 0)[:, None], start.direction, np.nan)[:, :, None]
    ends = np.where((last.kind == 0)[:, None], last.direction, np.nan)[:, :, None]
    worst = np.zeros(len(operators), int)
    for k in range(operators.shape[1] - 1):
        before, after = -(operators[:, k] @ ends)[:, :, 0], (operators[:, k + 1] @ starts)[:, :, 0]
        worst = np.maximum(worst, meeting(before, after))
    return worst


def _facts(
    found: Verdicts,
    chain: Sequence[str],
    good: Int[np.ndarray, "some"],
    start: End,
    last: End,
    joint: Int[np.ndarray, "some"],
) -> Facts:
    count = len(found.contracts)

    def spread(values: np.ndarray) -> np.ndarray:
        result = np.zeros(count, values.dtype)
        result[good] = values
        return result

    return Facts(
        np.select([found.contracts, found.diverges], [CONTRACTS, DIVERGES], default=UNDECIDED),
        found.alone,
        found.witness,
        tuple(tuple(chain[k] for k in word) for word in found.words),
        spread(start.kind),
        spread(last.kind),
        spread(start.own),
        spread(last.own),
        spread(start.flips),
        spread(last.flips),
        spread(joint),
    )


def _cell(whole: Family):
    return whole.shape.automaton.cells[whole.shape.system.shape]


def _embedding(whole: Family, label: str) -> Float[np.ndarray, "points own"]:
    columns = columns_of(whole.shape.automaton, whole.shape.system.shape, (label,))
    result = np.zeros((_cell(whole).points, len(columns)))
    for j, column in enumerate(columns):
        for row, value in column:
            result[row, j] = float(value)
    return result
