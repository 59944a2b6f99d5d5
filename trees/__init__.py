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
from trees.files import read_tree, write_tree
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
    "leaf_codes",
    "leaves",
    "post_order_code",
    "read_tree",
    "to_array",
    "to_morton",
    "to_points",
    "unit_cube",
    "write_tree",
]
