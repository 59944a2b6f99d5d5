"""Triangles that pass through each other."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from export.checks.adjacency import Edges
from export.checks.triangle_tree import TriangleTree

WORK = 20_000_000_000  # boxes looked at, where an exact test counts as 32
KEPT = 10_000  # pairs that are named
CHUNK = 100_000  # nodes between two moments at which it can be interrupted


@dataclass(frozen=True, eq=False)
class Crossings:
    """`count` pairs of triangles that meet where they should not; the first ones are named.

    `complete` is False where the search was given up: `count` is then what had been found.
    """

    count: int
    pairs: Int[np.ndarray, "pairs 2"]
    complete: bool


def crossings(tree: TriangleTree, work: int = WORK) -> Crossings:
    """The pairs of triangles that have more in common than their common corners and edges.

    Corners at equal positions are the same corner here, whatever their numbers: sheets that touch
    along edges of both are left to `crossed_edges`. Two triangles at the same place are a pair, unless
    they have the same vertices; triangles without area are in no pair. The answer is exact for the
    coordinates as they stand (see `TriangleTree`): signs of determinants are never guessed
    (`export.checks.predicates`).

    >>> from export.checks.triangle_tree import triangle_tree
    >>> points = np.array([[0.0, 0, 0], [2, 0, 0], [0, 2, 0], [0.5, 0.5, -1], [0.5, 0.5, 1], [3, 3, 0]])
    >>> crossings(triangle_tree(points, np.array([[0, 1, 2], [3, 4, 5]]))).pairs.tolist()
    [[0, 1]]
    """
    from export.checks.boxes import crossing_pairs

    found = np.empty((KEPT, 2), dtype=np.int64)
    count, budget, start = 0, work, 0
    while start < len(tree.skips) and budget >= 0:
        end = min(start + CHUNK, len(tree.skips))
        count, budget = crossing_pairs(*tree.parts, start, end, found, count, budget)
        start = end
    pairs = np.sort(tree.order[found[: min(count, KEPT)]], axis=1)
    return Crossings(int(count), pairs[np.lexsort(pairs.T[::-1])], budget >= 0)


def meeting_places(
    corners: Float[np.ndarray, "t 3 3"], pairs: Int[np.ndarray, "pairs 2"]
) -> Float[np.ndarray, "pairs 3"]:
    """The middle of what the boxes of the two triangles of each pair have in common (mm)."""
    low = corners[pairs].min(axis=2).max(axis=1)
    high = corners[pairs].max(axis=2).min(axis=1)
    return (low + high) / 2


def crossed_edges(
    tree: TriangleTree, triangles: Int[np.ndarray, "t 3"], edges: Edges, same: Int[np.ndarray, "vertices"]
) -> Int[np.ndarray, "pairs 2"]:
    """Pairs of triangles of two sheets that pass through each other just along an edge of both.

    Such sheets have edges of their own at the same place: `same` names for each vertex the first one at its
    position. They cross where the triangles of one lie on both sides of the other, around the edge; that
    is decided exactly. Where more than two edges lie together, each is compared with the next
    one in the order of their vertices. One triangle of each sheet is named.

    Around the edge from p to q, `side(p, q, x, y)` is the sign of the angle from x to y.
    """
    from export.checks.predicates import sides

    sound = np.flatnonzero((edges.counts == 2) & (same[edges.ends] != edges.ends).any(axis=1))
    sound = _at_their_places(edges, same, sound)
    ends = np.sort(same[edges.ends[sound]], axis=1)
    order = np.lexsort((sound, ends[:, 1], ends[:, 0]))
    twin = (ends[order[1:]] == ends[order[:-1]]).all(axis=1)
    one, other = sound[order[:-1][twin]], sound[order[1:][twin]]
    p, q = np.sort(same[edges.ends[one]], axis=1).T

    def apex(chosen: np.ndarray, k: int) -> np.ndarray:
        half = edges.order[edges.starts[chosen] + k]
        return triangles[half // 3, (half % 3 + 2) % 3]

    def around(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return sides(*(np.ascontiguousarray(tree.points[v]) for v in (p, q, x, y)))

    a, b = apex(one, 0), apex(one, 1)
    wide = around(a, b)

    def within(x: np.ndarray) -> Bool[np.ndarray, "pairs"]:
        """Whether x lies inside the angle from a to b, turning the way of positive signs."""
        after, before = around(a, x), around(x, b)
        narrow = (after > 0) & (before > 0)
        broad = (after > 0) | (before > 0)
        return np.where(wide > 0, narrow, np.where(wide < 0, broad, after > 0))

    cross = within(apex(other, 0)) != within(apex(other, 1))
    halves = np.column_stack([edges.order[edges.starts[one]], edges.order[edges.starts[other]]])
    return halves[cross] // 3


def _at_their_places(edges: Edges, same: np.ndarray, moved: np.ndarray) -> Int[np.ndarray, "edges"]:
    """With the edges that have a vertex at the place of an earlier one, those that lie where these do."""
    if not len(moved):
        return moved
    size = len(same)
    ends = np.sort(same[edges.ends], axis=1)
    keys = ends[:, 0] * size + ends[:, 1]
    return np.flatnonzero((edges.counts == 2) & np.isin(keys, np.unique(keys[moved])))
