"""Maps of R^d by their homogeneous matrix: affine, similarities among them, and projective."""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product as corners_of
from math import cos, isfinite, radians, sin

import numpy as np
from jaxtyping import Float, Real

from ifs.maps.exact import inverse as inverted
from ifs.maps.exact import product

Amount = int | float | Fraction
"""A number of a map; a float stands for the binary fraction that it is."""

Rows = tuple[tuple[Fraction, ...], ...]
Points = Float[np.ndarray, "points dim"]
Corner = Sequence[Amount] | Real[np.ndarray, "_dim"]

MOST_DIMENSIONS = 16
_SIMILAR = 1e-12
_QUARTERS = {0: (1, 0), 90: (0, 1), 180: (-1, 0), 270: (0, -1)}


@dataclass(frozen=True)
class Map:
    """The map `x -> (A x + b) / (c . x + w)` of R^d; `rows` is `[[A, b], [c, w]]`, (d + 1, d + 1), exact.

    Affine maps have c = 0 and w = 1. Made by `affine`, `similarity` and `projective`, which check their
    input.

    >>> half = affine([[0.5]], [1])
    >>> half.apply(np.array([[4.0]])).tolist()
    [[3.0]]
    """

    rows: Rows

    @property
    def dimension(self) -> int:
        return len(self.rows) - 1

    @property
    def is_affine(self) -> bool:
        return not any(self.rows[-1][:-1])

    @property
    def matrix(self) -> Float[np.ndarray, "_size _size"]:
        """The homogeneous matrix in double precision."""
        return np.array(self.rows, dtype=float)

    @property
    def linear(self) -> Float[np.ndarray, "_dim _dim"]:
        """A, of an affine map. Raises `ValueError` for another one."""
        self._require_affine("has no linear part")
        return self.matrix[:-1, :-1]

    @property
    def translation(self) -> Float[np.ndarray, "_dim"]:
        """b, of an affine map. Raises `ValueError` for another one."""
        self._require_affine("has no translation")
        return self.matrix[:-1, -1]

    def apply(self, points: Real[np.ndarray, "points dim"]) -> Points:
        """The images of points, a row each. Raises `ValueError` that names a point that goes to infinity."""
        points = np.asarray(points, dtype=float)
        if points.shape[1] != self.dimension:
            raise ValueError(f"the map takes points of {self.dimension} coordinates, found {points.shape[1]}")
        matrix = self.matrix
        above = points @ matrix[:-1, :-1].T + matrix[:-1, -1]
        if self.is_affine:
            return above
        below = points @ matrix[-1, :-1] + matrix[-1, -1]
        lost = np.flatnonzero(below == 0)
        if len(lost):
            raise ValueError(f"point {lost[0]}, {points[lost[0]].tolist()}, goes to infinity")
        return above / below[:, None]

    def compose(self, first: "Map") -> "Map":
        """The map that applies `first`, then this one: `self.compose(first)(x) = self(first(x))`."""
        if first.dimension != self.dimension:
            raise ValueError(f"a map of R^{self.dimension} cannot follow one of R^{first.dimension}")
        return Map(_normal(product(self.rows, first.rows)))

    def inverse(self) -> "Map":
        """The inverse, exact. Raises `ValueError` for a map that has none."""
        found = inverted(self.rows)
        if found is None:
            raise ValueError("the map has no inverse: its matrix is singular")
        return Map(_normal(found))

    def ratio(self) -> float | None:
        """The factor r of a similarity, `|f(x) - f(y)| = r |x - y|`; None for other maps (to 1e-12)."""
        if not self.is_affine:
            return None
        square = self.linear.T @ self.linear
        scale = float(np.trace(square)) / len(square)
        off = np.abs(square - scale * np.eye(len(square))).max()
        return float(np.sqrt(scale)) if off <= _SIMILAR * scale else None

    def lipschitz(self, lo: Corner | None = None, hi: Corner | None = None) -> float:
        """A constant L with `|f(x) - f(y)| <= L |x - y|`.

        For an affine map the largest singular value of A, which is the least such L. A projective map has
        none on all of R^d: give a box `lo <= x <= hi`. There `Df = (A - f(x) c') / (c . x + w)`, whose
        numerator is affine in f(x), and f maps the box into the hull of its corners' images, so that `L = max
        |A - f(corner) c'| / min |c . corner + w|`; rounding counts some units in the last place. Raises
        `ValueError` for a projective map without a box, or where a point of the box goes to infinity.
        """
        if self.is_affine:
            return float(np.linalg.norm(self.linear, 2))
        images, least = self._on_box(lo, hi)
        matrix = self.matrix
        norms = [np.linalg.norm(matrix[:-1, :-1] - np.outer(image, matrix[-1, :-1]), 2) for image in images]
        return float(max(norms)) / least

    def image_box(
        self, lo: Corner, hi: Corner
    ) -> tuple[Float[np.ndarray, "_dim"], Float[np.ndarray, "_dim"]]:
        """The least box around the image of a box: the image lies in the hull of the images of the corners.

        Raises `ValueError` where a point of the box goes to infinity.
        """
        images, _ = self._on_box(lo, hi)
        return images.min(axis=0), images.max(axis=0)

    def _on_box(
        self, lo: Corner | None, hi: Corner | None
    ) -> tuple[Float[np.ndarray, "_corners _dim"], float]:
        """The images of the corners of a box, and the least |c . x + w| on it."""
        if lo is None or hi is None:
            raise ValueError(
                "a projective map has no Lipschitz constant on the whole space: give the box lo, hi in which "
                "its points stay"
            )
        if len(lo) != self.dimension or len(hi) != self.dimension:
            raise ValueError(f"a box of R^{self.dimension} has lo and hi of {self.dimension} numbers each")
        corners = np.array(list(corners_of(*zip(lo, hi, strict=True))), dtype=float)
        matrix = self.matrix
        below = corners @ matrix[-1, :-1] + matrix[-1, -1]
        if below.min() <= 0 <= below.max():
            raise ValueError(
                f"the map sends points of the box {_listed(lo)} to {_listed(hi)} to infinity: its "
                f"denominator runs from {below.min():g} to {below.max():g} there"
            )
        return self.apply(corners), float(np.abs(below).min())

    def _require_affine(self, what: str) -> None:
        if not self.is_affine:
            raise ValueError(f"a projective map {what}; its homogeneous matrix is `rows`")


def affine(linear: Sequence[Sequence[Amount]], translation: Sequence[Amount]) -> Map:
    """The map `x -> A x + b`; A is d rows of d numbers, b has d.

    Raises `ValueError` for other sizes, naming the row, and for numbers that are not finite.

    >>> turn = affine([[0, Fraction(-1, 3)], [Fraction(1, 3), 0]], [2, 0])
    >>> turn.lipschitz(), turn.compose(turn).apply(np.array([[9.0, 0.0]])).round(12).tolist()
    (0.3333333333333333, [[1.0, 0.666666666667]])
    """
    size = len(translation)
    if not 1 <= size <= MOST_DIMENSIONS or len(linear) != size:
        raise ValueError(f"expected {size} rows for a translation of {size} numbers, found {len(linear)}")
    rows = [[*row, shift] for row, shift in zip(linear, translation, strict=True)]
    return projective([*rows, [0] * size + [1]])


def similarity(
    ratio: Amount,
    translation: Sequence[Amount],
    angle: Amount = 0,
    mirror: bool = False,
    rotation: Sequence[Sequence[Amount]] | None = None,
) -> Map:
    """The map `x -> r R M x + b`, which multiplies all distances by r.

    In the plane R turns by `angle` degrees, exact for multiples of 90; in other dimensions `rotation` gives
    an orthogonal matrix. With `mirror`, M changes the sign of the last coordinate. Raises `ValueError` for a
    ratio that is not positive, a matrix that is not orthogonal (to 1e-12), and an angle outside of the plane.

    >>> similarity(Fraction(1, 2), [1, 0], angle=90).apply(np.array([[2.0, 0.0]])).tolist()
    [[1.0, 1.0]]
    """
    size = len(translation)
    if not ratio > 0:
        raise ValueError(f"the ratio of a similarity is above 0, found {ratio}")
    if rotation is None:
        if angle and size != 2:
            raise ValueError(f"an angle turns the plane; give the rotation of R^{size} as a matrix")
        rotation = _turn(angle) if size == 2 else [[int(i == j) for j in range(size)] for i in range(size)]
    square = np.array(rotation, dtype=float)
    if square.shape != (size, size) or np.abs(square @ square.T - np.eye(size)).max() > _SIMILAR:
        raise ValueError(f"expected an orthogonal matrix of {size} rows, found {np.array(rotation).tolist()}")
    factor = _exact(ratio, "the ratio")
    signs = [-1 if mirror and j == size - 1 else 1 for j in range(size)]
    linear = [
        [factor * sign * _exact(x, "an entry") for x, sign in zip(row, signs, strict=True)]
        for row in rotation
    ]
    return affine(linear, translation)


def projective(rows: Sequence[Sequence[Amount]]) -> Map:
    """The map of a homogeneous matrix `[[A, b], [c, w]]` of d + 1 rows: `x -> (A x + b) / (c . x + w)`.

    Multiples of a matrix are the same map: with c = 0 it is divided by w. Raises `ValueError` for a matrix
    that is not square, naming the row, numbers that are not finite, and c = 0 with w = 0.

    >>> projective([[1, 0], [1, 1]]).apply(np.array([[1.0], [3.0]])).tolist()
    [[0.5], [0.75]]
    """
    size = len(rows)
    if not 2 <= size <= MOST_DIMENSIONS + 1:
        raise ValueError(f"a homogeneous matrix has 2 to {MOST_DIMENSIONS + 1} rows, found {size}")
    for number, row in enumerate(rows):
        if len(row) != size:
            raise ValueError(f"row {number} has {len(row)} numbers, expected {size}")
    return Map(_normal([[_exact(x, f"an entry of row {i}") for x in row] for i, row in enumerate(rows)]))


def _listed(corner: Corner) -> list[float]:
    return [float(x) for x in corner]


def _normal(rows: Sequence[Sequence[Fraction]]) -> Rows:
    *across, weight = rows[-1]
    if any(across):
        return tuple(tuple(row) for row in rows)
    if not weight:
        raise ValueError("the last row of the matrix is 0: every point would go to infinity")
    return tuple(tuple(entry / weight for entry in row) for row in rows)


def _turn(angle: Amount) -> list[list[Amount]]:
    quarter = _QUARTERS.get(int(angle) % 360) if angle == int(angle) else None
    cosine, sine = quarter or (cos(radians(angle)), sin(radians(angle)))
    return [[cosine, -sine], [sine, cosine]]


def _exact(amount: Amount, what: str) -> Fraction:
    if isinstance(amount, float) and not isfinite(amount):
        raise ValueError(f"{what} of a map is a finite number, found {amount}")
    return Fraction(amount)
