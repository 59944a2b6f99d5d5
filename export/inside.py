"""The cells of a grid whose centres lie inside a closed mesh, exactly."""

from typing import no_type_check

import numba
import numpy as np
from jaxtyping import Bool, Float, Int

from ifs.measures.grid import Grid, WrongGrid
from ifs.mesh import Mesh

_ASIDE = 1e-6 * np.sqrt([2.0, 3.0, 5.0])  # pitches: off the faces and edges of meshes on a lattice


class NotClosed(ValueError):
    """A mesh that bounds no solid; `edges` says how many of its edges are not met from both sides alike."""

    def __init__(self, name: str, edges: int):
        self.edges = edges
        super().__init__(
            f"{name} is not closed: {edges} edges are not shared by faces on both sides. Close the mesh, "
            f"or weld its vertices where equal positions are kept apart"
        )


class EmptyModel(ValueError):
    """A model without faces, or one that has no cell of the grid inside."""


def inside(mesh: Mesh, grid: Grid, name: str = "the mesh") -> Bool[np.ndarray, "x y z"]:
    """Which cells of a grid in space have their centres inside a closed mesh (mm).

    A line along z through each column of centres crosses the faces; a centre is inside where the crossings
    below it, counted with the direction of their faces, do not cancel (the winding number is not 0). So
    overlapping bodies are united, and faces turned outside in count as well. The points asked about lie some
    1e-6 of a pitch beside the centres, so that centres on faces are decided alike. Raises
    `EmptyModel` for a mesh without faces, `NotClosed`, `WrongGrid`.

    >>> corners = np.array([[0.0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]])
    >>> tetrahedron = Mesh(corners, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]))
    >>> int(inside(tetrahedron, Grid(np.zeros(3), 1.0, (4, 4, 4))).sum())
    10
    """
    if len(grid.size) != 3:
        raise WrongGrid(f"meshes fill cells of a grid in space; the grid has {len(grid.size)} axes")
    triangles = mesh.triangles()
    if not len(triangles):
        raise EmptyModel(f"{name} has no faces")
    if not np.isfinite(mesh.vertices).all():
        raise EmptyModel(f"{name} has vertices that are not finite")
    odd = open_edges(triangles)
    if odd:
        raise NotClosed(name, odd)
    corners = (mesh.points_3d()[triangles] - grid.origin) / grid.pitch - 0.5
    corners -= _ASIDE
    nx, ny, nz = grid.size
    steps = np.zeros((nx, ny, nz + 1), dtype=np.int16)
    _cross(np.ascontiguousarray(corners), steps)
    return _wound(steps)


def open_edges(triangles: Int[np.ndarray, "triangles 3"]) -> int:
    """How many edges are run through in one direction more often than in the other.

    >>> open_edges(np.array([[0, 1, 2]]))
    3
    """
    ends = np.concatenate([triangles[:, [i, (i + 1) % 3]] for i in range(3)])
    ends = ends[ends[:, 0] != ends[:, 1]]
    signs = np.where(ends[:, 0] < ends[:, 1], 1, -1)
    _, number = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True)
    return int(np.count_nonzero(np.bincount(number.ravel(), signs)))


def box_of(meshes: list[Mesh]) -> tuple[Float[np.ndarray, "3"], Float[np.ndarray, "3"]]:
    """The corners of the box around all faces of some meshes, in mm."""
    points = [mesh.points_3d()[np.unique(mesh.triangles())] for mesh in meshes]
    return np.min([p.min(axis=0) for p in points], axis=0), np.max([p.max(axis=0) for p in points], axis=0)


@numba.njit(cache=True)
@no_type_check
def _cross(corners, steps):
    nx, ny, nz = steps.shape[0], steps.shape[1], steps.shape[2] - 1
    for t in range(len(corners)):
        ax, ay, az = corners[t, 0]
        bx, by, bz = corners[t, 1]
        cx, cy, cz = corners[t, 2]
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if area == 0:
            continue
        first_i = max(0, int(np.ceil(min(ax, bx, cx))))
        last_i = min(nx - 1, int(np.floor(max(ax, bx, cx))))
        first_j = max(0, int(np.ceil(min(ay, by, cy))))
        last_j = min(ny - 1, int(np.floor(max(ay, by, cy))))
        for i in range(first_i, last_i + 1):
            for j in range(first_j, last_j + 1):
                u = _side(bx, by, cx, cy, i, j)
                v = _side(cx, cy, ax, ay, i, j)
                w = _side(ax, ay, bx, by, i, j)
                if (u >= 0) != (v >= 0) or (v >= 0) != (w >= 0):
                    continue
                height = (u * az + v * bz + w * cz) / (u + v + w)
                k = min(max(int(np.ceil(height)), 0), nz)
                steps[i, j, k] += 1 if area > 0 else -1


@numba.njit(cache=True)
@no_type_check
def _side(px, py, qx, qy, x, y):
    """Which side of p q a point lies on; exactly opposite for q p, so neighbours agree."""
    if px < qx or (px == qx and py < qy):
        return (qx - px) * (y - py) - (qy - py) * (x - px)
    return -((px - qx) * (y - qy) - (py - qy) * (x - qx))


@numba.njit(cache=True)
@no_type_check
def _wound(steps):
    nx, ny, nz = steps.shape[0], steps.shape[1], steps.shape[2] - 1
    result = np.zeros((nx, ny, nz), dtype=np.bool_)
    for i in range(nx):
        for j in range(ny):
            level = 0
            for k in range(nz):
                level += steps[i, j, k]
                result[i, j, k] = level != 0
    return result
