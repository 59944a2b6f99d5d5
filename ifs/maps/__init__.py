"""Affine and projective maps, and the plain systems that they make."""

from ifs.maps.homogeneous import NoContraction, contraction, projective_points
from ifs.maps.maps import Map, affine, projective, similarity
from ifs.maps.plain import from_maps, maps_of

__all__ = [
    "Map",
    "NoContraction",
    "affine",
    "contraction",
    "from_maps",
    "maps_of",
    "projective",
    "projective_points",
    "similarity",
]
