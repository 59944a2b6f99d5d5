"""Trees from arrays, cells and Morton keys, and back."""

import numpy as np
from jaxtyping import Bool, Int, Shaped, UInt8, UInt64

from trees.algebra import flat_words
from trees.bricks import form_of_words
from trees.cube import Cube, unit_cube
from trees.doors import Rows, array_of, numbers, whole
from trees.errors import TooManyPieces, TreeError
from trees.morton import cells_of_keys, check_cells, check_widths, keys_of_cells
from trees.runs import black_runs, tree_of_runs
from trees.shared import check_depth, shared_of_digits
from trees.tree import Tree

MAX_CELLS = 2**34


def from_array(array: np.ndarray, cube: Cube | None = None) -> Tree:
    """The true cells of an array of side `2^bits` on each axis; axis i of it is axis i of the cube.

    The cube is the unit cube unless given. Raises `TreeError` where the sides are unequal or no power of
    two, or where the entries are not Booleans.

    >>> from_array(np.array([[True, False], [False, False]]))
    <Tree: dimension 2, 1 bits an axis, 1 cells, cube of 1.0 at (0.0, 0.0)>
    """
    array = array_of(array, "array")
    if array.dtype != np.bool_:
        raise TreeError(f"an array of {array.dtype}: Booleans are needed")
    if array.ndim == 0 or len(set(array.shape)) > 1 or array.shape[0].bit_count() != 1:
        raise TreeError(f"an array of shape {array.shape}: equal sides, a power of two, are needed")
    from trees import kernels

    dimension, bits = array.ndim, array.shape[0].bit_length() - 1
    corners, offsets = _layout(dimension, bits)
    words = kernels.gathered(np.ascontiguousarray(array).reshape(-1), corners, offsets)
    return Tree(_cube(cube, dimension), bits, form_of_words(dimension * bits, words))


def to_array(tree: Tree) -> Bool[np.ndarray, "..."]:
    """The array that `from_array` reads, of shape `(2^bits,) * dimension`.

    Raises `TooManyPieces` above 2^34 cells.

    >>> to_array(from_points([[1, 0]], bits=1)).tolist()
    [[False, False], [True, False]]
    """
    if tree.depth > 34:
        raise TooManyPieces(2**tree.depth, MAX_CELLS)
    from trees import kernels

    array = np.zeros(2**tree.depth, dtype=bool)
    kernels.scattered(flat_words(tree), *_layout(tree.dimension, tree.bits), array)
    return array.reshape((2**tree.bits,) * tree.dimension)


def _layout(dimension: int, bits: int) -> tuple[Int[np.ndarray, " bricks"], Int[np.ndarray, " cells"]]:
    """Where the first cell of each brick stands in a flat array, and how far from it the cells of a brick."""
    strides = 2 ** (bits * np.arange(dimension - 1, -1, -1, dtype=np.int64))
    depth = dimension * bits
    inside = np.arange(2 ** min(depth, 6), dtype=np.uint64)
    bricks = np.arange(2 ** max(depth - 6, 0), dtype=np.uint64) << np.uint64(6)
    corners, offsets = (
        cells_of_keys(keys, dimension, bits).astype(np.int64) @ strides for keys in (bricks, inside)
    )
    return corners, offsets


def from_points(cells: Rows, bits: int, cube: Cube | None = None) -> Tree:
    """The cells with these integer coordinates in `[0, 2^bits)`, in any order, repeated or not.

    The cube is the unit cube unless given. Raises `TreeError` with the row and the axis where a
    coordinate is outside, or where `bits` is above 64 or `dimension * bits` above 512.

    >>> len(from_points([[1, 2, 3], [0, 0, 0], [1, 2, 3]], bits=2))
    2
    """
    rows, bits = _point_rows(cells), whole(bits, "bits")
    if not np.issubdtype(rows.dtype, np.integer):
        raise TreeError(f"points of {rows.dtype}: integers are needed; `from_reals` takes points in mm")
    cube = _cube(cube, rows.shape[1])
    check_cells(rows, bits)
    if cube.dimension * bits <= 64:
        return from_morton(keys_of_cells(rows, bits), cube, bits)
    check_depth(cube.dimension, bits)
    return Tree(cube, bits, shared_of_digits(_digits(rows.astype(np.uint64), bits)))


def from_morton(keys: Rows, cube: Cube, bits: int) -> Tree:
    """The cells with these Morton keys, in any order, repeated or not.

    Raises `TreeError` with the row where a key is outside `[0, 2^(dimension * bits))`.

    >>> list(from_morton(np.array([2, 15]), unit_cube(2), bits=2))
    [(1, 0), (3, 3)]
    """
    keys, bits = numbers(keys, "keys"), whole(bits, "bits")
    check_widths(cube.dimension, bits)
    if not np.issubdtype(keys.dtype, np.integer):
        raise TreeError(f"keys of {keys.dtype}: integers are needed")
    depth = cube.dimension * bits
    outside = (keys < 0) | (keys > np.uint64(2**depth - 1))
    if outside.any():
        row = int(np.argmax(outside))
        raise TreeError(f"key {row} is {keys[row]}, outside 0 to {2**depth - 1}")
    # Sorting and comparing is many times faster than np.unique; equal keys make no jump.
    rising = np.sort(keys.astype(np.uint64))
    jumps = rising[1:] - rising[:-1] > np.uint64(1)
    lows = rising[np.append(np.ones(min(rising.size, 1), bool), jumps)]
    highs = rising[np.append(jumps, np.ones(min(rising.size, 1), bool))]
    return tree_of_runs((lows, highs), cube, bits)


def to_morton(tree: Tree) -> UInt64[np.ndarray, " cells"]:
    """The Morton keys of the black cells, in rising order.

    Raises `TooManyPieces` above 2^28 cells.

    >>> to_morton(from_points([[3, 3], [1, 0]], bits=2)).tolist()
    [2, 15]
    """
    if tree.count > 2**28:
        raise TooManyPieces(tree.count, 2**28)
    lows, highs = black_runs(tree)
    sizes = (highs - lows).astype(np.int64) + 1
    begin = np.cumsum(sizes) - sizes
    steps = np.arange(int(sizes.sum())) - np.repeat(begin, sizes)
    return np.repeat(lows, sizes) + steps.astype(np.uint64)


def to_points(tree: Tree) -> UInt64[np.ndarray, "cells dim"]:
    """The black cells in Morton order, by their integer coordinates.

    >>> to_points(from_points([[3, 3], [1, 0]], bits=2)).tolist()
    [[1, 0], [3, 3]]
    """
    return cells_of_keys(to_morton(tree), tree.dimension, tree.bits)


def _point_rows(cells: Rows) -> Shaped[np.ndarray, "_cells _dim"]:
    rows = array_of(cells, "points")
    if rows.ndim != 2 or rows.shape[1] == 0:
        raise TreeError(f"points of shape {rows.shape}: (points, dimension) is needed")
    return rows if rows.size else rows.astype(np.uint64)


def _digits(cells: UInt64[np.ndarray, "cells dim"], bits: int) -> UInt8[np.ndarray, "_cells depth"]:
    """The paths of halvings that lead to the cells, sorted, each once."""
    shifts = np.arange(bits - 1, -1, -1, dtype=np.uint64)
    digits = ((cells[:, None, :] >> shifts[None, :, None]) & np.uint64(1)).astype(np.uint8)
    packed = np.packbits(digits.reshape(len(cells), bits * cells.shape[1]), axis=1)
    rows = np.ascontiguousarray(packed).view(f"S{packed.shape[1]}") if len(cells) else packed
    _, first = np.unique(rows.ravel(), return_index=True)
    return np.unpackbits(packed[first], axis=1, count=bits * cells.shape[1])


def _cube(cube: Cube | None, dimension: int) -> Cube:
    if cube is None:
        return unit_cube(dimension)
    if cube.dimension != dimension:
        raise TreeError(f"a cube of dimension {cube.dimension} for data of dimension {dimension}")
    return cube
