"""2^k-trees: sets of cells of a cube of any dimension, their Boolean algebra, and their forms outside."""

from trees.algebra import distance
from trees.cells import from_array, from_morton, from_points, to_array, to_morton, to_points
from trees.codes import (
    depth_first_code,
    from_depth_first_code,
    from_leaf_codes,
    from_post_order_code,
    leaf_codes,
    post_order_code,
)
from trees.cube import Cube, unit_cube
from trees.errors import CodeError, DamagedFile, KeyTooWide, Misaligned, TooManyPieces, TreeError
from trees.files import (
    map_tree,
    read_hypertree_grid,
    read_tree,
    read_vdb,
    write_hypertree_grid,
    write_tree,
    write_vdb,
)
from trees.hilbert import cells_of_hilbert, hilbert_cells, hilbert_indices
from trees.leaves import Leaves, leaves
from trees.predicate import from_predicate
from trees.reals import from_reals
from trees.states import from_states, from_substitution
from trees.tree import Tree, compact, empty, full

__all__ = [
    "CodeError",
    "Cube",
    "DamagedFile",
    "KeyTooWide",
    "Leaves",
    "Misaligned",
    "TooManyPieces",
    "Tree",
    "TreeError",
    "cells_of_hilbert",
    "compact",
    "depth_first_code",
    "distance",
    "empty",
    "from_array",
    "from_depth_first_code",
    "from_leaf_codes",
    "from_morton",
    "from_points",
    "from_post_order_code",
    "from_predicate",
    "from_reals",
    "from_states",
    "from_substitution",
    "full",
    "hilbert_cells",
    "hilbert_indices",
    "leaf_codes",
    "leaves",
    "map_tree",
    "post_order_code",
    "read_hypertree_grid",
    "read_tree",
    "read_vdb",
    "to_array",
    "to_morton",
    "to_points",
    "unit_cube",
    "write_hypertree_grid",
    "write_tree",
    "write_vdb",
]
