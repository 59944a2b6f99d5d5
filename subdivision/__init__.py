"""Constraints in, matrices out: the solver and the families that it finds."""

from subdivision.affine import Parameter
from subdivision.error import Contradiction, NotLinear, TooMuchWork, Undetermined, WrongValue
from subdivision.override import overridden
from subdivision.solution import Exact, Solution, solve

__all__ = [
    "Contradiction",
    "Exact",
    "NotLinear",
    "Parameter",
    "Solution",
    "TooMuchWork",
    "Undetermined",
    "WrongValue",
    "overridden",
    "solve",
]
