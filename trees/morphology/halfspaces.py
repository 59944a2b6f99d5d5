"""The convex hull of integer points as half-spaces with integer coefficients."""

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from jaxtyping import Int

from trees.errors import TreeError

ROOM = 2**62


@dataclass(frozen=True)
class HalfSpaces:
    """The points x with `normals[i] x <= limits[i]` for all i."""

    normals: Int[np.ndarray, "spaces dim"]
    limits: Int[np.ndarray, " spaces"]


def half_spaces(points: Int[np.ndarray, "points dim"], extent: int) -> HalfSpaces:
    """The half-spaces whose intersection is the convex hull of at least one point, exactly.

    Coordinates are from 0 to `extent - 1`; for such x, `normals x` and sums on the way are below 2^62.
    The points span a flat: each equation of it gives two half-spaces, and each facet of the hull in it
    one, seen along axes on which the points of the flat are told apart. Raises `TreeError` where the
    numbers are too large, or where Qhull is too coarse.

    >>> spaces = half_spaces(np.array([[0, 0], [2, 4]]), extent=8)
    >>> spaces.normals.tolist(), spaces.limits.tolist()
    ([[-2, 1], [2, -1], [1, 0], [-1, 0]], [0, 0, 2, 0])
    """
    dimension = points.shape[1]
    basis, axes = _basis(points)
    pairs: list[tuple[list[int], int]] = []
    for axis in range(dimension):
        if axis not in axes:
            normal = _equation(basis, axes, axis, dimension)
            limit = sum(n * int(x) for n, x in zip(normal, points[0], strict=True))
            pairs += [(normal, limit), ([-n for n in normal], -limit)]
    for normal, limit in _facets(points[:, axes]):
        wide = [0] * dimension
        for axis, n in zip(axes, normal, strict=True):
            wide[axis] = n
        pairs.append((wide, limit))
    pairs = [
        (list(normal), limit) for normal, limit in dict.fromkeys((tuple(n), limit) for n, limit in pairs)
    ]
    largest = max((sum(map(abs, normal)) for normal, _ in pairs), default=0) * 2 * extent
    if largest >= ROOM:
        raise TreeError(
            f"the facets of the hull need numbers of {largest.bit_length()} bits, and 62 are there: "
            "ask for fewer bits an axis"
        )
    normals = np.array([normal for normal, _ in pairs], dtype=np.int64).reshape(-1, dimension)
    return HalfSpaces(normals, np.array([limit for _, limit in pairs], dtype=np.int64))


def _basis(points: Int[np.ndarray, "points dim"]) -> tuple[list[list[int]], list[int]]:
    """Differences of points that span their flat, and as many axes on which they are independent."""
    moved = points - points[0]
    basis, axes, reduced = [], [], []
    while True:
        if len(basis) == points.shape[1]:
            return basis, sorted(axes)
        digits = (int(points.max()).bit_length() + 1) * 2 ** len(basis)
        rest = moved if digits <= 62 else moved.astype(object)
        for row, axis in reduced:
            rest = rest * row[axis] - rest[:, [axis]] * np.array([row])
        found = (rest != 0).any(axis=1)
        if not found.any():
            return basis, sorted(axes)
        which = int(np.argmax(found))
        row = [int(x) for x in rest[which]]
        common = math.gcd(*row)
        row = [x // common for x in row]
        axis = next(i for i, x in enumerate(row) if x)
        basis.append([int(x) for x in moved[which]])
        axes.append(axis)
        reduced.append((row, axis))


def _equation(basis: list[list[int]], axes: list[int], axis: int, dimension: int) -> list[int]:
    """A normal of the flat, zero off `axes` and `axis`: `n v = 0` for all v of the basis."""
    table = [[Fraction(v[a]) for a in axes] + [Fraction(v[axis])] for v in basis]
    size = len(axes)
    for i in range(size):
        pivot = next(j for j in range(i, size) if table[j][i])
        table[i], table[pivot] = table[pivot], table[i]
        table[i] = [x / table[i][i] for x in table[i]]
        for j in range(size):
            if j != i:
                table[j] = [x - table[j][i] * y for x, y in zip(table[j], table[i], strict=True)]
    shares = [row[-1] for row in table]
    scale = math.lcm(1, *(share.denominator for share in shares))
    normal = [0] * dimension
    normal[axis] = scale
    for a, share in zip(axes, shares, strict=True):
        normal[a] = -int(share * scale)
    return normal


def _facets(points: Int[np.ndarray, "points dim"]) -> list[tuple[list[int], int]]:
    """The facets of the hull of points that span the space."""
    if points.shape[1] == 0:
        return []
    if points.shape[1] == 1:
        return [([1], int(points.max())), ([-1], -int(points.min()))]
    from scipy.spatial import ConvexHull

    hull = ConvexHull(points)
    found: dict[tuple[int, ...], int] = {}
    for simplex, equation in zip(hull.simplices, hull.equations, strict=True):
        corners = [[int(x) for x in points[i]] for i in simplex]
        normal = _normal(corners)
        if not any(normal):
            continue
        if sum(n * e for n, e in zip(normal, equation, strict=False)) < 0:
            normal = [-n for n in normal]
        found[tuple(normal)] = sum(n * x for n, x in zip(normal, corners[0], strict=True))
    _check_behind(found, points)
    return [(list(normal), limit) for normal, limit in found.items()]


def _normal(corners: list[list[int]]) -> list[int]:
    """The normal of the flat through k points of dimension k, without common divisor: cofactors."""
    rows = [[x - y for x, y in zip(corner, corners[0], strict=True)] for corner in corners[1:]]
    size = len(corners[0])
    normal = [
        (-1) ** i * _determinant([[x for j, x in enumerate(row) if j != i] for row in rows])
        for i in range(size)
    ]
    common = math.gcd(*normal)
    return [n // common for n in normal] if common else normal


def _determinant(rows: list[list[int]]) -> int:
    """Bareiss's elimination, in integers."""
    rows, sign, before = [row[:] for row in rows], 1, 1
    for i in range(len(rows) - 1):
        pivot = next((j for j in range(i, len(rows)) if rows[j][i]), None)
        if pivot is None:
            return 0
        if pivot != i:
            rows[i], rows[pivot], sign = rows[pivot], rows[i], -sign
        for j in range(i + 1, len(rows)):
            for m in range(i + 1, len(rows)):
                rows[j][m] = (rows[j][m] * rows[i][i] - rows[j][i] * rows[i][m]) // before
        before = rows[i][i]
    return sign * rows[-1][-1] if rows else 1


def _check_behind(facets: dict[tuple[int, ...], int], points: Int[np.ndarray, "points dim"]) -> None:
    """Raises `TreeError` where a point lies beyond a facet."""
    largest = int(abs(points).max())
    most = max((sum(map(abs, normal)) for normal in facets), default=0) * largest
    kind = np.float64 if most < 2**53 else np.int64 if most < ROOM else object  # floats are exact up to 2^53
    exact = points.astype(kind)
    for normal, limit in facets.items():
        if (exact @ np.array(normal, dtype=kind)).max() > limit:
            raise TreeError(
                f"the facet {normal} x <= {limit} that Qhull found cuts off black cells: its floating-point "
                "numbers are too coarse for this grid, ask for fewer bits an axis"
            )
