"""Parts of a tree: sections across an axis, and branches taken out or put in."""

from fractions import Fraction

import numpy as np
from jaxtyping import UInt64

from trees.cube import Cube
from trees.errors import TreeError
from trees.geometry.lattice import Numbers, translate
from trees.leaves import leaf_runs
from trees.morton import cells_of_keys, check_widths, keys_of_cells
from trees.runs import black_runs, tree_of_runs
from trees.tree import Tree


def section(tree: Tree, axis: int, index: int) -> Tree:
    """The cells whose coordinate on an axis is `index`, as a tree of one dimension less.

    >>> from trees import from_points
    >>> list(section(from_points([[0, 1, 2], [3, 1, 3]], bits=2), axis=1, index=1))
    [(0, 2), (3, 3)]
    """
    check_flat(tree, axis)
    if not 0 <= index < 2**tree.bits:
        raise TreeError(f"cell {index} on axis {axis}: 0 to {2**tree.bits - 1} are possible")
    first, last = leaf_runs(tree, tree.dimension)
    low = cells_of_keys(first, tree.dimension, tree.bits)[:, axis]
    high = cells_of_keys(last, tree.dimension, tree.bits)[:, axis]
    cut = (low <= np.uint64(index)) & (np.uint64(index) <= high)
    blocks = without_axis(tree, axis, first[cut]), without_axis(tree, axis, last[cut])
    return tree_of_runs(blocks, without(tree.cube, axis), tree.bits)


def branch(tree: Tree, level: int, cell: Numbers) -> Tree:
    """The part of a tree in one of its nodes: the cube of this level with these coordinates.

    Its cube is the node's, with `bits - level` bits an axis.

    >>> from trees import from_points
    >>> branch(from_points([[3, 0], [0, 3]], bits=2), level=1, cell=[1, 0])
    <Tree: dimension 2, 1 bits an axis, 1 cells, cube of 0.5 at (0.5, 0.0)>
    """
    first, last, cube = _node(tree, level, cell)
    lows, highs = black_runs(tree)
    meets = (lows <= np.uint64(last)) & (highs >= np.uint64(first))
    lows = np.maximum(lows[meets], np.uint64(first)) - np.uint64(first)
    highs = np.minimum(highs[meets], np.uint64(last)) - np.uint64(first)
    return tree_of_runs((lows, highs), cube, tree.bits - level)


def insert(tree: Tree, part: Tree, level: int, cell: Numbers) -> Tree:
    """The tree with the node of this level and these coordinates replaced by `part`.

    The cube of `part` does not matter; where its cells are finer than those of the tree, the tree is
    refined to them, and where coarser, the part is.

    >>> from trees import from_points
    >>> tree = insert(from_points([[3, 0], [0, 3]], bits=2), from_points([[0, 0]], bits=1), 1, [1, 0])
    >>> list(tree)
    [(0, 3), (2, 0)]
    """
    if part.dimension != tree.dimension:
        raise TreeError(f"a part of dimension {part.dimension} for a tree of dimension {tree.dimension}")
    _node(tree, level, cell)
    bits = max(tree.bits, part.bits + level)
    tree, part = tree.at(bits), part.at(bits - level)
    first, last, _ = _node(tree, level, cell)
    lows, highs = black_runs(tree)
    before, after = lows < np.uint64(first), highs > np.uint64(last)
    inner = black_runs(part)
    low = [
        lows[before],
        inner[0] + np.uint64(first),
        np.maximum(lows[after], np.uint64(min(last + 1, 2**64 - 1))),
    ]
    high = [
        np.minimum(highs[before], np.uint64(max(first, 1) - 1)),
        inner[1] + np.uint64(first),
        highs[after],
    ]
    return tree_of_runs((np.concatenate(low), np.concatenate(high)), tree.cube, bits)


def window(tree: Tree, corner: Numbers, bits: int) -> Tree:
    """The `2^bits` cells an axis from a corner on, wherever it stands: it need not be a node.

    What of it lies outside the cube is white. The result's cube stands where the window does.

    >>> from trees import from_points
    >>> list(window(from_points([[1, 1], [2, 2]], bits=2), corner=[1, 1], bits=1))
    [(0, 0), (1, 1)]
    """
    if not 0 <= bits <= tree.bits:
        raise TreeError(f"a window of {bits} bits an axis in a tree of {tree.bits}")
    moved = branch(translate(tree, [-int(x) for x in corner]), tree.bits - bits, [0] * tree.dimension)
    cell = Fraction(tree.size) / 2**tree.bits
    origin = tuple(float(Fraction(x) + cell * int(n)) for x, n in zip(tree.origin, corner, strict=True))
    return tree_of_runs(black_runs(moved), Cube(origin, moved.size), bits)


def check_flat(tree: Tree, axis: int) -> None:
    """Raises `TreeError` where the tree has no such axis, or no other."""
    if not 0 <= axis < tree.dimension:
        raise TreeError(f"axis {axis}: 0 to {tree.dimension - 1} are possible")
    if tree.dimension == 1:
        raise TreeError("a tree of dimension 1: without its axis nothing would be left")


def without(cube: Cube, axis: int) -> Cube:
    """The cube of one dimension less."""
    return Cube(cube.origin[:axis] + cube.origin[axis + 1 :], cube.size)


def without_axis(tree: Tree, axis: int, keys: UInt64[np.ndarray, " _keys"]) -> UInt64[np.ndarray, " _keys"]:
    """Morton keys of one dimension less: the bits of an axis are left out."""
    k = tree.dimension
    found = np.zeros_like(keys)
    below = np.uint64(2 ** (k - 1 - axis) - 1)
    for level in range(tree.bits):
        digit = (keys >> np.uint64(k * level)) & np.uint64(2**k - 1)
        rest = ((digit >> np.uint64(k - axis)) << np.uint64(k - 1 - axis)) if axis else np.zeros_like(digit)
        found |= (rest | (digit & below)) << np.uint64((k - 1) * level)
    return found


def _node(tree: Tree, level: int, cell: Numbers) -> tuple[int, int, Cube]:
    """First and last key of a node, and its cube."""
    if not 0 <= level <= tree.bits:
        raise TreeError(f"level {level}: 0 to {tree.bits} are possible")
    if len(cell) != tree.dimension or any(not 0 <= x < 2**level or x != int(x) for x in cell):
        raise TreeError(
            f"node {tuple(cell)} of level {level}: {tree.dimension} integers, 0 to {2**level - 1}, are needed"
        )
    check_widths(tree.dimension, level)
    free = tree.depth - tree.dimension * level
    key = int(keys_of_cells(np.array([[int(x) for x in cell]], dtype=np.uint64), level)[0])
    edge = Fraction(tree.size) / 2**level
    origin = tuple(float(Fraction(x) + edge * int(n)) for x, n in zip(tree.origin, cell, strict=True))
    return key << free, (key + 1 << free) - 1, Cube(origin, float(edge))
