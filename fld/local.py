"""One side of a point of a curve: the linear map that comes back there, and the pieces that it carries in.

At the address `w u^omega` all points on one side are `c + L_w L_u^k (p - c')`, k = 0, 1, …, where c' is the
fixed point of T_u and p runs through the fundamental pieces: for every letter of u = u_1 … u_p the sub-pieces
`T_(u_1 … u_m) T_l` with l after (before) u_(m+1). Their distance in parameter is `r_w r_u^k s`. So all that
happens there is said by L_u, seen through L_w, and by these finitely many pieces.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from jaxtyping import Float, Inexact

from fld.address import Address, twin
from fld.curve import Column, Curve, fixed_point
from fld.directions import Directions, differences, projected, span, spanned, transported, visible
from fld.parts import parameter, starts
from fld.pieces import Pieces
from fld.spectrum import Dominant, Part, dominant, spectral_parts

Side = Literal["left", "right"]


@dataclass(frozen=True)
class Local:
    """One side of the point `w u^omega`, with the parametrisation `parts`.

    `points[m]` is the fixed point of the period that starts at its letter m (so `points[0]` is that of T_u),
    `beyond[m]` are the labels after (before) that letter, farthest first. `directions` are the
    directions of differences that count here; `linear[0]` is L_u on them divided by exp(`shrink`), `control`
    what they draw through L_w divided by exp(`fade`).
    """

    curve: Curve
    parts: Mapping[str, float]
    address: Address
    side: Side
    points: tuple[Column, ...]
    beyond: tuple[tuple[str, ...], ...]
    directions: Directions
    shrink: float
    fade: float

    @cached_property
    def spectrum(self) -> Dominant:
        """The dominant part of the scaled L_u."""
        return dominant(self.directions.linear[0])

    @cached_property
    def modes(self) -> tuple[Part, ...]:
        """The scaled L_u along each of its eigenvalues."""
        return spectral_parts(self.directions.linear[0])

    @cached_property
    def rate(self) -> float:
        """`log r_u`, below 0."""
        return math.fsum(math.log(self.parts[label]) for label in self.address.repeat)

    @cached_property
    def start(self) -> float:
        """`log r_w`."""
        return math.fsum(math.log(self.parts[label]) for label in self.address.word)

    @cached_property
    def places(self) -> tuple[float, ...]:
        """The parameters of `points`."""
        period = self.address.repeat
        return tuple(
            parameter(self.curve, self.parts, Address((), period[m:] + period[:m]))
            for m in range(len(period))
        )

    @property
    def far(self) -> Column:
        """The end of the curve on this side."""
        return fixed_point(self.curve.operators[-1 if self.side == "right" else 0])

    def reach(self, m: int = 0) -> float:
        """The distance in parameter from `points[m]` to the end of the curve on this side."""
        parts, place = self.parts, self.places[m]
        if len(self.address.repeat) > 1:
            return 1 - place if self.side == "right" else place
        labels = list(parts)
        here = labels.index(next(iter(self.address.repeat)))
        before = math.fsum(parts[label] for label in labels[:here])
        after = math.fsum(parts[label] for label in labels[here + 1 :])
        return (after if self.side == "right" else before) / (before + after)

    def order(self, value: complex) -> float:
        """`log|lambda| / log r_u` of an eigenvalue of the scaled L_u."""
        return (math.log(abs(value)) + self.shrink) / self.rate

    def eigenvalue(self, value: complex) -> complex:
        """An eigenvalue of L_u from one of the scaled L_u."""
        factor = math.exp(self.shrink)
        return complex(value.real * factor, value.imag * factor)

    def drawn(self, matrix: Inexact[np.ndarray, "d d"]) -> Inexact[np.ndarray, "dim points"]:
        """The rows R with which `R (p - c')` is what a matrix on `directions` makes of p - c', drawn."""
        return self.directions.control.T @ matrix @ self.directions.basis

    def phases(
        self, rows: Inexact[np.ndarray, "dim points"]
    ) -> list[tuple[Inexact[np.ndarray, "dim points"], float]]:
        """`R L_(u_1 … u_m)` for every letter, as (rows, log of a factor)."""
        found, logarithm = [], 0.0
        for label in self.address.repeat:
            found.append((rows, logarithm))
            rows = rows @ self.curve.operator((label,))
            rows = rows - rows.mean(axis=1, keepdims=True)
            size = float(np.linalg.norm(rows))
            if size == 0:
                logarithm = 0.0
                continue
            rows, logarithm = rows / size, logarithm + math.log(size)
        return found

    def pieces(self, rows: Float[np.ndarray, "dim points"], order: float = 0.0) -> Pieces:
        """The fundamental pieces, farthest first, as seen by rows: `R (p - c')` with its distance s.

        Each piece and its distances are scaled, so that `|value| / s^order` is right for the given order.
        """
        begin = starts(self.parts)
        matrices, near, sizes = [], [], []
        logarithm = 0.0  # of the part of the letters gone through
        for m, (seen, factor) in enumerate(self.phases(rows)):
            seen = seen * math.exp(factor - order * logarithm)
            here = seen @ self.points[m]
            for label in self.beyond[m]:
                matrices.append(seen @ self.curve.operator((label,)) - here[:, None])
                offset, size = begin[label] - self.places[m], self.parts[label]
                near.append(max(offset, 0.0) if self.side == "right" else max(-offset, size))
                sizes.append(size if self.side == "right" else -size)
            logarithm += math.log(self.parts[self.address.repeat[m]])
        return Pieces(self.curve, self.parts, np.array(matrices), np.array(near), np.array(sizes))

    def ends(
        self, rows: Inexact[np.ndarray, "dim points"], order: float
    ) -> Inexact[np.ndarray, "phases dim"]:
        """`R (p - c') / s^order` at the far ends of the pieces `u_1 … u_m`, those of equal ends once."""
        found, logarithm = [], 0.0
        for m, (seen, factor) in enumerate(self.phases(rows)):
            if self.beyond[m]:
                scale = math.exp(factor - order * logarithm) / self.reach(m) ** order
                found.append(seen @ (self.far - self.points[m]) * scale)
            logarithm += math.log(self.parts[self.address.repeat[m]])
        return np.array(found)


def local(curve: Curve, parts: Mapping[str, float], address: Address, side: Side) -> Local | None:
    """One side of a point; None where the piece `w` has nothing on that side of it."""
    period = address.repeat
    beyond = tuple(_beyond(curve, label, side) for label in period)
    if not any(beyond):
        return None
    points = _points(curve, period)
    matrix, shrink = _product(curve, period)
    frame = differences(len(curve.control))
    # L_u on differences as a matrix on columns: its rows and columns sum to 0.
    turn = frame.T @ matrix @ frame
    whole, start = spanned(curve), fixed_point(curve.operators[0])
    rows = []
    for m, labels in enumerate(beyond):
        for label in labels:
            operator = curve.operator((label,))
            directions = np.array([operator @ start - points[m], *(whole @ operator.T)])
            carried, _ = transported(curve, period[:m], directions)
            rows.extend(carried)
    basis = span(np.array(rows), [turn])
    image, fade = transported(curve, address.word, basis)
    directions = visible(basis, [turn], projected(curve, image))
    return Local(curve, parts, address, side, points, beyond, directions, shrink, fade)


def repeated(found: Local, times: int) -> Local:
    """The same side with the period gone through several times: its eigenvalues are powers."""
    matrix = np.linalg.matrix_power(found.directions.linear[0], times)
    directions = Directions(found.directions.basis, (matrix,), found.directions.control)
    address = Address(found.address.word, found.address.repeat * times)
    return Local(
        found.curve,
        found.parts,
        address,
        found.side,
        found.points * times,
        found.beyond * times,
        directions,
        found.shrink * times,
        found.fade,
    )


def _beyond(curve: Curve, label: str, side: Side) -> tuple[str, ...]:
    place = curve.labels.index(label)
    return curve.labels[:place:-1] if side == "right" else curve.labels[:place]


def _points(curve: Curve, period: tuple[str, ...]) -> tuple[Column, ...]:
    return tuple(fixed_point(curve.operator(period[m:] + period[:m])) for m in range(len(period)))


def _product(curve: Curve, period: tuple[str, ...]) -> tuple[Float[np.ndarray, "n n"], float]:
    """L_u on the frame of differences, as (matrix, log of a factor); a single letter keeps the factor 1."""
    frame = differences(len(curve.control))
    parts = [frame @ curve.operator((label,)) @ frame.T for label in period]
    if len(parts) == 1:
        return parts[0], 0.0
    product, logarithm = np.eye(len(frame)), 0.0
    for part in parts:
        product = product @ part
        size = float(np.linalg.norm(product))
        if size == 0:
            return product, 0.0
        product, logarithm = product / size, logarithm + math.log(size)
    return product, logarithm


def sides(curve: Curve, parts: Mapping[str, float], where: Address) -> tuple[Local | None, Local | None]:
    """The left and the right side of a point, each from its own address where the point is a joint."""
    other = twin(where, curve)
    left, right = (local(curve, parts, where, which) for which in ("left", "right"))
    if other is not None:
        left = left or local(curve, parts, other, "left")
        right = right or local(curve, parts, other, "right")
    return left, right
