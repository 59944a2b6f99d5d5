"""Pieces of a curve next to a point, seen through rows: bounds of what they do, as tight as asked."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from fld.curve import Curve, fixed_point
from fld.parts import starts
from ifs import extent

MOST = 20_000
_LEVELS = 60

Values = Float[np.ndarray, "_pieces"]


@dataclass(frozen=True)
class Pieces:
    """Parts of a curve as maps of the whole: the point p of the attractor becomes `matrices[k] p`, in mm.

    The parameter t in [0, 1] of p becomes the distance `offsets[k] + sizes[k] t` from the point looked at.
    """

    curve: Curve
    parts: Mapping[str, float]
    matrices: Float[np.ndarray, "pieces dim points"]
    offsets: Float[np.ndarray, "pieces"]
    sizes: Float[np.ndarray, "pieces"]

    def __len__(self) -> int:
        return len(self.matrices)

    def chosen(self, which: Int[np.ndarray, "_some"] | np.ndarray) -> "Pieces":
        """Some of the pieces."""
        return Pieces(self.curve, self.parts, self.matrices[which], self.offsets[which], self.sizes[which])

    def divided(self) -> "Pieces":
        """All sub-pieces, in the order along the curve that the pieces have (farthest first)."""
        labels = self.curve.labels
        begin = starts(self.parts)
        # A distance that grows along the labels runs from near to far.
        forward = bool(self.sizes[0] < 0)
        order = labels if forward else labels[::-1]
        steps = np.stack([self.curve.operator((label,)) for label in order])
        ratios = np.array([self.parts[label] for label in order])
        offsets = np.array([begin[label] for label in order])
        matrices = np.einsum("pdj,ljk->pldk", self.matrices, steps)
        return Pieces(
            self.curve,
            self.parts,
            matrices.reshape(-1, *self.matrices.shape[1:]),
            (self.offsets[:, None] + self.sizes[:, None] * offsets).ravel(),
            (self.sizes[:, None] * ratios).ravel(),
        )

    def boxes(self) -> tuple[Float[np.ndarray, "pieces dim"], Float[np.ndarray, "pieces dim"]]:
        """Boxes (lo, hi), in mm, that contain the pieces."""
        return extent(self.curve.box, np.ascontiguousarray(self.matrices.swapaxes(1, 2)))

    def ends(self) -> Float[np.ndarray, "pieces two dim"]:
        """The far and the near end of each piece."""
        first, last = (fixed_point(self.curve.operators[k]) for k in (0, -1))
        pair = (last, first) if self.sizes[0] > 0 else (first, last)
        return np.stack([self.matrices @ column for column in pair], axis=1)

    def distances(self) -> Float[np.ndarray, "pieces two"]:
        """The largest and the smallest distance in parameter of each piece: those of its `ends`."""
        return np.sort(np.stack([self.offsets + self.sizes, self.offsets], axis=1), axis=1)[:, ::-1]


@dataclass(frozen=True)
class Bound:
    """The largest value lies in `[inner, outer]`; the value `inner` is taken at an end of a piece."""

    inner: float
    outer: float


def largest(
    pieces: Pieces,
    bound: Callable[[Pieces], Values],
    value: Callable[[Pieces], Values],
    tolerance: float,
    least: float = 1.0,
) -> Bound:
    """The supremum of a function on pieces, by branch and bound.

    `bound` gives what no point of a piece exceeds, `value` what some point of it has. Stops at `tolerance`
    times the larger of `least` and |value|, after 60 subdivisions, or where more than 20000 pieces would be
    looked at.
    """
    known, settled = -np.inf, -np.inf
    for level in range(_LEVELS + 1):
        known = max(known, float(value(pieces).max()))
        upper = bound(pieces)
        enough = known + tolerance * max(least, abs(known))
        done = upper <= enough
        settled = max(settled, float(upper[done].max(initial=-np.inf)))
        if done.all():
            break
        rest = pieces.chosen(~done)
        if level == _LEVELS or len(rest) * len(pieces.curve.labels) > MOST:
            settled = max(settled, float(upper[~done].max()))
            break
        pieces = rest.divided()
    return Bound(known, max(known, settled))
