"""Faces between black and white: how many on each axis, and their area."""

from trees.shared import Shared
from trees.topology.entries import black_entries
from trees.topology.layout import layout
from trees.topology.node_faces import touching_pairs_of_nodes
from trees.tree import Tree

FEW = 2**14


def touching_pairs(tree: Tree) -> tuple[int, ...]:
    """For each axis, how many pairs of black cells share a face across it.

    >>> from trees import empty, unit_cube
    >>> touching_pairs(~empty(unit_cube(2), bits=1))
    (2, 2)
    """
    from trees.topology import tuple_kernels

    if isinstance(tree.form, Shared) and (tree.depth > 64 or len(tree.form.lows) <= FEW):
        k = tree.dimension
        return tuple(touching_pairs_of_nodes(tree.form, k, axis) for axis in range(k))
    entries = black_entries(tree)
    top, low = max(tree.depth - 6, 0), min(tree.depth, 6)
    counts = tuple_kernels.across_faces(*entries, top, low, layout(tree))
    return tuple(sum(n << m for m, n in enumerate(row)) for row in counts.tolist())


def face_counts(tree: Tree) -> tuple[int, ...]:
    """For each axis, how many faces of cells across it lie between black and white, exactly.

    A black cell has two faces across an axis, and a pair of black cells that touch hides two: the count is
    `2 (cells - pairs)`. The pairs are counted on nodes, two at a time, so that no region of equal words is
    expanded. What lies beyond the reference cube is white.

    >>> from trees import from_points
    >>> face_counts(from_points([[0, 0, 0], [0, 0, 1]], bits=1))
    (4, 4, 2)
    """
    return tuple(2 * (tree.count - pairs) for pairs in touching_pairs(tree))


def surface_area(tree: Tree) -> float:
    """The measure of the boundary of the union of the black cells, in mm^(k-1): an area for k = 3.

    It is that of the cells' faces, and not of a smooth surface which they may stand for: that of a ball of
    radius r comes to about `6 pi r^2`, one and a half times its area. On the line it is the number of ends.

    >>> from trees import empty, unit_cube
    >>> surface_area(~empty(unit_cube(3), bits=5))
    6.0
    """
    return sum(face_counts(tree)) * tree.cell_size ** (tree.dimension - 1)
