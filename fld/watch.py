"""The infinite product of a derivative at any address, watched letter by letter."""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import islice
from typing import Any, Literal

import numpy as np
from jaxtyping import Float

from fld.curve import Curve, curve, fixed_point
from fld.directions import differences
from fld.local import Side
from fld.order import dominant_moduli, solved_order
from fld.parts import Chosen, chosen, starts
from fld.wording import written
from ifs import Shape
from ifs.asked import require_whole

Status = Literal["value", "zero", "infinite", "oscillating", "spiralling", "undecided"]

_SETTLED = 1e-6
_FEWEST = 24
_MOST_DIRECTIONS = 12
_MOST_STEPS = 100_000
_TAIL = 1e-15
_GROWN = 1.0  # of log|Q|, from one quarter of the samples to another
_BOUNDED = 0.5
_EVEN = 1.5
_TURNED = 720.0  # degrees
_STEADY = 120.0


@dataclass(frozen=True)
class Watched:
    """What the quotients `Q = ± Gamma(1 + q) (H(t ± h) - H(t)) / h^q` did at the joints next to a point.

    `status` is read from the last half of `samples` quotients, at the joints of the pieces that the first
    `letters` of the address enter; nothing here is a proof for what follows.

    - "value": they stay within 1e-6 of `value`; `error` (mm per parameter^q) is how far they still were;
    - "zero", "infinite": all their lengths in the last quarter are below (above) those in the second one,
      by a factor e or more;
    - "spiralling" (plane curves): lengths stay bounded and directions turn steadily, by `turn` degrees a
      letter;
    - "oscillating": lengths stay bounded, and the quotients come back to `directions` (at most 12, else the
      two farthest apart, of lengths within a factor 4.5), or keep one direction and change in length;
    - "undecided": none of these after that many letters.

    `lengths` are the least and the largest |Q| of the last half, `spread` the largest angle in degrees
    between directions there, `local_order` the slope of log |H(t ± h) - H(t)| against log h over that half
    (None with too few samples), `point` the point in mm.
    """

    side: Side
    letters: int
    samples: int
    order: float
    status: Status
    point: Float[np.ndarray, "dim"]
    value: Float[np.ndarray, "dim"] | None
    error: float | None
    directions: Float[np.ndarray, "n dim"] | None
    lengths: tuple[float, float] | None
    spread: float | None
    turn: float | None
    local_order: float | None
    words: str

    def as_data(self) -> dict[str, Any]:
        """The same as plain lists and numbers, ready for JSON."""
        plain = {
            key: value.tolist() if isinstance(value, np.ndarray) else value
            for key, value in self.__dict__.items()
        }
        return plain | {"lengths": None if self.lengths is None else list(self.lengths)}


def watch(
    shape: Shape,
    labels: Iterable[str] | Callable[[int], str],
    order: float | None = None,
    side: str = "right",
    parametrisation: Chosen = "natural",
    steps: int = 400,
) -> Watched:
    """The derivative of order q at any address, from its first letters.

    `labels` is a finite word, an iterator of labels, or a function from the place (0, 1, …) to the label; at
    most `steps` labels are read, from 1 to 100000. `order` is q > 0, the critical order of the curve by
    default, `parametrisation` as in `derivatives`.

    Equation 4.2: for h between neighbouring joints, `H(t + h) - H(t) = L_s1 … L_sn v`, v between points of
    the curve of which one is in the piece s_(n+1); the product of the `L_s / r_s^q` is kept scaled, so that
    it neither under- nor overflows. The last letters only place the point: quotients are taken as long as the
    rest of the word fixes it to 1e-15.

    Raises `ValueError` for an unknown label (naming its place), an order not above 0, steps or a side out of
    range, and what `critical_order` raises. Source: Gentil 2010, equations 4.2 and 4.3.

    >>> import ifs
    >>> found = watch(ifs.shape("corner-cutting"), lambda place: "01"[(place * place) % 3 == 0])
    >>> found.status, round(found.local_order, 6)
    ('value', 1.0)
    """
    if order is not None and not (math.isfinite(order) and order > 0):
        raise ValueError(f"the order of a derivative must be above 0 and finite; found {order}")
    if side not in ("left", "right"):
        raise ValueError(f"the side is 'left' or 'right'; found {side!r}")
    require_whole("number of steps", steps, 1, _MOST_STEPS)
    if not callable(labels) and not isinstance(labels, Iterable):
        raise TypeError(f"labels are a word such as '0110', an iterator or a function; found {labels!r}")
    own = curve(shape)
    parts = chosen(own, parametrisation)
    q = solved_order(list(dominant_moduli(own).values())) if order is None else float(order)
    made = (labels(place) for place in range(steps)) if callable(labels) else labels
    word = tuple(islice(made, steps))
    for place, label in enumerate(word):
        if label not in own.labels:
            raise ValueError(
                f"unknown label {label!r} at place {place + 1} of the address; the labels of this curve are "
                f"{', '.join(own.labels)}"
            )
    which: Side = "left" if side == "left" else "right"
    return _judged(_quotients(own, parts, word, q, which), len(word), q, which)


@dataclass(frozen=True)
class _Quotients:
    """Quotients in the order of falling h: log|Q|, unit directions, log h, and the letters read by then."""

    point: Float[np.ndarray, "dim"]
    sizes: Float[np.ndarray, "n"]
    units: Float[np.ndarray, "n dim"]
    distances: Float[np.ndarray, "n"]
    letters: Float[np.ndarray, "n"]


def _quotients(
    curve: Curve, parts: dict[str, float], word: tuple[str, ...], order: float, side: Side
) -> _Quotients:
    tails, places, known = _tails(curve, parts, word)
    begin = starts(parts)
    end = fixed_point(curve.operators[0 if side == "right" else -1])
    # The near end of every piece, and its place.
    near = {label: operator @ end for label, operator in zip(curve.labels, curve.operators, strict=True)}
    at = {label: begin[label] + (0.0 if side == "right" else parts[label]) for label in curve.labels}
    rows = (curve.control - curve.control.mean(axis=0)).T
    shrunk, logarithm = 0.0, 0.0
    sizes, units, distances, letters = [], [], [], []
    sign = 1.0 if side == "right" else -1.0
    for n, label in enumerate(word[:known]):
        here = curve.labels.index(label)
        beyond = curve.labels[:here:-1] if side == "right" else curve.labels[:here]
        for other in beyond:
            vector = rows @ (near[other] - tails[n])
            length, distance = float(np.linalg.norm(vector)), sign * (at[other] - places[n])
            if length > 0 and distance > 0:
                units.append(sign * vector / length)
                distances.append(shrunk + math.log(distance))
                sizes.append(logarithm + math.log(length) + math.lgamma(1 + order) - order * distances[-1])
                letters.append(n)
        rows = rows @ curve.operators[here]
        rows = rows - rows.mean(axis=1, keepdims=True)
        size = float(np.linalg.norm(rows))
        if size == 0:
            break
        rows, logarithm, shrunk = rows / size, logarithm + math.log(size), shrunk + math.log(parts[label])
    dim = curve.control.shape[1]
    return _Quotients(
        tails[0] @ curve.control,
        np.array(sizes),
        np.array(units).reshape(-1, dim),
        np.array(distances),
        np.array(letters, dtype=float),
    )


def _tails(
    curve: Curve, parts: dict[str, float], word: tuple[str, ...]
) -> tuple[list[Float[np.ndarray, "points"]], list[float], int]:
    """Point and parameter of the rest of the word after each letter, and up to which letter they are sure."""
    begin = starts(parts)
    frame = differences(len(curve.control))
    point, place = fixed_point(curve.operators[0]), 0.5
    reach, wide, known = np.eye(len(frame)), 1.0, 0
    tails, places = [point], [place]
    for n in range(len(word) - 1, -1, -1):
        operator = curve.operator((word[n],))
        point, place = operator @ point, begin[word[n]] + parts[word[n]] * place
        tails.append(point)
        places.append(place)
        if not known:
            reach, wide = (frame @ operator @ frame.T) @ reach, wide * parts[word[n]]
            if max(float(np.linalg.norm(reach)), wide) <= _TAIL:
                known = n + 1
    return tails[::-1], places[::-1], known


def _judged(found: _Quotients, letters: int, order: float, side: Side) -> Watched:
    count = len(found.sizes)

    def made(status: Status, words: str, **more: Any) -> Watched:
        said = f"{status} after {letters} letters: {words}"
        defaults = dict.fromkeys(
            ("value", "error", "directions", "lengths", "spread", "turn", "local_order"), None
        )
        return Watched(
            side=side,
            letters=letters,
            samples=count,
            order=order,
            status=status,
            point=found.point,
            words=said,
            **(defaults | more),
        )

    if count < _FEWEST:
        return made(
            "undecided", f"only {count} quotients could be formed, {_FEWEST} are needed; read more letters"
        )
    half, last = count // 2, 3 * count // 4
    before, after, ending = found.sizes[count // 4 : half], found.sizes[half:], found.sizes[last:]
    local = _slope(found.distances[half:], after + order * found.distances[half:])
    units = found.units[half:]
    farthest, spread = _spread(units)
    more: dict[str, Any] = {"spread": spread, "local_order": local}
    if after.min() > -700 and after.max() < 700:
        more["lengths"] = (math.exp(after.min()), math.exp(after.max()))
    numbers = f"local order about {local:.6g}" if local is not None else "no local order"
    if ending.max() < before.min() - _GROWN:
        return made("zero", f"lengths shrink from order {order:.6g} on; {numbers}", **more)
    if ending.min() > before.max() + _GROWN:
        return made("infinite", f"lengths grow at order {order:.6g}; {numbers}", **more)
    if "lengths" in more:
        vectors = units * np.exp(after)[:, None]
        error = float(np.linalg.norm(vectors - vectors[-1], axis=1).max())
        if error <= _SETTLED * np.linalg.norm(vectors[-1]):
            words = f"{written(vectors[-1])} mm per parameter^{order:.6g}, to {error:.3g}"
            return made("value", words, value=vectors[-1], error=error, **more)
    if after.max() > before.max() + _BOUNDED or after.min() < before.min() - _BOUNDED:
        change = f"lengths changed by a factor {math.exp(min(float(np.ptp(after)), 700.0)):.6g}"
        return made("undecided", f"{change} without settling; {numbers}", **more)
    turn = _turn(units, found.letters[half:])
    if turn is not None:
        return made("spiralling", f"turns by {turn:.6g} degrees a letter; {numbers}", turn=turn, **more)
    directions = _clusters(units)
    low, high = np.exp(after.min()), np.exp(after.max())
    between = f"lengths between {low:.6g} and {high:.6g}"
    if directions is None and np.ptp(after) > _EVEN:
        return made("undecided", f"directions and lengths keep changing; {between}; {numbers}", **more)
    if directions is None:
        directions = farthest
        words = (
            f"more than {_MOST_DIRECTIONS} directions, up to {more['spread']:.6g} degrees apart; {between}"
        )
    else:
        words = " and ".join(written(row) for row in directions[:4])
        words += f" and {len(directions) - 4} more directions" if len(directions) > 4 else ""
        words += f"; {between}"
    return made("oscillating", words, directions=directions, **more)


def _slope(x: Float[np.ndarray, "n"], y: Float[np.ndarray, "n"]) -> float | None:
    if np.ptp(x) == 0:
        return None
    return float(np.polyfit(x - x.mean(), y - y.mean(), 1)[0])


def _spread(units: Float[np.ndarray, "n dim"]) -> tuple[Float[np.ndarray, "two dim"], float]:
    """Two directions that are farthest apart (of at most 1000 of them), and their angle in degrees."""
    some = units[:: max(1, len(units) // 1000)]
    one, other = divmod(int((some @ some.T).argmin()), len(some))
    pair = some[[one, other]]
    apart = 2 * math.atan2(np.linalg.norm(pair[0] - pair[1]), np.linalg.norm(pair[0] + pair[1]))
    return pair, math.degrees(apart)


def _clusters(units: Float[np.ndarray, "n dim"]) -> Float[np.ndarray, "directions dim"] | None:
    """The directions that come, to 1e-6; None for more than 12."""
    found: list[np.ndarray] = []
    for unit in units[::-1]:
        if not any(np.linalg.norm(unit - known) <= _SETTLED for known in found):
            found.append(unit)
            if len(found) > _MOST_DIRECTIONS:
                return None
    return np.array(found)


def _turn(units: Float[np.ndarray, "n dim"], letters: Float[np.ndarray, "n"]) -> float | None:
    """Degrees a letter, where plane directions turn steadily in one sense; None otherwise."""
    if units.shape[1] != 2 or np.ptp(letters) == 0:
        return None
    angles = np.degrees(np.unwrap(np.arctan2(units[:, 1], units[:, 0])))
    if abs(angles[-1] - angles[0]) < _TURNED:
        return None
    fit = np.polyfit(letters - letters.mean(), angles, 1)
    rest = angles - np.polyval(fit, letters - letters.mean())
    return float(fit[0]) if np.abs(rest).max() <= _STEADY else None
