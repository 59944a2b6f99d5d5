"""Vertices between blocks of unequal size: as near to the surface as triangles that do not cross allow."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from export.checks.crossings import crossings
from export.checks.places import representatives
from export.checks.triangle_tree import triangle_tree
from export.meshing.patches import FIELD, Patches
from export.meshing.rings import Rings

_AROUND = np.array([[i // 9, i // 3 % 3, i % 3] for i in range(27)]) - 1


@dataclass(frozen=True, eq=False)
class Bent:
    """Triangles of rectangles: `squares` names that of each. Points are in mm, those of vertices first."""

    points: Float[np.ndarray, "points 3"]
    faces: Int[np.ndarray, "faces 3"]
    squares: Int[np.ndarray, " faces"]


def uncrossed(
    bend: Callable[[Float[np.ndarray, "vertices 3"]], Bent],
    stands: list[Float[np.ndarray, "vertices 3"]],
    patches: Patches,
    rings: Rings,
    ways: Float[np.ndarray, "patches 3"],
) -> Bent:
    """What `bend` makes of vertices in cells, each at the first of its places in `stands` that does no harm.

    Vertices of rectangles with triangles that meet others, or that face against the way from their black
    block to their white one (`ways`), go on to their next place. The last one is safe: rectangles all of
    whose vertices are there do not meet, so this ends. Vertices that have one place only are not looked at.
    """
    step = np.zeros(len(rings.corners), dtype=np.int64)
    places = stands[0].copy()
    watched = _squares_of(rings, (places != stands[-1]).any(axis=1))
    while True:
        found = bend(places)
        if not watched.any():
            return found
        wrong = _wrong(found, watched, patches, ways)
        back = np.zeros(len(step), dtype=bool)
        back[rings.ring[np.repeat(wrong, np.diff(rings.starts))]] = True
        back &= step < len(stands) - 1
        step[back] += 1
        for number, stand in enumerate(stands):
            here = back & (step == number)
            places[here] = stand[here]
        watched = _squares_of(rings, back)


def _squares_of(rings: Rings, vertices: Bool[np.ndarray, " vertices"]) -> Bool[np.ndarray, " patches"]:
    """Which rectangles have one of the vertices on their border."""
    return np.logical_or.reduceat(vertices[rings.ring], rings.starts[:-1])


def _wrong(
    bent: Bent, watched: Bool[np.ndarray, " patches"], patches: Patches, ways: Float[np.ndarray, "patches 3"]
) -> Bool[np.ndarray, " patches"]:
    """Watched rectangles with triangles that face the wrong way, and those near them whose triangles meet."""
    wrong = np.zeros(len(watched), dtype=bool)
    rows = np.flatnonzero(watched[bent.squares])
    a, b, c = (bent.points[bent.faces[rows, i]] for i in range(3))
    facing = (np.cross(b - a, c - a) * ways[bent.squares[rows]]).sum(axis=1)
    wrong[bent.squares[rows[facing <= 0]]] = True
    rows = np.flatnonzero(_near(watched, patches)[bent.squares])
    faces = bent.faces[rows]
    same = representatives(bent.points, faces)
    wrong[bent.squares[rows[(same[faces] != faces).any(axis=1)]]] = True
    found = crossings(triangle_tree(bent.points, faces))
    if found.count > len(found.pairs) or not found.complete:
        return wrong | watched
    wrong[bent.squares[rows[found.pairs.ravel()]]] = True
    return wrong


def _near(watched: Bool[np.ndarray, " patches"], patches: Patches) -> Bool[np.ndarray, " patches"]:
    """The rectangles whose triangles may meet those of watched ones.

    Triangles are no further from their rectangle than half the largest block, so they do not meet where the
    bricks of that size that hold the rectangles do not touch.
    """
    assert patches.inner is not None
    assert patches.outer is not None
    largest = int(max(patches.inner.size.max(), patches.outer.size.max()))
    bricks = (patches.low >> largest.bit_length() - 1) + 1
    around = (np.unique(bricks[watched], axis=0)[:, None] + _AROUND).reshape(-1, 3)
    return np.isin(_keys(bricks), _keys(around))


def _keys(bricks: Int[np.ndarray, "_bricks 3"]) -> Int[np.ndarray, " _bricks"]:
    return bricks[:, 0] << 2 * FIELD | bricks[:, 1] << FIELD | bricks[:, 2]
