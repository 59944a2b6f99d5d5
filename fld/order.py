"""The critical order of a curve, and the parametrisation that goes with it."""

import math
from collections.abc import Sequence

import numpy as np

from fld.curve import Curve, curve
from fld.directions import projected, spanned, visible
from fld.error import Collapsed
from ifs import NotContracting, Shape
from ifs.differences import spectral_radius

_NOTHING = 1e-12


def critical_order(shape: Shape) -> float:
    """The critical order alpha of a curve: `sum_i |lambda_i|^(1/alpha) = 1`.

    lambda_i is the eigenvalue of largest modulus of the linear part of T_i: T_i on differences of barycentric
    points, where the eigenvalue 1 of its fixed point is gone, restricted to the directions that the curve
    spans and its control points show (`fld.directions`). A B-spline has order 1, on collinear control points
    too. The Koch curve has log 3 / log 4. The Takagi curve has order 1 although it is nowhere differentiable:
    its eigenvalue 1/2 is double with one eigenvector, so that its points leave like `h log(1/h)`.

    The theorem states alpha in [0, 1]. The equation also has solutions above 1 (corner cutting with a = b =
    9/20): then the curve is flat, to that order, at the points i^omega of this parametrisation. Whether the
    derivative of that order exists is a matter of each point: see `half_tangents` and `behaviour`.

    Raises `NotACurve`, `Collapsed` when some lambda_i is 0, `ifs.NotContracting` when one is 1 or more.
    Source: Gentil 2010, theorem 4.2.1 and equation 4.4.

    >>> import math, ifs
    >>> math.isclose(critical_order(ifs.shape("koch-curve")), math.log(3) / math.log(4))
    True
    """
    return solved_order(list(dominant_moduli(curve(shape)).values()))


def parametrisation(shape: Shape) -> dict[str, float]:
    """The part `r_i = |lambda_i|^(1/alpha)` of the parameter interval [0, 1] that each sub-cell takes.

    The labels come in the order along the curve, and the parts sum to 1. Raises as `critical_order` does.

    >>> import ifs
    >>> {label: round(part, 12) for label, part in parametrisation(ifs.shape("corner-cutting")).items()}
    {'0': 0.5, '1': 0.5}
    """
    return ratios(dominant_moduli(curve(shape)))


def dominant_moduli(curve: Curve) -> dict[str, float]:
    """`|lambda_i|` of every sub-cell, in the order along the curve."""
    basis = spanned(curve)
    directions = visible(basis, curve.operators, projected(curve, basis))
    if len(directions.basis) == 0:
        raise Collapsed(curve.cell, None, 0.0)
    moduli = {}
    for label, matrix in zip(curve.labels, directions.linear, strict=True):
        modulus = spectral_radius(matrix)
        if modulus <= _NOTHING:
            raise Collapsed(curve.cell, label, modulus)
        if modulus >= 1 - _NOTHING:
            raise NotContracting(curve.cell, (label,), modulus)
        moduli[label] = modulus
    return moduli


def solved_order(moduli: Sequence[float]) -> float:
    """alpha with `sum_i moduli_i^(1/alpha) = 1`, for two moduli or more in ]0, 1[.

    The sum falls as 1/alpha grows, and the solution lies between those of the extreme moduli alone.

    >>> round(solved_order([1 / 2, 1 / 4]), 12) == round(math.log(2) / math.log((1 + 5**0.5) / 2), 12)
    True
    """
    from scipy.optimize import brentq

    count = math.log(len(moduli))
    low, high = (count / -math.log(modulus) for modulus in (min(moduli), max(moduli)))
    if high - low <= 1e-14 * high:
        return 1 / high
    exponent = brentq(
        lambda s: math.fsum(modulus**s for modulus in moduli) - 1,
        low * (1 - 1e-9),
        high * (1 + 1e-9),
        xtol=1e-15,
    )
    return 1 / float(np.real(np.asarray(exponent)))


def ratios(moduli: dict[str, float]) -> dict[str, float]:
    """`r_i = moduli_i^(1/alpha)`."""
    order = solved_order(list(moduli.values()))
    return {label: modulus ** (1 / order) for label, modulus in moduli.items()}
