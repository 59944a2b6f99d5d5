"""A ball that is certain to contain an attractor, nearly the smallest."""

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from jaxtyping import Float, Real

from ifs.certificates.bounds import bounds, extent, sample
from ifs.certificates.supports import TOLERANCE, Control, Places, Values, farthest, placed
from ifs.shape import Shape

_ROUNDS = 40
_INSIDE = 1e-12


@dataclass(frozen=True)
class Ball:
    """The points within `radius` mm of `centre`; no ball around the attractor is smaller than `least`."""

    centre: Float[np.ndarray, "dim"]
    radius: float
    least: float


def ball(
    shape: Shape,
    tolerance: float = TOLERANCE,
    cell: str | None = None,
    control: Real[np.ndarray, "points dim"] | None = None,
) -> Ball:
    """A ball that contains the attractor; its radius exceeds the least by about `tolerance` of the extent.

    The smallest ball of some points of the attractor gives the centre and the lower bound; the farthest point
    from the centre, found as in `supports.hull`, joins the points until nothing is gained. `cell` and
    `control` as in `hull`. Raises `NotContracting` or `Undecided`.

    >>> from ifs.shape import shape
    >>> found = ball(shape("sierpinski-triangle"))
    >>> bool(0 <= found.radius - 80 / 3**0.5 < 0.1)
    True
    """
    cell, points = placed(shape, cell, control)
    table, columns = bounds(shape.system), sample(shape.system)
    size = float(np.ptp(points, axis=0).max())
    known = (columns[cell] @ points)[None]
    best: Ball | None = None
    for _ in range(_ROUNDS):
        centre, least = smallest_ball(known)

        def bound(state: str, controls: Control, centre: Float[np.ndarray, "dim"] = centre) -> Values:
            lo, hi = extent(table[state], controls)
            return np.linalg.norm(np.maximum(np.abs(lo - centre), np.abs(hi - centre)), axis=1)

        def value(places: Places, centre: Float[np.ndarray, "dim"] = centre) -> Values:
            return np.linalg.norm(places - centre, axis=1)

        found = farthest(shape.system, columns, cell, points, bound, value, tolerance / 2)
        if best is None or found.outer < best.radius:
            best = Ball(centre, found.outer, least)
        best = Ball(best.centre, best.radius, max(best.least, least * (1 - 1e-12)))
        if found.inner <= least + tolerance / 4 * size:
            break
        known = np.vstack([known, found.point])
    assert best is not None
    return best


def smallest_ball(points: Float[np.ndarray, "n dim"]) -> tuple[Float[np.ndarray, "dim"], float]:
    """The centre and the radius of the smallest ball around points.

    The farthest point joins those on the sphere, of which the smallest ball of the few is kept; the radius
    grows in each round, so that it ends.

    >>> centre, radius = smallest_ball(np.array([[0.0, 0], [2, 0], [1, 0.5]]))
    >>> centre.tolist(), radius
    ([1.0, 0.0], 1.0)
    """
    scale = float(np.abs(points - points[0]).max(initial=0.0))
    on, centre, radius = points[:1], points[0], 0.0
    for _ in range(100):
        distances = np.linalg.norm(points - centre, axis=1)
        if distances.max() <= radius + _INSIDE * scale:
            break
        few = np.vstack([on, points[distances.argmax()]])
        best = np.inf
        for count in range(2, min(len(few), points.shape[1] + 1) + 1):
            for chosen in combinations(range(len(few)), count):
                middle, around = _sphere(few[list(chosen)])
                if around < best and np.linalg.norm(few - middle, axis=1).max() <= around + _INSIDE * scale:
                    best, on, centre = around, few[list(chosen)], middle
        if best <= radius or not np.isfinite(best):
            break
        radius = best
    return centre, float(np.linalg.norm(points - centre, axis=1).max())


def _sphere(points: Float[np.ndarray, "n dim"]) -> tuple[Float[np.ndarray, "dim"], float]:
    """The smallest sphere through some points, in the flat that they span."""
    edges = points[1:] - points[0]
    step = np.linalg.lstsq(2 * edges, (edges**2).sum(axis=1), rcond=None)[0]
    return points[0] + step, float(np.linalg.norm(step))
