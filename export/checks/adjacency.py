"""How the triangles of a mesh hang together: edges, fans around vertices, shells."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy import sparse
from scipy.sparse import csgraph


@dataclass(frozen=True, eq=False)
class Edges:
    """Half-edges (row `3 t + s` goes from corner s of triangle t to the next), edge by edge.

    `order` sorts half-edges so that those of one edge follow each other, `starts` is where each
    edge begins in it, `ends` its two vertices, and the masks say which edges are faulty.
    """

    order: Int[np.ndarray, "halves"]
    starts: Int[np.ndarray, "edges"]
    counts: Int[np.ndarray, "edges"]
    ends: Int[np.ndarray, "edges 2"]
    forward: Bool[np.ndarray, "halves"]
    open: Bool[np.ndarray, "edges"]
    crowded: Bool[np.ndarray, "edges"]
    bent: Bool[np.ndarray, "edges"]

    def middles(
        self, points: Float[np.ndarray, "vertices 3"], chosen: Bool[np.ndarray, "edges"]
    ) -> Float[np.ndarray, "chosen 3"]:
        return points[self.ends[chosen]].mean(axis=1)

    def neighbours(self) -> tuple[Int[np.ndarray, "pairs"], Int[np.ndarray, "pairs"]]:
        """Half-edges that follow each other on the same edge."""
        same = np.ones(len(self.order), dtype=bool)
        same[self.starts] = False
        here = np.flatnonzero(same)
        return self.order[here - 1], self.order[here]


def find_edges(triangles: Int[np.ndarray, "t 3"], size: int) -> Edges:
    """The half-edges of triangles on `size` vertices."""
    start, end = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
    low, high = np.minimum(start, end), np.maximum(start, end)
    keys = low * size + high
    order = np.argsort(keys, kind="stable")
    keys = keys[order]
    starts = np.flatnonzero(np.concatenate([[True], keys[1:] != keys[:-1]]))
    counts = np.diff(np.append(starts, len(keys)))
    forward = (start < end)[order]
    ahead = np.add.reduceat(forward.astype(np.int64), starts)
    ends = np.column_stack([keys[starts] // size, keys[starts] % size])
    return Edges(
        order, starts, counts, ends, forward,
        open=counts == 1, crowded=counts > 2, bent=(counts == 2) & (ahead != 1),
    )  # fmt: skip


def find_fans(
    triangles: Int[np.ndarray, "t 3"], edges: Edges
) -> tuple[Int[np.ndarray, "corners"], Int[np.ndarray, "fans"]]:
    """The fan of each corner of each triangle, and the vertex of each fan.

    Corners at one vertex belong to one fan when their triangles share an edge there.
    """
    one, other = edges.neighbours()
    flat = triangles.ravel()
    after_one, after_other = one - one % 3 + (one + 1) % 3, other - other % 3 + (other + 1) % 3
    crossed = flat[one] == flat[other]
    rows = np.concatenate([one, after_one])
    columns = np.concatenate([np.where(crossed, other, after_other), np.where(crossed, after_other, other)])
    count, fans = _connected(len(flat), rows, columns)
    vertices = np.empty(count, dtype=np.int64)
    vertices[fans] = flat
    return fans, vertices


def find_shells(triangles: int, edges: Edges) -> tuple[int, Int[np.ndarray, "triangles"]]:
    """How many pieces hang together by edges, and the piece of each triangle."""
    one, other = edges.neighbours()
    return _connected(triangles, one // 3, other // 3)


def _connected(size: int, rows: np.ndarray, columns: np.ndarray) -> tuple[int, np.ndarray]:
    links = sparse.coo_matrix((np.ones(len(rows), dtype=bool), (rows, columns)), shape=(size, size))
    count, labels = csgraph.connected_components(links.tocsr(), directed=False)
    return int(count), labels


def euler_characteristics(
    edges: Edges, fans: np.ndarray, shells: int, shell: Int[np.ndarray, "triangles"]
) -> Int[np.ndarray, "shells"]:
    """Of each shell, its fans minus its edges plus its triangles."""
    fan_shell = np.empty(int(fans.max()) + 1, dtype=np.int64)
    fan_shell[fans] = np.repeat(shell, 3)
    edge_shell = shell[edges.order[edges.starts] // 3]
    return (
        np.bincount(fan_shell, minlength=shells)
        - np.bincount(edge_shell, minlength=shells)
        + np.bincount(shell, minlength=shells)
    )


def closed_shells(
    edges: Edges, shells: int, shell: Int[np.ndarray, "triangles"]
) -> Bool[np.ndarray, "shells"]:
    """Which shells have all edges in two triangles, passed in opposite directions."""
    closed = np.ones(shells, dtype=bool)
    wrong = edges.open | edges.crowded | edges.bent
    closed[shell[edges.order[edges.starts[wrong]] // 3]] = False
    return closed
