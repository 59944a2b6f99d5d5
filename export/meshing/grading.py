"""Cells of several sizes: fine ones in regions, blocks of 2, 4, 8, ... cells along an edge elsewhere.

The sizes are those of an octree. With `a_j` the places whose blocks have at most `2^j` cells along an edge,
`a_j` is a union of boxes that are aligned to `2^(j+1)` cells and hold what is within two blocks of `2^j`
cells of `a_(j-1)`. So what lies in `a_j` and not in `a_(j-1)` is made of whole blocks of `2^j` cells, and
blocks that touch, if only at a corner, differ at most twofold.
"""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int

from export.meshing.crossings import Field
from export.meshing.entries import check_space
from trees import from_morton, to_morton, to_points
from trees.cube import Cube
from trees.morton import keys_of_cells
from trees.runs import tree_of_runs
from trees.tree import Tree, empty

Box = tuple[tuple[int, int, int], tuple[int, int, int]]
LARGEST_BLOCK = 2**16
BETWEEN = 2  # blocks, at least, between those of half and those of twice their size
_OCTANTS = np.array([[i >> 2, i >> 1 & 1, i & 1] for i in range(8)])


@dataclass(frozen=True)
class Region:
    """The box from `low` to `high` (mm) in which blocks have at most `block` cells along an edge.

    Raises `ValueError` for corners that are no three finite numbers, for a box without inside, and where
    `block` is no power of two from 1 to 65536.

    >>> Region((0, 0, 0), (10, 10, 5)).block
    1
    """

    low: tuple[float, float, float]
    high: tuple[float, float, float]
    block: int = 1

    def __post_init__(self):
        for name, corner in (("low", self.low), ("high", self.high)):
            places = tuple(float(x) for x in corner)
            if len(places) != 3 or not all(math.isfinite(x) for x in places):
                raise ValueError(f"the {name} corner of a region is three finite numbers of mm, not {corner}")
            object.__setattr__(self, name, places)
        for axis in range(3):
            if not self.low[axis] < self.high[axis]:
                raise ValueError(
                    f"a region from {self.low[axis]} to {self.high[axis]} mm on axis {axis}: it has no inside"
                )
        _power(self.block)


@dataclass(frozen=True)
class Grading:
    """Blocks of `block` cells along an edge, smaller ones in `regions`; between sizes that differ more than
    twofold, the sizes between, each at least two blocks wide.

    Raises `ValueError` where `block` is no power of two from 1 to 65536, or smaller than that of a region.

    >>> Grading(4, (Region((0, 0, 0), (10, 10, 5)),)).levels
    2
    """

    block: int
    regions: tuple[Region, ...] = ()

    def __post_init__(self):
        _power(self.block)
        object.__setattr__(self, "regions", tuple(self.regions))
        for number, region in enumerate(self.regions):
            if not isinstance(region, Region):
                raise ValueError(f"regions[{number}] is no Region: {region!r}")
            if region.block > self.block:
                raise ValueError(
                    f"regions[{number}] has blocks of {region.block} cells, and outside there are blocks of "
                    f"{self.block}: a region is finer"
                )

    @property
    def levels(self) -> int:
        """Twofold steps from cells to the largest blocks."""
        return _power(self.block)


def graded(tree: Tree, grading: Grading, field: Field | None = None) -> Tree:
    """The blocks of a grading that hold a black cell: black as a whole.

    A point in a black cell is in the block that holds the cell, so a cover stays a cover; no cell is lost,
    and those added are less than a block away from one of the set along each axis. Grading twice changes
    nothing more. Blocks are aligned to the cube, and a block of more cells than the cube is the cube.

    With the `field` of a solid (places in mm to mm, see `export.skin`) only those blocks are black at whose
    centre it is at most 0: walls stay as thick as they are, and what is thinner than a block may be lost.

    Raises `TreeError` where the tree is not of dimension 3.

    >>> from trees import from_points
    >>> tree = from_points([[0, 0, 0], [15, 15, 15]], bits=4)
    >>> graded(tree, Grading(4, (Region((0, 0, 0), (0.1, 0.1, 0.1)),))).count
    65
    """
    check_space(tree)
    places = boxes_of(tree, grading)
    result = tree
    for level in range(1, len(places)):
        finer = tree_of_boxes(tree, places[level - 1], level)
        blocks = tree.at(tree.bits - level) - finer
        if field is not None:
            blocks = _inside(blocks, field)
        result = (result & finer.at(tree.bits)) | blocks.at(tree.bits)
    return result


def _inside(blocks: Tree, field: Field) -> Tree:
    centres = np.array(blocks.origin) + (to_points(blocks) + 0.5) * blocks.cell_size
    return from_morton(to_morton(blocks)[field(centres) <= 0], blocks.cube, blocks.bits)


def boxes_of(tree: Tree, grading: Grading) -> tuple[tuple[Box, ...], ...]:
    """For each level j the boxes, in cells, of which `a_j` is made; that of the last one is the cube."""
    levels, size = min(grading.levels, tree.bits), 2**tree.bits
    result, inner = [], []
    for level in range(levels):
        unit, margin = 2 ** (level + 1), BETWEEN * 2**level
        grown = [(tuple(x - margin for x in low), tuple(x + margin for x in high)) for low, high in inner]
        found = grown + [_cells(tree, r) for r in grading.regions if _power(r.block) == level]
        inner = []
        for low, high in found:
            starts = tuple(max(x, 0) // unit * unit for x in low)
            stops = tuple(-(-min(x, size) // unit) * unit for x in high)
            if all(start < stop for start, stop in zip(starts, stops, strict=True)):
                inner.append((starts, stops))
        inner = list(dict.fromkeys(inner))
        result.append(tuple(inner))
    return (*result, (((0, 0, 0), (size, size, size)),))


def levels_at(
    boxes: tuple[tuple[Box, ...], ...], cells: Int[np.ndarray, "cells 3"]
) -> Int[np.ndarray, " cells"]:
    """For each cell the binary logarithm of the cells along its block; the largest outside the cube."""
    last = len(boxes) - 1
    levels = np.full(len(cells), last, dtype=np.int64)
    for level in range(last - 1, -1, -1):
        levels[_within(boxes[level], cells)] = level
    return levels


def tree_of_boxes(tree: Tree, boxes: tuple[Box, ...], level: int, margin: int = 0) -> Tree:
    """The blocks of `2^level` cells in boxes (in cells, aligned to them), as a tree in the same cube.

    The boxes reach `margin` blocks further, or less far where it is negative; they need not be aligned then,
    and are rounded outwards or inwards first.
    """
    down, up = (0, 2**level - 1) if margin >= 0 else (2**level - 1, 0)
    grown = [
        (tuple((x + down >> level) - margin for x in low), tuple((x + up >> level) + margin for x in high))
        for low, high in boxes
    ]
    bits = tree.bits - level
    result = empty(tree.cube, bits)
    for low, high in grown:
        if all(a < b for a, b in zip(low, high, strict=True)):
            result = result | _box(tree.cube, bits, low, high)
    return result


def _box(cube: Cube, bits: int, low: tuple[int, ...], high: tuple[int, ...]) -> Tree:
    """The cells from `low` to `high`: nodes inside are runs of keys, those that are cut are halved."""
    nodes, level = np.zeros((1, 3), dtype=np.int64), bits
    firsts, lasts = [], []
    while len(nodes):
        ends = nodes + (1 << level)
        inside = _all(nodes >= low) & _all(ends <= high)
        keys = keys_of_cells(nodes[inside].astype(np.uint64), bits)
        firsts.append(keys)
        lasts.append(keys + np.uint64(8**level - 1))
        cut = nodes[~inside & _all(ends > low) & _all(nodes < high)]
        level -= 1
        nodes = (cut[:, None] + (_OCTANTS << max(level, 0))).reshape(-1, 3)
    first, last = np.concatenate(firsts), np.concatenate(lasts)
    order = np.argsort(first)
    return tree_of_runs((first[order], last[order]), cube, bits)


def _all(columns: Bool[np.ndarray, "_rows 3"]) -> Bool[np.ndarray, " _rows"]:
    return columns[:, 0] & columns[:, 1] & columns[:, 2]


def _cells(tree: Tree, region: Region) -> Box:
    """The cells that meet a region, before the cube cuts it."""
    lows = [math.floor((x - o) / tree.cell_size) for x, o in zip(region.low, tree.origin, strict=True)]
    highs = [math.ceil((x - o) / tree.cell_size) for x, o in zip(region.high, tree.origin, strict=True)]
    return (lows[0], lows[1], lows[2]), (highs[0], highs[1], highs[2])


def _within(boxes: tuple[Box, ...], cells: Int[np.ndarray, "cells 3"]) -> Bool[np.ndarray, " cells"]:
    found = np.zeros(len(cells), dtype=bool)
    for low, high in boxes:
        found |= _all(cells >= low) & _all(cells < high)
    return found


def _power(block: int) -> int:
    """The binary logarithm of a block."""
    whole = isinstance(block, int | np.integer) and 1 <= block <= LARGEST_BLOCK
    if not whole or block & (block - 1):
        raise ValueError(
            f"a block has 1, 2, 4, 8, ... cells along an edge, up to {LARGEST_BLOCK}, not {block}"
        )
    return int(block).bit_length() - 1
