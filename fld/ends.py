"""How curves leave their ends, for many members of a family at once: dominant eigenvalues and directions."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Bool, Complex, Float, Int

Kind = Literal["positive", "negative", "complex", "equal", "constant"]
KINDS: tuple[Kind, ...] = ("positive", "negative", "complex", "equal", "constant")

_SAME = 1e-9
_PARALLEL = 1e-7

Operators = Float[np.ndarray, "members points points"]
Columns = Float[np.ndarray, "members points"]


@dataclass(frozen=True)
class End:
    """One end of each curve of a family.

    `kind` counts in `KINDS`: the dominant eigenvalue (1 apart) is real and positive, real and negative, one
    of a complex pair, or as large in modulus as another one; or no eigenvalue other than 0 moves the far end.
    `direction` is the barycentric column of its eigenvector, oriented into the curve (to where the ends of
    ever smaller pieces lie), NaN unless the kind is positive or negative. `own` says whether it depends on
    the end's own control points alone, `flips` whether any eigenvalue is real and negative, and `value` is
    the dominant eigenvalue.
    """

    kind: Int[np.ndarray, "members"]
    value: Complex[np.ndarray, "members"]
    direction: Columns
    own: Bool[np.ndarray, "members"]
    flips: Bool[np.ndarray, "members"]


def fixed_points(operators: Operators) -> Columns:
    """The columns with `T p = p` that sum to 1, for operators whose linear parts have no eigenvalue 1."""
    size = operators.shape[1] - 1
    linear = operators[:, :-1, :-1] - operators[:, :-1, -1:]
    places = np.linalg.solve(np.eye(size) - linear, operators[:, :-1, -1:])[:, :, 0]
    return np.column_stack([places, 1 - places.sum(axis=1)])


def end(operators: Operators, far: Columns, embedding: Float[np.ndarray, "points own"]) -> End:
    """The end that `operators` fix, `far` being the other end, `embedding` that of the end's vertex.

    In the powers `L^k (far - p)` an eigenvalue counts only with its component of the chord, so that the
    dominant one is the largest whose component is not 0 (to 9 digits).
    Source: Gentil 2010, 4.3.1, "Analyse des valeurs et vecteurs propres".
    """
    count, points, _ = operators.shape
    linear = operators[:, :-1, :-1] - operators[:, :-1, -1:]
    values, vectors = np.linalg.eig(linear)
    values, vectors = np.asarray(values, complex), np.asarray(vectors, complex)
    chord = (far - fixed_points(operators))[:, :-1].astype(complex)
    defective = np.abs(np.linalg.det(vectors)) < 1e-10
    usable = np.where(defective[:, None, None], np.eye(points - 1), vectors)
    parts = np.linalg.solve(usable, chord[:, :, None])[:, :, 0]
    small = np.abs(parts) <= _SAME * np.abs(chord).max(axis=1, keepdims=True)
    moduli = np.where(small & ~defective[:, None], -1.0, np.abs(values))
    best = moduli.argmax(axis=1)
    rows = np.arange(count)
    value, largest = values[rows, best], moduli[rows, best]
    real = np.abs(np.imag(value)) <= _SAME * largest
    others = moduli.copy()
    others[rows, best] = -1.0
    tied = others.max(axis=1, initial=-1.0) >= largest * (1 - _SAME)
    kind = np.select(
        [largest <= 1e-12, ~real & ~defective, tied | defective, np.real(value) > 0], [4, 2, 3, 0], default=1
    )
    inner = (vectors[rows, :, best] * parts[rows, best, None]).real
    direction = np.column_stack([inner, -inner.sum(axis=1)])
    direction /= np.maximum(np.linalg.norm(direction, axis=1, keepdims=True), 1e-300)
    direction[kind > 1] = np.nan
    basis = np.linalg.qr(embedding)[0]
    outside = direction - direction @ basis @ basis.T
    own = np.linalg.norm(outside, axis=1) <= _PARALLEL
    negative = (np.abs(np.imag(values)) <= _SAME * np.abs(values)) & (np.real(values) < -1e-12)
    return End(kind, value, direction, own, np.asarray(negative.any(axis=1)))


def meeting(left: Columns, right: Columns) -> Int[np.ndarray, "members"]:
    """How two directions at a joint, both forwards along the curve, meet: for all control points alike.

    0 where they are parallel and the same, 1 parallel and opposite, 2 neither, 3 where one is missing.
    """
    one = left / np.maximum(np.linalg.norm(left, axis=1, keepdims=True), 1e-300)
    other = right / np.maximum(np.linalg.norm(right, axis=1, keepdims=True), 1e-300)
    apart = np.linalg.norm(one - other, axis=1)
    against = np.linalg.norm(one + other, axis=1)
    missing = np.isnan(apart) | (np.linalg.norm(one, axis=1) < 0.5) | (np.linalg.norm(other, axis=1) < 0.5)
    return np.select([missing, apart <= _PARALLEL, against <= _PARALLEL], [3, 0, 1], default=2)
