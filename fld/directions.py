"""Which differences of barycentric points a curve makes, and which of them its control points show.

Two things shrink the space of differences (columns that sum to 0). The points of the attractor may lie in a
smaller affine space: `spanned` keeps the directions they span. And the control points may hide directions
for good: those in the largest subspace that P maps to 0 and that the operators keep. `visible` divides
them out. What is left is the smallest system that draws the same curve, so its eigenvalues are those of
the drawn curve, whatever the number of control points; injective affine maps of the control points
change nothing. Ranks are decided to 9 digits.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from fld.curve import Curve, fixed_point

_RANK = 1e-9

Basis = Float[np.ndarray, "directions points"]


@dataclass(frozen=True)
class Directions:
    """Directions that count, as orthonormal rows `basis`, and the linear maps on their coordinates.

    A difference d has coordinates `basis d`; `linear[k]` is `(directions, directions)`, and
    `control` `(directions, dim)` holds what each direction draws, in mm.
    """

    basis: Basis
    linear: tuple[Float[np.ndarray, "directions directions"], ...]
    control: Float[np.ndarray, "directions dim"]


def closure(rows: Float[np.ndarray, "rows n"], matrices: Sequence[Float[np.ndarray, "n n"]]) -> Basis:
    """Orthonormal rows of the smallest space that holds `rows` and that `row -> row M` keeps.

    >>> closure(np.array([[2.0, 0, 0]]), [np.array([[0, 1.0, 0], [0, 0, 0], [0, 0, 1]])]).shape
    (2, 3)
    """
    basis = np.zeros((0, rows.shape[1]))
    scaled = [matrix / norm for matrix in matrices if (norm := np.linalg.norm(matrix, 2)) > 0]
    size = np.linalg.norm(rows, axis=1).max(initial=0.0)
    fresh = rows / size if size > 0 else rows[:0]
    while len(fresh) and len(basis) < rows.shape[1]:
        for _ in range(2):
            fresh = fresh - fresh @ basis.T @ basis
        _, values, directions = np.linalg.svd(fresh, full_matrices=False)
        new = directions[values > _RANK]
        basis = np.vstack([basis, new])
        fresh = np.vstack([new @ matrix for matrix in scaled]) if scaled else new[:0]
    # The whole space has a basis without rounding.
    return basis if len(basis) < rows.shape[1] else np.eye(len(basis))


def span(
    rows: Float[np.ndarray, "rows points"], operators: Sequence[Float[np.ndarray, "points points"]]
) -> Basis:
    """The directions of the smallest space that holds the given differences and that the operators keep."""
    frame = differences(rows.shape[1])
    return closure(rows @ frame.T, [frame @ operator.T @ frame.T for operator in operators]) @ frame


def differences(points: int) -> Basis:
    """Orthonormal rows that span the columns with sum 0: `(1, …, 1, -k, 0, …) / sqrt(k (k + 1))`."""
    rows = (
        np.tril(np.ones((points, points)), -1)[1:] - np.eye(points, k=1)[:-1] * np.arange(1, points)[:, None]
    )
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


def spanned(curve: Curve) -> Basis:
    """The directions that the differences of points of the attractor span.

    The smallest space that holds `T_j c - c` for a point c of the attractor and that every T_j keeps.
    """
    point = fixed_point(curve.operators[0])
    steps = np.array([operator @ point - point for operator in curve.operators])
    return span(steps, curve.operators)


def visible(
    basis: Basis,
    operators: Sequence[Float[np.ndarray, "points points"]],
    drawn: Float[np.ndarray, "directions dim"],
) -> Directions:
    """The directions of an invariant space that the control points, at some level, tell apart.

    `drawn` holds what each row of `basis` draws, in mm.
    """
    linear = [basis @ operator @ basis.T for operator in operators]
    seen = closure(drawn.T, linear)
    return Directions(seen @ basis, tuple(seen @ matrix @ seen.T for matrix in linear), seen @ drawn)


def projected(curve: Curve, rows: Basis) -> Float[np.ndarray, "directions dim"]:
    """What differences draw, in mm; 0 where it is nothing but rounding."""
    centred = curve.control - curve.control.mean(axis=0)
    drawn = rows @ centred
    small = np.linalg.norm(drawn) <= _RANK * np.linalg.norm(rows) * np.linalg.norm(centred, 2)
    # Control points that coincide up to their rounding draw nothing either.
    same = np.linalg.norm(centred) <= 1e-14 * np.linalg.norm(curve.control)
    return drawn * 0.0 if small or same else drawn


def transported(curve: Curve, word: tuple[str, ...], rows: Basis) -> tuple[Basis, float]:
    """`L_w d` for differences d as rows, as (rows, log of a factor): `L_w d = factor * row`.

    Letter by letter, so that long words lose no digits. Rows of 0 when the word flattens them all.
    """
    logarithm = 0.0
    for label in reversed(word):
        operator = curve.operator((label,))
        moved = rows @ operator.T
        moved -= moved.mean(axis=1, keepdims=True)
        size = np.linalg.norm(moved)
        if size <= _RANK * np.linalg.norm(operator, 2) * np.linalg.norm(rows):
            return moved * 0.0, 0.0
        rows, logarithm = moved / size, logarithm + float(np.log(size))
    return rows, logarithm
