"""Schemes: automata with their constraints, and a table of coefficients for what these leave open."""

from subdivision.schemes.curves import b_spline, bezier, corner_cutting, de_rham
from subdivision.schemes.fractal_curves import cesaro, hilbert, interpolation, koch, takagi
from subdivision.schemes.loop import loop
from subdivision.schemes.nonuniform import nonuniform_b_spline
from subdivision.schemes.segments import Segments, chain, nonuniform
from subdivision.schemes.tensor import tensor
from subdivision.schemes.triangles import bezier_triangle, sierpinski_triangle
from subdivision.schemes.wall import menger_wall, wall

__all__ = [
    "Segments",
    "b_spline",
    "bezier",
    "bezier_triangle",
    "cesaro",
    "chain",
    "corner_cutting",
    "de_rham",
    "hilbert",
    "interpolation",
    "koch",
    "loop",
    "menger_wall",
    "nonuniform",
    "nonuniform_b_spline",
    "sierpinski_triangle",
    "takagi",
    "tensor",
    "wall",
]
