"""Sizes of control points: too large or too small to compute with, and what is rounding of them."""

import numpy as np
from jaxtyping import Float

from fld.error import LEAST, MOST, OutOfScale

_ROUNDING = 64 * np.finfo(float).eps


def require_scale(control: Float[np.ndarray, "points dim"]) -> None:
    """Raise `OutOfScale` unless coordinates and differences of control points lie within the range."""
    size = float(np.abs(control).max(initial=0.0))
    if size > MOST:
        raise OutOfScale(size)
    across = float(np.ptp(control, axis=0).max(initial=0.0)) if len(control) else 0.0
    if 0 < across < LEAST:
        raise OutOfScale(across)


def settled(
    point: Float[np.ndarray, "dim"], control: Float[np.ndarray, "_points dim"]
) -> Float[np.ndarray, "dim"]:
    """A point, its coordinates 0 where they are no more than the rounding of the control points' size.

    >>> settled(np.array([90.0, 5.8e-15]), np.array([[0.0, 0.0], [90.0, 0.0]]))
    array([90.,  0.])
    """
    return np.where(np.abs(point) <= _ROUNDING * np.abs(control).max(initial=0.0), 0.0, point)
