"""Matrices in, attractors out: the engine, its certificates and the meshes that it draws."""

from ifs.adaptive import adaptive
from ifs.bounds import Box, bounds, extent, sample
from ifs.box import bounding_box
from ifs.complex import Complex, initial, refine, refined
from ifs.control_mesh import Region, Surface, smooth, surface
from ifs.convergence import Convergence, convergence, require_contraction
from ifs.drawing import draw
from ifs.error import EmptyAttractor, NotContracting, Undecided
from ifs.frames import NotParametrised
from ifs.mesh import Mesh
from ifs.patchwork import NotASelection, patchwork
from ifs.pieces import Pieces, pieces
from ifs.points import at
from ifs.polygon_mesh import WrongMesh
from ifs.shape import Shape, shape
from ifs.stamp import Stamped, stamped
from ifs.system import State, System
from ifs.tangents import VertexLimits, half_tangents, vertex_limits
from ifs.uniform import mesh, uniform

__all__ = [
    "Box",
    "Complex",
    "Convergence",
    "EmptyAttractor",
    "Mesh",
    "NotASelection",
    "NotContracting",
    "NotParametrised",
    "Pieces",
    "Region",
    "Shape",
    "Stamped",
    "State",
    "Surface",
    "System",
    "Undecided",
    "VertexLimits",
    "WrongMesh",
    "adaptive",
    "at",
    "bounding_box",
    "bounds",
    "convergence",
    "draw",
    "extent",
    "half_tangents",
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
    "stamped",
    "surface",
    "uniform",
    "vertex_limits",
]
