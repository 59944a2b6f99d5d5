"""What a shared tree would be, expanded: counts in one pass over nodes and levels, and black blocks."""

import numpy as np
from jaxtyping import Bool, Float, Integer, Shaped, UInt64

from trees.errors import TooManyPieces
from trees.shared import BLACK, Shared

Nodes = Integer[np.ndarray, " _nodes"]


def children(shared: Shared, nodes: Nodes) -> tuple[Nodes, Nodes]:
    """The low and the high children of grey nodes."""
    return shared.lows[nodes - 2].astype(np.int64), shared.highs[nodes - 2].astype(np.int64)


def looked_up(
    found: Nodes, known: Nodes, values: Shaped[np.ndarray, " _nodes"], colours: tuple[float, float]
) -> Shaped[np.ndarray, " _found"]:
    """The values of nodes: those of white and black, or of grey ones, which `known` lists in rising order."""
    result = np.where(found == BLACK, colours[1], colours[0]).astype(values.dtype)
    grey = found > BLACK
    result[grey] = values[np.searchsorted(known, found[grey])]
    return result


def entry_count(shared: Shared) -> float:
    """How many entries the set has as `Bricks`: exact up to 2^53. The depth is at most 64.

    A subtree has the entries of its halves, less one where the last word of the low half is the first word
    of the high one. Equal words are equal nodes.
    """
    top = shared.depth - 6
    if top <= 0 or shared.root <= BLACK:
        return 1.0
    levels = shared.levels()[: top + 1]
    known = levels[-1]
    counts, first, last = np.ones(len(known)), known, known
    begin = len(levels) - 2
    if len(levels) <= top:
        # No node is as deep as a brick: the deepest ones have colours below.
        known, begin = np.zeros(0, dtype=np.int64), len(levels) - 1
        counts, first, last = np.zeros(0), known, known
    for level in range(begin, -1, -1):
        low, high = children(shared, levels[level])
        tail, head = (looked_up(one, known, ends, (0, 1)) for one, ends in ((low, last), (high, first)))
        both = looked_up(low, known, counts, (1, 1)) + looked_up(high, known, counts, (1, 1))
        first, last = looked_up(low, known, first, (0, 1)), looked_up(high, known, last, (0, 1))
        counts, known = both - (tail == head), levels[level]
    return float(counts[0])


def block_count(shared: Shared, step: int) -> float:
    """How many largest black blocks of `2^(step n)` keys the set has: exact up to 2^53."""
    known: Nodes = np.zeros(0, dtype=np.int64)
    counts: Float[np.ndarray, " _nodes"] = np.zeros(0)
    levels = shared.levels()
    for level in range(len(levels) - 1, -1, -1):
        black = 2.0 ** (-(level + 1) % step)
        low, high = (looked_up(half, known, counts, (0, black)) for half in children(shared, levels[level]))
        counts, known = low + high, levels[level]
    return float(counts[0]) if levels else float(shared.root == BLACK)


def level_counts(shared: Shared) -> list[int]:
    """How many nodes of the binary tree meet the set, for each level from the root's to that of cells."""
    kind = np.uint64 if shared.depth <= 62 else object
    nodes, times = np.array([shared.root], dtype=np.int64), np.array([1], dtype=kind)
    black, found = 0, []
    for _ in range(shared.depth + 1):
        black = 2 * black + sum(times[nodes == BLACK].tolist())
        grey = nodes > BLACK
        nodes, times = nodes[grey], times[grey]
        found.append(black + int(times.sum()))
        if len(nodes):
            below, places = np.unique(np.concatenate(children(shared, nodes)), return_inverse=True)
            total = np.zeros(len(below), dtype=kind)
            np.add.at(total, places, np.concatenate([times, times]))
            nodes, times = below, total
    return found


def black_blocks(
    shared: Shared, step: int, most: int
) -> tuple[UInt64[np.ndarray, " _blocks"], UInt64[np.ndarray, " _blocks"]]:
    """First and last keys of the largest black blocks of `2^(step n)` keys, in rising order.

    The depth is at most 64. The blocks are counted before any is made: raises `TooManyPieces`.
    """
    count = block_count(shared, step)
    if count > most:
        raise TooManyPieces(int(count), most)
    firsts, widths = [], []
    nodes, keys = np.array([shared.root], dtype=np.int64), np.zeros(1, dtype=np.uint64)
    for level in range(shared.depth + 1):
        extra = -level % step
        free = shared.depth - level - extra
        black: Bool[np.ndarray, " _nodes"] = nodes == BLACK
        steps = np.arange(2**extra if black.any() else 0, dtype=np.uint64) << np.uint64(free & 63)
        firsts.append((keys[black][:, None] | steps[: 2**extra]).ravel())
        widths.append(np.full(len(firsts[-1]), 2**free - 1, dtype=np.uint64))
        grey = nodes > BLACK
        if level == shared.depth or not grey.any():
            break
        half = np.uint64(1 << shared.depth - level - 1)
        nodes, keys = np.concatenate(children(shared, nodes[grey])), keys[grey]
        keys = np.concatenate([keys, keys | half])
        live = nodes != 0
        nodes, keys = nodes[live], keys[live]
    first, width = np.concatenate(firsts), np.concatenate(widths)
    order = np.argsort(first)
    return first[order], (first | width)[order]
