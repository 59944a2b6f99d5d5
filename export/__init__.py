"""Attractors to voxels to printable meshes, their check, and the files they leave in."""

from export.check import Fault, Report, check
from export.cover import Cover, TooManyVoxels, cover
from export.files import UnreadableMesh, UnsupportedFormat, check_writable, read_mesh, write_part
from export.part import Part, make_part
from export.surface import surface
from export.thicken import thicken
from export.voxels import EmptySolid, Solid, Voxels

__all__ = [
    "Cover",
    "EmptySolid",
    "Fault",
    "Part",
    "Report",
    "Solid",
    "TooManyVoxels",
    "UnreadableMesh",
    "UnsupportedFormat",
    "Voxels",
    "check",
    "check_writable",
    "cover",
    "make_part",
    "read_mesh",
    "surface",
    "thicken",
    "write_part",
]
