"""Meshes whose triangles do not share vertices, as other programs write them."""

from export.checks.adjacency import find_edges
from export.checks.report import Fault
from export.formats.welding import weld
from ifs.mesh import Mesh


def sewn(mesh: Mesh) -> tuple[Mesh, Fault | None]:
    """The mesh with vertices at equal positions as one, where that closes open edges; and a note of it.

    Files hold a vertex several times when it has several normals or colours. A mesh whose edges all
    lie in two triangles or more stays as it is: there, equal positions are sheets that touch.

    >>> import numpy as np
    >>> corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    >>> faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    >>> closed, note = sewn(Mesh(corners[faces].reshape(-1, 3), np.arange(12).reshape(4, 3)))
    >>> closed.vertices.shape, str(note)
    ((4, 3), '8 vertices at the place of another one, taken as one')
    """
    triangles = mesh.triangles()
    open_edges = find_edges(triangles, len(mesh.vertices)).open.sum()
    if not open_edges:
        return mesh, None
    joined = weld(Mesh(mesh.points_3d(), triangles))
    if find_edges(joined.triangles(), len(joined.vertices)).open.sum() >= open_edges:
        return mesh, None
    fewer = len(mesh.vertices) - len(joined.vertices)
    return joined, Fault("joined_vertices", fewer, "vertices at the place of another one, taken as one", ())
