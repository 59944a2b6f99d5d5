"""A labelled tree: a tree for each label, all in one cube."""

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, UInt64

from trees.cells import from_morton, to_morton
from trees.cube import Cube
from trees.doors import Rows, numbers, point_rows, whole
from trees.errors import TreeError
from trees.morton import keys_of_cells
from trees.tree import Tree


@dataclass(frozen=True, eq=False)
class LabelledTree:
    """Sets with labels, as trees of one cube and precision ("arbre chromatique", Guye 1988, VI.2).

    A cell may have several labels.
    """

    trees: Mapping[Hashable, Tree]

    def votes(self, point: Float[np.ndarray, " dim"] | Sequence[float]) -> dict[Hashable, int]:
        """How many black cells each label has in the smallest node that holds the point and a black cell.

        The nodes are those of the binary tree: these cells are the nearest ones for the ultrametric of
        `trees.measures.cell_distance`. A point outside the cube counts as the nearest one inside.
        """
        some = next(iter(self.trees.values()))
        row = point_rows(numbers(point, "point")[None, :], some.dimension)
        key = int(_keys(row, some.cube, some.bits)[0])
        rows = {label: to_morton(tree) for label, tree in self.trees.items()}
        for height in range(some.depth + 1):
            low = key >> height << height
            ends = np.array([low, low + 2**height - 1], dtype=np.uint64)
            found = {
                label: int(np.searchsorted(keys, ends[1], "right") - np.searchsorted(keys, ends[0], "left"))
                for label, keys in rows.items()
            }
            if any(found.values()):
                return found
        return dict.fromkeys(self.trees, 0)


def labelled_tree(points: Rows, labels: Sequence[Hashable], cube: Cube, bits: int) -> LabelledTree:
    """The labelled tree of points: each label has the cells of its points; those outside the cube move in.

    Raises `TreeError` where there is no point, or not one label a point, `KeyTooWide` where
    `dimension * bits > 64`.

    >>> from trees import unit_cube
    >>> tree = labelled_tree(np.array([[0.1, 0.1], [0.9, 0.8]]), ["low", "high"], unit_cube(2), bits=3)
    >>> tree.votes(np.array([0.3, 0.2]))
    {'low': 1, 'high': 0}
    """
    points, bits = point_rows(points, cube.dimension), whole(bits, "bits")
    if len(points) == 0 or len(points) != len(labels):
        raise TreeError(
            f"{len(points)} points and {len(labels)} labels: as many, and at least one, are needed"
        )
    keys = _keys(points, cube, bits)
    trees = {}
    for label in dict.fromkeys(labels):
        own = np.array([other == label for other in labels])
        trees[label] = from_morton(keys[own], cube, bits)
    return LabelledTree(trees)


def _keys(points: Float[np.ndarray, "points dim"], cube: Cube, bits: int) -> UInt64[np.ndarray, " points"]:
    if not np.isfinite(points).all():
        row, axis = np.argwhere(~np.isfinite(points))[0].tolist()
        raise TreeError(f"point {row}: coordinate {points[row, axis]} on axis {axis} is not finite")
    cells = np.floor((points - np.array(cube.origin)) / (cube.size / 2**bits))
    return keys_of_cells(np.clip(cells, 0, 2**bits - 1).astype(np.int64), bits)
