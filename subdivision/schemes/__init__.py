"""Curve schemes: automata with their constraints, and a table of coefficients for what these leave open."""

from subdivision.schemes.curves import b_spline, bezier, corner_cutting, de_rham
from subdivision.schemes.fractal_curves import cesaro, hilbert, interpolation, koch, takagi
from subdivision.schemes.nonuniform import nonuniform_b_spline
from subdivision.schemes.segments import Segments, chain, nonuniform

__all__ = [
    "Segments",
    "b_spline",
    "bezier",
    "cesaro",
    "chain",
    "corner_cutting",
    "de_rham",
    "hilbert",
    "interpolation",
    "koch",
    "nonuniform",
    "nonuniform_b_spline",
    "takagi",
]
