"""Constraints in, matrices out: the solver and the families that it finds."""

from subdivision.error import Contradiction, NotLinear, Undetermined, WrongValue
from subdivision.solution import Exact, Parameter, Solution
from subdivision.solve import solve

__all__ = [
    "Contradiction",
    "Exact",
    "NotLinear",
    "Parameter",
    "Solution",
    "Undetermined",
    "WrongValue",
    "solve",
]
