"""Distances to the points, segments or triangles of a mesh."""

import math
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

    def distance(self, places: Places) -> Float[np.ndarray, "places"]:
        """How far places (mm) are from the nearest facet."""
        if self.simplices.shape[1] == 1:
            return self.tree.query(places, workers=-1)[0]
        found = [self._distance(places[i : i + BATCH]) for i in range(0, len(places), BATCH)]
        return np.concatenate(found) if found else np.zeros(0)

    def _distance(self, places: Places) -> Float[np.ndarray, "places"]:
        count = min(CANDIDATES, len(self.simplices))
        near = np.reshape(self.tree.query(places, k=count, workers=-1)[1], (len(places), count))
        best = np.full(len(places), np.inf)
        closest = _on_segments if self.simplices.shape[1] == 2 else _on_triangles
        for column in near.T:
            gap = closest(self.simplices[column], places) - places
            best = np.minimum(best, np.einsum("pd,pd->p", gap, gap))
        return np.sqrt(best)


def _on_segments(segments: Float[np.ndarray, "places 2 3"], places: Places) -> Places:
    """The point of each segment nearest to its place."""
    start, along = segments[:, 0], segments[:, 1] - segments[:, 0]
    length = np.maximum(np.einsum("pd,pd->p", along, along), np.finfo(float).tiny)
    share = np.clip(np.einsum("pd,pd->p", places - start, along) / length, 0.0, 1.0)
    return start + share[:, None] * along


def _on_triangles(triangles: Float[np.ndarray, "places 3 3"], places: Places) -> Places:
    from trimesh.triangles import closest_point

    return np.asarray(closest_point(triangles, places))
