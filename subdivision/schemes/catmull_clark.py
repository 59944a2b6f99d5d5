"""Catmull and Clark's scheme on quadrangles, with boundaries, creases and regions of other coefficients.

With n the valence of a vertex V, E its neighbours along edges, D the corners opposite it, F' new face points:

- face point: the mean of the corners;
- edge point: `(V0 + V1 + F0' + F1') / 4`;
- vertex point: `(n-2)/n V + 1/n^2 sum E + 1/n^2 sum F'`; its limit: `(n^2 V + 4 sum E + sum D) / (n (n+5))`.

Along a boundary or a crease the surface has an edge, a cubic B-spline curve: edge point `(V0 + V1) / 2`,
vertex point `(E0 + 6 V + E1) / 8`, limit `(E0 + 4 V + E1) / 6`; where more than two such edges meet, V stays.
An edge of sharpness s > 0 is a crease for s subdivisions and smooth then; a fraction weighs the two rules.
A vertex whose rule changes in a subdivision mixes the two, by the mean sharpness (at most 1) of the edges
that become smooth.

A corner is known by its edges, counterclockwise. A face depends on the points around its corners, as far as
the creases there; an edge on a crease only on the points of this curve, so that the two sides of it
have no more in common than that. Regular: 16 points a face, 12 an edge, 9 a vertex; at a boundary 12, 4
and 3. Source: Gentil 2010, §4.4.1, for the regular patch; Catmull and Clark 1978 for the rules; DeRose, Kass
and Truong 1998 for creases.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import inf
from typing import NamedTuple

from subdivision.schemes.patches import Form, Point, Scheme, Star, mixed

Sharpness = Fraction | float
"""How many subdivisions an edge stays sharp: 0 smooth, `inf` a crease or a boundary."""

_HALF, _QUARTER, _EIGHTH = Fraction(1, 2), Fraction(1, 4), Fraction(1, 8)


class Edge(NamedTuple):
    """An edge of a corner, and the region of the face that follows counterclockwise; None where none does."""

    sharpness: Sharpness
    face: str | None


class Corner(NamedTuple):
    """The edges around a vertex; a `fixed` one stays where it is."""

    edges: tuple[Edge, ...]
    fixed: bool = False


def ring(valence: int, region: str = "") -> Corner:
    """The corner of that many smooth edges, between faces of one region.

    Raises `ValueError` for fewer than 3.

    >>> ring(3).edges[0]
    Edge(sharpness=Fraction(0, 1), face='')
    """
    if valence < 3:
        raise ValueError(f"at least 3 patches meet at a corner, found {valence}")
    return Corner((Edge(Fraction(0), region),) * valence)


REGULAR = ring(4)


@dataclass(frozen=True)
class Coefficients:
    """The weights of a scheme: an edge point has `end` of each of its ends, and a quarter of the rest of each
    of the four other points; `vertex(n)` are the weights of V itself, of all its E and of all its D together.
    """

    end: Fraction = Fraction(3, 8)
    vertex: Callable[[int], tuple[Fraction, Fraction, Fraction]] = lambda n: (
        1 - Fraction(7, 4 * n),
        Fraction(3, 2 * n),
        Fraction(1, 4 * n),
    )


CLASSICAL = Coefficients()


# ---- corners -----------------------------------------------------------------------------------------------


def _turned(star: Star) -> Star:
    (edges, fixed), points = star
    return Star(Corner((*edges[1:], *edges[:1]), fixed), (points[0], *points[3:], *points[1:3]))


def _turned_by(star: Star, times: int) -> Star:
    for _ in range(times):
        star = _turned(star)
    return star


def _is_fixed(corner: Corner) -> bool:
    return corner.fixed or len(_creases(corner)) > 2


def _is_crease(corner: Corner) -> bool:
    """Whether two edges are sharp for ever, and no other one is sharp."""
    rest = any(0 < edge.sharpness < inf for edge in corner.edges)
    return not corner.fixed and len(_creases(corner)) == 2 and not rest


def _creases(corner: Corner) -> list[int]:
    return [k for k, edge in enumerate(corner.edges) if edge.sharpness == inf]


def _sector(star: Star) -> Star:
    """The star between the creases on both sides of its first face."""
    corner, points = star
    creases = _creases(corner)
    if len(creases) < 2 or not (_is_fixed(corner) or _is_crease(corner)):
        return star
    n = len(corner.edges)
    end = next(k for k in (*creases, creases[0] + n) if k > 0)
    start = max(k if k == 0 else k - n for k in creases)
    kept = [*range(end), end % n, *range(start + n, n)] if start else [*range(end), end % n]
    edges = [Edge(inf, None) if k == end % n else corner.edges[k] for k in kept]
    around = [p for k in kept for p in (points[1 + 2 * k], None if k == end % n else points[2 + 2 * k])]
    return Star(Corner(tuple(edges), _is_fixed(corner)), (points[0], *around))


def _in_vertex(star: Star) -> Star:
    """The vertex alone where it is fixed, on a crease with its two neighbours there, otherwise all."""
    corner, points = star
    if _is_fixed(corner):
        return Star(Corner((), True), points[:1])
    if not _is_crease(corner):
        return star
    ends = [p for k in _creases(corner) for p in (points[1 + 2 * k], None)]
    return Star(Corner((Edge(inf, None),) * 2), (points[0], *ends))


def _in_edge(a: Star, b: Star) -> tuple[Star, Star]:
    """The two sectors; of a crease only the points along it."""
    if a.corner.edges[0].sharpness < inf:
        return _sector(a), _sector(b)
    return _along(a), _along(b)


def _along(star: Star) -> Star:
    """What the curve of its first edge depends on."""
    if _is_fixed(star.corner):
        return Star(Corner((Edge(inf, None),), True), (*star.points[:2], None))
    return _in_vertex(star)


def _text(corner: Corner) -> str:
    """The valence where all is smooth and alike, else the edges one by one: `x` a crease, `|` no face."""
    edges, fixed = corner
    region = edges[0].face if edges else None
    if corner == Corner((Edge(Fraction(0), region),) * len(edges)) and region is not None:
        return f"{len(edges)}:{region}" if region else str(len(edges))
    around = [f"{_sharp(edge.sharpness)}{_side(edge.face)}" for edge in edges]
    return "".join(("!" if fixed else "", *around))


def _sharp(sharpness: Sharpness) -> str:
    return "x" if sharpness == inf else str(sharpness)


def _side(region: str | None) -> str:
    return "|" if region is None else f":{region}." if region else "."


def _order(corner: Corner):
    """Regular corners come first, then by valence."""
    around = [(edge.sharpness, edge.face is not None, edge.face or "") for edge in corner.edges]
    return corner != REGULAR, len(corner.edges), corner.fixed, around


# ---- points in common --------------------------------------------------------------------------------------


def _stars(corners: Sequence[Corner]) -> list[Star]:
    """The stars of a vertex, an edge or a face, with numbers as points."""
    same = {1: list, 2: lambda: _shared_by_ends(*corners), 4: lambda: _shared_by_corners(corners)}
    first: dict[tuple[int, int], tuple[int, int]] = {}
    for later, earlier in same[len(corners)]():
        low, high = sorted((_standing(first, later), _standing(first, earlier)))
        if low != high:
            first[high] = low
    numbers: dict[tuple[int, int], int] = {}
    result = []
    for i, corner in enumerate(corners):
        places = [0]
        for k, edge in enumerate(corner.edges):
            places += [1 + 2 * k, -1 if edge.face is None else 2 + 2 * k]
        points = tuple(
            None if k < 0 else numbers.setdefault(_standing(first, (i, k)), len(numbers)) for k in places
        )
        result.append(Star(corner, points))
    return result


def _standing(first: Mapping[tuple[int, int], tuple[int, int]], place: tuple[int, int]) -> tuple[int, int]:
    while place in first:
        place = first[place]
    return place


def _shared_by_ends(a: Corner, b: Corner) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    m, n = 2 * len(a.edges), 2 * len(b.edges)
    pairs = [((1, 1), (0, 0)), ((1, 0), (0, 1))]
    if _left(a, b):
        pairs += [((1, n - 1), (0, 2)), ((1, n), (0, 3))]
    if _left(b, a):
        pairs += [((1, 2), (0, m - 1)), ((1, 3), (0, m))]
    return pairs


def _shared_by_corners(corners: Sequence[Corner]) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    pairs = []
    for i, corner in enumerate(corners):
        j, n = (i + 1) % 4, 2 * len(corner.edges)
        pairs += [((i, 1 + k), ((i + 1 + k) % 4, 0)) for k in range(3)]
        if corner.edges[-1].face is not None and corners[j].edges[1].face is not None:
            pairs += [((j, 4), (i, n - 1)), ((j, 5), (i, n))]
    return pairs


def _left(a: Corner, b: Corner) -> bool:
    """Whether both ends of an edge know the face to the left of it, seen from a."""
    return a.edges[0].face is not None and b.edges[-1].face is not None


# ---- one subdivision ---------------------------------------------------------------------------------------


def scheme(regions: Mapping[str, Coefficients] | None = None) -> Scheme:
    """The scheme with other coefficients in some regions; where two regions meet the classical ones hold.

    >>> rough = scheme({"rough": Coefficients(end=Fraction(1, 4))})
    >>> len(rough.vertex(rough.stars((ring(4, "rough"),))[0]).points)
    9
    """
    rules = _Rules({"": CLASSICAL, **(regions or {})})
    return Scheme(
        "Catmull-Clark surface",
        lambda corner: len(corner.edges),
        _turned,
        _stars,
        _sector,
        _in_edge,
        _in_vertex,
        rules.vertex,
        rules.edge,
        rules.face,
        _text,
        _order,
    )


@dataclass(frozen=True)
class _Rules:
    """The rules of one subdivision, given the coefficients of each region."""

    regions: Mapping[str, Coefficients]

    def vertex(self, star: Star) -> Star:
        corner, points = star
        n = len(corner.edges)
        around: list[Point] = []
        for k, edge in enumerate(corner.edges):
            around += [self._edge_point(star, k), None if edge.face is None else _face_point(star, k)]
        edges = tuple(Edge(_later(edge.sharpness), edge.face) for edge in corner.edges)
        own = self._vertex_point(star) if n else points[0]
        return Star(Corner(edges, corner.fixed), (own, *around))

    def edge(self, a: Star, b: Star) -> list[tuple[Star, Star]]:
        middle = self._middle(a, b)
        return [
            (self.vertex(a), middle),
            (_turned_by(middle, 2 if _left(b.corner, a.corner) else 1), self.vertex(b)),
        ]

    def face(self, stars: Sequence[Star]) -> list[list[Star]]:
        region = stars[0].corner.edges[0].face
        children = []
        for i, star in enumerate(stars):
            following = self._beginning_inside(star, _turned(stars[(i + 1) % 4]))
            preceding = self._middle(_turned(star), stars[i - 1])
            around = [stars[(i + k) % 4] for k in range(4)]
            inner = [
                p for corner in around for p in (self._edge_point(corner, 1), self._vertex_point(corner))
            ]
            centre = Star(ring(4, region or ""), (_face_point(star, 0), *inner))
            children.append([self.vertex(star), following, centre, preceding])
        return children

    def _beginning_inside(self, a: Star, b: Star) -> Star:
        """The star of the new point on a side of a face, from the edge into the face on."""
        middle = self._middle(a, b)
        return _turned_by(middle, len(middle.corner.edges) - 1)

    def _middle(self, a: Star, b: Star) -> Star:
        """The star of the new point on an edge, from the half towards a on."""
        later = _later(a.corner.edges[0].sharpness)
        edges: list[Edge] = []
        points: list[Point] = [self._edge_point(a, 0)]
        for one, other in ((a, b), (b, a)):
            points.append(self._vertex_point(one))
            if _left(other.corner, one.corner):
                region = one.corner.edges[-1].face
                edges += [Edge(later, region), Edge(Fraction(0), region)]
                points += [self._edge_point(one, len(one.corner.edges) - 1), _face_point(other, 0)]
                points.append(self._edge_point(other, 1))
            else:
                edges.append(Edge(later, None))
                points.append(None)
        return Star(Corner(tuple(edges)), tuple(points))

    def _edge_point(self, star: Star, k: int) -> Form:
        """The new point on the edge k of a star."""
        corner, points = star
        sharp = corner.edges[k].sharpness
        ends = (points[0], points[1 + 2 * k])
        middle = mixed(*((_HALF, end) for end in ends))
        if sharp >= 1:
            return middle
        coefficients = self._of({corner.edges[k].face, corner.edges[k - 1].face})
        n = len(corner.edges)
        beside = [points[i] for j in (k, (k - 1) % n) for i in (2 + 2 * j, 1 + 2 * ((2 * j - k + 1) % n))]
        rest = (1 - 2 * coefficients.end) / 4
        smooth = mixed(*((coefficients.end, end) for end in ends), *((rest, point) for point in beside))
        return mixed((1 - sharp, smooth), (sharp, middle)) if sharp else smooth

    def _vertex_point(self, star: Star) -> Form:
        """The new place of a vertex; a mean of two rules where some of its edges become smooth."""
        edges = star.corner.edges
        now = [k for k, edge in enumerate(edges) if edge.sharpness > 0]
        later = [k for k in now if edges[k].sharpness > 1]
        before, after = self._by_rule(star, now), self._by_rule(star, later)
        if len(now) == len(later) or before == after:
            return before
        fading = [edges[k].sharpness for k in now if k not in later]
        weight = min(Fraction(1), sum((Fraction(s) for s in fading), Fraction(0)) / len(fading))
        return mixed((weight, before), (1 - weight, after))

    def _by_rule(self, star: Star, sharp: Sequence[int]) -> Form:
        corner, points = star
        if corner.fixed or len(sharp) > 2:
            return points[0]
        if len(sharp) == 2:
            return mixed((6 * _EIGHTH, points[0]), *((_EIGHTH, points[1 + 2 * k]) for k in sharp))
        n = len(corner.edges)
        own, edges, faces = self._of({edge.face for edge in corner.edges}).vertex(n)
        if own + edges + faces != 1:
            raise ValueError(
                f"the weights of a vertex of valence {n} sum to 1, found {own}, {edges}, {faces}"
            )
        return mixed(
            (own, points[0]), *((edges / n, p) for p in points[1::2]), *((faces / n, p) for p in points[2::2])
        )

    def _of(self, regions: set[str | None]) -> Coefficients:
        """The coefficients where these regions meet."""
        return self.regions[next(iter(regions)) or ""] if len(regions) == 1 else CLASSICAL


def _later(sharpness: Sharpness) -> Sharpness:
    return max(sharpness - 1, Fraction(0))


def _face_point(star: Star, k: int) -> Form:
    """The new point in the face after the edge k of a star."""
    points, n = star.points, len(star.corner.edges)
    corners = (points[0], points[1 + 2 * k], points[2 + 2 * k], points[1 + 2 * ((k + 1) % n)])
    return mixed(*((_QUARTER, point) for point in corners))


SCHEME = scheme()
"""Catmull and Clark's scheme with the classical coefficients."""
