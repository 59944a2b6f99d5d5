"""Control points and coefficients from data."""

from ifs.fitting.control import Fit, fit_control, fit_curve, project
from ifs.fitting.family import FamilyFit, fit_family

__all__ = [
    "FamilyFit",
    "Fit",
    "fit_control",
    "fit_curve",
    "fit_family",
    "project",
]
