"""A closed control mesh: its polygons checked, and walked from edge to edge."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float, Int

Numbers = Int[np.ndarray, "_halves"]
Polygons = Sequence[Sequence[int]] | Int[np.ndarray, "_faces _corners"]


class WrongMesh(ValueError):
    """A control mesh that is no closed surface: what is wrong, and at which face (counted from 0)."""

    def __init__(self, message: str, face: int | None = None):
        self.face = face
        super().__init__(message if face is None else f"face {face}: {message}")


@dataclass(frozen=True)
class ClosedMesh:
    """Polygons around a closed surface, as half-edges: the sides of the faces, face after face.

    `vertices` is `(vertices, 3)` in millimetres. For each half-edge, `origin` is the vertex it starts from,
    `after` and `before` its neighbours around its face, `twin` the same edge in the other face, and `face`
    its face.
    Faces run counterclockwise seen from outside.
    """

    vertices: Float[np.ndarray, "vertices 3"]
    origin: Numbers
    after: Numbers
    before: Numbers
    twin: Numbers
    face: Numbers

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

    def around(self, halves: Numbers) -> Numbers:
        """The next half-edge from the same vertex, counterclockwise."""
        return self.twin[self.before[halves]]


def closed_mesh(vertices: Any, faces: Polygons) -> ClosedMesh:
    """The checked mesh of vertices `(n, 3)` in millimetres and polygons with vertex numbers.

    Faces are lists of different lengths, or one array whose short rows end in -1.

    Raises `WrongMesh`, naming a face, for: no faces, vertices that are not finite, faces with fewer than 3 or
    repeated or unknown vertices, duplicate faces, edges with one face (a hole) or more than two, neighbours
    that do not run the same way round, vertices where the faces form several fans or fewer than 3 meet.

    >>> tetrahedron = closed_mesh(np.eye(4)[:, :3], [(0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)])
    >>> tetrahedron.valences
    array([3, 3, 3, 3])
    """
    points = np.array(vertices, dtype=float)
    if points.ndim != 2 or points.shape[1] != 3:
        raise WrongMesh(f"vertices are rows of 3 coordinates in millimetres, found an array {points.shape}")
    polygons = [_polygon(face) for face in faces]
    if not polygons:
        raise WrongMesh("the mesh has no faces")
    sizes = np.array([len(polygon) for polygon in polygons])
    if sizes.min() < 3:
        number = int(sizes.argmin())
        raise WrongMesh(f"a face has 3 corners or more, found {polygons[number]}", number)
    mesh = _linked(points, np.concatenate(polygons).astype(np.int64), sizes)
    _require_manifold(mesh)
    mesh.vertices.setflags(write=False)
    return mesh


def _polygon(face: Sequence[int] | np.ndarray) -> list[int]:
    corners = [int(corner) for corner in face]
    while corners and corners[-1] == -1:
        corners.pop()
    return corners


def _linked(points: np.ndarray, origin: np.ndarray, sizes: np.ndarray) -> ClosedMesh:
    face = np.repeat(np.arange(len(sizes)), sizes)
    _require_faces(points, origin, sizes, face)
    number = np.arange(len(origin))
    ends = np.cumsum(sizes)
    after, before = number + 1, number - 1
    after[ends - 1] = ends - sizes
    before[ends - sizes] = ends - 1
    twin = _twins(origin, origin[after], face)
    return ClosedMesh(points, origin, after, before, twin, face)


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


def _twins(origin: np.ndarray, end: np.ndarray, face: np.ndarray) -> np.ndarray:
    """For each half-edge, the one that runs the other way."""
    low, high = np.minimum(origin, end), np.maximum(origin, end)
    order = np.lexsort((origin, high, low))
    pairs = np.stack([low, high], axis=1)
    _, inverse, count = np.unique(pairs, axis=0, return_inverse=True, return_counts=True)
    inverse = inverse.reshape(-1)
    for h in np.flatnonzero(count[inverse] != 2)[:1]:
        sharing = np.flatnonzero(inverse == inverse[h])
        edge = f"the edge from vertex {origin[h]} to {end[h]}"
        if len(sharing) == 1:
            raise WrongMesh(f"{edge} has no other face: close the hole", int(face[h]))
        listed = ", ".join(str(face[i]) for i in sharing)
        raise WrongMesh(f"{edge} is shared by more than two faces ({listed})", int(face[h]))
    one, other = order[::2], order[1::2]
    for place in np.flatnonzero(origin[one] == origin[other])[:1]:
        h, k = sorted((int(one[place]), int(other[place])))
        message = f"it and face {face[h]} both run from vertex {origin[h]} to {end[h]}: turn one of them over"
        raise WrongMesh(message, int(face[k]))
    twin = np.empty(len(origin), dtype=np.int64)
    twin[one], twin[other] = other, one
    return twin


def _require_manifold(mesh: ClosedMesh) -> None:
    """The faces around each vertex are one fan, of three or more."""
    valences = mesh.valences
    for h in np.flatnonzero(valences[mesh.origin] < 3)[:1]:
        vertex = mesh.origin[h]
        message = f"only {valences[vertex]} faces meet at vertex {vertex}: 3 or more must"
        raise WrongMesh(message, int(mesh.face[h]))
    first = np.full(len(mesh.vertices), -1)
    first[mesh.origin[::-1]] = np.arange(len(mesh.origin))[::-1]
    starts = first[first >= 0]
    seen = np.zeros(len(mesh.origin), dtype=bool)
    halves = starts
    while len(halves):
        seen[halves] = True
        halves = mesh.around(halves)
        halves = halves[~seen[halves]]
    for h in np.flatnonzero(~seen)[:1]:
        vertex = mesh.origin[h]
        raise WrongMesh(f"the faces at vertex {vertex} form several fans: separate them", int(mesh.face[h]))
