"""What half-tangents of curves and of surfaces say alike."""

from typing import Literal

import numpy as np
from jaxtyping import Float

Status = Literal[
    "half-tangent", "undecided", "oscillates", "unoriented", "spiral", "several directions", "constant"
]
"""How a curve leaves a point; `fld.HalfTangent` says what each means."""

_NOTHING = 1e-9


def canonical(vector: Float[np.ndarray, "dim"]) -> Float[np.ndarray, "dim"]:
    """A vector or its opposite: the one whose largest coordinate is positive."""
    return vector * np.sign(vector[np.abs(vector).argmax()])


def written(vector: Float[np.ndarray, "dim"]) -> str:
    """A vector or a point to read: coordinates that are nothing beside the largest one are 0.

    >>> written(np.array([0.6, -1e-17, -0.8])), written(np.array([6e-20, 0.0]))
    ('(0.6, 0, -0.8)', '(6e-20, 0)')
    """
    least = _NOTHING * float(np.abs(vector).max(initial=0.0))
    return "(" + ", ".join(f"{x if abs(x) > least else 0.0:.6g}" for x in vector) + ")"


def number(value: complex) -> str:
    """An eigenvalue to read."""
    return f"{value.real:.6g}" if value.imag == 0 else f"{value.real:.6g}{value.imag:+.6g}i"


def power(order: float, logarithms: int = 0) -> str:
    """A power of h times a power of `log(1/h)`, to read.

    >>> power(1.2), power(0.5, 1), power(1, 2)
    ('h^1.2', 'h^0.5 log(1/h)', 'h^1 log(1/h)^2')
    """
    return f"h^{order:.6g}" + {0: "", 1: " log(1/h)"}.get(logarithms, f" log(1/h)^{logarithms}")
