"""Norms in which a system's operators shrink as visibly as ellipsoids allow."""

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from ifs.certificates.differences import Step, spectral_norm

# Underscores: factors of several sizes stand in one mapping.
Factor = Float[np.ndarray, "_size _size"]

_EPS = float(np.finfo(np.float64).eps)
_WEIGHTS = (1.0, 0.1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8)
_ROUNDS = 12
_TRIES = 20  # times that many rounds for one weight, while the largest norm falls by _GAIN
_GAIN = 1e-4


def ellipsoids(sizes: Mapping[str, int], steps: tuple[Step, ...]) -> dict[str, Factor]:
    """A factor R per cell, for the norm `|R_x v|` of a difference v, chosen for small step norms.

    The quadratic forms `P_x = R_x^T R_x` come from iterating `P_y = w I + sum L^T P_x L / r` over
    the steps L from y's differences to x's, r the growth of the sum, for smaller and smaller
    weights w (the plain metric); the forms with the smallest largest step norm win. For w -> 0
    they find the metric in which similarities are similarities, and flatten filtrations such as
    the degrees of a spline. Any choice gives a valid norm.
    """
    plain = {cell: np.eye(size) + 1.0 for cell, size in sizes.items()}
    best = {c: np.linalg.cholesky(form).T for c, form in plain.items()}
    least = _largest(steps, best)
    forms = {cell: form.copy() for cell, form in plain.items()}
    for weight in _WEIGHTS:
        for _ in range(_TRIES):
            if not _iterated(steps, forms, plain, weight):
                return best
            try:
                tried = {c: np.linalg.cholesky(form).T for c, form in forms.items()}
            except np.linalg.LinAlgError:
                return best
            largest = _largest(steps, tried)
            gained = least - largest
            if gained > 0:
                best, least = tried, largest
            if gained <= _GAIN * least:
                break
    return best


def scaled(
    step: Step, factors: Mapping[str, Factor]
) -> tuple[Float[np.ndarray, "_size _target_size"], float]:
    """The step in its norms, `R_x L R_y^-1`, and how far (spectral norm) rounding can put it off.

    The margin covers the rounding of the products and of the inverse, by the norms of the factors,
    and the spread of the maps that the step stands for.
    """
    left, right = factors[step.cell], factors[step.target]
    inverse = np.linalg.inv(right)
    size = max(*left.shape, *right.shape, 1)
    reach = float(np.linalg.norm(left) * np.linalg.norm(inverse))
    # The computed inverse of a triangular factor is off by its condition number.
    condition = float(np.linalg.norm(inverse) * np.linalg.norm(right))
    rounding = 4 * size * _EPS * (2 + condition) * float(np.linalg.norm(step.matrix))
    return left @ step.matrix @ inverse, reach * (step.spread + rounding)


def _iterated(
    steps: tuple[Step, ...],
    forms: dict[str, Factor],
    plain: Mapping[str, Factor],
    weight: float,
) -> bool:
    """Some rounds of the iteration, in place; False once the sum of the steps vanishes."""
    total = sum(float(np.trace(form)) for form in plain.values())
    for _ in range(_ROUNDS):
        moved = _pulled_back(steps, forms)
        growth = sum(float(np.trace(form)) for form in moved.values())
        if growth <= 0:
            return False
        size = sum(float(np.trace(form)) for form in forms.values())
        for cell in forms:
            mixed = weight * plain[cell] / total + moved[cell] / growth + forms[cell] / (2 * size)
            forms[cell] = mixed / (1.5 + weight)
    return True


def _pulled_back(steps: tuple[Step, ...], forms: Mapping[str, Factor]) -> dict[str, Factor]:
    moved = {cell: np.zeros_like(form) for cell, form in forms.items()}
    for step in steps:
        moved[step.target] += step.matrix.T @ forms[step.cell] @ step.matrix
    return moved


def _largest(steps: tuple[Step, ...], factors: Mapping[str, Factor]) -> float:
    sizes = [0.0]
    for step in steps:
        matrix, margin = scaled(step, factors)
        sizes.append(float(spectral_norm(matrix[None])[0]) + margin)
    return max(sizes)
