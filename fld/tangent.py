"""Half-tangents: in which direction a curve leaves a point, on either side."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from fld.address import Address
from fld.cone import Cone, Spiral, cone, spiral
from fld.curve import Curve, curve
from fld.local import Local, Side, local
from fld.order import dominant_moduli, ratios
from fld.sides import side
from fld.wording import Status, canonical, power, written
from ifs import Shape


@dataclass(frozen=True)
class HalfTangent:
    """How a curve leaves a point on one side, h being the distance in parameter from it.

    `status` is one of

    - "half-tangent": chords from the point tend to `direction`, a unit vector into the curve;
    - "undecided": the dominant eigenvalue is simple, real and positive and `direction` is the limit along
      the ends of the pieces; that the whole curve stays on that side was neither proven nor refuted;
    - "oscillates": chords come back, for ever, to different directions (opposite ones along `direction`
      when the dominant eigenvalue is positive and the curve lies on both sides);
    - "unoriented": the dominant eigenvalue is negative; chords swing between `direction` and its opposite;
    - "spiral": a complex pair dominates; chords turn round the point;
    - "several directions": equal dominant eigenvalues; each part of the curve keeps its own direction;
    - "constant": this end does not move the point, up to the last visible eigenvalue.

    `order` is the local order `log|lambda| / log r` (None when constant), `eigenvalues` those of the linear
    part on visible directions, largest modulus first, `block` the size m of the dominant Jordan block:
    distances shrink like `h^order log(1/h)^(m-1)`. For a half-tangent with m = 1, `size` is the limit in mm
    of `distance / h^order` along the ends of the pieces (`|a_i v_i|` or `|b_i v_i|` of equation 4.5, carried
    along by 4.7 or 4.8); the local fractional derivative of that order, where it exists, has the length
    `Gamma(1 + order) size` (see `fld.derivatives`).

    `cone` holds the directions that chords keep coming back to where they oscillate: two opposite ones, or an
    angle with its bounds. Where the curve lies on both sides of a line, chords also turn, ever faster
    against h, through the directions between the two opposite ones. `spiral` says how the curve turns.
    """

    side: Side
    address: str
    status: Status
    direction: Float[np.ndarray, "dim"] | None
    order: float | None
    eigenvalues: tuple[complex, ...]
    block: int
    size: float | None
    words: str
    cone: Cone | None = None
    spiral: Spiral | None = None

    def as_data(self) -> dict[str, Any]:
        """The same as plain lists and numbers, ready for JSON; eigenvalues are `[real, imaginary]`."""
        return {
            "side": self.side,
            "address": self.address,
            "status": self.status,
            "direction": None if self.direction is None else [float(x) for x in self.direction],
            "order": self.order,
            "eigenvalues": [[value.real, value.imag] for value in self.eigenvalues],
            "block": self.block,
            "size": self.size,
            "words": self.words,
            "cone": self.cone.as_data() if self.cone else None,
            "spiral": self.spiral.as_data() if self.spiral else None,
        }


def half_tangents(shape: Shape) -> tuple[HalfTangent, HalfTangent]:
    """The right half-tangent at the start of a curve and the left one at its end.

    At the start `0^omega`, points of the curve are `c + L_0^k (p - c)`, so their direction tends to the
    eigenvector of the dominant eigenvalue of L_0, projected by the control points, when that eigenvalue is
    real, positive and simple (or has one largest Jordan block, as for the Takagi curve, whose half-tangents
    are vertical) and all the rest of the curve has components of one sign along it. That last condition is
    proven by boxes around the pieces. Otherwise `status` says what happens instead.

    Raises as `critical_order` does. Source: Gentil 2010, equation 4.5 and theorem 4.2.3; section 4.3.1.

    >>> import ifs
    >>> start, end = half_tangents(ifs.shape("takagi-curve"))
    >>> bool(start.direction[1] > 1 - 1e-12 and end.direction[1] > 1 - 1e-12)
    True
    >>> half_tangents(ifs.shape("koch-curve"))[0].status
    'several directions'
    """
    own = curve(shape)
    parts = ratios(dominant_moduli(own))
    right = half_tangent(own, parts, Address((), (own.labels[0],)), "right")
    left = half_tangent(own, parts, Address((), (own.labels[-1],)), "left")
    assert right is not None
    assert left is not None
    return right, left


def half_tangent(
    curve: Curve, parts: Mapping[str, float], address: Address, which: Side
) -> HalfTangent | None:
    """One side of a point; None where the piece `word` of the address has nothing on that side."""
    found = local(curve, parts, address, which)
    return None if found is None else seen(found)


def seen(found: Local) -> HalfTangent:
    """The half-tangent of one side of a point."""
    spectrum = found.spectrum
    status, vector, along = _verdict(found)
    order = found.order(spectrum.modulus) if status != "constant" else None
    size = None
    if vector is not None and order is not None and status == "half-tangent" and spectrum.block == 1:
        shrunk = math.log(found.reach()) + found.start
        size = math.exp(found.fade + math.log(np.linalg.norm(vector) * abs(along)) - order * shrunk)
    direction = None if vector is None else vector / np.linalg.norm(vector)
    opening = cone(found) if status in ("several directions", "oscillates") else None
    if opening is None and status in ("oscillates", "unoriented") and direction is not None:
        opening = Cone(np.array([direction, -direction]), None, None)
    turning = spiral(found) if status == "spiral" else None
    values = tuple(found.eigenvalue(value) for value in spectrum.eigenvalues)
    words = _words(found, status, direction, order, size, opening, turning)
    return HalfTangent(
        found.side,
        str(found.address),
        status,
        direction,
        order,
        values,
        spectrum.block,
        size,
        words,
        opening,
        turning,
    )


def _verdict(found: Local) -> tuple[Status, Float[np.ndarray, "dim"] | None, float]:
    """The status, a vector in its direction, and the component of the far end along that vector."""
    values, ranks = found.spectrum.values, found.spectrum.ranks
    if not values:
        return "constant", None, 0.0
    if len(values) == 1 and ranks[0] == 1:
        return _single(found, values[0].real)
    if len(values) == 1:
        return "several directions", None, 0.0
    if len(values) == 2 and ranks == (1, 1) and values[0].imag != 0 and _turns(found):
        return "spiral", None, 0.0
    return "oscillates", None, 0.0


def _single(found: Local, value: float) -> tuple[Status, Float[np.ndarray, "dim"], float]:
    columns, sizes, rows = np.linalg.svd(np.real(found.spectrum.leading[0]))
    vector = columns[:, 0] * sizes[0] @ found.directions.control
    row = rows[:1] @ found.directions.basis
    along = float(row[0] @ (found.far - found.points[0]))
    if value < 0:
        return "unoriented", canonical(vector), along
    sign = side(found.pieces(row))
    if sign == 0:
        return "oscillates", canonical(vector), along
    if sign is None:
        return "undecided", vector * (1 if along >= 0 else -1), along
    return "half-tangent", vector * sign, along


def _turns(found: Local) -> bool:
    """Whether the control points show the plane of a complex pair as a plane."""
    column = np.linalg.svd(found.spectrum.leading[0])[0][:, 0]
    plane = np.array([np.real(column), np.imag(column)]) @ found.directions.control
    sizes = np.linalg.svd(plane, compute_uv=False)
    return len(sizes) > 1 and bool(sizes[1] > 1e-9 * sizes[0])


def _words(
    found: Local,
    status: Status,
    direction: Float[np.ndarray, "dim"] | None,
    order: float | None,
    size: float | None,
    opening: Cone | None,
    turning: Spiral | None,
) -> str:
    if order is None:
        return "the curve stays in this point: no visible eigenvalue differs from 0"
    spectrum = found.spectrum
    vector = "" if direction is None else written(direction)
    value = found.eigenvalue(spectrum.values[0])
    distance = power(order, spectrum.block - 1)
    if size is not None:
        distance = f"{size:.6g} mm {distance}"
    if status == "oscillates" and not vector:
        count = len(spectrum.values)
        said = f"chords oscillate and keep no direction ({count} eigenvalues of modulus {abs(value):.6g})"
    elif status == "oscillates":
        said = f"chords oscillate between {vector} and its opposite: the curve lies on both sides"
    elif status == "half-tangent":
        said = f"the curve leaves in the direction {vector}"
    elif status == "undecided":
        said = f"the ends of the pieces tend to {vector}; whether all the curve keeps that side is undecided"
    elif status == "unoriented":
        said = f"a negative eigenvalue, {value.real:.6g}: chords swing between {vector} and its opposite"
    elif turning is not None:
        known = "" if turning.proven else " or whole turns more"
        said = (
            f"the curve spirals: each step turns by {abs(turning.turn):.6g} degrees{known} and shrinks by "
            f"{turning.ratio:.6g}, a pitch of {turning.pitch:.6g} degrees"
        )
    else:
        said = (
            f"no half-tangent: the eigenvalue {value.real:.6g} has {sum(spectrum.ranks)} independent "
            f"directions, and each part of the curve keeps its own"
        )
    if opening is not None and not vector:
        said += f"; chords take {opening.words}"
    return f"{said}; its distance is like {distance}"
