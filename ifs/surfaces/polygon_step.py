"""One plain step of subdivision of polygons, after which every patch is quadrangular."""

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction

import numpy as np

from ifs.surfaces.polygon_mesh import Marks, PolygonMesh, polygon_mesh
from subdivision.schemes.doo_sabin import Weights


def catmull_clark_step(mesh: PolygonMesh) -> PolygonMesh:
    """The quadrangles of one step of Catmull and Clark's scheme on any polygons, with its marks.

    With n faces around V: face points are means of corners, edge points `(V0 + V1 + F0 + F1) / 4`, and
    `V' = (n-2)/n V + 1/n^2 sum E + 1/n^2 sum F`; on creases and boundaries `(V0 + V1) / 2` and
    `(E0 + 6 V + E1) / 8`; see `subdivision.schemes.catmull_clark` for sharpness. The coefficients are the
    classical ones in every region. The numbers of the vertices stay; then come the edges', then the faces'.
    Vertices that no face uses stay where they are.
    """
    points, face = mesh.vertices, mesh.face
    centres = np.zeros((len(mesh.sizes), 3))
    np.add.at(centres, face, points[mesh.origin])
    centres /= mesh.sizes[:, None]
    mid, edge_of = _edges(mesh)
    pairs = np.stack([mesh.origin[mid], mesh.ends[mid]], axis=1)
    sharp = [_sharpness(mesh, h, v, w) for h, (v, w) in zip(mid.tolist(), pairs.tolist(), strict=True)]
    middles = _middles(mesh, centres, mid, pairs, np.minimum(np.array(sharp, dtype=float), 1))
    moved = _moved(mesh, centres, pairs, sharp)
    new_edge, new_face = len(points) + edge_of, len(points) + len(mid) + face
    quadrangles = np.stack([mesh.origin, new_edge, new_face, new_edge[mesh.before]], axis=1)
    border = "smooth" if (mesh.twin < 0).any() else None
    result = polygon_mesh(np.concatenate([moved, middles, centres]), quadrangles, border)
    creases = {}
    for number, ((v, w), sharpness) in enumerate(zip(pairs.tolist(), sharp, strict=True)):
        if sharpness > 1:
            creases |= {(end, len(points) + number): sharpness - 1 for end in (v, w)}
    regions = {h: mesh.marks.regions[f] for h, f in enumerate(face.tolist()) if f in mesh.marks.regions}
    return replace(result, marks=Marks(creases, mesh.marks.fixed, regions))


def _sharpness(mesh: PolygonMesh, half: int, v: int, w: int) -> Fraction | float:
    return float("inf") if mesh.twin[half] < 0 else mesh.marks.sharpness(v, w)


def _middles(mesh: PolygonMesh, centres: np.ndarray, mid: np.ndarray, pairs: np.ndarray, sharp: np.ndarray):
    """The edge points; `sharp` weighs the midpoint."""
    halfway = mesh.vertices[pairs].mean(axis=1)
    beside = (centres[mesh.face[mid]] + centres[mesh.face[mesh.twin[mid]]]) / 2
    return np.where(sharp[:, None] == 1, halfway, halfway / 2 + beside / 2 * (1 - sharp)[:, None]
                    + halfway / 2 * sharp[:, None])  # fmt: skip


def _moved(mesh: PolygonMesh, centres: np.ndarray, pairs: np.ndarray, sharp: list) -> np.ndarray:
    """The vertices after the step."""
    points, origin = mesh.vertices, mesh.origin
    n = np.maximum(mesh.valences, 1)[:, None]
    around = np.zeros_like(points)
    np.add.at(around, origin, points[mesh.ends] + centres[mesh.face])
    moved = np.where(mesh.valences[:, None] > 0, (n - 2) / n * points + around / n**2, points)
    ends: dict[int, list[tuple[int, Fraction | float]]] = {}
    for (v, w), sharpness in zip(pairs.tolist(), sharp, strict=True):
        if sharpness > 0:
            ends.setdefault(v, []).append((w, sharpness))
            ends.setdefault(w, []).append((v, sharpness))
    smooth = moved.copy()
    for v in {*ends, *mesh.marks.fixed}:
        now = ends.get(v, [])
        later = [(w, s) for w, s in now if s > 1]
        fading = [float(s) for _, s in now if s <= 1]
        weight = min(1.0, sum(fading) / len(fading)) if fading else 1.0
        before, after = (_by_rule(mesh, smooth, v, [w for w, _ in sharp]) for sharp in (now, later))
        moved[v] = weight * before + (1 - weight) * after
    return moved


def _by_rule(mesh: PolygonMesh, smooth: np.ndarray, v: int, sharp: list[int]) -> np.ndarray:
    if v in mesh.marks.fixed or len(sharp) > 2:
        return mesh.vertices[v]
    if len(sharp) == 2:
        return 0.75 * mesh.vertices[v] + 0.125 * mesh.vertices[sharp].sum(axis=0)
    return smooth[v]


def doo_sabin_step(mesh: PolygonMesh, weights: Callable[[str], Weights]) -> PolygonMesh:
    """One step of Doo and Sabin's scheme: a face for each face, inner edge and inner vertex.

    The new vertex at corner j of a face of n is `sum_k alpha_(k-j) P_k`, with the weights of the face's
    region; its number is that of the half-edge.
    """
    points = np.zeros((len(mesh.origin), 3))
    named = np.array([mesh.marks.regions.get(face, "") for face in range(len(mesh.sizes))])
    for n, region in sorted(set(zip(mesh.sizes.tolist(), named.tolist(), strict=True))):
        alpha = np.array(weights(region)(n), dtype=float)
        halves = mesh.starts[(mesh.sizes == n) & (named == region)][:, None] + np.arange(n)
        corners = mesh.vertices[mesh.origin[halves]]
        circulant = alpha[(np.arange(n)[None] - np.arange(n)[:, None]) % n]
        points[halves] = np.einsum("jk,fkd->fjd", circulant, corners)
    faces = [list(range(start, start + n)) for start, n in zip(mesh.starts, mesh.sizes, strict=True)]
    mid, _ = _edges(mesh)
    mid = mid[mesh.twin[mid] >= 0]
    faces += np.stack([mesh.after[mid], mid, mesh.after[mesh.twin[mid]], mesh.twin[mid]], axis=1).tolist()
    faces += _fans(mesh)
    result = polygon_mesh(points, faces, "smooth" if (mesh.twin < 0).any() else None)
    found = [{str(named[mesh.face[half]]) for half in face} for face in faces]
    regions = {number: next(iter(names)) for number, names in enumerate(found) if len(names) == 1}
    return replace(result, marks=Marks(regions={face: name for face, name in regions.items() if name}))


def ribboned(mesh: PolygonMesh, corners: bool) -> PolygonMesh:
    """The mesh with a ribbon of quadrangles of no width along its boundaries.

    Doo and Sabin's surface then ends in the quadratic B-spline of each boundary polygon. With `corners` the
    vertices of a single face get a quadrangle of their own, which keeps them in place.
    """
    bounding = np.flatnonzero(mesh.twin < 0).tolist()
    if not bounding:
        return mesh
    origin, ends, count = mesh.origin.tolist(), mesh.ends.tolist(), len(mesh.vertices)
    sharp = {v for v in map(origin.__getitem__, bounding) if corners and mesh.valences[v] == 1}
    copies: list[int] = []

    def copy(v: int) -> int:
        copies.append(v)
        return count + len(copies) - 1

    leaving = {origin[h]: copy(origin[h]) for h in bounding}
    arriving = {v: copy(v) if v in sharp else leaving[v] for v in leaving}
    faces = np.split(mesh.origin, mesh.starts[1:])
    faces = [face.tolist() for face in faces]
    faces += [[ends[h], origin[h], leaving[origin[h]], arriving[ends[h]]] for h in bounding]
    faces += [[v, arriving[v], copy(v), leaving[v]] for v in sorted(sharp)]
    owners = [*range(len(mesh.sizes)), *mesh.face[bounding].tolist()]
    owners += [int(mesh.face[mesh.origin == v][0]) for v in sorted(sharp)]
    given = mesh.marks.regions
    regions = {number: given[face] for number, face in enumerate(owners) if face in given}
    result = polygon_mesh(np.concatenate([mesh.vertices, mesh.vertices[copies]]), faces, "smooth")
    return replace(result, marks=Marks(regions=regions))


def _edges(mesh: PolygonMesh) -> tuple[np.ndarray, np.ndarray]:
    """One half-edge of each edge, and the number of the edge of each half-edge."""
    number = np.arange(len(mesh.origin))
    lesser = np.where(mesh.twin < 0, number, np.minimum(number, mesh.twin))
    chosen, edge_of = np.unique(lesser, return_inverse=True)
    return chosen, edge_of.reshape(-1)


def _fans(mesh: PolygonMesh) -> list[list[int]]:
    """The half-edges from each inner vertex that is used, counterclockwise."""
    around = mesh.around(np.arange(len(mesh.origin))).tolist()
    first, at = np.unique(mesh.origin, return_index=True)
    fans = []
    for start in at[~mesh.at_boundary[first]].tolist():
        fan = [start]
        while around[fan[-1]] != start:
            fan.append(around[fan[-1]])
        fans.append(fan)
    return fans
