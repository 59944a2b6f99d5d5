"""Matrices in, attractors out: the engine, its certificates and the meshes that it draws."""

from ifs.bounds import Box, bounds, extent, sample
from ifs.box import bounding_box
from ifs.complex import Complex, initial, refine, refined
from ifs.control_mesh import Region, Surface, smooth, surface
from ifs.convergence import Convergence, convergence, require_contraction
from ifs.drawing import draw, mesh
from ifs.error import EmptyAttractor, NotContracting, Undecided
from ifs.mesh import Mesh
from ifs.patchwork import NotASelection, patchwork
from ifs.pieces import Pieces, pieces
from ifs.polygon_mesh import WrongMesh
from ifs.shape import Shape, shape
from ifs.system import State, System

__all__ = [
    "Box",
    "Complex",
    "Convergence",
    "EmptyAttractor",
    "Mesh",
    "NotASelection",
    "NotContracting",
    "Pieces",
    "Region",
    "Shape",
    "State",
    "Surface",
    "System",
    "Undecided",
    "WrongMesh",
    "bounding_box",
    "bounds",
    "convergence",
    "draw",
    "extent",
    "initial",
    "mesh",
    "patchwork",
    "pieces",
    "refine",
    "refined",
    "require_contraction",
    "sample",
    "shape",
    "smooth",
    "surface",
]
