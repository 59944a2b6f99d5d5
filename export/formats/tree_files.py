"""Sets of cells as volume files of other programs, by their extension."""

import os

from export.formats.endings import UnsupportedFormat, ending_of
from trees.errors import TreeError
from trees.tree import Tree

TREE_ENDINGS = (".vdb", ".htg")


def write_cells(tree: Tree, path: str | os.PathLike[str]) -> None:
    """Write a set of cells as an OpenVDB fog volume (.vdb) or VTK's HyperTreeGrid (.htg).

    Both keep place and size in mm, and full regions as one node. `trees.files` reads them back. Whole or not
    at all; the same set gives the same bytes. Raises `UnsupportedFormat` for another ending, `TreeError`
    where the set is not in space (for .htg: has more than three dimensions), `OSError`.

    >>> import tempfile
    >>> from trees import from_points
    >>> from trees.files import read_vdb
    >>> place = Path(tempfile.mkdtemp()) / "one.vdb"
    >>> write_cells(from_points([[1, 2, 3]], bits=2), place)
    >>> list(read_vdb(place))
    [(1, 2, 3)]
    """
    from trees.files import write_hypertree_grid, write_vdb

    ending = ending_of(path)
    if not isinstance(tree, Tree):
        raise TreeError(f"a trees.Tree is written, found a {type(tree).__name__}: voxelise it first")
    match ending:
        case ".vdb":
            write_vdb(tree, path)
        case ".htg":
            write_hypertree_grid(tree, path)
        case _:
            raise UnsupportedFormat(f"{path}: write {', '.join(TREE_ENDINGS)}")
