"""A control mesh: its polygons checked, walked from edge to edge, and what is marked on it."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from math import inf, isnan
from typing import Any

import numpy as np
from jaxtyping import Float, Int

Numbers = Int[np.ndarray, "_halves"]
Polygons = Sequence[Sequence[int]] | Int[np.ndarray, "_faces _corners"]
Pair = tuple[int, int]

SHARPEST = 10
"""An edge of this sharpness or more is a crease for ever."""


class WrongMesh(ValueError):
    """A control mesh that is no surface: what is wrong, and at which face (counted from 0)."""

    def __init__(self, message: str, face: int | None = None):
        self.face = face
        super().__init__(message if face is None else f"face {face}: {message}")


@dataclass(frozen=True)
class Marks:
    """What is marked on a mesh.

    `creases[v, w]` with v < w is the sharpness of an edge, `fixed` are the vertices that stay, and
    `regions[face]` is the region of a face that has one of its own.
    """

    creases: Mapping[Pair, Fraction | float] = field(default_factory=dict)
    fixed: frozenset[int] = frozenset()
    regions: Mapping[int, str] = field(default_factory=dict)

    def sharpness(self, v: int, w: int) -> Fraction | float:
        return self.creases.get((min(v, w), max(v, w)), Fraction(0))


@dataclass(frozen=True)
class PolygonMesh:
    """Polygons around a surface, closed or with boundaries, as half-edges: the sides of face after face.

    `vertices` is `(vertices, 3)` in millimetres. For each half-edge, `origin` is the vertex it starts from,
    `after` and `before` its neighbours around its face, `twin` the same edge in the other face, -1 at a
    boundary, and `face` its face. Faces run counterclockwise seen from outside.
    """

    vertices: Float[np.ndarray, "vertices 3"]
    origin: Numbers
    after: Numbers
    before: Numbers
    twin: Numbers
    face: Numbers
    marks: Marks = Marks()

    @property
    def sizes(self) -> Int[np.ndarray, "faces"]:
        """The number of corners of each face."""
        return np.bincount(self.face)

    @property
    def starts(self) -> Int[np.ndarray, "faces"]:
        """The first half-edge of each face."""
        return np.cumsum(self.sizes) - self.sizes

    @property
    def valences(self) -> Int[np.ndarray, "vertices"]:
        """The number of faces around each vertex."""
        return np.bincount(self.origin, minlength=len(self.vertices))

    @property
    def ends(self) -> Numbers:
        """The vertex that each half-edge leads to."""
        return self.origin[self.after]

    @property
    def at_boundary(self) -> np.ndarray:
        """Whether each vertex lies on a boundary."""
        found = np.zeros(len(self.vertices), dtype=bool)
        found[self.origin[self.twin < 0]] = True
        return found

    def around(self, halves: Numbers) -> Numbers:
        """The next half-edge from the same vertex, counterclockwise; -1 where a boundary comes first."""
        return self.twin[self.before[halves]]


def polygon_mesh(
    vertices: Any,
    faces: Polygons,
    boundary: str | None = None,
    creases: Mapping[Pair, float | Fraction] | None = None,
    corners: Iterable[int] = (),
    regions: Mapping[str, Iterable[int]] | None = None,
) -> PolygonMesh:
    """The checked mesh of vertices `(n, 3)` in millimetres and polygons with vertex numbers.

    Faces are lists of different lengths, or one array whose short rows end in -1. Without `boundary` the mesh
    must be closed; with "corners" the vertices of a single face stay where they are, with "smooth" they do
    not. `creases[v, w]` is the sharpness of an edge, `corners` are vertices that stay, `regions[name]` the
    faces of a region.

    Raises `WrongMesh`, naming a face, for: no faces, vertices that are not finite, faces with fewer than 3 or
    repeated or unknown vertices, duplicate faces, edges with one face (a hole, unless there is a `boundary`)
    or more than two, neighbours that do not run the same way round, vertices where the faces form several
    fans or, inside, fewer than 3 meet; and for marks on what is not there.

    >>> tetrahedron = polygon_mesh(np.eye(4)[:, :3], [(0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)])
    >>> tetrahedron.valences
    array([3, 3, 3, 3])
    """
    points = np.array(vertices, dtype=float)
    if points.ndim != 2 or points.shape[1] != 3:
        raise WrongMesh(f"vertices are rows of 3 coordinates in millimetres, found an array {points.shape}")
    if boundary not in (None, "smooth", "corners"):
        raise WrongMesh(f"the boundary is 'smooth' or 'corners', found {boundary!r}")
    polygons = [_polygon(face) for face in faces]
    if not polygons:
        raise WrongMesh("the mesh has no faces")
    sizes = np.array([len(polygon) for polygon in polygons])
    if sizes.min() < 3:
        number = int(sizes.argmin())
        raise WrongMesh(f"a face has 3 corners or more, found {polygons[number]}", number)
    mesh = _linked(points, np.concatenate(polygons).astype(np.int64), sizes, boundary is not None)
    _require_manifold(mesh)
    mesh.vertices.setflags(write=False)
    fixed = {int(vertex) for vertex in corners}
    if boundary == "corners":
        fixed |= set(np.flatnonzero(mesh.at_boundary & (mesh.valences == 1)).tolist())
    return replace(mesh, marks=_marks(mesh, creases or {}, fixed, regions or {}))


def _marks(
    mesh: PolygonMesh,
    creases: Mapping[Pair, float | Fraction],
    fixed: set[int],
    regions: Mapping[str, Iterable[int]],
) -> Marks:
    for vertex in fixed:
        if not 0 <= vertex < len(mesh.vertices):
            raise WrongMesh(f"there is no vertex {vertex} to be a corner: the mesh has {len(mesh.vertices)}")
    edges = set(zip(mesh.origin.tolist(), mesh.ends.tolist(), strict=True)) if creases else set()
    sharp: dict[Pair, Fraction | float] = {}
    for (v, w), sharpness in creases.items():
        if (v, w) not in edges and (w, v) not in edges:
            raise WrongMesh(f"there is no edge from vertex {v} to {w} to be a crease")
        if isnan(sharpness) or sharpness < 0:
            raise WrongMesh(
                f"the sharpness of the edge from vertex {v} to {w} is 0 or more, found {sharpness}"
            )
        if sharpness > 0:
            sharp[min(v, w), max(v, w)] = inf if sharpness >= SHARPEST else Fraction(str(sharpness))
    named: dict[int, str] = {}
    count = len(mesh.sizes)
    for name, faces in regions.items():
        for face in faces:
            if not 0 <= face < count:
                raise WrongMesh(f"region {name!r} has a face {face}: the mesh has {count}, counted from 0")
            if named.setdefault(int(face), name) != name:
                raise WrongMesh(f"it belongs to two regions, {named[face]!r} and {name!r}", int(face))
    return Marks(sharp, frozenset(fixed), named)


def _polygon(face: Sequence[int] | np.ndarray) -> list[int]:
    corners = [int(corner) for corner in face]
    if any(corner != given for corner, given in zip(corners, face, strict=True)):
        raise WrongMesh(f"corners are whole numbers of vertices, found {list(face)}")
    while corners and corners[-1] == -1:
        corners.pop()
    return corners


def _linked(points: np.ndarray, origin: np.ndarray, sizes: np.ndarray, open_: bool) -> PolygonMesh:
    face = np.repeat(np.arange(len(sizes)), sizes)
    _require_faces(points, origin, sizes, face)
    number = np.arange(len(origin))
    ends = np.cumsum(sizes)
    after, before = number + 1, number - 1
    after[ends - 1] = ends - sizes
    before[ends - sizes] = ends - 1
    twin = _twins(origin, origin[after], face, open_)
    return PolygonMesh(points, origin, after, before, twin, face)


def _require_faces(points: np.ndarray, origin: np.ndarray, sizes: np.ndarray, face: np.ndarray) -> None:
    for h in np.flatnonzero((origin < 0) | (origin >= len(points)))[:1]:
        raise WrongMesh(f"there is no vertex {origin[h]}: the mesh has {len(points)}", int(face[h]))
    wrong = np.logical_not(np.isfinite(points).all(axis=1))
    for h in np.flatnonzero(wrong[origin])[:1]:
        raise WrongMesh(f"vertex {origin[h]} is not finite: {points[origin[h]]}", int(face[h]))
    if wrong.any():
        raise WrongMesh(f"vertex {wrong.argmax()} is not finite: {points[wrong.argmax()]}")
    order = np.lexsort((origin, face))
    same = (np.diff(face[order]) == 0) & (np.diff(origin[order]) == 0)
    for place in np.flatnonzero(same)[:1]:
        raise WrongMesh(f"vertex {origin[order[place]]} comes twice", int(face[order[place]]))
    corners = np.split(origin[order], np.cumsum(sizes)[:-1])
    first: dict[bytes, int] = {}
    for number, found in enumerate(corners):
        other = first.setdefault(found.tobytes(), number)
        if other != number:
            raise WrongMesh(f"it has the same vertices as face {other}", number)


def _twins(origin: np.ndarray, end: np.ndarray, face: np.ndarray, open_: bool) -> np.ndarray:
    """For each half-edge, the one that runs the other way; -1 where an open mesh ends."""
    low, high = np.minimum(origin, end), np.maximum(origin, end)
    order = np.lexsort((origin, high, low))
    first = np.ones(len(order), dtype=bool)
    first[1:] = (np.diff(low[order]) != 0) | (np.diff(high[order]) != 0)
    starts = np.flatnonzero(first)
    counts = np.diff(np.append(starts, len(order)))
    for place in np.flatnonzero((counts > 2) | ((counts == 1) & (not open_)))[:1]:
        sharing = np.sort(order[starts[place] : starts[place] + counts[place]])
        h = sharing[0]
        edge = f"the edge from vertex {origin[h]} to {end[h]}"
        if len(sharing) == 1:
            mend = "close the hole, or say what the boundary becomes (boundary=, --boundary)"
            raise WrongMesh(f"{edge} has no other face: {mend}", int(face[h]))
        listed = ", ".join(str(face[i]) for i in sharing)
        raise WrongMesh(f"{edge} is shared by more than two faces ({listed})", int(face[h]))
    one = order[starts[counts == 2]]
    other = order[starts[counts == 2] + 1]
    for place in np.flatnonzero(origin[one] == origin[other])[:1]:
        h, k = sorted((int(one[place]), int(other[place])))
        message = f"it and face {face[h]} both run from vertex {origin[h]} to {end[h]}: turn one of them over"
        raise WrongMesh(message, int(face[k]))
    twin = np.full(len(origin), -1, dtype=np.int64)
    twin[one], twin[other] = other, one
    return twin


def _require_manifold(mesh: PolygonMesh) -> None:
    """The faces around each vertex are one fan, inside of three or more."""
    valences = mesh.valences
    few = (valences < 3) & ~mesh.at_boundary
    for h in np.flatnonzero(few[mesh.origin])[:1]:
        vertex = mesh.origin[h]
        message = f"only {valences[vertex]} faces meet at vertex {vertex}: 3 or more must"
        raise WrongMesh(message, int(mesh.face[h]))
    first = np.full(len(mesh.vertices), -1)
    first[mesh.origin[::-1]] = np.arange(len(mesh.origin))[::-1]
    bounding = np.flatnonzero(mesh.twin < 0)
    first[mesh.origin[bounding]] = bounding
    starts = first[first >= 0]
    seen = np.zeros(len(mesh.origin), dtype=bool)
    halves = starts
    while len(halves):
        seen[halves] = True
        halves = mesh.around(halves)
        halves = halves[halves >= 0]
        halves = halves[~seen[halves]]
    for h in np.flatnonzero(~seen)[:1]:
        vertex = mesh.origin[h]
        raise WrongMesh(f"the faces at vertex {vertex} form several fans: separate them", int(mesh.face[h]))
