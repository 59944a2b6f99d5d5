"""Cones of directions in which a curve leaves a point, and spirals, both with bounds by boxes."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from fld.local import Local, repeated
from fld.pieces import MOST, Pieces, largest
from fld.wording import written

_RANK = 1e-9
_ANGLE = 1e-7  # radians: how tight the extreme angles are made
_WIDE = math.radians(60)
_LEVELS = 30
_TURNS = 12
_WHOLE = 1e-7  # degrees: a cone of 360 degrees less this is the whole plane

Rows = Float[np.ndarray, "_dim _points"]


@dataclass(frozen=True)
class Cone:
    """The directions that chords from a point keep coming back to, on one side.

    In a plane they are all directions from `directions[0]` turning, counter-clockwise in a drawing in the
    plane, to `directions[1]`; both are reached, so that the opening is `angle` degrees at least, and `outer`
    at most, proven by boxes. 360 means every direction. With one direction there is nothing to turn through,
    with two opposite ones of angle None the chords jump from one to the other.

    In space `axis` is given, `directions` are those at the ends of the pieces, and all directions are within
    `outer / 2` degrees of the axis (some are `angle / 2` away); `outer` is 360 where no cone below
    a half space was found.
    """

    directions: Float[np.ndarray, "n dim"]
    angle: float | None
    outer: float | None
    axis: Float[np.ndarray, "dim"] | None = None

    def as_data(self) -> dict[str, Any]:
        """The same as plain lists and numbers."""
        return {
            "directions": self.directions.tolist(),
            "angle": self.angle,
            "outer": self.outer,
            "axis": None if self.axis is None else self.axis.tolist(),
        }

    @property
    def words(self) -> str:
        """The cone in words."""
        if self.angle is None:
            return f"two opposite directions, {written(self.directions[0])} and its opposite"
        if self.axis is not None:
            if self.outer is not None and self.outer < 360:
                return (
                    f"directions within {self.outer / 2:.6g} degrees of {written(self.axis)}, "
                    f"some of them {self.angle / 2:.6g} away"
                )
            return f"directions up to {self.angle / 2:.6g} degrees away from {written(self.axis)}"
        if len(self.directions) == 1:
            return f"the direction {written(self.directions[0])}"
        if self.angle >= 360 - _WHOLE:
            return "every direction of the plane"
        return (
            f"directions from {written(self.directions[0])} to {written(self.directions[1])}, "
            f"{self.angle:.6g} degrees apart"
        )


@dataclass(frozen=True)
class Spiral:
    """A logarithmic spiral: each step turns by `turn` degrees and shrinks by `ratio`.

    The turn is positive counter-clockwise in a drawing in the plane. `proven` says that it is the true one,
    followed by boxes along the curve, else it is the least turn with that effect. `pitch` is the angle,
    in degrees, between the spiral and the circles round the point: `tan(pitch) = |log ratio| / |turn|`, 90
    where the curve does not turn. `flattening` is 1 for a spiral of circles, below 1 for the image of
    one by an affine map: the ratio of its axes; turn and pitch are those before that map.
    """

    turn: float
    ratio: float
    pitch: float
    flattening: float
    proven: bool

    def as_data(self) -> dict[str, Any]:
        """The same as plain numbers."""
        return dict(self.__dict__)


@dataclass(frozen=True)
class Sweep:
    """Angles, in radians, of pieces of a plane curve seen from a point, followed along the curve.

    All lie in `[low, high]`, those of the ends of the pieces in `[inner_low, inner_high]`; `turn` is the
    angle from the far end of the first to the near end of the last.
    """

    low: float
    high: float
    inner_low: float
    inner_high: float
    turn: float


def cone(found: Local) -> Cone | None:
    """The cone of directions on one side of a point; None where it cannot be told.

    The dominant part of L_u, run through until its eigenvalues are positive (at most 12 times), shows what
    the fundamental pieces look like at every scale: their directions are the limits of chords. None where
    turns never become whole, and where these pieces come back to the point as far as boxes tell.
    """
    times = period(found)
    if times is None:
        return None
    own = repeated(found, times) if times > 1 else found
    rows = leading(found)
    columns, sizes, _ = np.linalg.svd(rows, full_matrices=False)
    rank = int((sizes > _RANK * sizes[0]).sum())
    if rank == 1:
        return None
    if rank > 2:
        return _space(own.pieces(rows / sizes[0]))
    plane = np.eye(2) if len(rows) == 2 else columns[:, :2].T
    return _plane(own.pieces(plane @ rows / sizes[0]), plane)


def spiral(found: Local) -> Spiral:
    """The spiral of one side of a point whose dominant eigenvalues are a complex pair."""
    value, lead = found.spectrum.values[0], found.spectrum.leading[0]
    columns, sizes, rows = np.linalg.svd(lead)
    column, row = columns[:, 0] * sizes[0], rows[0] @ found.directions.basis
    drawn = np.array([np.real(column), -np.imag(column)]) @ found.directions.control
    lengths = np.linalg.svd(drawn, compute_uv=False)
    swept = sweep(found.pieces(np.array([np.real(row), np.imag(row)])))
    turn = math.atan2(value.imag, value.real)
    if swept is not None:
        # The followed turn differs from the principal one by whole turns.
        turn += 2 * math.pi * round((swept.turn - turn) / (2 * math.pi))
    ratio = math.exp(math.log(abs(value)) + found.shrink)
    pitch = math.degrees(math.atan2(-math.log(ratio), abs(turn)))
    sign = np.sign(np.linalg.det(drawn)) if drawn.shape[1] == 2 else 1.0
    return Spiral(
        math.degrees(turn) * float(sign),
        ratio,
        pitch,
        float(lengths[1] / lengths[0]) if len(lengths) > 1 else 0.0,
        swept is not None,
    )


def leading(found: Local) -> Float[np.ndarray, "dim points"]:
    """The rows that show the dominant part of L_u^k for every k that `period` divides."""
    spectrum = found.spectrum
    total = np.zeros_like(spectrum.leading[0])
    for value, lead in zip(spectrum.values, spectrum.leading, strict=True):
        total = total + lead * (abs(value) / value) ** (spectrum.block - 1)
    return found.drawn(np.real(total))


def period(found: Local) -> int | None:
    """After how many steps the dominant eigenvalues are all positive; None beyond 12."""
    angles = [math.atan2(value.imag, value.real) / (2 * math.pi) for value in found.spectrum.values]
    for times in range(1, _TURNS + 1):
        if all(abs(times * angle - round(times * angle)) < 1e-10 for angle in angles):
            return times
    return None


def sweep(pieces: Pieces) -> Sweep | None:
    """The angles of plane pieces in order along a curve; None where boxes do not keep away from 0."""
    for _ in range(_LEVELS):
        angles, widths = _angles(pieces)
        wide = ~(widths < _WIDE)
        if not wide.any():
            break
        if len(pieces) + wide.sum() * len(pieces.curve.labels) > MOST:
            return None
        fine = pieces.chosen(wide).divided()
        order = np.concatenate(
            [np.flatnonzero(~wide), np.repeat(np.flatnonzero(wide), len(pieces.curve.labels))]
        )
        rest = pieces.chosen(~wide)
        pieces = Pieces(
            pieces.curve,
            pieces.parts,
            np.concatenate([rest.matrices, fine.matrices]),
            np.concatenate([rest.offsets, fine.offsets]),
            np.concatenate([rest.sizes, fine.sizes]),
        ).chosen(np.argsort(order, kind="stable"))
    else:
        return None
    centres = np.concatenate([angles[:1], angles[0] + np.cumsum(_wrapped(np.diff(angles)))])
    ends = pieces.ends()
    places = np.arctan2(ends[:, :, 1], ends[:, :, 0])
    places = centres[:, None] + _wrapped(places - centres[:, None])
    return Sweep(
        float((centres - widths).min()),
        float((centres + widths).max()),
        float(places.min()),
        float(places.max()),
        float(places[-1, 1] - places[0, 0]),
    )


def _angles(pieces: Pieces) -> tuple[Float[np.ndarray, "pieces"], Float[np.ndarray, "pieces"]]:
    """The angle of the middle of each box and how far its corners are from it; infinite round the point."""
    lo, hi = pieces.boxes()
    middle = (lo + hi) / 2
    centre = np.arctan2(middle[:, 1], middle[:, 0])
    corners = np.stack([np.arctan2(y[:, 1], x[:, 0]) for x in (lo, hi) for y in (lo, hi)], axis=1)
    widths = np.abs(_wrapped(corners - centre[:, None])).max(axis=1)
    inside = ((lo <= 0) & (hi >= 0)).all(axis=1)
    return centre, np.where(inside, np.inf, widths)


def _wrapped(angles: np.ndarray) -> np.ndarray:
    return (angles + math.pi) % (2 * math.pi) - math.pi


def _plane(pieces: Pieces, plane: Float[np.ndarray, "two dim"]) -> Cone | None:
    swept = sweep(pieces)
    if swept is None:
        return None
    low, high = swept.inner_low, swept.inner_high
    outer = swept.high - swept.low
    if high - low < 2 * math.pi and outer < math.radians(330):
        # Turned so that the middle is ahead, no angle comes near 180 degrees.
        middle = (swept.low + swept.high) / 2
        across = np.array([[math.cos(middle), math.sin(middle)], [-math.sin(middle), math.cos(middle)]])
        ahead = Pieces(
            pieces.curve,
            pieces.parts,
            np.einsum("ij,pjk->pik", across, pieces.matrices),
            pieces.offsets,
            pieces.sizes,
        )
        above = largest(ahead, lambda p: _reach(p, 1), lambda p: _seen(p, 1), _ANGLE)
        below = largest(ahead, lambda p: _reach(p, -1), lambda p: _seen(p, -1), _ANGLE)
        low, high = middle - below.inner, middle + above.inner
        outer = min(outer, above.outer + below.outer)
    opening = min(math.degrees(high - low), 360.0)
    directions = np.array([[math.cos(angle), math.sin(angle)] for angle in (low, high)]) @ plane
    return Cone(directions, opening, max(opening, min(math.degrees(outer), 360.0)))


def _reach(pieces: Pieces, sign: int) -> Float[np.ndarray, "_pieces"]:
    """The largest angle (smallest for the sign -1, then as its opposite) of each box, seen from the point."""
    lo, hi = pieces.boxes()
    corners = np.stack([np.arctan2(sign * y[:, 1], x[:, 0]) for x in (lo, hi) for y in (lo, hi)], axis=1)
    inside = ((lo <= 0) & (hi >= 0)).all(axis=1)
    return np.where(inside, math.pi, corners.max(axis=1))


def _seen(pieces: Pieces, sign: int) -> Float[np.ndarray, "_pieces"]:
    ends = pieces.ends()
    return np.arctan2(sign * ends[:, :, 1], ends[:, :, 0]).max(axis=1)


def _space(pieces: Pieces) -> Cone:
    far = pieces.ends()[:, 0]
    units = far / np.linalg.norm(far, axis=1, keepdims=True)
    fine = pieces.divided().ends().reshape(-1, far.shape[1])
    lengths = np.linalg.norm(fine, axis=1)
    some = fine[lengths > 0] / lengths[lengths > 0, None]
    axis = some.mean(axis=0)
    if np.linalg.norm(axis) < 1e-3:
        axis = some[0]
    axis = axis / np.linalg.norm(axis)

    def bound(pieces: Pieces) -> Float[np.ndarray, "_pieces"]:
        lo, hi = pieces.boxes()
        bits = np.array(np.meshgrid(*[[0, 1]] * len(axis), indexing="ij")).reshape(len(axis), -1).T
        corners = np.where(bits[None, :, :] == 1, hi[:, None, :], lo[:, None, :])
        worst = _away(corners, axis).max(axis=1)
        return np.where(worst <= math.pi / 2, worst, math.pi)

    def value(pieces: Pieces) -> Float[np.ndarray, "_pieces"]:
        return _away(pieces.ends(), axis).max(axis=1)

    found = largest(pieces, bound, value, 1e-4)
    outer = 360.0 if found.outer > math.pi / 2 else math.degrees(2 * found.outer)
    return Cone(units, math.degrees(2 * found.inner), outer, axis)


def _away(points: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """The angle, in radians, between points and an axis."""
    along = points @ axis
    across = np.linalg.norm(points - along[..., None] * axis, axis=-1)
    return np.arctan2(across, along)
