"""Pairs of cells that share a face, counted on the nodes of a shared tree: two at a time, each pair once."""

from trees.shared import BLACK, WHITE, Shared


def touching_pairs_of_nodes(shared: Shared, dimension: int, axis: int) -> int:
    """How many pairs of black cells share a face across the axis.

    Within a node: those within its halves, and where it is halved along the axis, those between them.
    Between two boxes side by side along the axis: where they are halved across it, those between the
    low halves and between the high ones; where along it, those between the high half of the first and
    the low half of the second. Equal pairs at one level are counted once, so a self-similar set takes
    a few steps a level.
    """
    lows, highs = shared.lows.tolist(), shared.highs.tolist()
    depth = shared.depth
    across = [sum(level % dimension != axis for level in range(start, depth)) for start in range(depth + 1)]
    along = [depth // dimension - (start + dimension - 1 - axis) // dimension for start in range(depth + 1)]
    known: dict[tuple[int, int, int], int] = {}

    def halves(node: int) -> tuple[int, int]:
        return (node, node) if node <= BLACK else (lows[node - 2], highs[node - 2])

    def settled(a: int, b: int, level: int) -> int | None:
        if a == WHITE or b == WHITE:
            return 0
        return 2 ** across[level] if a == b == BLACK else None

    def within(node: int, level: int) -> int | None:
        if node <= BLACK:
            return node * 2 ** across[level] * (2 ** along[level] - 1)
        return None

    def parts(a: int, b: int, level: int) -> list[tuple[int, int, int]]:
        """The pairs of which a pair consists; `b` is -1 for what is within `a`."""
        (low, high), below = halves(a), level + 1
        if b < 0:
            inner = [(low, -1, below), (high, -1, below)]
            return [*inner, (low, high, below)] if level % dimension == axis else inner
        first, second = halves(b)
        if level % dimension == axis:
            return [(high, first, below)]
        return [(low, first, below), (high, second, below)]

    def value(a: int, b: int, level: int) -> int | None:
        found = within(a, level) if b < 0 else settled(a, b, level)
        return known.get((a, b, level)) if found is None else found

    stack = [(shared.root, -1, 0)]
    while stack:
        pair = stack[-1]
        if value(*pair) is not None:
            stack.pop()
            continue
        pieces = parts(*pair)
        values = [value(*piece) for piece in pieces]
        due = [piece for piece, found in zip(pieces, values, strict=True) if found is None]
        if due:
            stack.extend(due)
        else:
            known[pair] = sum(found for found in values if found is not None)
    total = value(shared.root, -1, 0)
    assert total is not None
    return total
