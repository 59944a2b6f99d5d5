"""Points of an attractor: by chance, by depth, by address."""

from ifs.orbits.addresses import Address, UnknownLabel, joints, parse_address, twins
from ifs.orbits.attractor import pieces_in_chunks, points_in_chunks
from ifs.orbits.chaos import points
from ifs.orbits.limits import LimitPoint, ManyFixedPoints, point_at, points_at

__all__ = [
    "Address",
    "LimitPoint",
    "ManyFixedPoints",
    "UnknownLabel",
    "joints",
    "parse_address",
    "pieces_in_chunks",
    "point_at",
    "points",
    "points_at",
    "points_in_chunks",
    "twins",
]
