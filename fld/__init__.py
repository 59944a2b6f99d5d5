"""Local fractional derivatives: how rough a curve is, where, and in which direction it leaves a point."""

from fld.behaviour import Behaviour, behaviour
from fld.classes import Region, named
from fld.error import Collapsed, NotACurve
from fld.order import critical_order, parametrisation
from fld.regions import Facts, Map, classify, regions
from fld.tangent import HalfTangent, half_tangents

__all__ = [
    "Behaviour",
    "Collapsed",
    "Facts",
    "HalfTangent",
    "Map",
    "NotACurve",
    "Region",
    "behaviour",
    "classify",
    "critical_order",
    "half_tangents",
    "named",
    "parametrisation",
    "regions",
]
