"""Shells within shells: which side of each faces the material."""

import numpy as np
from jaxtyping import Bool, Float, Int

from export.checks.triangle_tree import TriangleTree

WORK = 4_000_000_000  # boxes that rays look at, all together
NEAR = 1e-9  # of the size: places so near to another shell lie on it
TRIES = 6
RAYS = ((0.8312, 0.4171, 0.3677), (-0.2813, 0.8651, -0.4152), (0.3319, -0.2947, 0.8961))


def misplaced_shells(
    tree: TriangleTree,
    shell: Int[np.ndarray, "triangles"],
    volumes: Float[np.ndarray, "shells"],
    closed: Bool[np.ndarray, "shells"],
    work: int = WORK,
) -> tuple[Int[np.ndarray, "inverted"], Int[np.ndarray, "nested"], bool]:
    """The shells that are inside out, those inside solid material, and whether all could be told.

    A shell of positive volume belongs where the other closed shells wind 0 times around it, one of
    negative volume (a cavity) where they wind once. That is counted along a ray from a triangle of
    the shell; a ray that passes an edge too closely is replaced by one in another direction, and a
    triangle that lies on another shell by another triangle, six times at most. A shell that lies on others
    everywhere is not told, nor are those that are left when too much work was done.
    """
    shells = len(volumes)
    if shells == 1:
        return np.flatnonzero(closed & (volumes < 0)), np.zeros(0, dtype=np.int64), True
    winding, told = _windings(tree, shell, closed, work)
    inverted = told & closed & (volumes < 0) & (winding < 1)
    nested = told & closed & (((volumes >= 0) & (winding != 0)) | ((volumes < 0) & (winding > 1)))
    return np.flatnonzero(inverted), np.flatnonzero(nested), bool(told[closed].all())


def _windings(
    tree: TriangleTree, shell: Int[np.ndarray, "triangles"], closed: Bool[np.ndarray, "shells"], work: int
) -> tuple[Int[np.ndarray, "shells"], Bool[np.ndarray, "shells"]]:
    """How often the other closed shells wind around each closed shell, and which of them were told."""
    from export.checks.boxes import windings

    ordered = np.ascontiguousarray(shell[tree.order])
    by_shell = np.argsort(ordered, kind="stable")
    starts = np.searchsorted(ordered[by_shell], np.arange(len(closed) + 1))
    sizes = np.diff(starts)
    winding = np.zeros(len(closed), dtype=np.int64)
    told = np.zeros(len(closed), dtype=bool)
    budget = work
    for turn in range(TRIES):
        left = np.flatnonzero(closed & ~told)
        if not len(left) or budget < 0:
            break
        one = by_shell[starts[left] + turn * sizes[left] // TRIES]
        places = tree.points[tree.triangles[one]].mean(axis=1)
        ray = np.array(RAYS[turn % len(RAYS)])
        near = NEAR * tree.size
        found, sure, budget = windings(*tree.parts, ordered, closed, places, left, ray, near, budget)
        winding[left[sure]], told[left[sure]] = found[sure], True
    return winding, told
