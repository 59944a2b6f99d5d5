"""Exact maps of the lattice of cells: shifts, powers of two, mirrors, exchanges of axes."""

from collections.abc import Sequence
from fractions import Fraction

import numpy as np
from jaxtyping import Integer, UInt64

from trees.cube import Cube, common_cube
from trees.doors import whole, wholes
from trees.errors import Misaligned, TooManyPieces, TreeError
from trees.geometry.pyramid import pyramid
from trees.leaves import leaf_runs
from trees.morton import cells_of_keys, check_widths
from trees.node_maps import mirrored, permuted
from trees.runs import MAX_RUNS, black_runs, embed, tree_of_runs
from trees.shared import Shared, branch, check_depth, placed
from trees.tree import Tree, empty

MOST_BITS = 62

Numbers = Sequence[int] | Integer[np.ndarray, " _numbers"]


def translate(tree: Tree, vector: Numbers, grow: bool = False) -> Tree:
    """The set shifted by whole cells, one number an axis.

    What leaves the cube is dropped; with `grow` the cube becomes the `common_cube` of itself and the cubes
    of its size, on its grid, that the shifted set reaches, and nothing is lost.

    Raises `TreeError` where the vector is not of `dimension` integers, or above 62 bits an axis; with `grow`
    also `KeyTooWide`, and `Misaligned` where the larger cube has corners that are no floats.

    >>> from trees import from_points
    >>> tree = from_points([[2, 0], [3, 0]], bits=2)
    >>> list(translate(tree, [1, 2])), translate(tree, [1, 2], grow=True)
    ([(3, 2)], <Tree: dimension 2, 3 bits an axis, 2 cells, cube of 2.0 at (0.0, 0.0)>)
    """
    from trees.geometry import kernels

    shift = wholes(vector, "vector", tree.dimension)
    if tree.bits > MOST_BITS:
        raise TreeError(f"{tree.bits} bits an axis: shifts are made up to {MOST_BITS}")
    if not tree or not any(shift):
        return tree
    if grow:
        tree = embed(tree, _reached(tree, shift))
    if tree.bits > MOST_BITS:
        raise TreeError(f"{tree.bits} bits an axis: shifts are made up to {MOST_BITS}")
    if max(map(abs, shift)) >= 2**tree.bits:
        return empty(tree.cube, tree.bits)
    lows, highs = kernels.shifted(
        pyramid(tree), pyramid(~tree), -np.array(shift, dtype=np.int64), tree.dimension, tree.bits, MAX_RUNS
    )
    if len(lows) > MAX_RUNS:
        raise TooManyPieces(len(lows), MAX_RUNS)
    return tree_of_runs((lows, highs), tree.cube, tree.bits)


def scale(tree: Tree, power: int, grow: bool = False) -> Tree:
    """The set scaled by `2^power` about the low corner of the cube: the cells grow or shrink with it.

    The cube stays: what leaves it is dropped, and there are `bits - power` bits an axis. With `grow` the
    cube is scaled too, and the bits stay.

    Raises `TreeError` where `power` is above `bits`, and where the bits become too many: `KeyTooWide`
    unless the tree is shared.

    >>> from trees import from_points
    >>> tree = from_points([[1, 0], [3, 3]], bits=2)
    >>> list(scale(tree, 1)), list(scale(tree, -1))
    ([(1, 0)], [(1, 0), (3, 3)])
    >>> scale(tree, 3, grow=True).measure == 64 * tree.measure
    True
    """
    power = whole(power, "power")
    if grow:
        if abs(power) > 800:
            raise TreeError(f"a scale of 2^{power}: at most 2^800 is possible")
        return Tree(Cube(tree.origin, tree.size * 2.0**power), tree.bits, tree.form)
    if power > tree.bits:
        raise TreeError(
            f"a scale of 2^{power} for cells of size / 2^{tree.bits}: one would be wider than the cube"
        )
    if isinstance(tree.form, Shared):
        check_depth(tree.dimension, tree.bits - power)
        path = [0] * (tree.dimension * abs(power))
        return Tree(tree.cube, tree.bits - power, (branch if power > 0 else placed)(tree.form, path))
    check_widths(tree.dimension, tree.bits - power)
    lows, highs = black_runs(tree)
    if power > 0:
        last = np.uint64(2 ** (tree.depth - tree.dimension * power) - 1)
        lows, highs = lows[lows <= last], np.minimum(highs[lows <= last], last)
    return tree_of_runs((lows, highs), tree.cube, tree.bits - power)


def reflect(tree: Tree, axes: Numbers) -> Tree:
    """The mirror image about the middle of the cube, along each of these axes.

    >>> from trees import from_points
    >>> list(reflect(from_points([[0, 1]], bits=2), [0]))
    [(3, 1)]
    """
    axes = _axes(tree, axes)
    if len(set(axes)) < len(axes):
        raise TreeError(f"axes {axes}: each is reflected once")
    if isinstance(tree.form, Shared):
        form = mirrored(tree.form, lambda level: level % tree.dimension in axes)
        return Tree(tree.cube, tree.bits, form)
    mirror = sum(1 << (tree.dimension - 1 - axis) for axis in axes)
    flip = np.uint64(sum(mirror << (tree.dimension * level) for level in range(tree.bits)))
    first, last = leaf_runs(tree, tree.dimension)
    free = last - first
    return _of_blocks((first ^ flip) & ~free, free, tree.cube, tree.bits)


def permute(tree: Tree, axes: Numbers) -> Tree:
    """The set with its axes in another order: axis i of the result is axis `axes[i]` of the tree.

    That is `transpose(axes)` of the array; the origin of the cube changes along.

    >>> from trees import from_points
    >>> list(permute(from_points([[3, 1, 0]], bits=2), [2, 0, 1]))
    [(0, 3, 1)]
    """
    axes = _axes(tree, axes)
    if sorted(axes) != list(range(tree.dimension)):
        raise TreeError(f"axes {axes}: each of 0 to {tree.dimension - 1} is needed once")
    k = tree.dimension
    cube = Cube(tuple(tree.origin[axis] for axis in axes), tree.size)
    if isinstance(tree.form, Shared):
        return Tree(cube, tree.bits, permuted(tree.form, axes))
    first, last = leaf_runs(tree, k)
    moved = np.zeros_like(first)
    every = sum(1 << (k * level) for level in range(tree.bits))
    for axis, source in enumerate(axes):
        bits = (first >> np.uint64(k - 1 - source)) & np.uint64(every)
        moved |= bits << np.uint64(k - 1 - axis)
    return _of_blocks(moved, last - first, cube, tree.bits)


def quarter_turn(tree: Tree, first: int, second: int) -> Tree:
    """The rotation by 90 degrees about the middle of the cube that takes axis `first` to axis `second`.

    >>> from trees import from_points
    >>> list(quarter_turn(from_points([[3, 1]], bits=2), 0, 1))
    [(2, 3)]
    """
    one, other = _axis(tree, first), _axis(tree, second)
    if one == other:
        raise TreeError(f"axes {first} and {second}: a turn needs two axes")
    axes = list(range(tree.dimension))
    axes[one], axes[other] = other, one
    turned = reflect(permute(tree, axes), [one])
    return Tree(tree.cube, tree.bits, turned.form)


def _of_blocks(
    first: UInt64[np.ndarray, " blocks"], free: UInt64[np.ndarray, " blocks"], cube: Cube, bits: int
) -> Tree:
    """The tree of blocks, apart from each other, in any order."""
    order = np.argsort(first)
    first, free = first[order], free[order]
    return tree_of_runs((first, first | free), cube, bits)


def _axes(tree: Tree, axes: Numbers) -> list[int]:
    return [_axis(tree, axis) for axis in wholes(axes, "axes")]


def _axis(tree: Tree, axis: int) -> int:
    number = whole(axis, "axis")
    if not 0 <= number < tree.dimension:
        raise TreeError(f"axis {axis}: 0 to {tree.dimension - 1} are possible")
    return number


def _reached(tree: Tree, shift: list[int]) -> Cube:
    """The common cube of a tree's cube and those beside it that hold the shifted set."""
    first, last = leaf_runs(tree, tree.dimension)
    low = cells_of_keys(first, tree.dimension, tree.bits).min(0).tolist()
    high = cells_of_keys(last, tree.dimension, tree.bits).max(0).tolist()
    size, cube = Fraction(tree.size), tree.cube
    for corner in (low, high):
        exact = [
            Fraction(start) + size * ((x + step) >> tree.bits)
            for start, x, step in zip(tree.origin, corner, shift, strict=True)
        ]
        tile = Cube(tuple(float(x) for x in exact), tree.size)
        if [Fraction(x) for x in tile.origin] != exact:
            raise Misaligned(f"the cube beside {tree.cube} has a corner, {tile.origin}, that is no float")
        cube = common_cube(cube, tile)
    return cube
