"""Trees in files: an own format that opens in parts, VTK's HyperTreeGrid, and OpenVDB."""

from trees.files.hypertree import read_hypertree_grid, write_hypertree_grid
from trees.files.mapped import MappedTree, map_tree
from trees.files.openvdb import read_vdb, write_vdb
from trees.files.tree_file import from_bytes, read_tree, to_bytes, write_tree

__all__ = [
    "MappedTree",
    "from_bytes",
    "map_tree",
    "read_hypertree_grid",
    "read_tree",
    "read_vdb",
    "to_bytes",
    "write_hypertree_grid",
    "write_tree",
    "write_vdb",
]
