"""The critical order of a curve, and the parametrisation that goes with it."""

from fld.curve import Curve, curve
from fld.directions import projected, spanned, visible
from fld.error import Collapsed
from ifs import NotContracting, Shape
from ifs.certificates.differences import spectral_radius
from ifs.dimensions.order import ratios, solved_order

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
