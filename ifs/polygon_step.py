"""One plain step of subdivision of polygons, after which every patch is quadrangular."""

import numpy as np

from ifs.closed_mesh import ClosedMesh, closed_mesh
from subdivision.schemes.doo_sabin import coefficients


def catmull_clark_step(mesh: ClosedMesh) -> ClosedMesh:
    """The quadrangles of one step of Catmull and Clark's scheme on any polygons.

    With n faces around V: face points are means of corners, edge points `(V0 + V1 + F0 + F1) / 4`, and
    `V' = (n-2)/n V + 1/n^2 sum E + 1/n^2 sum F`. The numbers of the vertices stay; then come the edges', then
    the faces'. Vertices that no face uses stay where they are.
    """
    points, origin, face = mesh.vertices, mesh.origin, mesh.face
    ends = origin[mesh.after]
    centres = np.zeros((len(mesh.sizes), 3))
    np.add.at(centres, face, points[origin])
    centres /= mesh.sizes[:, None]
    mid, edge_of = _edges(mesh)
    middles = (
        points[origin[mid]] + points[ends[mid]] + centres[face[mid]] + centres[face[mesh.twin[mid]]]
    ) / 4
    n = np.maximum(mesh.valences, 1)[:, None]
    around = np.zeros_like(points)
    np.add.at(around, origin, points[ends] + centres[face])
    moved = np.where(mesh.valences[:, None] > 0, (n - 2) / n * points + around / n**2, points)
    new_edge, new_face = len(points) + edge_of, len(points) + len(mid) + face
    quadrangles = np.stack([origin, new_edge, new_face, new_edge[mesh.before]], axis=1)
    return closed_mesh(np.concatenate([moved, middles, centres]), quadrangles)


def doo_sabin_step(mesh: ClosedMesh) -> ClosedMesh:
    """One step of Doo and Sabin's scheme: a face for each face, edge and vertex, four around each new vertex.

    The new vertex at corner j of a face of n is `sum_k alpha_(k-j) P_k`; its number is that of the half-edge.
    """
    points = np.zeros((len(mesh.origin), 3))
    for n in np.unique(mesh.sizes):
        weights = np.array(coefficients(int(n)), dtype=float)
        starts = mesh.starts[mesh.sizes == n]
        halves = starts[:, None] + np.arange(n)
        corners = mesh.vertices[mesh.origin[halves]]
        circulant = weights[(np.arange(n)[None] - np.arange(n)[:, None]) % n]
        points[halves] = np.einsum("jk,fkd->fjd", circulant, corners)
    faces = [list(range(start, start + n)) for start, n in zip(mesh.starts, mesh.sizes, strict=True)]
    mid, _ = _edges(mesh)
    faces += np.stack([mesh.after[mid], mid, mesh.after[mesh.twin[mid]], mesh.twin[mid]], axis=1).tolist()
    faces += _fans(mesh)
    return closed_mesh(points, faces)


def _edges(mesh: ClosedMesh) -> tuple[np.ndarray, np.ndarray]:
    """One half-edge of each edge, and the number of the edge of each half-edge."""
    number = np.arange(len(mesh.origin))
    lesser = np.minimum(number, mesh.twin)
    chosen, edge_of = np.unique(lesser, return_inverse=True)
    return chosen, edge_of.reshape(-1)


def _fans(mesh: ClosedMesh) -> list[list[int]]:
    """The half-edges from each vertex that is used, counterclockwise."""
    around = mesh.around(np.arange(len(mesh.origin))).tolist()
    fans = []
    for start in np.unique(mesh.origin, return_index=True)[1].tolist():
        fan = [start]
        while around[fan[-1]] != start:
            fan.append(around[fan[-1]])
        fans.append(fan)
    return fans
