"""Parts of a tree: sections across an axis, and branches taken out or put in."""

from fractions import Fraction

import numpy as np
from jaxtyping import UInt64

from trees.cube import Cube
from trees.doors import whole, wholes
from trees.errors import TreeError
from trees.geometry.lattice import Numbers, translate
from trees.leaves import leaf_runs
from trees.morton import cells_of_keys, keys_of_cells
from trees.node_maps import inserted
from trees.runs import black_runs, tree_of_runs
from trees.shared import Shared
from trees.shared import branch as branch_of
from trees.tree import Tree


def section(tree: Tree, axis: int, index: int) -> Tree:
    """The cells whose coordinate on an axis is `index`, as a tree of one dimension less.

    >>> from trees import from_points
    >>> list(section(from_points([[0, 1, 2], [3, 1, 3]], bits=2), axis=1, index=1))
    [(0, 2), (3, 3)]
    """
    axis, index = check_flat(tree, axis), whole(index, "index")
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
    level, numbers, cube = _node(tree, level, cell)
    if isinstance(tree.form, Shared):
        return Tree(cube, tree.bits - level, branch_of(tree.form, path_of(numbers, level)))
    first, last = _keys(tree, level, numbers)
    lows, highs = black_runs(tree)
    meets = (lows <= np.uint64(last)) & (highs >= np.uint64(first))
    lows = np.maximum(lows[meets], np.uint64(first)) - np.uint64(first)
    highs = np.minimum(highs[meets], np.uint64(last)) - np.uint64(first)
    return tree_of_runs((lows, highs), cube, tree.bits - level)


def insert(tree: Tree, part: Tree, level: int, cell: Numbers) -> Tree:
    """The tree with the node of this level and these coordinates replaced by `part`.

    The cube of `part` does not matter; where its cells are finer than those of the tree, the tree is
    refined to them, and where coarser, the part is. Where one of the two is shared, the result is.

    >>> from trees import from_points
    >>> tree = insert(from_points([[3, 0], [0, 3]], bits=2), from_points([[0, 0]], bits=1), 1, [1, 0])
    >>> list(tree)
    [(0, 3), (2, 0)]
    """
    if part.dimension != tree.dimension:
        raise TreeError(f"a part of dimension {part.dimension} for a tree of dimension {tree.dimension}")
    level, numbers, _ = _node(tree, level, cell)
    bits = max(tree.bits, part.bits + level)
    tree, part = tree.at(bits), part.at(bits - level)
    if isinstance(tree.form, Shared) or isinstance(part.form, Shared):
        form = inserted(tree.as_shared, part.as_shared, path_of(numbers, level))
        return Tree(tree.cube, bits, form)
    first, last = _keys(tree, level, numbers)
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
    """The `2^bits` cells an axis, `bits` at most those of the tree, from the cell `corner` on.

    It need not be a node, and may reach beyond the cube, where all is white: coordinates of the corner may be
    negative. The cube of the result stands where the window does, its corner rounded to floats.

    Raises `TreeError` where the corner is not of `dimension` integers, where `bits` is not from 0 to those of
    the tree, or where the tree has more than 62; `KeyTooWide` for a tree of more than 64 levels.

    >>> from trees import from_points
    >>> list(window(from_points([[1, 1], [2, 2]], bits=2), corner=[1, 1], bits=1))
    [(0, 0), (1, 1)]
    """
    bits, numbers = whole(bits, "bits"), wholes(corner, "corner", tree.dimension)
    if not 0 <= bits <= tree.bits:
        raise TreeError(f"a window of {bits} bits an axis in a tree of {tree.bits}")
    moved = branch(translate(tree, [-x for x in numbers]), tree.bits - bits, [0] * tree.dimension)
    cell = Fraction(tree.size) / 2**tree.bits
    origin = tuple(float(Fraction(x) + cell * n) for x, n in zip(tree.origin, numbers, strict=True))
    return Tree(Cube(origin, moved.size), bits, moved.form)


def check_flat(tree: Tree, axis: int) -> int:
    """The axis. Raises `TreeError` where the tree has no such axis, or no other."""
    axis = whole(axis, "axis")
    if not 0 <= axis < tree.dimension:
        raise TreeError(f"axis {axis}: 0 to {tree.dimension - 1} are possible")
    if tree.dimension == 1:
        raise TreeError("a tree of dimension 1: without its axis nothing would be left")
    return axis


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


def path_of(cell: list[int], level: int) -> list[int]:
    """The halvings, 0 low and 1 high, that lead to a node.

    >>> path_of([1, 2], 2)
    [0, 1, 1, 0]
    """
    return [x >> bit & 1 for bit in range(level - 1, -1, -1) for x in cell]


def _node(tree: Tree, level: int, cell: Numbers) -> tuple[int, list[int], Cube]:
    """Level and coordinates of a node, and its cube."""
    level, numbers = whole(level, "level"), wholes(cell, "cell")
    if not 0 <= level <= tree.bits:
        raise TreeError(f"level {level}: 0 to {tree.bits} are possible")
    if len(numbers) != tree.dimension or any(not 0 <= x < 2**level for x in numbers):
        raise TreeError(
            f"node {tuple(numbers)} of level {level}: {tree.dimension} integers, 0 to {2**level - 1}, are "
            "needed"
        )
    edge = Fraction(tree.size) / 2**level
    origin = tuple(float(Fraction(x) + edge * n) for x, n in zip(tree.origin, numbers, strict=True))
    return level, numbers, Cube(origin, float(edge))


def _keys(tree: Tree, level: int, cell: list[int]) -> tuple[int, int]:
    """The first and the last key of a node."""
    free = tree.depth - tree.dimension * level
    key = int(keys_of_cells(np.array([cell], dtype=np.uint64), level)[0])
    return key << free, (key + 1 << free) - 1
