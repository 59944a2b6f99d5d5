"""A curve as seen in a square window, however small: the lines in it, and how far to zoom."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from bcifs.picture import WrongPicture
from bcifs.view import axes
from fld.curve import Curve, fixed_point
from fld.tangent import HalfTangent
from ifs import extent

_MOST = 60_000
_LEVELS = 400
_ZOOM = 6.0
_LARGEST = 40.0
_ROOM = 2.4

Line = Float[np.ndarray, "_n 2"]


@dataclass(frozen=True)
class Window:
    """A square of the drawing plane: its middle and the length of its sides, in mm."""

    centre: Float[np.ndarray, "2"]
    side: float


def plane(control: Float[np.ndarray, "points dim"]) -> Float[np.ndarray, "dim 2"]:
    """The linear map that draws coordinates in the plane: from above, or as shapes in space are seen.

    Raises `WrongPicture` for more than three coordinates.

    >>> plane(np.zeros((3, 2))).tolist()
    [[1.0, 0.0], [0.0, 1.0]]
    """
    dim = control.shape[1]
    if dim > 3:
        raise WrongPicture(f"a picture needs 1 to 3 coordinates; here are {dim}")
    if dim < 3 or np.ptp(control[:, 2]) == 0:
        return np.eye(dim, 2)
    return axes(control)[:2].T


def windows(
    curve: Curve,
    control: Float[np.ndarray, "points 2"],
    point: Float[np.ndarray, "2"],
    sides: Sequence[HalfTangent | None],
    word: Sequence[str],
) -> tuple[Window, Window, Window]:
    """The whole curve, then two zooms about a point.

    A zoom is by a power of the dominant eigenvalue of the point, near 6: where that decides, both zooms show
    the same. The first one shows a piece of the size of that which the word of the address leads to, or less.
    """
    whole = _whole(curve, control)
    moduli = [abs(side.eigenvalues[0]) for side in sides if side is not None and side.eigenvalues]
    shrink = max(moduli, default=0.0)
    factor = _ZOOM
    if 0 < shrink < 1:
        steps = max(1, round(math.log(_ZOOM) / -math.log(shrink)))
        factor = min(shrink**-steps, _LARGEST)
    piece = curve.operator(tuple(word)).T @ (control - point)
    ends = np.array([fixed_point(curve.operators[k]) for k in (0, -1)])
    first = _ROOM * float(np.linalg.norm(ends @ piece, axis=1).max())
    while first > whole.side / 4:
        first /= factor
    first = max(first, 1e-9 * whole.side)
    return whole, Window(point, first), Window(point, first / factor)


def lines(curve: Curve, control: Float[np.ndarray, "points 2"], window: Window, fine: float) -> list[Line]:
    """The curve in a window, as lines through points of it no more than `fine` mm apart, or so; in mm.

    Pieces are divided while their boxes meet the window, so that a window of any size costs as much. At most
    60000 pieces are drawn.
    """
    half = window.side / 2
    first, last = (fixed_point(curve.operators[k]) for k in (0, -1))
    steps = np.stack([operator.T for operator in curve.operators])
    pieces, start, size = (control - window.centre)[None], np.zeros(1), 1.0
    drawn: list[tuple[np.ndarray, np.ndarray]] = []
    count = 0
    for _ in range(_LEVELS):
        lo, hi = extent(curve.box, np.ascontiguousarray(pieces))
        inside = ((hi >= -half) & (lo <= half)).all(axis=1)
        small = (hi - lo).max(axis=1) <= fine
        rest = inside & ~small
        full = count + len(steps) * int(rest.sum()) > _MOST
        chosen = inside if full else inside & small
        drawn.append((pieces[chosen], start[chosen]))
        count += int(chosen.sum())
        if full or not rest.any():
            break
        size /= len(steps)
        start = (start[rest, None] + size * np.arange(len(steps))).ravel()
        pieces = np.einsum("lij,pjd->plid", steps, pieces[rest]).reshape(-1, *control.shape)
    found = np.concatenate([pieces for pieces, _ in drawn])
    order = np.argsort(np.concatenate([start for _, start in drawn]), kind="stable")
    begin, end = first @ found[order], last @ found[order]
    apart = np.linalg.norm(begin[1:] - end[:-1], axis=1) > 1e-6 * window.side
    cuts = np.split(np.arange(len(begin)), np.flatnonzero(apart) + 1)
    return [np.vstack([begin[cut], end[cut[-1:]]]) + window.centre for cut in cuts if len(cut)]


def clipped(line: Line, low: Float[np.ndarray, "2"], high: Float[np.ndarray, "2"]) -> list[Line]:
    """The parts of a line inside a box (Liang and Barsky's way, all segments at once).

    >>> clipped(np.array([[-1.0, 0.5], [2.0, 0.5]]), np.zeros(2), np.ones(2))[0].tolist()
    [[0.0, 0.5], [1.0, 0.5]]
    """
    start, step = line[:-1], np.diff(line, axis=0)
    enter, leave = np.zeros(len(start)), np.ones(len(start))
    with np.errstate(divide="ignore", invalid="ignore"):
        for axis in range(2):
            ends = np.stack([(low - start)[:, axis], (high - start)[:, axis]]) / step[:, axis]
            level = step[:, axis] == 0
            outside = (start[:, axis] < low[axis]) | (start[:, axis] > high[axis])
            near = np.where(level, np.where(outside, 2.0, 0.0), ends.min(axis=0))
            far = np.where(level, 1.0, ends.max(axis=0))
            enter, leave = np.maximum(enter, near), np.minimum(leave, far)
    kept = np.flatnonzero(enter <= leave)
    if not len(kept):
        return []
    begin = start + enter[:, None] * step
    end = start + leave[:, None] * step
    breaks = (np.diff(kept) > 1) | (leave[kept[:-1]] < 1) | (enter[kept[1:]] > 0)
    return [np.vstack([begin[run], end[run[-1:]]]) for run in np.split(kept, np.flatnonzero(breaks) + 1)]


def _whole(curve: Curve, control: Float[np.ndarray, "points 2"]) -> Window:
    lo, hi = extent(curve.box, np.ascontiguousarray(control[None]))
    size = float((hi - lo).max())
    rough = Window((lo[0] + hi[0]) / 2, 2 * size)
    points = np.concatenate(lines(curve, control, rough, size / 200))
    low, high = points.min(axis=0), points.max(axis=0)
    return Window((low + high) / 2, 1.12 * float((high - low).max()))
