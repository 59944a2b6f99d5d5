"""Images of trees under homographies, through the inverse image of the cube they are drawn in."""

import itertools
from fractions import Fraction

import numpy as np
from jaxtyping import Float, Real

from trees.cube import Cube
from trees.doors import Rows as Given
from trees.doors import whole
from trees.errors import TooManyPieces, TreeError
from trees.geometry.errors import BeyondHorizon
from trees.geometry.matrices import check_matrix, exact, exact_inverse, product
from trees.geometry.pyramid import pyramid
from trees.leaves import leaf_runs
from trees.morton import cells_of_keys, check_widths
from trees.runs import MAX_RUNS, tree_of_runs
from trees.tree import Tree, empty

ROUND = 2.0**-52
MOST_AXES, MOST_BITS, MOST_EXACT = 10, 50, 4

Rows = list[list[Fraction]]


def homography(
    tree: Tree,
    matrix: Given,
    cube: Cube | None = None,
    bits: int | None = None,
    closed: bool = True,
) -> Tree:
    """The cells of a cube that meet the image of a tree under `x -> M x` in homogeneous coordinates.

    `matrix` is `(k + 1, k + 1)` and acts on columns `(x, 1)`, x in mm; a multiple of it is the same map. The
    image is drawn in `cube` with `bits` bits an axis, those of the tree unless given; what falls outside
    the cube is dropped.

    Cells are taken closed: every point of the image of every black cell, faces included, lies in a black
    cell. For this a set that stays where it is grows by the cells that touch it; with `closed=False` a cell
    that the image only touches, or enters by less than rounding, stays white, and the identity, or a quarter
    turn of the cube, changes nothing.

    Affine maps up to 4 axes: black are exactly the cells that meet the image, up to rounding, so all of the
    result lies within the diagonal of a cell of the image. Else a cell C may in addition be black where a
    source cell's image has a box around it that meets C: then within one diagonal of C and one of that box.

    The cube of the result is halved; the inverse image of each part, a convex set as the map keeps
    convexity, is compared with the source (Guye 1988, IV.2, who compares by the faces of the two
    alone; from three dimensions on a plane along an edge of each may be needed to part them). The inverse
    is computed in fractions, and all rounding is widened for.

    Raises `SingularMatrix` where the matrix has no inverse, `BeyondHorizon` where black cells reach the
    points that have no image, `TooManyPieces` above 2^28 runs, `TreeError` above 10 axes or 50 bits an axis.

    >>> from trees import from_points, unit_cube
    >>> from trees.geometry.matrices import rotation
    >>> tree = from_points([[0, 1], [1, 1]], bits=2)
    >>> turned = homography(tree, rotation(2, 0, 1, np.pi / 2, about=[0.5, 0.5]), closed=False)
    >>> list(turned)
    [(2, 0), (2, 1)]
    """
    from trees.geometry import image_kernels

    cube, bits = cube or tree.cube, tree.bits if bits is None else whole(bits, "bits")
    rows = exact(_checked(tree, matrix, cube, bits))
    exact_inverse(rows)
    forward = product(product(_cells_of(cube, bits), rows), _points_of(tree.cube, tree.bits))
    affine = not any(forward[-1][:-1])
    if not tree:
        return empty(cube, bits)
    most, forward = _in_front(tree, forward, affine)
    backward = exact_inverse(forward)
    front, back = _floats(forward), _floats(backward)
    across, within = 2.0**bits, 2.0**tree.bits
    errors = _errors(back, across)
    errors[:-1] += 0 if not affine else (tree.dimension + 4) * ROUND * within
    slacks = _errors(front, within)
    slacks = slacks[:-1] + across * slacks[-1]
    floor = 0.0 if affine else 0.75 / most
    if not affine and errors[-1] > 0.125 / most:
        raise TreeError("a perspective too steep for double precision: shear and turn less, or cut the set")
    sharp = affine and tree.dimension <= MOST_EXACT
    normals = _normals(back[:-1, :-1]) if sharp else _none(tree.dimension)
    norms = np.abs(normals).sum(1)
    sign = 1.0 if closed else -1.0
    supports = 0.5 * np.abs(normals @ back[:-1, :-1]).sum(1) + sign * np.abs(normals) @ errors[:-1]
    lows, highs = image_kernels.image(
        pyramid(tree), pyramid(~tree), tree.dimension, bits, tree.bits, back, errors, front, sign * slacks,
        normals, supports, norms, affine, sharp, floor, sign, MAX_RUNS,
    )  # fmt: skip
    if len(lows) > MAX_RUNS:
        raise TooManyPieces(len(lows), MAX_RUNS)
    return tree_of_runs((lows, highs), cube, bits)


def _checked(tree: Tree, matrix: Given, cube: Cube, bits: int) -> Real[np.ndarray, "_rows _columns"]:
    array = check_matrix(matrix, tree.dimension)
    check_widths(cube.dimension, bits)
    if cube.dimension != tree.dimension:
        raise TreeError(f"a cube of dimension {cube.dimension} for a tree of dimension {tree.dimension}")
    if tree.dimension > MOST_AXES or max(bits, tree.bits) > MOST_BITS:
        raise TreeError(
            f"dimension {tree.dimension}, {tree.bits} bits an axis, drawn at {bits}: images have at most "
            f"{MOST_AXES} axes and {MOST_BITS} bits"
        )
    return array


def _points_of(cube: Cube, bits: int) -> Rows:
    """The matrix from cells, counted from the corner, to mm."""
    cell, k = Fraction(cube.size) / 2**bits, cube.dimension
    rows = [[cell * (i == j) for j in range(k)] + [Fraction(x)] for i, x in enumerate(cube.origin)]
    return [*rows, [Fraction(0)] * k + [Fraction(1)]]


def _cells_of(cube: Cube, bits: int) -> Rows:
    return exact_inverse(_points_of(cube, bits))


def _floats(rows: Rows) -> Float[np.ndarray, "_n _n"]:
    return np.array([[float(x) for x in row] for row in rows])


def _errors(matrix: Float[np.ndarray, "_n _n"], extent: float) -> Float[np.ndarray, " _n"]:
    """A bound of the rounding of `matrix @ (x, 1)`, rows apart, for x from 0 to extent."""
    sums = np.abs(matrix[:, :-1]).sum(1) * extent + np.abs(matrix[:, -1])
    return (len(matrix) + 4) * ROUND * sums


def _in_front(tree: Tree, forward: Rows, affine: bool) -> tuple[float, Rows]:
    """The greatest weight of black cells, and the matrix scaled so that weights are positive, about 1."""
    last = forward[-1]
    if affine:
        return 1.0, [[x / last[-1] for x in row] for row in forward]
    first, end = leaf_runs(tree, tree.dimension)
    low = cells_of_keys(first, tree.dimension, tree.bits).astype(np.float64)
    high = cells_of_keys(end, tree.dimension, tree.bits).astype(np.float64) + 1
    scale = max(abs(last[-1]), *(abs(x) * 2**tree.bits for x in last[:-1]))
    slope = np.array([float(x / scale) for x in last[:-1]])
    constant = float(last[-1] / scale)
    least = np.where(slope > 0, low, high) @ slope + constant
    most = np.where(slope > 0, high, low) @ slope + constant
    margin = (tree.dimension + 4) * ROUND * 4 * tree.dimension
    if most.max() < 0:
        least, most, scale = -most, -least, -scale
    if least.min() <= margin:
        worst = int(np.argmin(least))
        cell = tuple(int(x) for x in low[worst])
        raise BeyondHorizon(
            f"the black leaf that begins at cell {cell}",
            float(least.min() * scale),
            float(most.max() * scale),
        )
    return float(most.max()) * (1 + 2.0**-30), [[x / scale for x in row] for row in forward]


def _normals(linear: Float[np.ndarray, "_k _k"]) -> Float[np.ndarray, "_m _k"]:
    """Directions that part a source cell from the inverse image of a target cell, where any does.

    The sum of both is a zonotope, spanned by the axes and the columns: each of its facets is spanned by k - 1
    of these. Normals of the faces of one of the two alone are left out, for these are tested beforehand.
    """
    k = len(linear)
    scaled = linear / np.linalg.norm(linear, axis=0)
    edges = np.concatenate([np.eye(k), scaled.T])
    found: list[np.ndarray] = []
    for chosen in itertools.combinations(range(2 * k), k - 1):
        if max(chosen, default=0) < k or min(chosen, default=k) >= k:
            continue
        _, values, rows = np.linalg.svd(edges[list(chosen)])
        if values[-1] < 1e-12:
            continue
        normal = rows[-1]
        if all(abs(abs(normal @ other) - 1) > 1e-15 for other in found):
            found.append(normal)
    return np.array(found) if found else _none(k)


def _none(dimension: int) -> Float[np.ndarray, "_m _k"]:
    return np.zeros((0, dimension))
