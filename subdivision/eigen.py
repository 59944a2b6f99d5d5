"""Eigenvalue conditions that a solver can differentiate, written once for NumPy and for JAX."""

from typing import Any

from subdivision.member import Array

_SQUARINGS = 5


def spectral_radius(matrix: Array, xp: Any) -> Array:
    """The largest modulus of an eigenvalue, with a derivative that is always finite.

    With NumPy it is just that. With JAX the value is the same, while the derivative is that of
    `|A^32|^(1/32)`, scaled to the value: it tends to the derivative of a simple dominant eigenvalue, is
    an average where several tie, and exists at defective matrices, where the eigenvalue's own is infinite.
    """
    if matrix.shape[0] == 0:
        return xp.zeros(())
    if xp.__name__ == "numpy":
        return abs(xp.linalg.eigvals(matrix)).max()
    from jax.lax import stop_gradient

    value = abs(xp.linalg.eigvals(stop_gradient(matrix))).max()
    size = _norm(matrix, xp)
    power = matrix / size
    for _ in range(_SQUARINGS):
        power = power @ power
    logarithm = xp.log(size) + xp.log(_norm(power, xp)) / 2**_SQUARINGS
    return value * xp.exp(logarithm - stop_gradient(logarithm))


def rest(matrix: Array, vectors: Array, xp: Any) -> Array:
    """The other eigenvalues: L compressed to the complement of its invariant subspace V, orthonormal (n, m).

    L is block triangular along V and its complement, so `(1 - V V^T) L (1 - V V^T)` has the eigenvalues
    of L without those on V, and m zeros.
    """
    complement = xp.eye(matrix.shape[0]) - vectors @ vectors.T
    return complement @ matrix @ complement


def left_vector(matrix: Array, value: Array, vector: Array, xp: Any) -> Array:
    """The left eigenvector w of a simple eigenvalue with unit right eigenvector v, scaled so that `w v = 1`.

    w = v + z with z orthogonal to v, where `(value - M^T) z = M^T v` and M = L (1 - v v^T).
    """
    size = matrix.shape[0]
    complement = xp.eye(size) - xp.outer(vector, vector)
    other = matrix @ complement
    solved = xp.linalg.solve((value + 1e-14) * xp.eye(size) - other.T, other.T @ vector)
    return vector + complement @ solved


def schur_vectors(matrix: Array, count: int, first: int = 0) -> Array:
    """Orthonormal V, (n, count), nearest to `A V = V N` with N strictly upper triangular; by NumPy.

    Each vector is the right singular vector of the least singular value of A compressed to the complement
    of those before it, so that an eigenvalue 0 is resolved in full precision in a Jordan block too.
    `first` starts with another singular vector: 1 with that of the largest value, 2 with the next one.
    """
    import numpy as np

    space = np.eye(len(matrix))
    vectors = []
    for step in range(count):
        rows = np.linalg.svd(space.T @ matrix @ space)[2]
        rows = np.roll(rows, first if step == 0 else 0, axis=0)
        vectors.append(space @ rows[-1])
        space = space @ rows[:-1].T
    return np.stack(vectors, axis=1)


def triangle(strict: Array, count: int, xp: Any) -> Array:
    """The strictly upper triangular (count, count) matrix with the given entries, row after row."""
    if count == 1:
        return xp.zeros((1, 1))
    entries = iter(range(count * (count - 1) // 2))
    return xp.stack(
        [
            xp.stack([strict[next(entries)] if j > i else xp.zeros(()) for j in range(count)])
            for i in range(count)
        ]
    )


def _norm(matrix: Array, xp: Any) -> Array:
    return xp.sqrt((matrix * matrix).sum() + 1e-280)
