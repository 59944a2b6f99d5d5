"""Maps of shared trees, on nodes: each node is mapped once for each level at which it appears."""

from collections.abc import Callable, Sequence

import numpy as np
from jaxtyping import Integer

from trees.errors import TooManyPieces
from trees.node_counts import children, looked_up
from trees.shared import BLACK, MAX_NODES, Shared, renumbered

Nodes = Integer[np.ndarray, "..."]


def mirrored(shared: Shared, swaps: Callable[[int], bool]) -> Shared:
    """The set with low and high halves exchanged at the levels for which `swaps` says so."""
    levels = shared.levels()
    if not levels:
        return shared
    made = _Made(sum(map(len, levels)))
    known = names = np.zeros(0, dtype=np.int64)
    for level in range(len(levels) - 1, -1, -1):
        low, high = (looked_up(one, known, names, (0, 1)) for one in children(shared, levels[level]))
        known, names = levels[level], made.nodes(*((high, low) if swaps(level) else (low, high)))
    return made.shared(shared.depth, int(names[0]))


def permuted(shared: Shared, axes: Sequence[int]) -> Shared:
    """The set with its axes in another order: axis i of the result is axis `axes[i]`."""
    k = len(axes)
    levels = shared.levels()[::k]
    room = sum(map(len, levels)) << k
    if room > MAX_NODES:
        raise TooManyPieces(room, MAX_NODES)
    if not levels:
        return shared
    made = _Made(room)
    order = np.arange(2**k).reshape((2,) * k).transpose(axes).ravel()
    known = names = np.zeros(0, dtype=np.int64)
    for nodes in reversed(levels):
        below = nodes[:, None]
        for _ in range(k):
            below = _halves(shared, below)
        parts = looked_up(below.ravel(), known, names, (0, 1)).reshape(below.shape)[:, order]
        while parts.shape[1] > 1:
            parts = made.nodes(parts[:, ::2].ravel(), parts[:, 1::2].ravel()).reshape(len(nodes), -1)
        known, names = nodes, parts[:, 0]
    return made.shared(shared.depth, int(names[0]))


def inserted(shared: Shared, part: Shared, path: Sequence[int]) -> Shared:
    """The set with the branch at the end of a path of halvings, 0 low and 1 high, replaced."""
    held, node = len(shared.lows), shared.root
    halves, beside = (shared.lows, shared.highs), []
    for side in path:
        low, high = (node, node) if node <= BLACK else (int(half[node - 2]) for half in halves)
        beside.append(low if side else high)
        node = high if side else low
    moved = (np.where(nodes > BLACK, nodes + np.uint32(held), nodes) for nodes in (part.lows, part.highs))
    lows, highs = (np.concatenate(pair) for pair in zip((shared.lows, shared.highs), moved, strict=True))
    root = part.root if part.root <= BLACK else part.root + held
    more: list[tuple[int, int]] = []
    for side, other in zip(reversed(path), reversed(beside), strict=True):
        more.append((other, root) if side else (root, other))
        root = len(lows) + len(more) + 1
    pairs = np.array(more, dtype=np.int64).reshape(-1, 2)
    return renumbered(
        shared.depth, root, np.concatenate([lows, pairs[:, 0]]), np.concatenate([highs, pairs[:, 1]])
    )


def _halves(shared: Shared, nodes: Nodes) -> Nodes:
    """The children of nodes of any colour, two for each, along the last axis."""
    both = np.stack([nodes, nodes], axis=-1)
    grey = nodes > BLACK
    both[grey] = np.stack(children(shared, nodes[grey]), axis=-1)
    return both.reshape(len(nodes), -1)


class _Made:
    """New nodes, in an order that has children first; those alike become one in the end."""

    def __init__(self, room: int):
        if room > MAX_NODES:
            raise TooManyPieces(room, MAX_NODES)
        self.lows: list[Nodes] = []
        self.highs: list[Nodes] = []
        self.count = 0

    def nodes(self, lows: Nodes, highs: Nodes) -> Nodes:
        """The numbers of nodes with these children."""
        self.lows.append(lows)
        self.highs.append(highs)
        self.count += len(lows)
        return np.arange(self.count - len(lows), self.count) + 2

    def shared(self, depth: int, root: int) -> Shared:
        return renumbered(depth, root, np.concatenate(self.lows), np.concatenate(self.highs))
