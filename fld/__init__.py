"""Local fractional derivatives: how rough a curve is, where, and in which direction it leaves a point."""

from fld.behaviour import Behaviour, behaviour
from fld.error import Collapsed, NotACurve
from fld.order import critical_order, parametrisation
from fld.tangent import HalfTangent, half_tangents

__all__ = [
    "Behaviour",
    "Collapsed",
    "HalfTangent",
    "NotACurve",
    "behaviour",
    "critical_order",
    "half_tangents",
    "parametrisation",
]
