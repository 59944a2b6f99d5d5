"""Dilation and ranks on tiles: those whose neighbourhood is all white or all black are passed over."""

import numpy as np
from jaxtyping import UInt64

from trees.cells import to_morton
from trees.errors import TooManyPieces
from trees.morphology.elements import Box, Element, Rows, cell_of, reach, rows
from trees.morphology.tiles import (
    BATCH_WORDS,
    Layout,
    Tiles,
    Window,
    rows_of,
    slots,
    tiled,
    tree_of_pieces,
    window,
)
from trees.tree import Tree, empty

MAX_TILES = 2**26
MODERATE = 2**24


def spread(tree: Tree, element: Element, outside: bool) -> Tree:
    """The dilation; outside the cube all is white, or with `outside` black.

    >>> from trees import from_points
    >>> list(spread(from_points([[4]], bits=3), Box(1), outside=True))
    [(0,), (3,), (4,), (5,), (7,)]
    """
    if isinstance(element, Box):
        return _spread_box(tree, reach(element, tree.dimension, cell_of(tree)), outside)
    tiles, found = tiled(tree), rows(element, tree.dimension, cell_of(tree))
    around = window(tiles.layout, reach(element, tree.dimension, cell_of(tree)))
    candidates = _spread_box(tiles.some, _steps(around), outside) - tiles.every
    return _filtered(tiles, candidates, tiles.every, around, found, 1, outside)


def counted(tree: Tree, element: Element, found: Rows, least: int, outside: bool) -> Tree:
    """The cells around which at least `least` cells of the element are black; see `spread`."""
    if least == 1:
        return spread(tree, element, outside)
    tiles = tiled(tree)
    around = window(tiles.layout, reach(element, tree.dimension, cell_of(tree)))
    near = _spread_box(tiles.some, _steps(around), outside)
    deep = ~_spread_box(~tiles.every, _steps(around), not outside)
    return _filtered(tiles, near - deep, deep, around, found, least, outside)


def _spread_box(tree: Tree, radii: tuple[int, ...], outside: bool) -> Tree:
    """The dilation by a box: in steps where it reaches far beyond tiles."""
    rest = tuple(min(radius, 2**tree.bits) for radius in radii)
    while True:
        tiles = tiled(tree)
        around = window(tiles.layout, _step(tiles.layout, rest))
        if tiles.some.bits == 0:
            candidates = ~empty(tree.cube, 0)
        else:
            candidates = _spread_box(tiles.some, _steps(around), outside) - tiles.every
        none = Rows(np.zeros((1, tree.dimension - 1), np.int64), np.array([around.reach[-1]]))
        tree = _filtered(tiles, candidates, tiles.every, around, none, 0, outside)
        rest = tuple(radius - part for radius, part in zip(rest, around.reach, strict=True))
        if not any(rest):
            return tree


def _step(found: Layout, radii: tuple[int, ...]) -> tuple[int, ...]:
    """As much of the radii as a window of moderate size has room for, a tile at least."""
    most = found.edge
    while most < max(radii) and (found.edge + 4 * most) ** found.dimension <= MODERATE:
        most *= 2
    return tuple(min(radius, most) for radius in radii)


def _steps(around: Window) -> tuple[int, ...]:
    """How many tiles an axis an element reaches."""
    return tuple(around.neighbours.max(axis=0).tolist())


def _filtered(
    tiles: Tiles, candidates: Tree, black: Tree, around: Window, found: Rows, least: int, outside: bool
) -> Tree:
    """The candidate tiles filtered, joined with the black ones; `least` 0 is a box."""
    from trees.morphology import kernels

    if candidates.count > MAX_TILES:
        raise TooManyPieces(candidates.count, MAX_TILES)
    keys, tree, shape = to_morton(candidates), tiles.tree, tiles.layout
    offsets = found.offsets @ around.strides
    radii = np.array(around.reach[:-1], dtype=np.int64)
    digits = max((found.count - 1).bit_length(), 1) if least > 1 else 1
    pieces: list[tuple[UInt64[np.ndarray, " entries"], UInt64[np.ndarray, " entries"]]] = []
    after = 0
    batch = max(1, BATCH_WORDS // shape.count)
    for first in range(0, len(keys), batch):
        part = keys[first : first + batch]
        places, greys = slots(tiles, part, around, outside)
        starts, words, end = kernels.filter_tiles(
            rows_of(tiles, greys),
            places,
            part,
            np.uint64(shape.shift),
            np.uint64(after),
            shape.tables,
            around.tables,
            found.halves,
            offsets,
            radii,
            around.strides,
            least,
            digits,
        )
        pieces.append((starts, words))
        after = int(end)
    if after < tree.bricks:
        pieces.append((np.array([after], dtype=np.uint64), np.zeros(1, dtype=np.uint64)))
    result = tree_of_pieces(pieces, tree.cube, tree.bits)
    return result | black.at(tree.bits) if black else result
