"""The box-counting dimension of a shape by regression over scales, with an interval of confidence."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from ifs.asked import require_shape, require_whole
from ifs.certificates.bounds import sample
from ifs.pieces import pieces
from ifs.shape import Shape

MOST_POINTS = 300_000
_OFFSETS = 8
_FINEST = 4  # the smallest boxes, in sizes of pieces


@dataclass(frozen=True)
class BoxCounting:
    """`dimension` is the slope of log `counts` against -log `sizes` (mm); `low` and `high` its interval."""

    dimension: float
    low: float
    high: float
    confidence: float
    sizes: Float[np.ndarray, "scales"]
    counts: Int[np.ndarray, "scales"]


def box_counting(
    shape: Shape, scales: int = 10, confidence: float = 0.95, most: int = MOST_POINTS, seed: int = 0
) -> BoxCounting:
    """An estimate of the box-counting dimension of any shape.

    One point of each of up to `most` equally large pieces is counted in grids of cubes whose sizes fall
    geometrically from a fifth of the shape to four times the size of a piece; of 8 random positions of each
    grid the one with the fewest full cubes counts. The interval is Student's for the slope, widened by half
    the difference between the slopes of the coarse and of the fine scales: the counts are neither random nor
    independent, so that it is a guide, not a certificate. Raises `ValueError` for under 4 scales, a
    confidence outside ]0, 1[, under 1000 points, and a shape that is a point; `NotContracting` or
    `Undecided`.

    >>> from ifs.shape import shape
    >>> found = box_counting(shape("sierpinski-triangle"), most=30_000)
    >>> bool(abs(found.dimension - 1.585) < 0.05)
    True
    """
    from scipy.stats import t as student

    require_shape(shape)
    require_whole("number of scales", scales, 4)
    require_whole("number of points", most, 1000)
    require_whole("seed", seed)
    if not 0 < confidence < 1:
        raise ValueError(f"the confidence lies in ]0, 1[, found {confidence}")
    points, finest = _points(shape, most)
    extent = float(np.ptp(points, axis=0).max())
    sizes = np.geomspace(extent / 5, max(_FINEST * finest, extent * 1e-6), scales)
    rng = np.random.default_rng(seed)
    counts = np.array([_count(points, size, rng) for size in sizes])
    x, y = -np.log(sizes), np.log(counts)
    slope = _slope(x, y)
    rest = y - y.mean() - slope * (x - x.mean())
    error = np.sqrt((rest @ rest) / (scales - 2) / ((x - x.mean()) ** 2).sum())
    half = scales // 2
    width = student.ppf((1 + confidence) / 2, scales - 2) * error
    width += abs(_slope(x[:half], y[:half]) - _slope(x[half:], y[half:])) / 2
    return BoxCounting(slope, slope - float(width), slope + float(width), confidence, sizes, counts)


def _points(shape: Shape, most: int) -> tuple[Float[np.ndarray, "n dim"], float]:
    """One point of each piece of a size, the smallest that needs at most so many, and that size in mm."""
    columns = sample(shape.system)
    size = float(np.ptp(shape.control, axis=0).max())
    if not size > 0:
        raise ValueError("all control points coincide: the shape is a point")
    found: Float[np.ndarray, "n dim"] | None = None
    for _ in range(40):
        size /= 2
        parts, count = [], 0
        for group in pieces(shape.system, shape.control, size=size):
            parts.append(np.einsum("p,npd->nd", columns[group.cell], group.control))
            count += len(group.control)
            if count > most:
                break
        if count > most and found is not None:
            break
        found = np.concatenate(parts)
        if count > most:
            break
    assert found is not None
    if not np.ptp(found, axis=0).max() > 0:
        raise ValueError("the shape is a point: its dimension is 0")
    return found, size * 2


def _count(points: Float[np.ndarray, "n dim"], size: float, rng: np.random.Generator) -> int:
    """The fewest full cubes of a grid over its random positions."""
    least = len(points)
    for _ in range(_OFFSETS):
        cells = np.floor((points - points.min(axis=0)) / size + rng.random(points.shape[1])).astype(np.int64)
        spans = cells.max(axis=0) + 1
        least = min(least, len(np.unique(np.ravel_multi_index(tuple(cells.T), tuple(spans)))))
    return least


def _slope(x: Float[np.ndarray, "n"], y: Float[np.ndarray, "n"]) -> float:
    return float(((x - x.mean()) @ (y - y.mean())) / ((x - x.mean()) ** 2).sum())
