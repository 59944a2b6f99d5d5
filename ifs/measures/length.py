"""The length of a curve: of the polygons inscribed in it, and whether they grow without end."""

from dataclasses import dataclass
from math import inf

import numpy as np

from ifs.asked import require_shape, require_whole
from ifs.dimensions.dimension import similarity
from ifs.measures.chains import chains
from ifs.shape import Shape
from ifs.uniform import mesh

_SAME = 1e-9
_SETTLED = 1e-6


@dataclass(frozen=True)
class Length:
    """The length of a curve in mm, as far as it is known.

    `polygons[n]` is the length of the polygon through the joints after n subdivisions: a lower bound of the
    curve's, since joints stay. `value` is the length where it is known: `inf` where the polygons of a
    self-similar curve grow by a factor above 1, the limit where they settle; None where neither can be said.
    `exact` says that the value follows from the ratios; otherwise it is extrapolated from the last polygons.
    """

    polygons: tuple[float, ...]
    growth: float
    value: float | None
    exact: bool


def length(shape: Shape, depth: int = 12) -> Length:
    """The length of a curve of a single cell or of several.

    Where all pieces are scaled copies, a polygon's length is multiplied in every subdivision, in the long run
    by the largest eigenvalue g of the matrix of the sums of ratios: for `g > 1` the length is infinite, for
    g = 1 and one cell the curve is a polygon and its length that of the chord. Elsewhere the polygons are
    looked at: where their lengths settle to six digits in steps that shrink at least by 3, as those of smooth
    curves do by 4, the limit is extrapolated by Richardson's rule; else nothing is said.

    Raises `NoChain` for what is no curve, `ValueError` for a depth below 3.

    >>> from ifs.shape import shape
    >>> length(shape("koch-curve"), 5).value
    inf
    >>> length(shape("corner-cutting")).exact
    False
    """
    require_shape(shape)
    require_whole("depth", depth, 3)
    chains(shape)
    polygons = tuple(_polygon(shape, level) for level in range(depth + 1))
    growth = polygons[-1] / polygons[-2] if polygons[-2] else 1.0
    found = similarity(shape)
    if found is not None and len(found.ratios) == 1 and polygons[0] > 0:
        (ratios,) = found.ratios.values()
        growth = sum(ratios.values())
        if growth > 1 + _SAME:
            return Length(polygons, growth, inf, True)
        return Length(polygons, growth, polygons[0], True)
    steps = np.diff(polygons[-3:])
    if abs(steps[1]) <= _SETTLED * polygons[-1] and abs(steps[1]) <= abs(steps[0]) / 3 + _SAME * polygons[-1]:
        return Length(polygons, growth, polygons[-1] + float(steps[1]) / 3, False)
    return Length(polygons, growth, None, False)


def _polygon(shape: Shape, depth: int) -> float:
    found = mesh(shape, depth)
    ends = found.vertices[found.faces[:, [0, -1]]]
    return float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum())
