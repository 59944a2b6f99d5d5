"""Doo and Sabin's scheme on polygons with four at each vertex, whatever their numbers of corners.

A face of n corners P_0 … P_(n-1) shrinks to a face of corners `Q_j = sum_k alpha_(k-j) P_k`,

    alpha_0 = (n + 5) / (4 n),    alpha_k = (3 + 2 cos(2 pi k / n)) / (4 n),

n = 4 giving (9, 3, 1, 3)/16; the sum of the corners stays, so the centroid of a face is on the limit surface.
Another scheme has `alpha_0 = 1/2 + 1/(4n)`, `alpha_1 = alpha_(n-1) = 1/8 + 1/(4n)` and otherwise `1/(4n)`:
the same for n = 4, and rational for every n.

A patch belongs to a vertex of the mesh, its corners to the four faces there. A corner depends on the n
points of its face, a side on those of two faces, a + b - 2 (regular: 6), the patch on those of four,
5 + sum (n_i - 3) (regular: 9). Where the cosine is irrational the coefficient is a fraction within 1e-20
of it, and alpha_0 what is left of 1: symmetric, so that all equations hold exactly.
Source: Gentil 2010, §4.4.1, for the regular patch; Doo and Sabin 1978, Catmull and Clark 1978 for the
coefficients.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import NamedTuple

from subdivision.schemes.patches import Form, Scheme, Star, mixed

_DIGITS = 20

Weights = Callable[[int], Sequence[Fraction]]
"""The weights alpha_0 … alpha_(n-1) of a face of n corners; their sum is 1."""


class Corner(NamedTuple):
    """The number of corners of a face, and the region that it belongs to."""

    size: int
    region: str = ""


@cache
def coefficients(n: int) -> tuple[Fraction, ...]:
    """Doo and Sabin's weights alpha_0 … alpha_(n-1) of a face of n corners, n >= 3.

    >>> [str(weight) for weight in coefficients(4)]
    ['9/16', '3/16', '1/16', '3/16']
    """
    _require_corners(n)
    rest = [(3 + 2 * _cosine(min(k, n - k), n)) / (4 * n) for k in range(1, n)]
    return (1 - sum(rest, Fraction(0)), *rest)


@cache
def rational_coefficients(n: int) -> tuple[Fraction, ...]:
    """The weights with `alpha_0 = 1/2 + 1/(4n)`.

    >>> [str(weight) for weight in rational_coefficients(3)]
    ['7/12', '5/24', '5/24']
    """
    _require_corners(n)
    small, eighth = Fraction(1, 4 * n), Fraction(1, 8)
    rest = [small + (eighth if k in (1, n - 1) else 0) for k in range(1, n)]
    return (Fraction(1, 2) + small, *rest)


def _require_corners(n: int) -> None:
    if n < 3:
        raise ValueError(f"a face has 3 corners or more, found {n}")


def _cosine(k: int, n: int) -> Fraction:
    """cos(2 pi k / n), exact where it is rational."""
    from sympy import Rational, cos, pi

    value = cos(2 * pi * Rational(k, n))
    if isinstance(value, Rational):
        return Fraction(int(value.p), int(value.q))
    return Fraction(str(value.evalf(_DIGITS + 5))).limit_denominator(10**_DIGITS)


def _turned(star: Star) -> Star:
    return Star(star.corner, (*star.points[1:], star.points[0]))


def _stars(corners: Sequence[Corner]) -> list[Star]:
    sizes = [corner.size for corner in corners]
    return [
        Star(corner, tuple(points))
        for corner, points in zip(corners, _LOCAL[len(corners)](sizes), strict=True)
    ]


def _around_face(sizes: Sequence[int]) -> list[list[int]]:
    return [list(range(sizes[0]))]


def _across_edge(sizes: Sequence[int]) -> list[list[int]]:
    a, b = sizes
    return [list(range(a)), [1, 0, *range(a, a + b - 2)]]


def _around_vertex(sizes: Sequence[int]) -> list[list[int]]:
    stars, start = [], 5
    for i, n in enumerate(sizes):
        stars.append([1 + i, 0, 1 + (i - 1) % 4, *range(start, start + n - 3)])
        start += n - 3
    return stars


_LOCAL = {1: _around_face, 2: _across_edge, 4: _around_vertex}


def _whole(star: Star) -> Star:
    return star


def _text(corner: Corner) -> str:
    return f"{corner.size}:{corner.region}" if corner.region else str(corner.size)


def _order(corner: Corner):
    """Regular corners come first, then by size."""
    return corner != Corner(4), corner


@dataclass(frozen=True)
class _Rules:
    """The rules of one subdivision, given the weights in each region."""

    regions: Mapping[str, Weights]

    def new(self, star: Star, j: int) -> Form:
        """The new point at the corner j of a face."""
        n, region = star.corner
        weights = self.regions[region](n)
        if len(weights) != n or sum(weights) != 1:
            raise ValueError(f"the {n} weights of a face of {n} corners sum to 1, found {_listed(weights)}")
        return mixed(*((weights[(k - j) % n], star.points[k]) for k in range(n)))

    def vertex(self, star: Star) -> Star:
        return Star(star.corner, tuple(self.new(star, j) for j in range(star.corner.size)))

    def edge(self, a: Star, b: Star) -> list[tuple[Star, Star]]:
        points = (self.new(a, 1), self.new(a, 0), self.new(b, 1), self.new(b, 0))
        middle = Star(_joint(a, b), points)
        return [(self.vertex(a), middle), (_turned(_turned(middle)), self.vertex(b))]

    def face(self, stars: Sequence[Star]) -> list[list[Star]]:
        own = [self.new(star, 1) for star in stars]
        children = []
        for i, star in enumerate(stars):
            following, opposite, preceding = ((i + k) % 4 for k in (1, 2, 3))
            after, before = self.new(star, 0), self.new(star, 2)
            across_after, across_before = self.new(stars[following], 2), self.new(stars[preceding], 0)
            children.append(
                [
                    self.vertex(star),
                    Star(_joint(star, stars[following]), (own[following], own[i], after, across_after)),
                    Star(_joint(*stars), (own[preceding], own[i], own[following], own[opposite])),
                    Star(_joint(star, stars[preceding]), (before, own[i], own[preceding], across_before)),
                ]
            )
        return children


def _listed(weights: Sequence[Fraction]) -> str:
    return ", ".join(map(str, weights))


def _joint(*stars: Star) -> Corner:
    """The new face between some: of their region, or of none where they differ."""
    regions = {star.corner.region for star in stars}
    return Corner(4, regions.pop() if len(regions) == 1 else "")


def scheme(weights: Weights = coefficients, regions: Mapping[str, Weights] | None = None) -> Scheme:
    """The scheme with these weights, and others for the faces of some regions.

    >>> len(scheme(rational_coefficients).stars((Corner(5),) * 4))
    4
    """
    rules = _Rules({"": weights, **(regions or {})})
    return Scheme(
        "Doo-Sabin surface",
        lambda corner: corner.size,
        _turned,
        _stars,
        _whole,
        lambda a, b: (a, b),
        _whole,
        rules.vertex,
        rules.edge,
        rules.face,
        _text,
        _order,
    )


SCHEME = scheme()
"""Doo and Sabin's scheme with their own coefficients."""
