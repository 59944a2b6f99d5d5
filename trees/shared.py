"""The form for storage and for self-similar sets: the binary tree with equal subtrees kept once."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Integer, UInt8, UInt32, UInt64

from trees.bricks import Bricks, bricks_of
from trees.doors import whole
from trees.errors import TooManyPieces, TreeError

MAX_NODES = 2**28
MAX_DEPTH = 512
SOON = 2**20
WHITE, BLACK = 0, 1

Pair = tuple[UInt32[np.ndarray, " _nodes"], UInt32[np.ndarray, " _nodes"]]


@dataclass(frozen=True, eq=False)
class Shared:
    """Grey nodes 2, 3, ..., each after its children `lows[i - 2]` and `highs[i - 2]`; 0 is white, 1 black.

    The binary tree of Guye 1988, II.4, where no node has two white or two black children and no two
    nodes have the same children. A node stands for all the places, at any level, where its subtree
    appears. Nodes are numbered in post-order, low children first: a set has one form. The root is the
    last node, or a colour. `depth` is how many halvings lead to a cell, at most 512.
    """

    depth: int
    root: int
    lows: UInt32[np.ndarray, " nodes"]
    highs: UInt32[np.ndarray, " nodes"]

    def __post_init__(self):
        for name in ("lows", "highs"):
            array = np.asarray(getattr(self, name), dtype=np.uint32)
            if array.flags.writeable:
                array = array.copy()
                array.setflags(write=False)
            object.__setattr__(self, name, array)

    def __reduce__(self):
        return Shared, (self.depth, self.root, self.lows, self.highs)

    @property
    def nbytes(self) -> int:
        """The memory of the arrays."""
        return self.lows.nbytes + self.highs.nbytes

    @cached_property
    def count(self) -> int:
        """How many cells are black: one pass over the nodes."""
        from trees import sharing

        if self.depth <= 63:
            part = int(sharing.shares(self.lows, self.highs)[self.root])
            return part >> (63 - self.depth)
        parts = [0, 2**self.depth]
        for low, high in zip(self.lows.tolist(), self.highs.tolist(), strict=True):
            parts.append((parts[low] + parts[high]) // 2)
        return parts[self.root]

    def same(self, other: "Shared") -> bool:
        """Whether root and nodes are equal."""
        return (
            self.root == other.root
            and np.array_equal(self.lows, other.lows)
            and np.array_equal(self.highs, other.highs)
        )

    def levels(self) -> list[Integer[np.ndarray, " _nodes"]]:
        """The different grey nodes at each level, the root's first: a node may be in several of them."""
        nodes = np.array([self.root], dtype=np.int64)
        found = []
        while (nodes := nodes[nodes > BLACK]).size:
            found.append(nodes)
            nodes = np.unique(np.concatenate([self.lows[nodes - 2], self.highs[nodes - 2]])).astype(np.int64)
        return found


def check_depth(dimension: int, bits: int) -> None:
    """Raises `TreeError` where a cell is more than 512 halvings away."""
    if whole(dimension, "dimension") < 1 or whole(bits, "bits") < 0:
        raise TreeError(f"dimension {dimension} and {bits} bits an axis: at least 1 and 0 are needed")
    if dimension * bits > MAX_DEPTH:
        raise TreeError(
            f"{dimension} axes of {bits} bits are {dimension * bits} halvings, and {MAX_DEPTH} are possible: "
            f"ask for at most {MAX_DEPTH // dimension} bits an axis"
        )


def check_nodes(shared: Shared) -> None:
    """Raises `TreeError` where the nodes are not in canonical form: for arrays that come from outside."""
    lows, highs = shared.lows.astype(np.int64), shared.highs.astype(np.int64)
    places = np.arange(2, lows.size + 2)
    if lows.shape != highs.shape or lows.ndim != 1:
        raise TreeError("low and high children are needed in equal number")
    if shared.root != lows.size + 1 and not (lows.size == 0 and shared.root in (WHITE, BLACK)):
        raise TreeError(f"root {shared.root} of {lows.size} nodes: the last one, or a colour, is needed")
    late = (lows >= places) | (highs >= places)
    if late.any():
        raise TreeError(f"node {int(np.argmax(late)) + 2} is not after its children")
    if lows.size and _height(lows, highs) > shared.depth:
        raise TreeError(f"the nodes are more than {shared.depth} halvings deep")
    again = renumbered(shared.depth, shared.root, lows, highs)
    if not again.same(shared):
        raise TreeError("the nodes are not in post-order, or some are equal, of one colour or not used")


def _height(lows: Integer[np.ndarray, " nodes"], highs: Integer[np.ndarray, " nodes"]) -> int:
    heights = [0, 0]
    for low, high in zip(lows.tolist(), highs.tolist(), strict=True):
        heights.append(1 + max(heights[low], heights[high]))
    return heights[-1]


def renumbered(
    depth: int, root: int, lows: Integer[np.ndarray, " nodes"], highs: Integer[np.ndarray, " nodes"]
) -> Shared:
    """The canonical form of nodes given in any order that has children first."""
    from trees import sharing

    if len(lows) > MAX_NODES:
        raise TooManyPieces(len(lows), MAX_NODES)
    nodes, table = sharing.new_nodes(2 * len(lows) + 16)
    nodes, table, names = sharing.loaded(nodes, table, lows.astype(np.uint32), highs.astype(np.uint32))
    return _numbered(depth, nodes, int(names[root]))


def shared_of_bricks(bricks: Bricks) -> Shared:
    """The same set, shared. Raises `TooManyPieces` above 2^28 nodes."""
    from trees import sharing

    try:
        nodes, root = sharing.of_bricks(bricks.starts, bricks.words, np.uint64(bricks.number), bricks.depth)
    except OverflowError:
        raise TooManyPieces(MAX_NODES, MAX_NODES) from None
    return _numbered(bricks.depth, nodes, int(root))


def bricks_of_shared(shared: Shared, most: int = 2**28) -> Bricks:
    """The same set as bricks. Raises `TooManyPieces` above `most` entries, `TreeError` above 64 levels.

    A large set is counted on its nodes before it is expanded.
    """
    from trees import sharing
    from trees.node_counts import entry_count

    if shared.depth > 64:
        raise TreeError(f"bricks of a tree of {shared.depth} levels: at most 64 are possible")
    for limit in (min(most, SOON), most):
        try:
            return bricks_of(
                shared.depth,
                sharing.to_bricks(shared.lows, shared.highs, np.uint64(shared.root), shared.depth, limit),
            )
        except OverflowError:
            found = int(entry_count(shared)) if limit < most else limit
            if found > most or limit == most:
                raise TooManyPieces(found, most) from None
    raise AssertionError("the second attempt returns or raises")


def combine_shared(a: Shared, b: Shared, operation: int) -> Shared:
    """0 is or, 1 and, 2 exclusive or, 3 minus: one step for each pair of nodes that meet."""
    from trees import sharing

    nodes, table = sharing.new_nodes(2 * (len(a.lows) + len(b.lows)) + 16)
    nodes, table, of_a = sharing.loaded(nodes, table, a.lows, a.highs)
    nodes, table, of_b = sharing.loaded(nodes, table, b.lows, b.highs)
    try:
        nodes, _, root = sharing.combined(nodes, table, of_a[a.root], of_b[b.root], operation)
    except OverflowError:
        raise TooManyPieces(MAX_NODES, MAX_NODES) from None
    return _numbered(a.depth, nodes, int(root))


def shared_of_digits(digits: UInt8[np.ndarray, "cells depth"]) -> Shared:
    """The cells with these paths of halvings, 0 low and 1 high, in rising order and all different."""
    from trees import sharing

    nodes, root = sharing.of_digits(digits)
    return _numbered(digits.shape[1], nodes, int(root))


def deepened(shared: Shared, levels: int) -> Shared:
    """The same set, in cells halved `levels` times more: the nodes stay."""
    return Shared(shared.depth + levels, shared.root, shared.lows, shared.highs)


def truncated(shared: Shared, depth: int) -> Shared:
    """The upper envelope at fewer levels: grey nodes at level `depth` become black."""
    levels = shared.levels()
    if len(levels) <= depth:
        return Shared(depth, shared.root, shared.lows, shared.highs)
    lows, highs = [], []
    names = dict.fromkeys(levels[depth].tolist(), BLACK)
    made: dict[tuple[int, int], int] = {}
    for nodes in reversed(levels[:depth]):
        above: dict[int, int] = {}
        for node in nodes.tolist():
            children = int(shared.lows[node - 2]), int(shared.highs[node - 2])
            low, high = (child if child <= BLACK else names[child] for child in children)
            if low == high == BLACK:
                above[node] = BLACK
                continue
            if (low, high) not in made:
                made[low, high] = len(lows) + 2
                lows.append(low)
                highs.append(high)
            above[node] = made[low, high]
        names = above
    return renumbered(depth, names[shared.root], np.array(lows, np.int64), np.array(highs, np.int64))


def placed(shared: Shared, path: Sequence[int]) -> Shared:
    """The set as the branch at the end of a path of halvings, 0 low and 1 high, all else white."""
    depth = shared.depth + len(path)
    if shared.root == WHITE:
        return Shared(depth, WHITE, shared.lows, shared.highs)
    lows, highs, root = [], [], shared.root
    for side in reversed(path):
        lows.append(WHITE if side else root)
        highs.append(root if side else WHITE)
        root = len(shared.lows) + len(lows) + 1
    more = (np.array(extra, dtype=np.uint32) for extra in (lows, highs))
    joined = (np.concatenate(pair) for pair in zip((shared.lows, shared.highs), more, strict=True))
    return renumbered(depth, root, *joined)


def branch(shared: Shared, path: Sequence[int]) -> Shared:
    """The set within the branch at the end of a path of halvings."""
    node = shared.root
    for side in path:
        if node > BLACK:
            node = int((shared.highs if side else shared.lows)[node - 2])
    return renumbered(shared.depth - len(path), node, shared.lows, shared.highs)


def holds_cell(shared: Shared, cell: Sequence[int], bits: int) -> bool:
    """Whether one cell is black, its coordinates of any width."""
    node = shared.root
    for bit in range(bits - 1, -1, -1):
        for x in cell:
            if node <= BLACK:
                return node == BLACK
            node = int((shared.highs if x >> bit & 1 else shared.lows)[node - 2])
    return node == BLACK


def holds_cells(
    shared: Shared, cells: UInt64[np.ndarray, "cells dim"], bits: int
) -> Bool[np.ndarray, " cells"]:
    """Which cells, given by integer coordinates of so many bits, are black."""
    from trees import sharing

    return sharing.holds(shared.lows, shared.highs, np.uint64(shared.root), cells, bits)


def _numbered(depth: int, nodes: UInt64[np.ndarray, " _nodes"], root: int) -> Shared:
    from trees import sharing

    lows, highs = sharing.numbered(nodes, np.uint64(root))
    return Shared(depth, root if root <= BLACK else len(lows) + 1, lows, highs)
