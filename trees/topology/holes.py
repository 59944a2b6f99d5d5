"""Holes: white components that do not reach the outside."""

from trees.topology.components import Components, at_border, components
from trees.topology.metrics import D1, dual_metric
from trees.tree import Tree


def holes(tree: Tree, metric: str = D1) -> Components:
    """The white components that black cells close in: holes of the plane, cavities of space, gaps of a line.

    White cells touch by the other metric than black ones: a closed curve of black cells then has an inside
    and an outside. All that lies beyond the reference cube is white. The labels are those of white cells, -1
    for black ones and for those of the outside.

    >>> from trees import from_points
    >>> ring = from_points([[0, 1], [1, 0], [1, 2], [2, 1]], bits=2)
    >>> len(holes(ring, "d-infinity")), len(holes(ring, "d1"))
    (1, 0)
    """
    white = components(~tree, dual_metric(metric))
    return white.kept(~at_border(white))


def fill_holes(tree: Tree, metric: str = D1) -> Tree:
    """The set together with its holes; see `holes`.

    >>> from trees import from_points
    >>> ring = from_points([[0, 1], [1, 0], [1, 2], [2, 1]], bits=2)
    >>> sorted(set(fill_holes(ring, "d-infinity")) - set(ring))
    [(1, 1)]
    """
    closed = holes(tree, metric)
    return tree | closed.tree_of(range(len(closed)))
