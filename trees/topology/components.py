"""Connected components: the classes of cells that touch one another (Guye 1988, V.2)."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int, Int32, UInt64

from trees.doors import Rows, cell_rows, point_rows, wholes
from trees.doors import numbers as numbers_of
from trees.errors import TooManyPieces, TreeError
from trees.leaves import leaf_runs
from trees.morton import keys_of_cells
from trees.runs import MAX_RUNS
from trees.topology.metrics import D1, is_box
from trees.topology.pieces import Pieces, pieces
from trees.tree import Tree, of_bricks

MAX_TREES = 2**20
DENSE = 8


@dataclass(frozen=True)
class Components:
    """The components of a tree, numbered from the largest on; of equal ones the first in Morton order leads.

    `sizes[n]` is how many cells component n has. A piece of the tree, one brick or one block of black bricks,
    has parts, `masks[offsets[i]:offsets[i + 1]]`, that do not touch within it; `labels` is the component of
    each part. White cells, and black cells of components that were left out, have the label -1.

    >>> from trees import from_points
    >>> found = components(from_points([[0, 0], [2, 0], [3, 0]], bits=2))
    >>> len(found), found.sizes.tolist(), found.labels_of(np.array([[0, 0], [3, 0], [3, 3]])).tolist()
    (2, [2, 1], [1, 0, -1])
    """

    tree: Tree
    metric: str
    sizes: UInt64[np.ndarray, " components"]
    pieces: Pieces
    offsets: Int32[np.ndarray, " offsets"]
    masks: UInt64[np.ndarray, " parts"]
    labels: Int32[np.ndarray, " parts"]

    def __len__(self) -> int:
        return len(self.sizes)

    def labels_of(self, cells: Rows) -> Int[np.ndarray, " cells"]:
        """The components of cells given by integer coordinates, -1 where white or outside the cube."""
        rows = cell_rows(cells, self.tree.dimension)
        found = np.full(len(rows), -1, dtype=np.int64)
        black = self.tree.holds_cells(rows)
        found[black] = self._of_keys(keys_of_cells(rows[black], self.tree.bits))
        return found

    def labels_of_points(self, points: Rows) -> Int[np.ndarray, " points"]:
        """The components of the cells that hold these points, in mm, -1 where white or outside the cube."""
        from trees.reals import cells_of_points

        rows = point_rows(points, self.tree.dimension)
        found = np.full(len(rows), -1, dtype=np.int64)
        black = self.tree.holds(rows)
        cells = cells_of_points(rows[black], self.tree.cube, self.tree.bits)
        found[black] = self._of_keys(keys_of_cells(cells, self.tree.bits))
        return found

    def labels_of_leaves(self, binary: bool = False) -> Int[np.ndarray, " leaves"]:
        """The components of the leaves, in the order of `leaves(tree, binary)`."""
        return self._of_keys(leaf_runs(self.tree, 1 if binary else self.tree.dimension)[0])

    def tree_of(self, which: int | Sequence[int]) -> Tree:
        """The union of the components with these numbers."""
        from trees.topology import component_kernels, piece_kernels

        numbers = wholes(which if isinstance(which, Iterable) else [which], "component")
        for number in numbers:
            if not 0 <= number < len(self):
                raise TreeError(f"component {number} of {len(self)}: 0 to {len(self) - 1} are possible")
        wanted = np.zeros(len(self), dtype=bool)
        wanted[numbers] = True
        words = component_kernels.chosen_words(self.offsets, self.masks, self.labels, wanted)
        bricks = np.uint64(self.tree.bricks)
        found = piece_kernels.entries(self.pieces.starts, words, self.pieces.levels, bricks)
        return of_bricks(self.tree.cube, self.tree.bits, *found)

    def forest(self) -> list[Tree]:
        """The components as trees, from the largest on: the "forêt des arbres segments" of Guye 1988, V.2.

        Raises `TooManyPieces` above 2^20 of them.
        """
        if len(self) > MAX_TREES:
            raise TooManyPieces(len(self), MAX_TREES)
        return list(self._trees())

    def kept(self, wanted: Bool[np.ndarray, " components"] | Sequence[bool]) -> "Components":
        """The components chosen by a mask, in the same order, numbered anew.

        Raises `TreeError` where the mask has not one Boolean a component.
        """
        wanted = numbers_of(wanted, "mask")
        if len(wanted) != len(self) or (len(self) and wanted.dtype != np.bool_):
            raise TreeError(f"a mask of {len(wanted)} {wanted.dtype}: {len(self)} Booleans are needed")
        wanted = wanted.astype(bool)
        numbers = np.append(np.cumsum(wanted) - 1, -1).astype(np.int32)
        numbers[:-1][~wanted] = -1
        labels = numbers[self.labels]
        return Components(
            self.tree, self.metric, self.sizes[wanted], self.pieces, self.offsets, self.masks, labels
        )

    def _of_keys(self, keys: UInt64[np.ndarray, " _keys"]) -> Int[np.ndarray, " _keys"]:
        from trees.topology import component_kernels

        return component_kernels.labels_of_keys(
            keys,
            self.pieces.low,
            self.pieces.starts,
            self.pieces.levels,
            self.offsets,
            self.masks,
            self.labels,
        )

    def _trees(self) -> Iterator[Tree]:
        from trees.topology import piece_kernels

        order = np.argsort(self.labels, kind="stable")
        bounds = np.searchsorted(self.labels[order], np.arange(len(self) + 1))
        piece = np.repeat(np.arange(len(self.pieces)), np.diff(self.offsets))
        bricks = np.uint64(self.tree.bricks)
        for begin, end in zip(bounds[:-1].tolist(), bounds[1:].tolist(), strict=True):
            parts = order[begin:end]
            at = piece[parts]
            found = piece_kernels.entries(
                self.pieces.starts[at], self.masks[parts], self.pieces.levels[at], bricks
            )
            yield of_bricks(self.tree.cube, self.tree.bits, *found)


def components(tree: Tree, metric: str = D1) -> Components:
    """The connected components of the black cells, for the metric "d1" or "d-infinity".

    The parts of each brick are found by filling words; parts of bricks that touch are joined, and so
    are black blocks of any size, never cut into cells (after Guye 1988, V.2, with union-find in place of
    the waiting list).

    Raises `TooManyPieces` above 2^28 bricks or parts, `TreeError` for another metric.

    >>> from trees import from_points
    >>> diagonal = from_points([[0, 0], [1, 1]], bits=1)
    >>> len(components(diagonal)), len(components(diagonal, "d-infinity"))
    (2, 1)
    """
    from trees.topology import component_kernels

    box = is_box(metric)
    if tree.count == 2**64:
        raise TooManyPieces(2**64, 2**64 - 1)
    cut = pieces(tree)
    room = int(component_kernels.most_parts(cut.words, cut.layout))
    if room > MAX_RUNS:
        raise TooManyPieces(room, MAX_RUNS)
    offsets, masks = component_kernels.part_masks(cut.words, room, box, cut.layout)
    dense = 2**cut.top <= DENSE * len(cut)
    join = component_kernels.joined_dense if dense else component_kernels.joined
    labels = join(cut.starts, cut.words, cut.levels, cut.top, cut.low, offsets, masks, box, cut.layout)
    sizes = component_kernels.measured(labels, cut.levels, offsets, masks)
    order = np.argsort(~sizes, kind="stable")
    numbers = np.empty(len(sizes), dtype=np.int32)
    numbers[order] = np.arange(len(sizes), dtype=np.int32)
    component_kernels.renumber(labels, numbers)
    return Components(tree, metric, sizes[order], cut, offsets, masks, labels)


def at_border(found: Components) -> Bool[np.ndarray, " components"]:
    """Which components have a cell on the border of the reference cube.

    >>> from trees import from_points
    >>> at_border(components(from_points([[1, 1], [3, 1]], bits=2))).tolist()
    [False, True]
    """
    from trees.topology import component_kernels

    cut = found.pieces
    return component_kernels.at_border(
        cut.starts,
        cut.levels,
        cut.top,
        cut.low,
        found.offsets,
        found.masks,
        found.labels,
        len(found),
        cut.layout,
    )
