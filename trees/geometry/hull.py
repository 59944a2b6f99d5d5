"""Trees of convex hulls: of points, of a cube's image, in any dimension, flat ones included."""

import itertools

import numpy as np
from jaxtyping import Float

from trees.cube import Cube
from trees.doors import Rows, point_rows, whole
from trees.errors import TooManyPieces, TreeError
from trees.geometry.matrices import transform
from trees.morton import check_widths
from trees.runs import MAX_RUNS, tree_of_runs
from trees.tree import Tree

FLAT = 1e-12
MOST_AXES = 10


def from_hull(
    points: Rows,
    cube: Cube,
    bits: int,
    closed: bool = True,
) -> Tree:
    """The cells of a cube that meet the convex hull of points, in mm; one point, a segment, a polygon too.

    Cells are taken closed, so each point of the hull, faces included, lies in a black cell; with
    `closed=False` a cell that the hull only touches, or enters by less than rounding, stays white.
    Black are exactly the cells that meet the hull once they are widened by rounding, about 1e-15 of the
    cube and of the farthest point; where points are within 1e-12 of a plane the hull is taken as flat.

    A box meets a convex set P where no plane parts them. The planes that may be needed are those of the
    facets of P + box: a facet whose normal is 0 on the axes outside a set T is a facet of the projection of P
    to the axes of T. So the hulls of all 2^k - 1 projections give all planes, in any dimension. (Guye 1988,
    IV.1 tests the faces of the two polytopes alone: then a cell beside an edge may come out grey.)

    Raises `TreeError` where there is no point, a coordinate is not finite, or above 10 axes.

    >>> from trees import unit_cube
    >>> list(from_hull([[0.1, 0.1], [0.9, 0.4]], unit_cube(2), bits=1))
    [(0, 0), (1, 0)]
    """
    rows, bits = point_rows(points), whole(bits, "bits")
    if len(rows) == 0 or rows.shape[1] != cube.dimension:
        raise TreeError(f"points of shape {rows.shape}: (points, {cube.dimension}), at least one, are needed")
    if not np.isfinite(rows).all():
        row, axis = np.argwhere(~np.isfinite(rows))[0].tolist()
        raise TreeError(f"point {row}: coordinate {rows[row, axis]} on axis {axis} is not finite")
    check_widths(cube.dimension, bits)
    if cube.dimension > MOST_AXES:
        raise TreeError(f"a hull in {cube.dimension} dimensions: at most {MOST_AXES} are possible")
    scaled = (rows - np.array(cube.origin)) / cube.size
    normals = parting_normals(scaled)
    offsets = supports(scaled, normals)
    return convex_tree(normals, offsets, 1 + float(np.abs(scaled).max()), cube, bits, closed)


def image_of_cube(
    matrix: Rows,
    cube: Cube,
    bits: int,
    of: Cube | None = None,
    closed: bool = True,
) -> Tree:
    """The cells that meet the image of a cube, `of` or `cube` itself, under a homogeneous matrix.

    Rotated, sheared, flattened (the matrix may be singular), in perspective: the homographic images of
    Guye 1988, IV.1. The corners' images are rounded once, to floats.

    Raises `BeyondHorizon` where the cube reaches the points that have no image.

    >>> from trees import unit_cube
    >>> from trees.geometry.matrices import scaling
    >>> flat = image_of_cube(scaling([0.0, 1.0], about=[0.3, 0.0]), unit_cube(2), bits=2)
    >>> flat.count
    4
    """
    return from_hull(transform(corners_of(of or cube), matrix), cube, bits, closed)


def corners_of(cube: Cube) -> Float[np.ndarray, "corners dim"]:
    """The `2^k` corners of a cube, in Morton order.

    >>> corners_of(Cube((0.0, 1.0), 2.0)).tolist()
    [[0.0, 1.0], [0.0, 3.0], [2.0, 1.0], [2.0, 3.0]]
    """
    if cube.dimension > MOST_AXES:
        raise TreeError(
            f"the corners of a cube in {cube.dimension} dimensions: at most {MOST_AXES} are possible"
        )
    sides = np.array(list(itertools.product((0.0, 1.0), repeat=cube.dimension)))
    return np.array(cube.origin) + sides * cube.size


def convex_tree(
    normals: Float[np.ndarray, "faces dim"],
    offsets: Float[np.ndarray, " faces"],
    extent: float,
    cube: Cube,
    bits: int,
    closed: bool,
) -> Tree:
    """The cells no half-space `normal . u <= offset` leaves out, u = (x - origin) / size."""
    from trees.geometry import kernels

    room = len(offsets) * (cube.dimension * bits + 1)
    if room > MAX_RUNS:
        raise TooManyPieces(room, MAX_RUNS)
    slack = (2 * cube.dimension + 6) * 2.0**-52 * extent * (1 if closed else -1)
    runs = kernels.convex(normals, offsets, slack, cube.dimension, bits, MAX_RUNS)
    if len(runs[0]) > MAX_RUNS:
        raise TooManyPieces(len(runs[0]), MAX_RUNS)
    return tree_of_runs(runs, cube, bits)


def supports(
    points: Float[np.ndarray, "points dim"], normals: Float[np.ndarray, "faces dim"]
) -> Float[np.ndarray, " faces"]:
    """How far the points reach along each normal; in pieces, for memory."""
    step = max(2**24 // len(points), 1)
    parts = [(points @ normals[i : i + step].T).max(0) for i in range(0, len(normals), step)]
    return np.concatenate(parts)


def parting_normals(points: Float[np.ndarray, "points dim"]) -> Float[np.ndarray, "_faces dim"]:
    """The outward unit normals of the facets of all projections of the hull to sets of axes.

    Those of the hull itself come first.

    >>> parting_normals(np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])).round(3).shape
    (7, 2)
    """
    dimension = points.shape[1]
    extreme = _extreme(points)
    found = []
    for count in range(dimension, 0, -1):
        for axes in itertools.combinations(range(dimension), count):
            part = _facet_normals(extreme[:, list(axes)])
            normals = np.zeros((len(part), dimension))
            normals[:, list(axes)] = part
            found.append(normals)
    return np.concatenate(found)


def _extreme(points: Float[np.ndarray, "_points dim"]) -> Float[np.ndarray, "_corners dim"]:
    """The corners of the hull where they are found, else all points."""
    from scipy.spatial import ConvexHull, QhullError

    points = np.unique(points, axis=0)
    if points.shape[1] == 1 or _rank(points) < points.shape[1]:
        return points
    try:
        return points[ConvexHull(points).vertices]
    except QhullError:
        return points


def _rank(points: Float[np.ndarray, "_points dim"]) -> int:
    values = np.linalg.svd(points - points.mean(0), compute_uv=False)
    return int((values > FLAT * max(float(values[0]), 1.0)).sum())


def _facet_normals(points: Float[np.ndarray, "_points dim"]) -> Float[np.ndarray, "_faces dim"]:
    """The normals of the facets; of a flat set the two sides; none where it is flatter still."""
    from scipy.spatial import ConvexHull, QhullError

    dimension = points.shape[1]
    if dimension == 1:
        return np.array([[1.0], [-1.0]])
    rank = _rank(points)
    if rank < dimension - 1:
        return np.zeros((0, dimension))
    if rank == dimension:
        try:
            normals = ConvexHull(np.unique(points, axis=0)).equations[:, :-1]
            _, kept = np.unique(normals.round(14), axis=0, return_index=True)
            return normals[np.sort(kept)]
        except QhullError:
            pass
    normal = np.linalg.svd(points - points.mean(0), full_matrices=True)[2][-1]
    return np.stack([normal, -normal])
