"""Creases found by the angle between faces."""

from typing import Any

import numpy as np

from ifs.surfaces.polygon_mesh import Pair, PolygonMesh, Polygons, polygon_mesh


def creases_by_angle(vertices: Any, faces: Polygons, angle: float) -> list[Pair]:
    """The edges of a mesh across which the direction of the faces turns by more than an angle in degrees.

    The direction of a polygon is that of its area vector, half the sum of `P_i x P_(i+1)`. Raises `WrongMesh`
    as `ifs.surface` does for what no boundary rule mends.

    >>> corners = [(x, y, z) for z in (0, 9) for y in (0, 9) for x in (0, 9)]
    >>> sides = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    >>> len(creases_by_angle(corners, sides, 60)), len(creases_by_angle(corners, sides, 91))
    (12, 0)
    """
    mesh = polygon_mesh(vertices, faces, "smooth")
    normal = _directions(mesh)
    half = np.flatnonzero(mesh.twin > np.arange(len(mesh.twin)))
    one, other = mesh.face[half], mesh.face[mesh.twin[half]]
    turn = np.degrees(np.arccos(np.clip((normal[one] * normal[other]).sum(axis=1), -1, 1)))
    sharp = half[turn > angle]
    return [
        (min(v, w), max(v, w))
        for v, w in zip(mesh.origin[sharp].tolist(), mesh.ends[sharp].tolist(), strict=True)
    ]


def _directions(mesh: PolygonMesh) -> np.ndarray:
    area = np.zeros((len(mesh.sizes), 3))
    np.add.at(area, mesh.face, np.cross(mesh.vertices[mesh.origin], mesh.vertices[mesh.ends]))
    length = np.linalg.norm(area, axis=1, keepdims=True)
    return area / np.where(length > 0, length, 1)
