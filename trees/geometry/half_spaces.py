"""Trees of polytopes given by their faces, and of slabs."""

import numpy as np
from jaxtyping import Float

from trees.cube import Cube
from trees.doors import Rows, array_of, numbers, point_rows, real, whole
from trees.errors import TreeError
from trees.geometry.hull import MOST_AXES, convex_tree, parting_normals
from trees.geometry.matrices import Vector
from trees.morton import check_widths
from trees.tree import Tree

NEAR = (1e-12, 1e-9, 1e-6)


def from_half_spaces(
    faces: Rows,
    cube: Cube,
    bits: int,
    closed: bool = True,
) -> Tree:
    """The cells of a cube that meet the points with `a . x + b <= 0` for every row `(a, b)`, x in mm.

    The polytope may be unbounded; it is looked at inside the cube, where each of its points lies in a black
    cell (cells are closed; for `closed` see `from_hull`). Black are the cells that meet it, but for errors
    below 1e-6 of the cube along edges and corners. Where the polytope inside the cube is empty, flat or
    thinner than 1e-6 of the cube, the faces alone are tested: a cell that no face has wholly outside is
    black then, even beside an edge.

    The corners of the polytope, found by Qhull, give the further planes that part boxes from it (see
    `from_hull`). How far the polytope reaches along each is bounded through the faces themselves, by
    duality: `n = sum y_i a_i` with `y >= 0` gives `n . x <= -sum y_i b_i`. So wrong corners cost no cover.

    Raises `TreeError` with the row where a face is not finite or its normal is 0.

    >>> from trees import unit_cube
    >>> len(from_half_spaces([[1.0, 1.0, -0.6]], unit_cube(2), bits=2))
    6
    """
    given, bits = array_of(faces, "faces"), whole(bits, "bits")
    rows = point_rows(given) if given.size else np.zeros((len(given), given.shape[-1]))
    if rows.shape[1] != cube.dimension + 1:
        raise TreeError(f"faces of shape {rows.shape}: (faces, {cube.dimension + 1}) is needed")
    check_widths(cube.dimension, bits)
    if cube.dimension > MOST_AXES:
        raise TreeError(f"a polytope in {cube.dimension} dimensions: at most {MOST_AXES} are possible")
    if not np.isfinite(rows).all():
        row, column = np.argwhere(~np.isfinite(rows))[0].tolist()
        raise TreeError(f"face {row}: coefficient {rows[row, column]} in column {column} is not finite")
    lengths = np.abs(rows[:, :-1]).max(1)
    if (lengths == 0).any():
        raise TreeError(f"face {int(np.argmax(lengths == 0))}: the normal is 0")
    normals = rows[:, :-1] / lengths[:, None]
    reach = np.abs(normals) @ np.abs(cube.origin) + np.abs(rows[:, -1]) / lengths
    offsets = -(rows[:, -1] / lengths + normals @ np.array(cube.origin)) / cube.size
    extent = 1 + float(np.max(reach / cube.size, initial=0.0))
    more, bounds = _further(normals, offsets)
    every, limits = np.concatenate([normals, more]), np.concatenate([offsets, bounds])
    return convex_tree(every, limits, extent, cube, bits, closed)


def slab(normal: Vector, offset: float, thickness: float, cube: Cube, bits: int) -> Tree:
    """The cells that meet the points within `thickness / 2` mm of the plane `normal . x = offset`.

    The normal need not be of length 1. Thickness 0 gives the cells that the plane meets, exactly up to
    rounding (Guye 1988, IV.1: the plane as the cube flattened to one cell).

    >>> from trees import unit_cube
    >>> slab([1.0, 0.0, 0.0], 0.3, 0.0, unit_cube(3), bits=2).count
    16
    """
    direction = point_rows(numbers(normal, "normal")[None, :])[0]
    offset, thickness = real(offset, "offset"), real(thickness, "thickness")
    if not thickness >= 0:
        raise TreeError(f"a slab of thickness {thickness} mm: at least 0 is needed")
    half = thickness / 2 * float(np.linalg.norm(direction))
    return from_half_spaces(
        np.array([[*direction, -offset - half], [*-direction, offset - half]]), cube, bits, closed=True
    )


def _further(
    normals: Float[np.ndarray, "faces dim"], offsets: Float[np.ndarray, " faces"]
) -> tuple[Float[np.ndarray, "_more dim"], Float[np.ndarray, " _more"]]:
    """Normals of further planes, and how far the polytope in the unit cube at most reaches along each."""
    k = normals.shape[1]
    walls = np.concatenate([np.eye(k), -np.eye(k)])
    rows = np.concatenate([normals, walls])
    limits = np.concatenate([offsets, np.ones(k), np.zeros(k)])
    corners = _corners(rows, limits) if len(normals) > 0 else np.zeros((0, k))
    if len(corners) <= k:
        return np.zeros((0, k)), np.zeros(0)
    found = parting_normals(corners)
    bounds = np.array([_bound(normal, corners, rows, limits) for normal in found])
    return found, bounds


def _corners(
    rows: Float[np.ndarray, "_rows dim"], limits: Float[np.ndarray, " _rows"]
) -> Float[np.ndarray, "_corners dim"]:
    from scipy.optimize import linprog
    from scipy.spatial import HalfspaceIntersection, QhullError

    k = rows.shape[1]
    lengths = np.linalg.norm(rows, axis=1)
    ball = linprog(
        [0.0] * k + [-1.0], np.column_stack([rows, lengths]), limits, bounds=[(None, None)] * (k + 1)
    )
    if ball.status != 0 or ball.x[-1] < NEAR[-1]:
        return np.zeros((0, k))
    if k == 1:
        ends = limits / rows[:, 0]
        return np.array([[ends[rows[:, 0] < 0].max()], [ends[rows[:, 0] > 0].min()]])
    try:
        corners = HalfspaceIntersection(np.column_stack([rows, -limits]), ball.x[:-1]).intersections
    except QhullError:
        return np.zeros((0, k))
    return corners[np.isfinite(corners).all(1)]


def _bound(
    normal: Float[np.ndarray, " dim"],
    corners: Float[np.ndarray, "_corners dim"],
    rows: Float[np.ndarray, "_rows dim"],
    limits: Float[np.ndarray, " _rows"],
) -> float:
    """An upper bound of `normal . x` over the polytope, from the faces at its farthest corner."""
    from scipy.optimize import nnls

    farthest = corners[np.argmax(corners @ normal)]
    best = float(np.maximum(normal, 0).sum())
    for near in NEAR:
        tight = np.abs(limits - rows @ farthest) < near
        if tight.any():
            weights = nnls(rows[tight].T, normal)[0]
            rest = normal - weights @ rows[tight]
            rounding = 2.0**-50 * len(rows) * float(1 + weights @ np.abs(limits[tight]))
            best = min(best, float(weights @ limits[tight] + np.maximum(rest, 0).sum()) + rounding)
    return best
