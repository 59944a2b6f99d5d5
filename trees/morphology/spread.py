"""Dilation and ranks on tiles: those whose neighbourhood is all white or all black are passed over."""

import numpy as np
from jaxtyping import UInt64

from trees.cells import to_morton
from trees.errors import TooManyPieces
from trees.morphology.elements import Box, Element, Rows, cell_of, reach, rows
from trees.morphology.tiles import (
    BATCH_WORDS,
    MAX_SLOTS,
    Layout,
    Tiles,
    Window,
    rows_of,
    slots,
    tiled,
    tree_of_pieces,
    window,
)
from trees.runs import MAX_RUNS, black_runs, tree_of_runs
from trees.topology.faces import touching_pairs
from trees.tree import Tree, empty

MAX_TILES = 2**26
MODERATE = 2**24


def spread(tree: Tree, element: Element, outside: bool) -> Tree:
    """The dilation; outside the cube all is white, or with `outside` black.

    >>> from trees import from_points
    >>> list(spread(from_points([[4]], bits=3), Box(1), outside=True))
    [(0,), (3,), (4,), (5,), (7,)]
    """
    radii = reach(element, tree.dimension, cell_of(tree))
    if tree.dimension == 1:
        return _spread_line(tree, radii[0], outside)
    if isinstance(element, Box):
        return _spread_box(tree, radii, outside)
    tiles = tiled(tree)
    around = window(tiles.layout, radii)
    found = rows(element, tree.dimension, cell_of(tree))
    _check_shell(tiles, around)
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


def _spread_line(tree: Tree, radius: int, outside: bool) -> Tree:
    """The dilation of a set on the line: runs grow at both ends."""
    lows, highs = black_runs(tree)
    side = 2**tree.bits
    last, by, edge = np.uint64(side - 1), np.uint64(min(radius, side - 1)), min(radius, side) - 1
    lows, highs = lows - np.minimum(lows, by), highs + np.minimum(last - highs, by)
    if outside and edge >= 0:
        lows = np.append(lows, np.array([0, side - 1 - edge], dtype=np.uint64))
        highs = np.append(highs, np.array([edge, side - 1], dtype=np.uint64))
    order = np.argsort(lows)
    lows, highs = lows[order], np.maximum.accumulate(highs[order])
    apart = lows[1:] > highs[:-1]
    some = np.ones(min(len(lows), 1), dtype=bool)
    return tree_of_runs((lows[np.append(some, apart)], highs[np.append(apart, some)]), tree.cube, tree.bits)


def _spread_box(tree: Tree, radii: tuple[int, ...], outside: bool) -> Tree:
    """The dilation by a box: in steps where it reaches far beyond tiles."""
    rest = tuple(min(radius, 2**tree.bits) for radius in radii)
    while True:
        tiles = tiled(tree)
        around = window(tiles.layout, _step(tiles.layout, rest))
        if tiles.some.bits == 0:
            candidates = ~empty(tree.cube, 0)
        else:
            _check_shell(tiles, around)
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


def _check_shell(tiles: Tiles, around: Window) -> None:
    """Raises `TooManyPieces` at once where the tiles that touch black ones are too many.

    A white tile has at most `2 k` faces to black ones: the pairs of tiles of both colours that share a face
    are counted on nodes.
    """
    coarse, k = tiles.some, tiles.tree.dimension
    if 2**coarse.depth <= MAX_TILES or not all(_steps(around)):
        return
    pairs = k * (2**coarse.bits - 1) * 2 ** (coarse.depth - coarse.bits)
    mixed = pairs - sum(touching_pairs(coarse)) - sum(touching_pairs(~coarse))
    if mixed > 2 * k * MAX_TILES:
        raise TooManyPieces(mixed // (2 * k), MAX_TILES)


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
    batch = max(1, min(BATCH_WORDS // shape.count, MAX_SLOTS // len(around.neighbours)))
    entries = 0
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
        entries += len(starts)
        if entries > MAX_RUNS:
            raise TooManyPieces(entries, MAX_RUNS)
        after = int(end)
    if after < tree.bricks:
        pieces.append((np.array([after], dtype=np.uint64), np.zeros(1, dtype=np.uint64)))
    result = tree_of_pieces(pieces, tree.cube, tree.bits)
    return result | black.at(tree.bits) if black else result
