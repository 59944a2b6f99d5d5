"""The boundary of a tree as rectangles: squares between blocks, or coplanar squares merged."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int

from export.meshing.entries import entries
from export.meshing.grading import Box, Grading, boxes_of, levels_at, tree_of_boxes
from trees.errors import TooManyPieces
from trees.tree import Tree

FIELD = 21  # bits of a coordinate in a key of three
MAX_SQUARES = 2**29
BRICK = 2  # bits an axis of a brick of cells


@dataclass(frozen=True, eq=False)
class Leaves:
    """The blocks on one side of each rectangle: their low corners and their edges, in cells."""

    low: Int[np.ndarray, "patches 3"]
    size: Int[np.ndarray, " patches"]


@dataclass(frozen=True, eq=False)
class Patches:
    """Rectangles that tile the boundary, in cells.

    Each lies across `axis`, from its lowest corner `low` on, `size` cells along the next axis and the one
    after; `out` says that it faces the rising side of its axis. `inner` and `outer` are the black and the
    white blocks that it parts, where it parts but two.
    """

    axis: Int[np.ndarray, " patches"]
    low: Int[np.ndarray, "patches 3"]
    size: Int[np.ndarray, "patches 2"]
    out: Bool[np.ndarray, " patches"]
    inner: Leaves | None = None
    outer: Leaves | None = None


def graded_patches(tree: Tree, grading: Grading) -> tuple[Patches, bool]:
    """The squares between black and white blocks of a graded tree, each that of the smaller block; and
    whether sheets of the boundary may touch: if not, they do not.

    Blocks of `2^j` cells are looked at in the tree of that precision, so they cost what a tree of such cells
    costs. A square is found there if one of its blocks has this size, and the other one this or a larger one.
    """
    boxes = boxes_of(tree, grading)
    found, touched = [], False
    for level in range(len(boxes)):
        patches, touch = _squares(_near(tree, boxes, level), boxes, level)
        found.append(patches)
        touched |= touch
    return _joined(found), touched


def merged_patches(tree: Tree) -> tuple[Patches, bool]:
    """Rectangles of squares that lie in one plane and face one way: rows of squares, and equal rows that
    follow one another; and whether sheets of the boundary touch."""
    inside, outside, touched = _faces(tree)
    return _joined([_rectangles(*faces) for faces in _by_plane(inside, outside)]), touched


def _faces(tree: Tree) -> tuple[Int[np.ndarray, "faces 3"], Int[np.ndarray, "faces 3"], bool]:
    """The black and the white cell of each square of the boundary, and whether sheets of it touch."""
    from export.meshing.blocks import collected
    from export.meshing.kernels import cells_beside

    if not tree:
        return np.zeros((0, 3), dtype=np.int64), np.zeros((0, 3), dtype=np.int64), False
    rows, touched, _, squares = collected(*entries(tree), 0)
    check_squares(int(squares))
    inside, outside = np.empty((squares, 3), np.int64), np.empty((squares, 3), np.int64)
    cells_beside(rows, 0, squares, inside, outside)
    return inside, outside, len(touched) > 0


def check_squares(squares: int) -> None:
    """Raises `TooManyPieces` above 2^29 squares."""
    if squares > MAX_SQUARES:
        raise TooManyPieces(squares, MAX_SQUARES)


def _near(tree: Tree, boxes: tuple[tuple[Box, ...], ...], level: int) -> Tree:
    """The tree at the precision of a level, where blocks of the level are or touch.

    Elsewhere it is white, but for what is nearer than a few blocks: there whole bricks are kept.
    """
    part, brick = tree.at(tree.bits - level), min(level + BRICK, tree.bits)
    if level < len(boxes) - 1:
        part = part & tree_of_boxes(tree, boxes[level], brick, 1).at(part.bits)
    if level:
        part = part - tree_of_boxes(tree, boxes[level - 1], brick, -1).at(part.bits)
    return part


def _squares(tree: Tree, boxes: tuple[tuple[Box, ...], ...], level: int) -> tuple[Patches, bool]:
    """The squares of a level, given the tree at its precision, and whether sheets of this tree touch."""
    inside, outside, touched = _faces(tree)
    within = levels_at(boxes, inside << level)
    beyond = levels_at(boxes, outside << level)
    kept = np.minimum(within, beyond) == level
    inside, outside, within, beyond = inside[kept], outside[kept], within[kept], beyond[kept]
    step = outside - inside
    axis = np.abs(step) @ np.arange(3)
    out = step.sum(axis=1) > 0
    place = np.where(out, outside[np.arange(len(axis)), axis], 0)
    in_cube = (place < 2**tree.bits) & (outside.min(axis=1, initial=0) >= 0)
    beyond = np.where(in_cube, beyond, within)
    low = np.maximum(inside, outside)
    patches = Patches(
        axis=axis,
        low=low << level,
        size=np.full((len(low), 2), 1 << level, dtype=np.int64),
        out=out,
        inner=Leaves(inside << level >> within[:, None] << within[:, None], 1 << within),
        outer=Leaves(outside << level >> beyond[:, None] << beyond[:, None], 1 << beyond),
    )
    return patches, touched


def _by_plane(inside: Int[np.ndarray, "faces 3"], outside: Int[np.ndarray, "faces 3"]):
    """For each axis and way out the squares there: axis, way, and their lowest corners."""
    for axis in range(3):
        step = outside[:, axis] - inside[:, axis]
        for way in (-1, 1):
            chosen = step == way
            if chosen.any():
                yield axis, way > 0, np.maximum(inside[chosen], outside[chosen])


def _rectangles(axis: int, out: bool, low: Int[np.ndarray, "faces 3"]) -> Patches:
    """Greedy rectangles of the squares across an axis that face one way."""
    u, v = (axis + 1) % 3, (axis + 2) % 3
    keys = np.sort(_packed(low[:, axis], low[:, v], low[:, u]))
    rows, lengths = _runs(keys)
    plane, at_v, at_u = _unpacked(rows)
    columns = _packed(plane, at_u, at_v)
    order = np.argsort(columns)
    starts, heights = _runs(columns[order], lengths[order])
    plane, at_u, at_v = _unpacked(starts)
    first = order[np.cumsum(heights) - heights]
    corner = np.empty((len(starts), 3), dtype=np.int64)
    corner[:, axis], corner[:, u], corner[:, v] = plane, at_u, at_v
    size = np.stack([lengths[first], heights], axis=1)
    return Patches(np.full(len(starts), axis), corner, size, np.full(len(starts), out))


def _runs(
    keys: Int[np.ndarray, " keys"], kinds: Int[np.ndarray, " keys"] | None = None
) -> tuple[Int[np.ndarray, " runs"], Int[np.ndarray, " runs"]]:
    """First keys and lengths of the longest runs of keys that follow one another and are of a kind."""
    new = np.append(True, keys[1:] != keys[:-1] + 1)
    if kinds is not None:
        new[1:] |= kinds[1:] != kinds[:-1]
    starts = np.flatnonzero(new)
    return keys[starts], np.diff(np.append(starts, len(keys)))


def _packed(
    x: Int[np.ndarray, " keys"], y: Int[np.ndarray, " keys"], z: Int[np.ndarray, " keys"]
) -> Int[np.ndarray, " keys"]:
    return x << 2 * FIELD | y << FIELD | z


def _unpacked(keys: Int[np.ndarray, " keys"]) -> tuple[Int[np.ndarray, " keys"], ...]:
    mask = (1 << FIELD) - 1
    return keys >> 2 * FIELD, keys >> FIELD & mask, keys & mask


def _joined(parts: list[Patches]) -> Patches:
    """Patches one after the other."""

    def leaves(found: list[Leaves | None]) -> Leaves | None:
        known = [one for one in found if one is not None]
        if len(known) < len(found):
            return None
        return Leaves(np.concatenate([one.low for one in known]), np.concatenate([one.size for one in known]))

    return Patches(
        axis=np.concatenate([part.axis for part in parts]),
        low=np.concatenate([part.low for part in parts]),
        size=np.concatenate([part.size for part in parts]),
        out=np.concatenate([part.out for part in parts]),
        inner=leaves([part.inner for part in parts]),
        outer=leaves([part.outer for part in parts]),
    )
