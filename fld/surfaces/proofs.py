"""What linear functions do on a ring, with proof: which sign they have, and whether they vanish together."""

import numpy as np
from jaxtyping import Float

from fld.surfaces.rings import Ring
from ifs import extent

_MARGIN = 1e-10
_LEVELS = 24
_PIECES = 20_000
_WAYS = 8

Rows = Float[np.ndarray, "functions points"]
Waiting = dict[str, Float[np.ndarray, "_pieces _functions _points"]]


def sign(ring: Ring, row: Float[np.ndarray, "points"]) -> int | None:
    """The sign of `row (p - c)` over all points p of the ring around c.

    1 or -1 when one strict sign is proven for all, 0 when points of both signs are proven; None when it stays
    open: the value comes within 1e-10 (of the largest entry of `row`) to 0 without changing sign, or the
    refinement is not deep enough to tell.
    """
    waiting = _start(ring, row[None] / np.abs(row).max())
    signs: set[int] = set()
    for _ in range(_LEVELS):
        following: Waiting = {}
        for cell, rows in waiting.items():
            lo, hi = (end[:, 0] for end in _extents(ring, cell, rows))
            signs |= {1} if (lo > _MARGIN).any() else set()
            signs |= {-1} if (hi < -_MARGIN).any() else set()
            following[cell] = rows[(lo <= _MARGIN) & (hi >= -_MARGIN)]
        if len(signs) == 2:
            return 0
        if not any(len(rows) for rows in following.values()):
            return signs.pop() if signs else None
        stepped = _stepped(ring, following)
        if stepped is None:
            return None
        waiting = stepped
    return None


def avoids(ring: Ring, rows: Rows) -> bool:
    """Whether some linear functions of `p - c` are proven to vanish together nowhere on the ring around c.

    Two functions: the point of the plane that they give is 1e-10 or more from 0, their common size being 1.
    False means that this was not proven.
    """
    if len(rows) == 1:
        return sign(ring, rows[0]) in (1, -1)
    if len(rows) != 2:
        raise ValueError(f"one or two functions are followed, found {len(rows)}")
    angles = np.pi * np.arange(_WAYS) / _WAYS
    ways = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    waiting = _start(ring, ways @ _evened(rows))
    for _ in range(_LEVELS):
        following = {}
        for cell, found in waiting.items():
            lo, hi = _extents(ring, cell, found)
            following[cell] = found[((lo <= _MARGIN) & (hi >= -_MARGIN)).all(axis=1)]
        if not any(len(found) for found in following.values()):
            return True
        stepped = _stepped(ring, following)
        if stepped is None:
            return False
        waiting = stepped
    return False


def _evened(rows: Rows) -> Rows:
    """Functions that vanish together where the given ones do, orthonormal on differences."""
    centred = rows - rows.mean(axis=1, keepdims=True)
    return np.linalg.svd(centred / np.linalg.norm(centred, axis=1, keepdims=True), full_matrices=False)[2]


def _start(ring: Ring, rows: Rows) -> Waiting:
    """The functions of `p - c` on the points of each piece: `sum p = 1` takes in the constant."""
    shifted = rows - (rows @ ring.point)[:, None]
    found: dict[str, list[np.ndarray]] = {}
    for operator, target in ring.pieces:
        found.setdefault(target, []).append(shifted @ operator)
    return {cell: np.stack(pieces) for cell, pieces in found.items()}


def _extents(ring: Ring, cell: str, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    box = ring.ground.box(cell)
    if box is None:
        return np.full(rows.shape[:2], -np.inf), np.full(rows.shape[:2], np.inf)
    return extent(box, np.ascontiguousarray(rows.transpose(0, 2, 1)))


def _stepped(ring: Ring, waiting: Waiting) -> Waiting | None:
    """The same functions on all sub-pieces; None when these are too many, or some cell has no box."""
    if any(len(rows) and ring.ground.box(cell) is None for cell, rows in waiting.items()):
        return None
    found: dict[str, list[np.ndarray]] = {}
    for cell, rows in waiting.items():
        state = ring.ground.system.states[cell]
        for operator, target in zip(state.operators, state.targets, strict=True):
            if len(rows):
                found.setdefault(target, []).append(rows @ operator)
    result = {cell: np.concatenate(pieces) for cell, pieces in found.items()}
    return result if sum(len(rows) for rows in result.values()) <= _PIECES else None
