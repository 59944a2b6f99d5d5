"""Attractors to voxels to printable meshes, their check, and the files they leave in."""

from export.check import Fault, Report, check
from export.files import UnreadableMesh, UnsupportedFormat, check_writable, read_mesh, write_part
from export.formats.scene import Body, Place, Scene, WrongMesh, WrongScene
from export.formats.slices import WrongSlices, write_slices
from export.formats.tree_files import write_cells
from export.meshing.skin import EmptySolid, skin
from export.part import Part, make_part
from export.thicken import Solid, thicken
from export.voxels.estimate import Budget, OverBudget, Prediction, estimate
from export.voxels.voxelise import Cover, voxelise

__all__ = [
    "Body",
    "Budget",
    "Cover",
    "EmptySolid",
    "Fault",
    "OverBudget",
    "Part",
    "Place",
    "Prediction",
    "Report",
    "Scene",
    "Solid",
    "UnreadableMesh",
    "UnsupportedFormat",
    "WrongMesh",
    "WrongScene",
    "WrongSlices",
    "check",
    "check_writable",
    "estimate",
    "make_part",
    "read_mesh",
    "skin",
    "thicken",
    "voxelise",
    "write_cells",
    "write_part",
    "write_slices",
]
