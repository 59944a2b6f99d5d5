"""Triangles in a tree of boxes, scaled so that exact predicates hold."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

SMALLEST = 2.0**-250  # of the size of the mesh: coordinates below that are taken as 0


@dataclass(frozen=True, eq=False)
class TriangleTree:
    """The triangles of a mesh in the order of a space-filling curve, with the boxes over them.

    `points` are the vertices divided by `scale`, a power of two, so that none is above 1 in size;
    that is exact, but for coordinates below 2^-250 of the largest, which become 0. `order` names
    the triangle of the mesh that stands in each row of `triangles`. The nodes of the tree are in
    `boxes` (low, high), `starts` and `skips`, as `export.checks.boxes` tells.
    """

    points: Float[np.ndarray, "vertices 3"]
    triangles: Int[np.ndarray, "t 3"]
    order: Int[np.ndarray, "t"]
    boxes: Float[np.ndarray, "nodes 6"]
    starts: Int[np.ndarray, "nodes+1"]
    skips: Int[np.ndarray, "nodes"]
    scale: float

    @property
    def parts(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """What the kernels ask for: points, triangles, boxes, starts, skips."""
        return self.points, self.triangles, self.boxes, self.starts, self.skips

    @property
    def size(self) -> float:
        """The longest side of the box around everything, in units of `scale`."""
        return float((self.boxes[0, 3:] - self.boxes[0, :3]).max())


def triangle_tree(points: Float[np.ndarray, "vertices 3"], triangles: Int[np.ndarray, "t 3"]) -> TriangleTree:
    """The tree over at least one triangle. About 100 bytes for each, and 24 for each vertex."""
    from export.checks.boxes import curve_keys, grow_boxes, grow_nodes

    largest = float(np.abs(points).max())
    exponent = int(np.frexp(largest)[1])
    scaled = np.ldexp(np.ascontiguousarray(points), -exponent)
    scaled[np.abs(scaled) < SMALLEST] = 0.0
    used = scaled[triangles[:, 0]]
    low, high = used.min(axis=0), used.max(axis=0)
    span = float((high - low).max())
    keys = curve_keys(scaled, triangles, low, 2097152.0 / span if span > 0 else 0.0)
    order = np.argsort(keys, kind="stable")
    ordered = np.ascontiguousarray(triangles[order])
    starts, skips = grow_nodes(keys[order])
    boxes = grow_boxes(scaled, ordered, starts, skips)
    return TriangleTree(scaled, ordered, order, boxes, starts, skips, 2.0**exponent)
