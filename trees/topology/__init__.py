"""Neighbours, boundaries, components, holes and Euler characteristics of sets of cells, in any dimension."""

from trees.topology.adjacency import Neighbours, adjacent_cells, adjacent_leaves, adjacent_nodes, directions
from trees.topology.boundary import boundary
from trees.topology.components import Components, at_border, components
from trees.topology.euler import betti_numbers, euler_characteristic
from trees.topology.faces import face_counts, surface_area, touching_pairs
from trees.topology.holes import fill_holes, holes

__all__ = [
    "Components",
    "Neighbours",
    "adjacent_cells",
    "adjacent_leaves",
    "adjacent_nodes",
    "at_border",
    "betti_numbers",
    "boundary",
    "components",
    "directions",
    "euler_characteristic",
    "face_counts",
    "fill_holes",
    "holes",
    "surface_area",
    "touching_pairs",
]
