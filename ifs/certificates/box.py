"""The bounding box of a shape in modelling space, to a stated tolerance."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from ifs.asked import require_shape
from ifs.certificates.bounds import Box, bounds, extent, sample
from ifs.shape import Shape
from ifs.system import System

Corner = Float[np.ndarray, "dim"]
Heights = Float[np.ndarray, "_pieces _points"]

MOST_PIECES = 200_000
DIVE = 60


def bounding_box(shape: Shape, tolerance: float = 1e-3) -> tuple[Corner, Corner]:
    """A box (lo, hi), in mm, that contains the attractor, each side loose by `tolerance` of its size at most.

    The box of a cell is loose where operators have negative entries. Here, for each side, the pieces
    that may reach beyond the farthest known point are subdivided until none does by more than the
    tolerance (branch and bound; at 200000 pieces the bound reached so far is returned, which still
    contains the attractor). Raises `NotContracting`.

    >>> from ifs.shape import shape
    >>> lo, hi = bounding_box(shape("takagi-curve"))
    >>> bool(abs(hi[1] - 160 / 3) < 0.02)
    True
    """
    require_shape(shape)
    search = _Search(shape.system, bounds(shape.system), sample(shape.system))
    low, high = extent(search.boxes[shape.system.shape], shape.control[None])
    rounding = 64 * np.finfo(float).eps * len(shape.control) * float(np.abs(shape.control).max())
    slack = max(tolerance * float((high - low).max()), rounding)  # an attractor may be a single point
    tops = [search.reach(column, slack) for column in shape.control.T]
    bottoms = [-search.reach(-column, slack) for column in shape.control.T]
    return np.array(bottoms), np.array(tops)


@dataclass(frozen=True)
class _Search:
    """Upper bounds of one coordinate; pieces are rows of that coordinate of their control points."""

    system: System
    boxes: Mapping[str, Box]
    points: Mapping[str, np.ndarray]

    def reach(self, heights: Float[np.ndarray, "points"], slack: float) -> float:
        """An upper bound, by `slack` at most too high, of a coordinate on the attractor."""
        known = self._dive(heights)
        pieces: dict[str, Heights] = {self.system.shape: heights[None]}
        settled = known
        while pieces:
            kept: dict[str, Heights] = {}
            for cell, rows in pieces.items():
                bound = self._bound(cell, rows)
                low = bound <= known + slack
                settled = max(settled, float(bound[low].max(initial=settled)))
                if not low.all():
                    kept[cell] = rows[~low]
            if sum(len(rows) for rows in kept.values()) > MOST_PIECES:
                return max(float(self._bound(cell, rows).max()) for cell, rows in kept.items())
            pieces = self._children(kept)
            for cell, rows in pieces.items():
                known = max(known, float((rows @ self.points[cell]).max()))
        return settled

    def _bound(self, cell: str, rows: Heights) -> Float[np.ndarray, "_pieces"]:
        return extent(self.boxes[cell], rows[:, :, None])[1][:, 0]

    def _children(self, pieces: Mapping[str, Heights]) -> dict[str, Heights]:
        found: dict[str, list[Heights]] = {}
        for cell, rows in pieces.items():
            state = self.system.states[cell]
            for operator, target in zip(state.operators, state.targets, strict=True):
                found.setdefault(target, []).append(rows @ operator)
        return {cell: np.concatenate(parts) for cell, parts in found.items()}

    def _dive(self, heights: Float[np.ndarray, "points"]) -> float:
        """The coordinate of a point found by always entering the piece whose bound is highest."""
        cell, row = self.system.shape, heights[None]
        known = float((row @ self.points[cell])[0])
        for _ in range(DIVE):
            best = -np.inf
            for target, rows in self._children({cell: row}).items():
                known = max(known, float((rows @ self.points[target]).max()))
                bound = self._bound(target, rows)
                if bound.max() > best:
                    best, cell, row = bound.max(), target, rows[[bound.argmax()]]
        return known
