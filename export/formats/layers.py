"""One layer of a tree after the other as pictures, straight from its bricks or its shared branches."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Int64, UInt8

from trees.cube import Cube
from trees.runs import embed
from trees.shared import Shared
from trees.tree import Tree

Picture = UInt8[np.ndarray, "rows columns"]


@dataclass(frozen=True, eq=False)
class CellBox:
    """The cells from `low` to before `high`."""

    low: Int64[np.ndarray, "3"]
    high: Int64[np.ndarray, "3"]

    @property
    def sides(self) -> Int64[np.ndarray, "3"]:
        """How many cells it has on each axis."""
        return self.high - self.low


def cell_box(tree: Tree) -> CellBox | None:
    """The smallest box of cells around a set in space; None where the set is empty.

    >>> from trees import from_points
    >>> box = cell_box(from_points([[1, 2, 3], [2, 2, 0]], bits=2))
    >>> box.low.tolist(), box.high.tolist()
    ([1, 2, 0], [3, 3, 4])
    """
    from export.formats import slices_kernels as kernels

    if not tree:
        return None
    box = np.array([[2**62] * 3, [-1] * 3], dtype=np.int64)
    if isinstance(tree.form, Shared):
        kernels.box_of_shared(tree.form.lows, tree.form.highs, tree.form.root, tree.bits, box)
    else:
        tree = of_whole_bricks(tree)
        kernels.box_of_bricks(tree.starts, tree.words, tree.bits, box)
    return CellBox(box[0], box[1])


def layers(tree: Tree, box: CellBox, heights: Int64[np.ndarray, " layers"]) -> Iterator[Picture]:
    """The cells of some z as pictures, [y, x] from the low corner of the box; the same array each time.

    >>> from trees import from_points
    >>> tree = from_points([[1, 2, 3], [2, 2, 0]], bits=2)
    >>> [picture.tolist() for picture in layers(tree, cell_box(tree), np.array([0, 1, 3]))]
    [[[0, 1]], [[0, 0]], [[1, 0]]]
    """
    from export.formats import slices_kernels as kernels

    width, depth, _ = box.sides.tolist()
    picture = np.zeros((depth, width), dtype=np.uint8)
    if not isinstance(tree.form, Shared):
        tree = of_whole_bricks(tree)
    for height in heights.tolist():
        picture[:] = 0
        if isinstance(tree.form, Shared):
            form = tree.form
            kernels.layer_of_shared(form.lows, form.highs, form.root, tree.bits, height, box.low, picture)
        else:
            kernels.layer_of_bricks(tree.starts, tree.words, tree.bits, height, box.low, picture)
        yield picture


def of_whole_bricks(tree: Tree) -> Tree:
    """The same cells in a cube of 4 cells an axis at least."""
    if tree.bits >= 2:
        return tree
    return embed(tree, Cube(tree.origin, tree.size * 2 ** (2 - tree.bits)))
