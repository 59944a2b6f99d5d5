"""Distances to the points, segments or triangles of a mesh."""

import math
from collections.abc import Callable
from functools import cached_property

import numpy as np
from jaxtyping import Float
from scipy import spatial

from ifs import Mesh

CANDIDATES = 8
BATCH = 100_000

Places = Float[np.ndarray, "places 3"]


class Facets:
    """The facets of a mesh, and a tree of their centres to find the near ones.

    The distance is exact to the nearest of the eight facets whose centres are nearest, which is the
    nearest of all where facets are small and alike.
    """

    def __init__(self, mesh: Mesh):
        corners = mesh.faces if mesh.faces.shape[1] <= 2 else mesh.triangles()
        self.simplices: Float[np.ndarray, "facets corners 3"] = mesh.points_3d()[corners]

    @cached_property
    def tree(self) -> spatial.KDTree:
        """The centres of the facets."""
        return spatial.KDTree(self.simplices.mean(axis=1))

    @property
    def longest(self) -> float:
        """The longest edge, mm."""
        edges = self.simplices - np.roll(self.simplices, 1, axis=1)
        return math.sqrt(float((edges**2).sum(axis=2).max()))

    def distance(self, places: Places, metric: str = "euclidean") -> Float[np.ndarray, "places"]:
        """How far places (mm) are from the nearest facet, by the metric "euclidean" or "d-infinity"."""
        far = _euclidean if metric == "euclidean" else _box_distances
        order = 2 if metric == "euclidean" else np.inf
        if self.simplices.shape[1] == 1:
            return self.tree.query(places, p=order, workers=-1)[0]
        parts = (places[i : i + BATCH] for i in range(0, len(places), BATCH))
        found = [self._distance(part, far, order) for part in parts]
        return np.concatenate(found) if found else np.zeros(0)

    def _distance(self, places: Places, far: Callable, order: float) -> Float[np.ndarray, "places"]:
        count = min(CANDIDATES, len(self.simplices))
        near = np.reshape(self.tree.query(places, k=count, p=order, workers=-1)[1], (len(places), count))
        best = np.full(len(places), np.inf)
        for column in near.T:
            best = np.minimum(best, far(self.simplices[column], places))
        return best


def _euclidean(
    simplices: Float[np.ndarray, "places corners 3"], places: Places
) -> Float[np.ndarray, "places"]:
    closest = _on_segments if simplices.shape[1] == 2 else _on_triangles
    gap = closest(simplices, places) - places
    return np.sqrt(np.einsum("pd,pd->p", gap, gap))


def _box_distances(
    simplices: Float[np.ndarray, "places corners 3"], places: Places
) -> Float[np.ndarray, "places"]:
    """The half side of the smallest box about each place, square to the axes, that meets its simplex.

    A box and a simplex are apart where they are apart along an axis of space, the normal of the simplex, or
    the product of one of its edges with an axis of space (Gottschalk, Lin and Manocha, OBBTree, 1996). Along
    n the box reaches `half side * sum |n_i|`; so the answer is the largest `gap / sum |n_i|`.
    """
    corners = simplices - places[:, None]
    edges = np.roll(simplices, -1, axis=1) - simplices
    edges = edges[:, : 1 if simplices.shape[1] == 2 else 3]
    axes = np.eye(3)
    normals = [np.broadcast_to(axis, places.shape) for axis in axes]
    normals += [np.cross(edges[:, k], axis) for k in range(edges.shape[1]) for axis in axes]
    if simplices.shape[1] == 3:
        normals.append(np.cross(edges[:, 0], edges[:, 1]))
    found = np.zeros(len(places))
    for normal in normals:
        along = np.einsum("pcd,pd->pc", corners, normal)
        gap = np.maximum(along.min(axis=1), -along.max(axis=1))
        reach = np.abs(normal).sum(axis=1)
        found = np.maximum(found, gap / np.where(reach > 0, reach, np.inf))
    return found


def _on_segments(segments: Float[np.ndarray, "places 2 3"], places: Places) -> Places:
    """The point of each segment nearest to its place."""
    start, along = segments[:, 0], segments[:, 1] - segments[:, 0]
    length = np.maximum(np.einsum("pd,pd->p", along, along), np.finfo(float).tiny)
    share = np.clip(np.einsum("pd,pd->p", places - start, along) / length, 0.0, 1.0)
    return start + share[:, None] * along


def _on_triangles(triangles: Float[np.ndarray, "places 3 3"], places: Places) -> Places:
    from trimesh.triangles import closest_point

    return np.asarray(closest_point(triangles, places))
