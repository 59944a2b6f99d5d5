"""The Euler characteristic and the Betti numbers of a set of cells."""

from trees.errors import TreeError
from trees.topology.components import components
from trees.topology.entries import black_entries
from trees.topology.holes import holes
from trees.topology.layout import layout
from trees.topology.metrics import D1, is_box
from trees.tree import Tree

LARGEST_DIMENSION = 8


def euler_characteristic(tree: Tree, metric: str = D1) -> int:
    """`chi = n_0 - n_1 + n_2 - ...`, where `n_j` counts the cells of dimension j of a cubical complex.

    For d-infinity the complex is the union of the closed black cells, with all their faces. For d1 it is its
    dual: black cells are vertices, two that share a face span an edge, `2^j` around a face of dimension
    `k - j` a cube of dimension j. Components of the complex are then components for the metric. The sums are
    taken on words, and a region of equal words, of any size, is one term: inside a black box they are 1 for
    d1.

    Raises `TreeError` above 8 dimensions, where the `3^k` pairs of faces and cells get out of hand.

    >>> from trees import from_points
    >>> ring = from_points([[0, 1], [1, 0], [1, 2], [2, 1]], bits=2)
    >>> euler_characteristic(ring, "d-infinity"), euler_characteristic(ring, "d1")
    (0, 4)
    """
    from trees.topology import tuple_kernels

    box = is_box(metric)
    if tree.dimension > LARGEST_DIMENSION:
        raise TreeError(f"dimension {tree.dimension}: at most {LARGEST_DIMENSION} is possible")
    top, low = max(tree.depth - 6, 0), min(tree.depth, 6)
    return int(tuple_kernels.alternating(*black_entries(tree), top, low, box, layout(tree)))


def betti_numbers(tree: Tree, metric: str = D1) -> tuple[int, ...]:
    """Components, then (for k = 3) tunnels, then, from k = 2 on, holes: k numbers, for k = 1 to 3.

    Of a body in space, `chi = b_0 - b_1 + b_2`; `b_1` is the sum of the genera of the surfaces around it
    where these are free of singular edges. Holes are white components of the other metric (Alexander
    duality), and `b_1` is what remains.

    Raises `TreeError` above three dimensions, where chi does not tell the rest.

    >>> from trees import from_points
    >>> ring = from_points([[0, 1, 0], [1, 0, 0], [1, 2, 0], [2, 1, 0]], bits=2)
    >>> betti_numbers(ring, "d-infinity")
    (1, 1, 0)
    """
    if tree.dimension > 3:
        raise TreeError(f"dimension {tree.dimension}: Betti numbers are known up to 3")
    parts = len(components(tree, metric))
    if tree.dimension == 1:
        return (parts,)
    closed = len(holes(tree, metric))
    if tree.dimension == 2:
        return parts, closed
    return parts, parts + closed - euler_characteristic(tree, metric), closed
