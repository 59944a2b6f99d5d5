"""Surfaces to CAD: exact B-spline faces where the limit is polynomial, fitted ones where it is not."""

from export.step.error import InsideOut, NotPolynomial, TooManyFaces, WrongEnding, WrongShell
from export.step.writing import StepReport, step_report, to_build123d, write_step

__all__ = [
    "InsideOut",
    "NotPolynomial",
    "StepReport",
    "TooManyFaces",
    "WrongEnding",
    "WrongShell",
    "step_report",
    "to_build123d",
    "write_step",
]
