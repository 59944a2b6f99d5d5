"""The similarity dimension of a shape whose pieces are scaled copies of the whole."""

import numpy as np
from jaxtyping import Float

from ifs import Shape

TOLERANCE = 1e-9
STEPS = 200


def similarity_dimension(shape: Shape) -> float | None:
    """The s with `sum_i r_i^s = 1`, where piece i is the whole scaled by r_i; None without such r_i.

    A piece is a scaled copy when a similarity of the span of the control points carries them to those of the
    piece. For shapes that subdivide into themselves alone; pieces that overlap are not noticed.

    >>> from ifs import shape
    >>> dimension = similarity_dimension(shape("sierpinski-triangle"))
    >>> bool(np.isclose(dimension, np.log(3) / np.log(2)))
    True
    >>> similarity_dimension(shape("corner-cutting")) is None
    True
    """
    state = shape.system.states[shape.system.shape]
    if set(state.targets) != {state.name}:
        return None
    coordinates = _intrinsic(shape.control)
    if coordinates.shape[1] == 0:
        return None
    ratios = []
    for operator in state.operators:
        ratio = _ratio(coordinates, operator.T @ coordinates)
        if ratio is None:
            return None
        ratios.append(ratio)
    return _exponent(np.array(ratios))


def _intrinsic(control: Float[np.ndarray, "points dim"]) -> Float[np.ndarray, "points rank"]:
    """The control points in orthonormal coordinates of the flat that they span."""
    differences = control - control.mean(axis=0)
    _, sizes, axes = np.linalg.svd(differences, full_matrices=False)
    rank = int((sizes > TOLERANCE * max(sizes[0], 1e-300)).sum()) if sizes[0] > 0 else 0
    return differences @ axes[:rank].T


def _ratio(points: Float[np.ndarray, "n rank"], images: Float[np.ndarray, "n rank"]) -> float | None:
    """The factor of the similarity that carries the points to their images, if there is one below 1."""
    sources = points - points[0]
    targets = images - images[0]
    linear, *_ = np.linalg.lstsq(sources, targets, rcond=None)
    square = linear.T @ linear
    scale = float(np.trace(square)) / len(square)
    size = float(np.abs(sources).max())
    exact = np.abs(sources @ linear - targets).max() <= TOLERANCE * size
    similar = np.abs(square - scale * np.eye(len(square))).max() <= TOLERANCE
    return float(np.sqrt(scale)) if exact and similar and 0 < scale < 1 else None


def _exponent(ratios: Float[np.ndarray, "maps"]) -> float:
    """The root of `sum r^s = 1`, which falls strictly with s, by bisection."""
    low, high = 0.0, 1.0
    while (ratios**high).sum() > 1:
        high *= 2
    for _ in range(STEPS):
        middle = (low + high) / 2
        if (ratios**middle).sum() > 1:
            low = middle
        else:
            high = middle
    return (low + high) / 2
