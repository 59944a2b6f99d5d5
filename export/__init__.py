"""Attractors to voxels to printable meshes, their check, and the files they leave in."""

from export.check import Fault, Report, check
from export.files import UnreadableMesh, UnsupportedFormat, check_writable, read_mesh, write_part
from export.formats.scene import Body, Place, Scene, WrongMesh, WrongRecipe, WrongScene
from export.formats.slices import WrongSlices, write_slices
from export.formats.tree_files import write_cells
from export.meshing.grading import Grading, Region, graded
from export.meshing.skin import EmptySolid, skin
from export.part import Part, make_part
from export.prepare import Prepared, TooThick, TooThin, prepare
from export.printable.fitting import DoesNotFit
from export.printable.frame import WrongLength
from export.printable.requests import Printable
from export.printable.steps import Step
from export.thicken import Solid, thicken
from export.voxels.estimate import Budget, OverBudget, Prediction, estimate
from export.voxels.voxelise import Cover, voxelise

__all__ = [
    "Body",
    "Budget",
    "Cover",
    "DoesNotFit",
    "EmptySolid",
    "Fault",
    "Grading",
    "OverBudget",
    "Part",
    "Place",
    "Prediction",
    "Prepared",
    "Printable",
    "Region",
    "Report",
    "Scene",
    "Solid",
    "Step",
    "TooThick",
    "TooThin",
    "UnreadableMesh",
    "UnsupportedFormat",
    "WrongLength",
    "WrongMesh",
    "WrongRecipe",
    "WrongScene",
    "WrongSlices",
    "check",
    "check_writable",
    "estimate",
    "graded",
    "make_part",
    "prepare",
    "read_mesh",
    "skin",
    "thicken",
    "voxelise",
    "write_cells",
    "write_part",
    "write_slices",
]
