"""Catmull and Clark's scheme on quadrangles, whatever the valences of their vertices.

With n the valence of a vertex V, E its neighbours along edges, F' the new face points:

- face point: the mean of the corners;
- edge point: `(V0 + V1 + F0' + F1') / 4`;
- vertex point: `(n-2)/n V + 1/n^2 sum E + 1/n^2 sum F'`;
- its limit: `(n^2 V + 4 sum E + sum D) / (n (n+5))`, D the corners opposite V in the quadrangles around it.

A vertex depends on 2n + 1 points, listed as V, E0, D0, E1, D1, …; an edge on 2 (a + b) - 4 (regular: 12), a
face on 2 (a + b + c + d) - 16 (regular: 16). Source: Gentil 2010, §4.4.1, for the regular patch;
Catmull and Clark 1978 for the rules.
"""

from collections.abc import Sequence
from fractions import Fraction

from subdivision.schemes.quad_patches import Form, Scheme, Star, mixed

_QUARTER = Fraction(1, 4)


def _turned(star: Star) -> Star:
    return [star[0], *star[3:], *star[1:3]]


def _edge_row(start: Star, end: Star) -> Star:
    """The star of the start, and what the star of the end has beyond it."""
    return [*start, *end[4:-2]]


def _face_row(stars: Sequence[Star]) -> Star:
    """The corners, and what the star of each has beyond the face and the faces across its sides."""
    return [star[0] for star in stars] + [point for star in stars for point in star[5:-1]]


def _local_stars(valences: Sequence[int]) -> list[list[int]]:
    if len(valences) == 1:
        return [list(range(2 * valences[0] + 1))]
    if len(valences) == 2:
        size = 2 * valences[0] + 1
        own = range(size, size + 2 * valences[1] - 5)
        return [list(range(size)), [1, 0, size - 2, size - 1, *own, 2, 3]]
    owned, start = [], 4
    for n in valences:
        owned.append(range(start, start + 2 * n - 5))
        start += 2 * n - 5
    return [
        [i, (i + 1) % 4, (i + 2) % 4, (i + 3) % 4, owned[i - 1][-1], *owned[i], owned[(i + 1) % 4][0]]
        for i in range(4)
    ]


def _face_point(star: Star, k: int) -> Form:
    """The new point in the quadrangle between the edges k and k + 1 of a star."""
    n = len(star) // 2
    return mixed(
        *((_QUARTER, p) for p in (star[0], star[1 + 2 * k], star[2 + 2 * k], star[1 + 2 * ((k + 1) % n)]))
    )


def _edge_point(star: Star, k: int) -> Form:
    """The new point on the edge k of a star."""
    n = len(star) // 2
    faces = (_face_point(star, k), _face_point(star, (k - 1) % n))
    return mixed(*((_QUARTER, p) for p in (star[0], star[1 + 2 * k], *faces)))


def _vertex(star: Star) -> list[Form]:
    n = len(star) // 2
    faces = [_face_point(star, k) for k in range(n)]
    small = Fraction(1, n * n)
    centre = mixed((Fraction(n - 2, n), star[0]), *((small, p) for p in [*star[1::2], *faces]))
    return [centre, *(point for k in range(n) for point in (_edge_point(star, k), faces[k]))]


def _middle(a: Star, b: Star) -> list[Form]:
    """The star of the new point on an edge, from the half towards a on."""
    m, n = len(a) // 2, len(b) // 2
    return [
        *(_edge_point(a, 0), _vertex(a)[0], _edge_point(a, m - 1), _face_point(b, 0), _edge_point(b, 1)),
        *(_vertex(b)[0], _edge_point(b, n - 1), _face_point(a, 0), _edge_point(a, 1)),
    ]


def _edge(a: Star, b: Star) -> list[tuple[Star, Star]]:
    middle = _middle(a, b)
    return [(_vertex(a), middle), (_turned(_turned(middle)), _vertex(b))]


def _face(stars: Sequence[Star]) -> list[list[Star]]:
    centre = _face_point(stars[0], 0)
    children = []
    for i, star in enumerate(stars):
        following = _turned(_turned(_turned(_middle(star, _turned(stars[(i + 1) % 4])))))
        preceding = _middle(_turned(star), stars[i - 1])
        around = [stars[(i + k) % 4] for k in range(4)]
        inner = [p for corner in around for p in (_edge_point(corner, 1), _vertex(corner)[0])]
        children.append([_vertex(star), following, [centre, *inner], preceding])
    return children


SCHEME = Scheme("Catmull-Clark surface", _turned, _edge_row, _face_row, _local_stars, _vertex, _edge, _face)
"""The coefficients and the control points of Catmull and Clark's scheme."""
