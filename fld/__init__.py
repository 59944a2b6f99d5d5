"""Local fractional derivatives: how rough a curve is, where, and in which direction it leaves a point."""

from fld.behaviour import Behaviour, behaviour
from fld.classes import Region, named
from fld.cone import Cone, Spiral
from fld.derivative import Derivative, Derivatives, derivatives
from fld.design import Fit, OutOfReach, fit_behaviour
from fld.error import Collapsed, NotACurve, OutOfScale
from fld.expansion import Bend, Expansion, Term, expansions
from fld.exponent import Orders, orders
from fld.order import critical_order, parametrisation
from fld.parts import WrongParts
from fld.regions import Facts, Map, classify, regions
from fld.roughness import Roughness, roughness
from fld.tangent import HalfTangent, half_tangents
from fld.watch import Watched, watch

__all__ = [
    "Behaviour",
    "Bend",
    "Collapsed",
    "Cone",
    "Derivative",
    "Derivatives",
    "Expansion",
    "Facts",
    "Fit",
    "HalfTangent",
    "Map",
    "NotACurve",
    "Orders",
    "OutOfReach",
    "OutOfScale",
    "Region",
    "Roughness",
    "Spiral",
    "Term",
    "Watched",
    "WrongParts",
    "behaviour",
    "classify",
    "critical_order",
    "derivatives",
    "expansions",
    "fit_behaviour",
    "half_tangents",
    "named",
    "orders",
    "parametrisation",
    "regions",
    "roughness",
    "watch",
]
