"""Directions in which a symmetric tensor is greatest: axes where variances are equal."""

import numpy as np
from jaxtyping import Float

STARTS = 64
FIRST_STEPS, LAST_STEPS = 40, 400
CLOSE = 1e-7


def value(tensor: Float[np.ndarray, "..."], direction: Float[np.ndarray, " dim"]) -> float:
    """`T(u, u, ...)`."""
    for _ in range(tensor.ndim):
        tensor = tensor @ direction
    return float(tensor)


def extreme_directions(
    basis: Float[np.ndarray, "axes dim"],
    third: Float[np.ndarray, "dim dim dim"],
    fourth: Float[np.ndarray, "dim dim dim dim"],
    tolerance: float,
) -> Float[np.ndarray, "axes dim"]:
    """An orthonormal basis of the same space: the greatest third moment, the next one orthogonal to it, ...

    Third moments below `tolerance` times the variance to the power 3/2 count as 0. Then the direction is
    taken whose fourth moment is farthest from the mean over all directions: for a cube and for an
    octahedron these are the axes of fourfold symmetry. (The greatest fourth moment would not do: for a cube
    it lies along a diagonal, and orthogonal to a diagonal all fourth moments are equal.)

    >>> cube = np.zeros((3, 3, 3, 3))
    >>> cube[0, 0, 0, 0] = cube[1, 1, 1, 1] = cube[2, 2, 2, 2] = 1.0
    >>> found = extreme_directions(np.linalg.qr(np.arange(9.0).reshape(3, 3) ** 2)[0], 0 * cube[0], cube, 0.1)
    >>> np.abs(found).round(6).max(axis=1).tolist()
    [1.0, 1.0, 1.0]
    """
    chosen: list[np.ndarray] = []
    rest = basis
    while len(rest) > 1:
        spread = value(_restricted(fourth, rest[:1]), np.ones(1)) ** 0.75
        cubic = _restricted(third, rest)
        best = _greatest(cubic) if np.sqrt((cubic**2).sum()) > tolerance * spread else None
        if best is None or value(cubic, best) <= tolerance * spread:
            quartic = _anisotropic(_restricted(fourth, rest))
            best = max(_greatest(quartic), _greatest(-quartic), key=lambda u: abs(value(quartic, u)))
        chosen.append(best @ rest)
        # The rows of the complement of `best` among the rest.
        rest = np.linalg.svd(best[None, :])[2][1:] @ rest
    return np.array([*chosen, *rest])


def _restricted(
    tensor: Float[np.ndarray, "..."], rows: Float[np.ndarray, "axes dim"]
) -> Float[np.ndarray, "..."]:
    for _ in range(tensor.ndim):
        tensor = np.tensordot(tensor, rows, axes=(0, 1))
    return tensor


def _anisotropic(
    fourth: Float[np.ndarray, "axes axes axes axes"],
) -> Float[np.ndarray, "axes axes axes axes"]:
    """`T(u, u, u, u)` less its mean over all unit vectors, `3 sum T_aabb / (n (n + 2))`."""
    size, one = len(fourth), np.eye(len(fourth))
    mean = 3 * np.einsum("aabb", fourth) / (size * (size + 2))
    pairs = [np.einsum(f"ab,cd->{places}", one, one) for places in ("abcd", "acbd", "acdb")]
    return fourth - mean * sum(pairs) / 3


def _greatest(tensor: Float[np.ndarray, "..."]) -> Float[np.ndarray, " axes"]:
    """The unit vector of greatest `T(u, u, ...)`, by shifted power steps from many fixed starts."""
    size = tensor.shape[0]
    starts = np.random.default_rng(0).normal(size=(STARTS, size))
    u = starts / np.linalg.norm(starts, axis=1, keepdims=True)
    if not tensor.any():
        return np.eye(size)[0]
    shift = float(np.sqrt((tensor**2).sum()))
    for _ in range(FIRST_STEPS):
        u = _step(tensor, u, shift)
    best = int(np.argmax((_gradients(tensor, u) * u).sum(axis=1)))
    u = u[best : best + 1]
    for _ in range(LAST_STEPS):
        before, u = u, _step(tensor, u, shift)
        if np.abs(u - before).max() < CLOSE:
            break
    return u[0]


def _step(
    tensor: Float[np.ndarray, "..."], u: Float[np.ndarray, "starts axes"], shift: float
) -> Float[np.ndarray, "starts axes"]:
    found = _gradients(tensor, u) + shift * u
    return found / np.linalg.norm(found, axis=1, keepdims=True)


def _gradients(
    tensor: Float[np.ndarray, "..."], u: Float[np.ndarray, "starts axes"]
) -> Float[np.ndarray, "starts axes"]:
    found = np.broadcast_to(tensor, (len(u), *tensor.shape))
    for _ in range(tensor.ndim - 1):
        found = np.einsum("s...i,si->s...", found, u)
    return found
