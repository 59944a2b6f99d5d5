"""Small convex polytopes of dimension 1, 2 or 3: corners, faces, volume, and how deep two of them overlap."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float


@dataclass(frozen=True)
class Polytope:
    """The x with `normals @ x <= offsets` (unit normals), which is the hull of `corners`."""

    corners: Float[np.ndarray, "n dim"]
    normals: Float[np.ndarray, "faces dim"]
    offsets: Float[np.ndarray, "faces"]
    volume: float

    @property
    def size(self) -> float:
        return float(np.ptp(self.corners, axis=0).max())


def polytope(points: Float[np.ndarray, "n dim"]) -> Polytope | None:
    """The hull of some points; None where they lie in a flat.

    >>> found = polytope(np.array([[0.0, 0], [2, 0], [0, 2], [0.5, 0.5]]))
    >>> len(found.corners), round(found.volume, 9)
    (3, 2.0)
    """
    from scipy.spatial import ConvexHull, QhullError

    if points.shape[1] == 1:
        lo, hi = points.min(), points.max()
        if not hi > lo:
            return None
        return Polytope(
            np.array([[lo], [hi]]), np.array([[-1.0], [1.0]]), np.array([-lo, hi]), float(hi - lo)
        )
    scale = float(np.ptp(points, axis=0).max())
    if not scale > 0:
        return None
    origin = points.mean(axis=0)
    scaled = (points - origin) / scale
    try:
        found = ConvexHull(scaled)
    except QhullError:
        return None
    if found.volume <= 1e-12:
        return None
    normals = found.equations[:, :-1]
    offsets = -found.equations[:, -1] * scale + normals @ origin
    keep = np.unique(
        np.round(np.column_stack([normals, found.equations[:, -1]]), 10), axis=0, return_index=True
    )[1]
    corners = points[np.sort(found.vertices)]
    return Polytope(corners, normals[keep], offsets[keep], float(found.volume) * scale ** points.shape[1])


def overlap(one: Polytope, other: Polytope) -> float:
    """The radius of the largest ball in both; negative or 0 where their insides are disjoint.

    >>> left = polytope(np.array([[0.0, 0], [2, 0], [2, 2], [0, 2]]))
    >>> right = polytope(np.array([[1.0, 0], [4, 0], [4, 2], [1, 2]]))
    >>> round(overlap(left, right), 9)
    0.5
    """
    from scipy.optimize import linprog

    gap = np.maximum(
        other.corners.min(axis=0) - one.corners.max(axis=0),
        one.corners.min(axis=0) - other.corners.max(axis=0),
    ).max()
    if gap >= 0:
        return -float(gap)
    dim = one.corners.shape[1]
    scale = min(one.size, other.size)
    centre = one.corners.mean(axis=0)
    normals = np.vstack([one.normals, other.normals])
    offsets = (np.concatenate([one.offsets, other.offsets]) - normals @ centre) / scale
    found = linprog(
        np.append(np.zeros(dim), -1.0),
        A_ub=np.column_stack([normals, np.ones(len(normals))]),
        b_ub=offsets,
        bounds=[(None, None)] * (dim + 1),
    )
    return -float(found.fun) * scale if found.status == 0 else np.inf
