"""Trees cut into tiles of rows: which tiles an operation must look at, and what they hold."""

import itertools
import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Int, UInt64

from trees.cube import Cube
from trees.errors import TooManyPieces
from trees.morton import cells_of_keys, keys_of_cells
from trees.runs import black_runs, tree_of_runs
from trees.tree import Tree, empty

SIDES = {1: 6, 2: 6, 3: 6, 4: 5, 5: 4, 6: 3, 7: 2, 8: 2, 9: 2}
BATCH_WORDS = 2**22
MAX_WINDOW = 2**26
MAX_SLOTS = 2**22


@dataclass(frozen=True)
class Layout:
    """Cubes of `2^side` cells an axis, one branch of the tree each, as rows of the last axis.

    Brick b of a tile lies in rows `base[b] + parts`, from cell `begin[b]` on; each row gets a part of
    `width` bits, once the bits of the numbers of its cells are exchanged as `swaps` (shift, mask) say.
    """

    dimension: int
    side: int
    swaps: UInt64[np.ndarray, "swaps 2"]
    base: Int[np.ndarray, " bricks"]
    begin: UInt64[np.ndarray, " bricks"]
    parts: Int[np.ndarray, " parts"]
    width: int

    @property
    def edge(self) -> int:
        """Cells an axis."""
        return 2**self.side

    @property
    def count(self) -> int:
        """Rows a tile."""
        return self.edge ** (self.dimension - 1)

    @property
    def shift(self) -> int:
        """A tile is `2^shift` bricks."""
        return max(self.dimension * self.side - 6, 0)

    @property
    def tables(self) -> tuple:
        """What kernels need to turn bricks into rows and back."""
        return self.swaps, self.base, self.begin, self.parts, np.uint64(self.width)


def layout(dimension: int, bits: int) -> Layout:
    """The tiles of trees of this dimension and this many bits an axis: at most 64 cells an axis."""
    side = min(bits, SIDES.get(dimension, 1))
    inner = min(6, dimension * side)
    along = list(range(0, inner, dimension))
    swaps, places = [], list(range(inner))
    for low, high in enumerate(along):
        if low != high:
            mask = sum(1 << p for p in range(64) if p >> low & 1 and not p >> high & 1)
            swaps.append((2**high - 2**low, mask))
            places[low], places[high] = places[high], places[low]
    depth = dimension * side
    firsts = np.arange(2 ** (depth - inner), dtype=np.uint64) << np.uint64(inner)
    others = places[len(along) :]
    numbers = np.arange(2 ** len(others), dtype=np.uint64)
    keys = np.zeros(len(numbers), dtype=np.uint64)
    for i, place in enumerate(others):
        keys |= ((numbers >> np.uint64(i)) & np.uint64(1)) << np.uint64(place)
    base, begin = _row_of(firsts, dimension, side)
    parts, _ = _row_of(keys, dimension, side)
    table = np.array(swaps, dtype=np.uint64).reshape(-1, 2)
    return Layout(dimension, side, table, base, begin.astype(np.uint64), parts, 2 ** len(along))


def _row_of(
    keys: UInt64[np.ndarray, " keys"], dimension: int, side: int
) -> tuple[Int[np.ndarray, " keys"], Int[np.ndarray, " keys"]]:
    cells = cells_of_keys(keys, dimension, side).astype(np.int64)
    row = np.zeros(len(keys), dtype=np.int64)
    for axis in range(dimension - 1):
        row = (row << side) + cells[:, axis]
    return row, cells[:, -1]


@dataclass(frozen=True)
class Tiles:
    """The tiles of a tree as two coarser trees: those with a black cell, those without a white one."""

    tree: Tree
    layout: Layout
    some: Tree
    every: Tree


def tiled(tree: Tree) -> Tiles:
    """The tree, cut into tiles."""
    from trees.morphology import kernels

    found = layout(tree.dimension, tree.bits)
    coarse = tree.bits - found.side
    if coarse == 0:
        none = empty(tree.cube, 0)
        return Tiles(tree, found, ~none, none)
    some, every = kernels.tile_runs(tree.starts, tree.words, np.uint64(tree.bricks), np.uint64(found.shift))
    trees = [
        tree_of_runs((runs[:, 0].copy(), runs[:, 1].copy()), tree.cube, coarse) for runs in (some, every)
    ]
    return Tiles(tree, found, *trees)


@dataclass(frozen=True)
class Window:
    """The rows within `reach` of a tile: those of row i come from neighbour `tile_of_row[i]`."""

    reach: tuple[int, ...]
    neighbours: Int[np.ndarray, "neighbours dim"]
    tile_of_row: Int[np.ndarray, " window"]
    row_of_row: Int[np.ndarray, " window"]
    places: Int[np.ndarray, " across"]
    planes: int
    strides: Int[np.ndarray, " others"]
    lines: Int[np.ndarray, " lines"]
    length: int

    @property
    def tables(self) -> tuple:
        """What kernels need to fill windows and to walk over the rows of the tile in them."""
        return self.tile_of_row, self.row_of_row, self.places, self.planes, self.lines, self.length


def window(found: Layout, reach: tuple[int, ...]) -> Window:
    """The windows of tiles for an element of this reach, in cells on each axis.

    Raises `TooManyPieces` where a window would be more than 2^26 words, or meet more than 2^22 tiles.
    """
    edge, words = found.edge, 2 * -(-reach[-1] // 64) + 1
    extents = [edge + 2 * r for r in reach[:-1]]
    size = math.prod(extents) * words
    if size > MAX_WINDOW:
        raise TooManyPieces(size, MAX_WINDOW)
    steps = [-(-r // edge) for r in reach]
    tiles = math.prod(2 * step + 1 for step in steps)
    if tiles > MAX_SLOTS:
        raise TooManyPieces(tiles, MAX_SLOTS)
    neighbours = np.array(list(itertools.product(*(range(-s, s + 1) for s in steps))), dtype=np.int64)
    tile, row = np.zeros((1,), np.int64), np.zeros((1,), np.int64)
    for r, step, extent in zip(reach, steps, extents, strict=False):
        cell = np.arange(extent) - r
        tile = (tile[:, None] * (2 * step + 1) + (cell // edge + step)).ravel()
        row = (row[:, None] * edge + cell % edge).ravel()
    strides = np.array([math.prod(extents[a + 1 :]) for a in range(len(extents))], dtype=np.int64)
    lines = np.zeros(1, np.int64)
    for axis, stride in enumerate(strides[:-1].tolist()):
        lines = (lines[:, None] + (np.arange(edge) + reach[axis]) * stride).ravel()
    if len(extents):
        lines = lines + reach[len(extents) - 1]
    middle = (words // 2) * 64
    places = middle + np.arange(-steps[-1], steps[-1] + 1) * edge
    length = edge if len(extents) else 1
    return Window(reach, neighbours, tile, row, places, words, strides, lines, length)


def slots(
    tiles: Tiles, keys: UInt64[np.ndarray, " tiles"], around: Window, outside: bool
) -> tuple[Int[np.ndarray, "tiles neighbours"], UInt64[np.ndarray, " greys"]]:
    """Where neighbours of tiles stand in the store: 0 is white, 1 black, `i + 2` the i-th key returned."""
    coarse = tiles.some.bits
    here = cells_of_keys(keys, tiles.tree.dimension, coarse).astype(np.int64)
    cells = (here[:, None, :] + around.neighbours).reshape(-1, tiles.tree.dimension)
    inside = ((cells >= 0) & (cells < 2**coarse)).all(axis=1)
    places = np.full(len(cells), int(outside), dtype=np.int64)
    near = keys_of_cells(cells[inside], coarse)
    black, grey = _in_runs(near, tiles.every), _in_runs(near, tiles.some)
    grey &= ~black
    wanted, which = np.unique(near[grey], return_inverse=True)
    found = black.astype(np.int64)
    found[grey] = which + 2
    places[inside] = found
    return places.reshape(len(keys), -1), wanted


def rows_of(tiles: Tiles, keys: UInt64[np.ndarray, " tiles"]) -> UInt64[np.ndarray, "_store _rows"]:
    """The store: a white tile, a black one, and the rows of these tiles."""
    from trees.morphology import kernels

    store = np.zeros((len(keys) + 2, tiles.layout.count), dtype=np.uint64)
    store[1] = np.uint64(2**tiles.layout.edge - 1)
    tree, shift = tiles.tree, np.uint64(tiles.layout.shift)
    kernels.rows_of_tiles(tree.starts, tree.words, keys, shift, tiles.layout.tables, store)
    return store


def tree_of_pieces(pieces: list[tuple[np.ndarray, np.ndarray]], cube: Cube, bits: int) -> Tree:
    """The tree of entries that follow each other, some of which repeat the word before."""
    from trees.tree import of_bricks

    if not pieces:
        return empty(cube, bits)
    starts, words = (np.concatenate(arrays) for arrays in zip(*pieces, strict=True))
    new = np.append(True, words[1:] != words[:-1])
    return of_bricks(cube, bits, starts[new], words[new])


def _in_runs(keys: UInt64[np.ndarray, " keys"], tree: Tree) -> np.ndarray:
    lows, highs = black_runs(tree)
    if len(lows) == 0:
        return np.zeros(len(keys), dtype=bool)
    run = np.searchsorted(lows, keys, side="right") - 1
    return (run >= 0) & (keys <= highs[run])
