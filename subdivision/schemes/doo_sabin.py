"""Doo and Sabin's scheme on polygons with four at each vertex, whatever their numbers of corners.

A face of n corners P_0 … P_(n-1) shrinks to a face of corners `Q_j = sum_k alpha_(k-j) P_k`,

    alpha_0 = (n + 5) / (4 n),    alpha_k = (3 + 2 cos(2 pi k / n)) / (4 n),

n = 4 giving (9, 3, 1, 3)/16; the sum of the corners stays, so the centroid of a face is on the limit surface.
A patch belongs to a vertex of the mesh, its corners to the four faces there; the valence of a corner is the
number of corners of its face. A corner depends on the n points of its face, a side on those of two faces,
a + b - 2 (regular: 6), the patch on those of four, 5 + sum (n_i - 3) (regular: 9). Where the cosine is
irrational the coefficient is a fraction within 1e-20 of it, and alpha_0 what is left of 1: symmetric, so that
all equations hold exactly.
Source: Gentil 2010, §4.4.1, for the regular patch; Doo and Sabin 1978 for the coefficients.
"""

from collections.abc import Sequence
from fractions import Fraction
from functools import cache

from subdivision.schemes.quad_patches import Form, Scheme, Star, mixed

_DIGITS = 20


@cache
def coefficients(n: int) -> tuple[Fraction, ...]:
    """The weights alpha_0 … alpha_(n-1) of a face of n corners, n >= 3.

    >>> [str(weight) for weight in coefficients(4)]
    ['9/16', '3/16', '1/16', '3/16']
    """
    if n < 3:
        raise ValueError(f"a face has 3 corners or more, found {n}")
    rest = [(3 + 2 * _cosine(min(k, n - k), n)) / (4 * n) for k in range(1, n)]
    return (1 - sum(rest, Fraction(0)), *rest)


def _cosine(k: int, n: int) -> Fraction:
    """cos(2 pi k / n), exact where it is rational."""
    from sympy import Rational, cos, pi

    value = cos(2 * pi * Rational(k, n))
    if isinstance(value, Rational):
        return Fraction(int(value.p), int(value.q))
    return Fraction(str(value.evalf(_DIGITS + 5))).limit_denominator(10**_DIGITS)


def _turned(star: Star) -> Star:
    return [*star[1:], star[0]]


def _edge_row(start: Star, end: Star) -> Star:
    """The points of a face, and what the face across the edge of its first two points has beyond them."""
    return [*start, *end[2:]]


def _face_row(stars: Sequence[Star]) -> Star:
    """The vertex, its four neighbours, and what its faces have beyond them."""
    return [stars[0][1], *(star[0] for star in stars), *(point for star in stars for point in star[3:])]


def _local_stars(valences: Sequence[int]) -> list[list[int]]:
    if len(valences) == 1:
        return [list(range(valences[0]))]
    if len(valences) == 2:
        a, b = valences
        return [list(range(a)), [1, 0, *range(a, a + b - 2)]]
    stars, start = [], 5
    for i, n in enumerate(valences):
        stars.append([1 + i, 0, 1 + (i - 1) % 4, *range(start, start + n - 3)])
        start += n - 3
    return stars


def _new(star: Star, j: int) -> Form:
    """The new point at the corner j of a face."""
    n = len(star)
    weights = coefficients(n)
    return mixed(*((weights[(k - j) % n], star[k]) for k in range(n)))


def _vertex(star: Star) -> list[Form]:
    return [_new(star, j) for j in range(len(star))]


def _edge(a: Star, b: Star) -> list[tuple[Star, Star]]:
    middle = [_new(a, 1), _new(a, 0), _new(b, 1), _new(b, 0)]
    return [(_vertex(a), middle), (_turned(_turned(middle)), _vertex(b))]


def _face(stars: Sequence[Star]) -> list[list[Star]]:
    own = [_new(star, 1) for star in stars]
    children = []
    for i, star in enumerate(stars):
        following, opposite, preceding = ((i + k) % 4 for k in (1, 2, 3))
        after, before = _new(star, 0), _new(star, 2)
        across_after, across_before = _new(stars[following], 2), _new(stars[preceding], 0)
        children.append(
            [
                _vertex(star),
                [own[following], own[i], after, across_after],
                [own[preceding], own[i], own[following], own[opposite]],
                [before, own[i], own[preceding], across_before],
            ]
        )
    return children


SCHEME = Scheme("Doo-Sabin surface", _turned, _edge_row, _face_row, _local_stars, _vertex, _edge, _face)
"""The coefficients and the control points of Doo and Sabin's scheme."""
