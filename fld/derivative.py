"""Local fractional derivatives at eventually periodic addresses, in closed form."""

import math
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

import numpy as np
from jaxtyping import Float

from fld.address import parse_address
from fld.cone import Cone, Spiral, leading, period
from fld.curve import curve, fixed_point
from fld.local import Local, Side, repeated, sides
from fld.monomials import is_power
from fld.parts import Chosen, chosen, parameter
from fld.pieces import Pieces, largest
from fld.sides import side
from fld.tangent import HalfTangent, seen
from fld.wording import written
from ifs import Shape

Status = Literal["value", "zero", "infinite", "oscillating", "spiralling", "undecided"]
Holds = Literal["all h", "ends of pieces"]

_SAME_ORDER = 1e-9
_TIGHT = 1e-3
_POSITIVE = 0.5  # tight enough to see that a lower bound is above 0
_SAME_ANGLE = 1e-6  # degrees
_SAME_LENGTH = 1e-9
_NOTHING = 1e-9  # of the size: a lower bound of lengths below this may be rounding


@dataclass(frozen=True)
class Derivative:
    """The local fractional derivative of order q on one side of a point.

    With the quotients `Q(h) = ± Gamma(1 + q) (H(t ± h) - H(t)) / h^q`, h > 0, plus on the right (4.1):

    - "value": `value` is their limit. `holds` says for which h: "all h", or only along the "ends of pieces"
      `w u^k`, as (4.5) takes it. In that case the whole curve keeps the direction (theorem 4.2.3, proven by
      boxes), and the length of Q varies for ever within `lengths`: the limit (4.1) over all h does not exist;
    - "zero": Q tends to 0, for all h;
    - "infinite": |Q| grows beyond all bounds, for all h or (what is proven) along the ends of pieces;
    - "oscillating": Q keeps no direction; `cone` says between which it swings;
    - "spiralling": a complex pair dominates, see `spiral`;
    - "undecided": along the ends of pieces Q tends to `ends[0]`, and whether all the curve keeps that side
      was neither proven nor refuted.

    `order` is q, `local_order` the one order at which Q neither vanishes nor grows (None where the curve
    stays in the point), `block` the size m of the dominant Jordan block: at q = `local_order`, |Q| grows
    like `log(1/h)^(m-1)`. `ends`, `(phases, dim)`, holds the limits of Q along the ends of the pieces
    `w u^k u_1 … u_m`, those of whole periods first; a negative eigenvalue doubles the period. `lengths`
    bounds the |Q| that come back for ever: proven, to 1e-3 or as tight as 20000 boxes make them. Vectors and
    lengths are in mm per parameter^q.
    """

    side: Side
    address: str
    order: float
    local_order: float | None
    status: Status
    value: Float[np.ndarray, "dim"] | None
    holds: Holds | None
    block: int
    ends: Float[np.ndarray, "phases dim"] | None
    lengths: tuple[float, float] | None
    cone: Cone | None
    spiral: Spiral | None
    words: str

    def as_data(self) -> dict[str, Any]:
        """The same as plain lists and numbers, ready for JSON."""
        return {
            "side": self.side,
            "address": self.address,
            "order": self.order,
            "local_order": self.local_order,
            "status": self.status,
            "value": None if self.value is None else self.value.tolist(),
            "holds": self.holds,
            "block": self.block,
            "ends": None if self.ends is None else self.ends.tolist(),
            "lengths": None if self.lengths is None else list(self.lengths),
            "cone": self.cone.as_data() if self.cone else None,
            "spiral": self.spiral.as_data() if self.spiral else None,
            "words": self.words,
        }


@dataclass(frozen=True)
class Derivatives:
    """Both sides of a point (mm) of a curve; a side is None where the curve has none.

    `parameter` is the place of the point in [0, 1] under the parametrisation `parts`.
    """

    name: str
    address: str
    point: Float[np.ndarray, "dim"]
    parameter: float
    parts: dict[str, float]
    left: Derivative | None
    right: Derivative | None

    @property
    def passage(self) -> str | None:
        """How the two derivatives agree; None unless both are values of one order.

        "one derivative" is local differentiability of that order, "one direction" the G-alpha
        differentiability of equation 4.6, with the ratio of the lengths.
        """
        left, right = self.left, self.right
        if left is None or right is None or left.value is None or right.value is None:
            return None
        if "zero" in (left.status, right.status) or abs(left.order - right.order) > _SAME_ORDER:
            return None
        before, after = float(np.linalg.norm(left.value)), float(np.linalg.norm(right.value))
        one, other = left.value / before, right.value / after
        turn = math.degrees(2 * math.atan2(np.linalg.norm(one - other), np.linalg.norm(one + other)))
        if turn <= _SAME_ANGLE and abs(before / after - 1) <= _SAME_LENGTH:
            return f"one derivative of order {right.order:.6g}"
        if turn <= _SAME_ANGLE:
            return f"one direction, lengths in the ratio {before / after:.6g}"
        return "cusp" if turn >= 180 - _SAME_ANGLE else f"corner, turning by {turn:.6g} degrees"

    def as_data(self) -> dict[str, Any]:
        """The same as plain dictionaries, lists and numbers, ready for JSON."""
        return {
            "name": self.name,
            "address": self.address,
            "point": self.point.tolist(),
            "parameter": self.parameter,
            "parts": dict(self.parts),
            "left": self.left.as_data() if self.left else None,
            "right": self.right.as_data() if self.right else None,
            "passage": self.passage,
        }

    def as_text(self) -> str:
        """The same as lines to read."""
        lines = [f"{self.name} at {self.address}, parameter {self.parameter:.9g}"]
        for which, found in (("left", self.left), ("right", self.right)):
            lines.append(f"  {which:<7}{found.words if found else 'the curve has no such side here'}")
        if self.passage:
            lines.append(f"  joint  {self.passage}")
        return "\n".join(lines)


def derivatives(
    shape: Shape, address: str, order: float | None = None, parametrisation: Chosen = "natural"
) -> Derivatives:
    """The left and the right local fractional derivative of a curve at an address such as `"1 (0 2)*"`.

    At `w u^omega` the points on one side are `c + L_w L_u^k (p - c')`, p in the fundamental pieces, at the
    distances `h = r_w r_u^k s`. So the local order is `log|lambda| / log r_u` with the largest visible
    eigenvalue lambda of L_u, and for lambda > 0 simple the quotients tend to
    `Gamma(1 + q) r_w^-q L_w v (l (p - c')) / s^q`, with the eigenvectors v and l: equation 4.5 is this at the
    end of the curve, (4.7) and (4.8) are L_w / r_w^q. It is one value for all h only where
    `l (p - c')` is a constant times s^q. That is possible for whole q alone (otherwise its pieces were
    infinitely many independent functions), and decided with `fld.monomials`.

    `order` is q > 0, by default each side's local order; `parametrisation` is "natural", "uniform" or the
    part of each label. In (4.1) the sign on the left suits odd orders: at order 2 of a smooth curve the left
    value is the opposite of the ordinary one.

    Raises `ValueError` for an address that cannot be read, an order that is not above 0 and finite, or wrong
    parts, and what `critical_order` raises. Source: Gentil 2010, equations 4.1 to 4.8, theorem 4.2.3.

    >>> import ifs
    >>> found = derivatives(ifs.shape("corner-cutting"), "0")
    >>> found.right.value.round(9).tolist(), found.right.holds
    ([30.0, 60.0], 'all h')
    """
    if order is not None and not (math.isfinite(order) and order > 0):
        raise ValueError(f"the order of a derivative must be above 0 and finite; found {order}")
    own = curve(shape)
    where = parse_address(address, own)
    parts = chosen(own, parametrisation)
    left, right = (found and derivative(found, order) for found in sides(own, parts, where))
    point = own.operator(where.word) @ fixed_point(own.operator(where.repeat)) @ own.control
    return Derivatives(shape.name, str(where), point, parameter(own, parts, where), parts, left, right)


def derivative(found: Local, order: float | None = None) -> Derivative:
    """The derivative of one side of a point; `order` is its local order by default."""
    spectrum = found.spectrum
    if not spectrum.values:
        nothing = np.zeros(found.curve.control.shape[1])
        words = "zero at every order: the curve stays in this point"
        return _made(found, order or 1.0, None, "zero", "all h", words, value=nothing)
    own = found.order(spectrum.modulus)
    q = own if order is None else float(order)
    if q < own - _SAME_ORDER:
        nothing = np.zeros(found.curve.control.shape[1])
        words = f"zero at order {q:.6g}, below the local order {own:.12g}, for all h"
        return _made(found, q, own, "zero", "all h", words, value=nothing)
    tangent = seen(found)
    if q > own + _SAME_ORDER or spectrum.block > 1:
        return _infinite(found, tangent, q, own)
    return _at_its_order(found, tangent, q, own)


def _infinite(found: Local, tangent: HalfTangent, q: float, own: float) -> Derivative:
    """Above the local order, or at it with a logarithm: |Q| = |leading part| h^(own - q) log(1/h)^(m-1)."""
    times = period(found)
    if tangent.spiral is not None:
        low = _least_turning(found, own)
    elif times is not None:
        pieces = (repeated(found, times) if times > 1 else found).pieces(leading(found), own)
        low = _shortest(pieces, own, _POSITIVE)
    else:
        low = 0.0
    block = found.spectrum.block
    grows = f"h^{own - q:.6g}" if q > own + _SAME_ORDER else ""
    if block > 1:
        grows += f"{' ' if grows else ''}log(1/h)" + (f"^{block - 1}" if block > 2 else "")
    keeps = ""
    if tangent.direction is not None and tangent.status == "half-tangent":
        keeps = f", in the direction {written(tangent.direction)}"
    if tangent.direction is not None and low == 0 and _crosses(found):
        words = (
            f"oscillating at order {q:.6g}: quotients grow like {grows} towards {written(tangent.direction)} "
            "and its opposite, and pass by smaller lengths in between"
        )
        return _made(found, q, own, "oscillating", None, words, tangent=tangent)
    holds: Holds = "all h" if low > 0 or tangent.status == "half-tangent" else "ends of pieces"
    known = "for all h" if holds == "all h" else "along the ends of pieces"
    words = f"infinite at order {q:.6g} (local order {own:.12g}): grows like {grows} {known}{keeps}"
    return _made(found, q, own, "infinite", holds, words, tangent=tangent)


def _crosses(found: Local) -> bool:
    """Whether the curve has points on both sides of the dominant component 0, proven by boxes."""
    row = np.linalg.svd(np.real(found.spectrum.leading[0]))[2][:1] @ found.directions.basis
    return side(found.pieces(row)) == 0


def _at_its_order(found: Local, tangent: HalfTangent, q: float, own: float) -> Derivative:
    scale = math.gamma(1 + q) * math.exp(found.fade - q * found.start)
    sign = 1.0 if found.side == "right" else -1.0
    times = period(found)
    said = f"at the local order {q:.12g}"
    if times is None:
        if tangent.spiral is None:
            words = f"oscillating {said}: {tangent.words}"
            return _made(found, q, own, "oscillating", None, words, tangent=tangent)
        return _spiralling(found, tangent, q, None)
    whole = repeated(found, times) if times > 1 else found
    rows = leading(found)
    ends = sign * scale * whole.ends(rows, q)
    if tangent.spiral is not None:
        return _spiralling(found, tangent, q, ends)
    pieces = whole.pieces(rows, q)
    power = round(q)
    if times == 1 and abs(q - power) < _SAME_ORDER and is_power(pieces, power, ends[0] / (sign * scale)):
        words = f"{written(ends[0])} mm per parameter^{q:.6g} {said}, for all h"
        length = float(np.linalg.norm(ends[0]))
        more = {"value": ends[0], "ends": ends, "lengths": (length, length)}
        return _made(found, q, own, "value", "all h", words, **more)
    low, high = scale * _shortest(pieces, q), scale * _longest(pieces, q)
    between = f"lengths between {low:.6g} and {high:.6g}"
    if tangent.status == "half-tangent":
        words = (
            f"{written(ends[0])} mm per parameter^{q:.6g} {said} along the ends of pieces; over all h the "
            f"direction is kept and the length varies for ever, between {low:.6g} and {high:.6g}"
        )
        return _made(
            found, q, own, "value", "ends of pieces", words, value=ends[0], ends=ends, lengths=(low, high)
        )
    more = {"ends": ends, "lengths": (low, high), "tangent": tangent}
    if tangent.status == "undecided":
        words = f"undecided {said}: {tangent.words}"
        return _made(found, q, own, "undecided", "ends of pieces", words, **more)
    swings = tangent.cone.words if tangent.cone else "no cone of directions was found"
    return _made(found, q, own, "oscillating", None, f"oscillating {said}: {swings}; {between}", **more)


def _spiralling(
    found: Local, tangent: HalfTangent, q: float, ends: Float[np.ndarray, "phases dim"] | None
) -> Derivative:
    own = found.order(found.spectrum.modulus)
    words = f"spiralling at the local order {q:.12g}: {tangent.words}"
    return _made(found, q, own, "spiralling", None, words, tangent=tangent, ends=ends)


def _least_turning(found: Local, order: float) -> float:
    """A lower bound of the dominant part of a spiral, in its own plane: 0 where it may pass the point."""
    row = np.linalg.svd(found.spectrum.leading[0])[2][:1] @ found.directions.basis
    pieces = found.pieces(np.vstack([np.real(row), np.imag(row)]), order)
    return _shortest(pieces, order, _POSITIVE)


def _shortest(pieces: Pieces, order: float, tolerance: float = _TIGHT) -> float:
    """A proven lower bound of `|value| / s^order`; 0 where the pieces come too near to the point."""
    found = largest(pieces, partial(_bound, order, -1), partial(_value, order, -1), tolerance, 0.0)
    size = float(_value(order, 1, pieces).max())
    return -found.outer if -found.outer > _NOTHING * size else 0.0


def _longest(pieces: Pieces, order: float) -> float:
    """A proven upper bound of `|value| / s^order` over the pieces."""
    return largest(pieces, partial(_bound, order, 1), partial(_value, order, 1), _TIGHT, 0.0).outer


def _value(order: float, sign: int, pieces: Pieces) -> Float[np.ndarray, "_pieces"]:
    found = np.linalg.norm(pieces.ends(), axis=2) / pieces.distances() ** order
    return (sign * found).max(axis=1)


def _bound(order: float, sign: int, pieces: Pieces) -> Float[np.ndarray, "_pieces"]:
    lo, hi = pieces.boxes()
    far, near = pieces.distances().T
    if sign > 0:
        return np.linalg.norm(np.maximum(np.abs(lo), np.abs(hi)), axis=1) / near**order
    inside = (lo <= 0) & (hi >= 0)
    return -np.linalg.norm(np.where(inside, 0.0, np.minimum(np.abs(lo), np.abs(hi))), axis=1) / far**order


def _made(
    found: Local,
    order: float,
    own: float | None,
    status: Status,
    holds: Holds | None,
    words: str,
    *,
    value: Float[np.ndarray, "dim"] | None = None,
    ends: Float[np.ndarray, "phases dim"] | None = None,
    lengths: tuple[float, float] | None = None,
    tangent: HalfTangent | None = None,
) -> Derivative:
    return Derivative(
        found.side,
        str(found.address),
        order,
        own,
        status,
        value,
        holds,
        found.spectrum.block,
        ends,
        lengths,
        tangent.cone if tangent else None,
        tangent.spiral if tangent else None,
        words,
    )
