"""Geometry of trees: polytopes and hulls, images, exact maps of the lattice, parts and projections."""

from trees.geometry.errors import BeyondHorizon, SingularMatrix
from trees.geometry.half_spaces import from_half_spaces, slab
from trees.geometry.homography import homography
from trees.geometry.hull import from_hull, image_of_cube
from trees.geometry.lattice import permute, quarter_turn, reflect, scale, translate
from trees.geometry.matrices import perspective, rotation, scaling, shear, transform, translation
from trees.geometry.projection import depth_map, project, visible
from trees.geometry.sections import branch, insert, section, window

__all__ = [
    "BeyondHorizon",
    "SingularMatrix",
    "branch",
    "depth_map",
    "from_half_spaces",
    "from_hull",
    "homography",
    "image_of_cube",
    "insert",
    "permute",
    "perspective",
    "project",
    "quarter_turn",
    "reflect",
    "rotation",
    "scale",
    "scaling",
    "section",
    "shear",
    "slab",
    "transform",
    "translate",
    "translation",
    "visible",
    "window",
]
