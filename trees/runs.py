"""Runs of black keys: the form from which bricks are made, and in which precision and cube change."""

from collections.abc import Iterator
from fractions import Fraction
from itertools import product

import numpy as np
from jaxtyping import UInt64

from trees.bricks import bricks_of, form_of_bricks
from trees.cube import Cube, steps_between
from trees.doors import whole
from trees.errors import Misaligned, TooManyPieces, TreeError
from trees.morton import cells_of_keys, check_widths, keys_of_cells
from trees.shared import Shared, branch, check_depth, combine_shared, deepened, placed, truncated
from trees.tree import Tree

MAX_RUNS = 2**28

Runs = tuple[UInt64[np.ndarray, " _runs"], UInt64[np.ndarray, " _runs"]]


def black_runs(tree: Tree) -> Runs:
    """First and last keys of the longest runs of black cells, in rising order.

    Raises `TooManyPieces` above 2^28 of them.

    >>> from trees import from_morton, unit_cube
    >>> low, high = black_runs(from_morton(np.array([3, 4, 9]), unit_cube(2), bits=2))
    >>> low.tolist(), high.tolist()
    ([3, 9], [4, 9])
    """
    from trees import kernels

    words, lengths = tree.words, tree.lengths
    pieces = np.bitwise_count(words & ~(words << np.uint64(1))).astype(np.uint64)
    repeats = np.where(words == np.uint64(2**64 - 1), np.uint64(1), lengths)
    room = float((pieces * repeats.astype(np.float64)).sum())
    if room > MAX_RUNS:
        raise TooManyPieces(int(room), MAX_RUNS)
    return kernels.unpack(tree.starts, words, np.uint64(tree.bricks), int(room))


def tree_of_runs(runs: Runs, cube: Cube, bits: int) -> Tree:
    """The tree of runs in rising order; a run may begin at the last key of the one before, or touch it."""
    from trees import kernels

    bits = whole(bits, "bits")
    check_widths(cube.dimension, bits)
    bricks = np.uint64(2 ** max(cube.dimension * bits - 6, 0))
    depth = cube.dimension * bits
    return Tree(cube, bits, form_of_bricks(bricks_of(depth, kernels.pack(*runs, bricks))))


def at_bits(tree: Tree, bits: int) -> Tree:
    """See `Tree.at`: the upper envelope at another precision (Guye 1988, III.4).

    >>> from trees import from_points
    >>> tree = from_points([[3, 0]], bits=2)
    >>> list(tree.at(1)), list(tree.at(3))
    ([(1, 0)], [(6, 0), (6, 1), (7, 0), (7, 1)])
    """
    bits = whole(bits, "bits")
    check_depth(tree.dimension, bits)
    if bits == tree.bits:
        return tree
    if isinstance(tree.form, Shared) or tree.dimension * bits > 64:
        return _shared_at(tree, bits)
    lows, highs = black_runs(tree)
    shift = tree.dimension * abs(bits - tree.bits)
    if shift == 64:
        every = np.full(min(len(lows), 1), 2**64 - 1, dtype=np.uint64)
        return tree_of_runs((every * np.uint64(0), every * np.uint64(bits > 0)), tree.cube, bits)
    if bits < tree.bits:
        runs = lows >> np.uint64(shift), highs >> np.uint64(shift)
    else:
        runs = lows << np.uint64(shift), (highs << np.uint64(shift)) | np.uint64(2**shift - 1)
    return tree_of_runs(runs, tree.cube, bits)


def _shared_at(tree: Tree, bits: int) -> Tree:
    shared, depth = tree.as_shared, tree.dimension * bits
    form = truncated(shared, depth) if bits < tree.bits else deepened(shared, depth - tree.depth)
    return Tree(tree.cube, bits, form)


def wide_runs(tree: Tree) -> Iterator[tuple[int, int]]:
    """First and last keys of the largest black blocks of the shared binary tree, in Morton order."""
    shared = tree.as_shared
    stack = [(shared.root, tree.depth, 0)]
    while stack:
        node, height, key = stack.pop()
        if node > 1:
            stack.append((int(shared.highs[node - 2]), height - 1, key + (1 << height - 1)))
            stack.append((int(shared.lows[node - 2]), height - 1, key))
        elif node == 1:
            yield key, key + (1 << height) - 1


def embed(tree: Tree, cube: Cube) -> Tree:
    """The same set with the same cells in a larger reference cube.

    Raises `Misaligned` where neither the tree nor its halves are branches of the larger tree, and
    `TreeError` where a cell would be more than 512 halvings away.

    >>> from trees import from_points
    >>> wide = embed(from_points([[1, 0]], bits=1), Cube((-1.0, 0.0), 2.0))
    >>> wide.bits, list(wide)
    (2, [(3, 0)])
    """
    if cube == tree.cube:
        return tree
    if cube.dimension != tree.dimension:
        raise TreeError(f"a cube of dimension {cube.dimension} for a tree of dimension {tree.dimension}")
    steps = steps_between(tree.cube, cube)
    if steps is None or steps > tree.bits:
        raise Misaligned(f"{tree.cube} and its halves are no branches of {cube}")
    bits = tree.bits + int(cube.size / tree.size).bit_length() - 1
    if isinstance(tree.form, Shared) or tree.dimension * bits > 64:
        return Tree(cube, bits, _shared_embedded(tree, cube, bits, steps))
    depth = tree.depth - steps * tree.dimension
    lows, highs = _cut(*black_runs(tree), depth)
    branches, which = np.unique(_shifted(lows, depth), return_inverse=True)
    corners = _branch_corners(tree, cube, branches, steps)
    bases = keys_of_cells(corners, bits)
    offsets = bases - (branches << np.uint64(depth) if depth < 64 else branches)
    lows, highs = lows + offsets[which], highs + offsets[which]
    order = np.argsort(lows)
    return tree_of_runs((lows[order], highs[order]), cube, bits)


def _shared_embedded(tree: Tree, cube: Cube, bits: int, steps: int) -> Shared:
    k, whole = tree.dimension, tree.as_shared
    cell = Fraction(tree.size) / 2**tree.bits
    offset = [int((Fraction(a) - Fraction(b)) / cell) for a, b in zip(tree.origin, cube.origin, strict=True)]
    check_depth(k, bits)
    result = None
    for sides in product((0, 1), repeat=k * steps):
        corner = [x + (side << tree.bits >> 1) for x, side in zip(offset, sides or (0,) * k, strict=True)]
        path = [x >> bit & 1 for bit in range(bits - 1, tree.bits - steps - 1, -1) for x in corner]
        part = placed(branch(whole, sides), path)
        result = part if result is None else combine_shared(result, part, 0)
    assert result is not None
    return result


def _shifted(keys: UInt64[np.ndarray, " _keys"], depth: int) -> UInt64[np.ndarray, " _keys"]:
    return keys >> np.uint64(depth) if depth < 64 else np.zeros_like(keys)


def _cut(lows: UInt64[np.ndarray, " _runs"], highs: UInt64[np.ndarray, " _runs"], depth: int) -> Runs:
    """The runs, cut where a branch of this depth ends."""
    first, last = _shifted(lows, depth), _shifted(highs, depth)
    extra = (last - first).astype(np.int64)
    if len(lows) + int(extra.sum()) > MAX_RUNS:
        raise TooManyPieces(len(lows) + int(extra.sum()), MAX_RUNS)
    run = np.repeat(np.arange(len(lows)), extra + 1)
    begin = np.cumsum(extra + 1) - (extra + 1)
    branch = first[run] + (np.arange(len(run)) - begin[run]).astype(np.uint64)
    if depth >= 64:
        return lows, highs
    low = np.maximum(lows[run], branch << np.uint64(depth))
    high = np.minimum(highs[run], (branch << np.uint64(depth)) | np.uint64(2**depth - 1))
    return low, high


def _branch_corners(
    tree: Tree, cube: Cube, branches: UInt64[np.ndarray, " branches"], steps: int
) -> UInt64[np.ndarray, "branches dim"]:
    """The low corners of the branches, in cells of the tree, counted from the corner of the cube."""
    cell = Fraction(tree.size) / 2**tree.bits
    offset = [int((Fraction(a) - Fraction(b)) / cell) for a, b in zip(tree.origin, cube.origin, strict=True)]
    if steps == 0:
        within = np.zeros((len(branches), tree.dimension), dtype=np.uint64)
    else:
        within = cells_of_keys(branches, tree.dimension, steps)
    return np.array(offset, dtype=np.uint64) + (within << np.uint64(tree.bits - steps) if steps else within)
