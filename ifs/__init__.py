"""Matrices in, attractors out: the engine, its certificates and the meshes that it draws."""

from ifs.adaptivity.adaptive import adaptive
from ifs.certificates.bounds import Box, bounds, extent, sample
from ifs.certificates.box import bounding_box
from ifs.certificates.convergence import Convergence, convergence, require_contraction
from ifs.complex import Complex, initial, refine, refined
from ifs.drawing import draw
from ifs.error import EmptyAttractor, NotContracting, Undecided
from ifs.mesh import Mesh
from ifs.patchwork import NotASelection, patchwork
from ifs.pieces import Pieces, pieces
from ifs.shape import Shape, shape
from ifs.stamp import Stamped, stamped
from ifs.surfaces.control_mesh import Region, Surface, smooth, surface
from ifs.surfaces.polygon_mesh import WrongMesh
from ifs.system import State, System
from ifs.tangency.frames import NotParametrised
from ifs.tangency.points import at
from ifs.tangency.tangents import VertexLimits, half_tangents, vertex_limits
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
