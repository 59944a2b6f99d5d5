"""Equal positions as one vertex."""

import numpy as np

from ifs.mesh import Mesh


def weld(mesh: Mesh) -> Mesh:
    """The same triangles with equal positions as one vertex, vertices sorted.

    >>> corners = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 0]])
    >>> weld(Mesh(corners, np.array([[0, 1, 2], [3, 2, 1]]))).vertices.shape
    (3, 3)
    """
    from export.formats.welding_kernels import first_of_each

    points = np.ascontiguousarray(mesh.points_3d() + 0.0)  # minus zero becomes zero
    slots = np.full(1 << (2 * len(points)).bit_length(), -1)
    number, first = first_of_each(points.view(np.uint64), slots)
    points = points[first]
    order = np.lexsort(points.T[::-1])
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return Mesh(points[order], rank[number][mesh.triangles()])
