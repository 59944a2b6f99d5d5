"""Shells within shells: which side of each faces the material."""

import numpy as np
from jaxtyping import Bool, Float, Int

WORK = 50_000_000  # pairs of a shell and a triangle around it that are looked at, at most
PAIR = 500  # looking at a pair of shells costs as much as so many triangles
CHUNK = 1_000_000


def misplaced_shells(
    corners: Float[np.ndarray, "triangles 3 3"],
    shell: Int[np.ndarray, "triangles"],
    volumes: Float[np.ndarray, "shells"],
    closed: Bool[np.ndarray, "shells"],
) -> tuple[Int[np.ndarray, "inverted"], Int[np.ndarray, "nested"], bool]:
    """The shells that are inside out, those inside solid material, and whether it was tested.

    A shell of positive volume belongs where the other shells wind 0 times around it, one of
    negative volume (a cavity) where they wind once. Outside the bounding box of a closed shell its
    winding number is 0, so only shells whose box encloses that of another are looked at.
    """
    shells = len(volumes)
    if shells == 1:
        return np.flatnonzero(closed & (volumes < 0)), np.zeros(0, dtype=np.int64), True
    skipped = np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64), False
    if shells**2 > WORK:
        return skipped
    order = np.argsort(shell, kind="stable")
    starts = np.searchsorted(shell[order], np.arange(shells + 1))
    low = np.minimum.reduceat(corners.min(axis=1)[order], starts[:-1])
    high = np.maximum.reduceat(corners.max(axis=1)[order], starts[:-1])
    around = [_enclosing(low, high, closed, s) for s in range(shells)]
    sizes = np.diff(starts)
    if sum(int((sizes[others] + PAIR).sum()) for others in around) > WORK:
        return skipped
    winding = np.zeros(shells, dtype=np.int64)
    for s, others in enumerate(around):
        place = corners[order[starts[s]]].mean(axis=0)
        for other in others:
            winding[s] += _winding(corners[order[starts[other] : starts[other + 1]]], place)
    inverted = closed & (volumes < 0) & (winding < 1)
    nested = closed & (((volumes >= 0) & (winding != 0)) | ((volumes < 0) & (winding > 1)))
    return np.flatnonzero(inverted), np.flatnonzero(nested), True


def _enclosing(
    low: Float[np.ndarray, "shells 3"],
    high: Float[np.ndarray, "shells 3"],
    closed: Bool[np.ndarray, "shells"],
    s: int,
) -> Int[np.ndarray, "around"]:
    """The closed shells whose bounding box encloses that of shell s."""
    wide = (low <= low[s]).all(axis=1) & (high >= high[s]).all(axis=1) & closed
    wide[s] = False
    return np.flatnonzero(wide)


def _winding(corners: Float[np.ndarray, "t 3 3"], place: Float[np.ndarray, "3"]) -> int:
    """How often a closed shell winds around a place: the solid angles of its triangles over 4 pi.

    van Oosterom and Strackee: tan(angle / 2) = det(a, b, c) / (|a||b||c| + (a.b)|c| + ...).
    """
    total = 0.0
    for start in range(0, len(corners), CHUNK):
        a, b, c = np.moveaxis(corners[start : start + CHUNK] - place, 1, 0)
        la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
        spread = la * lb * lc + (a * b).sum(axis=1) * lc + (b * c).sum(axis=1) * la + (c * a).sum(axis=1) * lb
        total += float(np.arctan2((a * np.cross(b, c)).sum(axis=1), spread).sum())
    return round(total / (2 * np.pi))
