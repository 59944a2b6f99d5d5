"""Sets combined: or, and, exclusive or, minus, and the distance of two sets."""

from fractions import Fraction

import numpy as np
from jaxtyping import UInt64

from trees.bricks import Flat, bricks_of, flat_of_bricks, form_of_bricks, form_of_words
from trees.cube import common_cube, log2_ratio, steps_between
from trees.errors import TreeError
from trees.node_counts import entry_count
from trees.runs import embed
from trees.shared import Shared, combine_shared
from trees.tree import Tree

FEW = 2**20
FULL = 2**64 - 1
# Whether a cell stays that is in both sets, in the first alone, in the second alone.
STAYS = {"or": (1, 1, 1), "and": (1, 0, 0), "exclusive or": (0, 1, 1), "minus": (0, 1, 0)}


def combine(a: Tree, b: Tree, operation: str) -> Tree:
    """`a | b`, `a & b`, `a ^ b` or `a - b`: `operation` is "or", "and", "exclusive or" or "minus".

    The operands are first brought to one cube (`common_cube`) and to the finer of their cells, both
    exactly (Guye 1988, III.4 and III.5).

    Two shared trees give a shared one, two trees of bricks one of bricks.

    Raises `TreeError` where the dimensions differ, `Misaligned` where the cubes' grids do not meet.

    >>> from trees import from_points
    >>> combine(from_points([[0]], bits=1), from_points([[1], [2]], bits=2), "exclusive or")
    <Tree: dimension 1, 2 bits an axis, 2 cells, cube of 1.0 at (0.0,)>
    """
    from trees import kernels

    if operation not in STAYS:
        raise TreeError(f"operation {operation!r}: one of {', '.join(STAYS)} is needed")
    a, b = aligned(a, b)
    if _better_shared(a, b):
        return Tree(a.cube, a.bits, combine_shared(a.as_shared, b.as_shared, list(STAYS).index(operation)))
    both, first, second = (np.uint64(FULL if stays else 0) for stays in STAYS[operation])
    if isinstance(a.form, Flat) or isinstance(b.form, Flat):
        one, other = flat_words(a), flat_words(b)
        result = np.empty_like(one)  # NumPy's arrays stand on huge pages, those of kernels do not
        form = form_of_words(a.depth, result, kernels.merge_flat(one, other, both, first, second, result))
    else:
        starts, words = np.empty((2, len(a.words) + len(b.words)), dtype=np.uint64)
        count = kernels.merge(a.starts, a.words, b.starts, b.words, both, first, second, starts, words)
        form = form_of_bricks(bricks_of(a.depth, (starts[:count].copy(), words[:count].copy())))
    return Tree(a.cube, a.bits, form)


def aligned(a: Tree, b: Tree) -> tuple[Tree, Tree]:
    """The two sets, unchanged, on one cube with equal cells.

    >>> from trees import from_points
    >>> one, other = aligned(from_points([[0]], bits=1), from_points([[3]], bits=2))
    >>> one.bits == other.bits == 2, one.cube == other.cube
    (True, True)
    """
    for tree in (a, b):
        if not isinstance(tree, Tree):
            raise TreeError(f"a {type(tree).__name__} where a Tree is needed")
    if a.dimension != b.dimension:
        raise TreeError(f"trees of dimensions {a.dimension} and {b.dimension} cannot be combined")
    if a.cube == b.cube:
        bits = max(a.bits, b.bits)
        return a.at(bits), b.at(bits)
    cube = common_cube(a.cube, b.cube)
    cell = min(_needed_cell(tree, cube) for tree in (a, b))
    one, other = (_at_cell(tree, cell) for tree in (a, b))
    return embed(one, cube), embed(other, cube)


def distance(a: Tree, b: Tree) -> float:
    """The measure of the exclusive or, in mm^k: `d(A, B) = mu(A ^ B)` (Guye 1988, II.7).

    >>> from trees import from_points
    >>> distance(from_points([[0, 0]], bits=1), from_points([[0, 0], [1, 1]], bits=1))
    0.25
    """
    return combine(a, b, "exclusive or").measure


def flat_words(tree: Tree) -> UInt64[np.ndarray, " bricks"]:
    """The word of every brick."""
    return tree.form.words if isinstance(tree.form, Flat) else flat_of_bricks(tree.as_bricks).words


def _better_shared(a: Tree, b: Tree) -> bool:
    """Bricks where both are bricks, or where the shared one is soon expanded."""
    forms = a.form, b.form
    shared = [form for form in forms if isinstance(form, Shared)]
    if a.depth > 64 or len(shared) == 2:
        return True
    return any(entry_count(form) > FEW for form in shared)


def _needed_cell(tree: Tree, cube) -> Fraction:
    steps = steps_between(tree.cube, cube) or 0
    return Fraction(tree.size) / 2 ** max(tree.bits, steps)


def _at_cell(tree: Tree, cell: Fraction) -> Tree:
    bits = log2_ratio(Fraction(tree.size), cell)
    assert bits is not None
    return tree.at(bits)
