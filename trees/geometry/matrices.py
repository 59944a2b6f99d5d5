"""Homogeneous matrices: those of the usual maps, their exact inverses, and points under them.

A matrix is `(k + 1, k + 1)` and acts on columns `(x, 1)`, x in mm; the last row gives the weight w, and the
image is the rest divided by w (Guye 1988, IV.2). Products are `a @ b`, b first.
"""

import math
from collections.abc import Sequence
from fractions import Fraction

import numpy as np
from jaxtyping import Float, Real

from trees.doors import Rows, array_of, numbers, point_rows
from trees.errors import TreeError
from trees.geometry.errors import BeyondHorizon, SingularMatrix

Matrix = Float[np.ndarray, "_rows _columns"]
Vector = Sequence[float] | Real[np.ndarray, " _coordinates"]


def translation(vector: Vector) -> Matrix:
    """`x -> x + vector`, in mm.

    >>> (translation([2, 3]) @ [1, 1, 1]).tolist()
    [3.0, 4.0, 1.0]
    """
    vector = _vector(vector, "vector")
    matrix = np.eye(len(vector) + 1)
    matrix[:-1, -1] = vector
    return matrix


def scaling(factors: Vector, about: Vector | None = None) -> Matrix:
    """`x_i -> factors_i x_i`, about a fixed point (by default 0); a factor of -1 is a mirror.

    >>> (scaling([2, -1], about=[1, 1]) @ [2, 3, 1]).tolist()
    [3.0, -1.0, 1.0]
    """
    return _about(np.diag([*_vector(factors, "factors"), 1.0]), about)


def rotation(dimension: int, first: int, second: int, angle: float, about: Vector | None = None) -> Matrix:
    """The rotation by `angle` radians in the plane of two axes, from the first to the second.

    >>> np.round(rotation(2, 0, 1, np.pi / 2) @ [1, 0, 1], 12).tolist()
    [0.0, 1.0, 1.0]
    """
    for axis in (first, second):
        if not 0 <= axis < dimension:
            raise TreeError(f"axis {axis}: 0 to {dimension - 1} are possible")
    if first == second:
        raise TreeError(f"axes {first} and {second}: a rotation turns one axis to another")
    matrix = np.eye(dimension + 1)
    matrix[first, first] = matrix[second, second] = math.cos(angle)
    matrix[second, first] = math.sin(angle)
    matrix[first, second] = -math.sin(angle)
    return _about(matrix, about)


def shear(dimension: int, axis: int, along: int, factor: float, about: Vector | None = None) -> Matrix:
    """`x_axis -> x_axis + factor x_along`.

    >>> (shear(2, 0, 1, 0.5) @ [1, 2, 1]).tolist()
    [2.0, 2.0, 1.0]
    """
    for one in (axis, along):
        if not 0 <= one < dimension:
            raise TreeError(f"axis {one}: 0 to {dimension - 1} are possible")
    if axis == along:
        raise TreeError(f"axes {axis} and {along}: a shear needs two axes")
    matrix = np.eye(dimension + 1)
    matrix[axis, along] = factor
    return _about(matrix, about)


def perspective(coefficients: Vector, about: Vector | None = None) -> Matrix:
    """`x -> x / (1 + coefficients . x)`: coefficients in 1/mm; the horizon is `1 + coefficients . x = 0`.

    Its inverse is the perspective of the opposite coefficients.

    >>> y = perspective([0.5, 0.0]) @ [2, 3, 1]
    >>> (y[:-1] / y[-1]).tolist()
    [1.0, 1.5]
    """
    coefficients = _vector(coefficients, "coefficients")
    matrix = np.eye(len(coefficients) + 1)
    matrix[-1, :-1] = coefficients
    return _about(matrix, about)


def transform(points: Rows, matrix: Rows) -> Float[np.ndarray, "points dim"]:
    """The images of points, in mm.

    Raises `BeyondHorizon` where the weights of the points have not one sign.

    >>> transform([[1.0, 2.0]], translation([1, 1])).tolist()
    [[2.0, 3.0]]
    """
    points = point_rows(points)
    matrix = check_matrix(matrix, points.shape[1])
    images = points @ matrix[:-1, :-1].T + matrix[:-1, -1]
    weights = points @ matrix[-1, :-1] + matrix[-1, -1]
    if len(points) and not (weights.min() > 0 or weights.max() < 0):
        a, b = int(np.argmin(weights)), int(np.argmax(weights))
        raise BeyondHorizon(f"point {a}", float(weights[a]), float(weights[b]))
    return images / weights[:, None]


def check_matrix(matrix: Rows, dimension: int) -> Real[np.ndarray, "_rows _columns"]:
    """The matrix as an array. Raises `TreeError` where the shape is wrong or an entry is not finite."""
    matrix = array_of(matrix, "matrix")
    if not (np.issubdtype(matrix.dtype, np.integer) or np.issubdtype(matrix.dtype, np.floating)):
        raise TreeError(f"a matrix of {matrix.dtype}: real numbers are needed")
    if matrix.shape != (dimension + 1, dimension + 1):
        needed = f"({dimension + 1}, {dimension + 1})"
        raise TreeError(f"a matrix of shape {matrix.shape}: {needed} is needed for dimension {dimension}")
    if not np.isfinite(matrix).all():
        row, column = np.argwhere(~np.isfinite(matrix))[0].tolist()
        raise TreeError(f"matrix: entry {matrix[row, column]} in row {row}, column {column} is not finite")
    return matrix


def exact(matrix: Real[np.ndarray, "_rows _columns"]) -> list[list[Fraction]]:
    """The entries as fractions; floats are dyadic, so nothing is lost."""
    return [[Fraction(x) for x in row] for row in matrix.tolist()]


def exact_inverse(matrix: list[list[Fraction]]) -> list[list[Fraction]]:
    """The inverse by elimination in fractions. Raises `SingularMatrix` with the rank.

    >>> exact_inverse([[Fraction(2), Fraction(1)], [Fraction(0), Fraction(1)]])[0]
    [Fraction(1, 2), Fraction(-1, 2)]
    """
    n = len(matrix)
    rows = [[*row, *(Fraction(i == j) for j in range(n))] for i, row in enumerate(matrix)]
    rank = 0
    for column in range(n):
        pivot = next((i for i in range(rank, n) if rows[i][column]), None)
        if pivot is None:
            continue
        rows[rank], rows[pivot] = rows[pivot], rows[rank]
        lead = rows[rank][column]
        rows[rank] = [x / lead for x in rows[rank]]
        for i in range(n):
            factor = rows[i][column]
            if i != rank and factor:
                rows[i] = [x - factor * y for x, y in zip(rows[i], rows[rank], strict=True)]
        rank += 1
    if rank < n:
        raise SingularMatrix(rank, n)
    return [row[n:] for row in rows]


def product(a: list[list[Fraction]], b: list[list[Fraction]]) -> list[list[Fraction]]:
    """The exact product of two matrices."""
    return [
        [sum((x * y for x, y in zip(row, col, strict=True)), Fraction(0)) for col in zip(*b, strict=True)]
        for row in a
    ]


def _vector(values: Vector, name: str) -> list[float]:
    return point_rows(numbers(values, name)[None, :])[0].tolist() if len(values) else []


def _about(matrix: Matrix, point: Vector | None) -> Matrix:
    if point is None:
        return matrix
    point = _vector(point, "about")
    if len(point) + 1 != len(matrix):
        raise TreeError(f"a fixed point of {len(point)} coordinates for a map of dimension {len(matrix) - 1}")
    return translation(point) @ matrix @ translation([-x for x in point])
