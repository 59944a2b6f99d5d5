"""How thick walls are, and how wide gaps, along rays square to the surface."""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from export.checks.report import Place, as_place
from export.checks.triangle_tree import TriangleTree

FEWEST = 60_000  # places that are measured where there are fewer triangles, spread by area
MOST = 1_000_000  # places that are measured where there are more
OPPOSITE = np.cos(np.radians(45.0))
WORK = 2_000_000_000  # boxes that rays look at in each direction
CHUNK = 20_000  # rays between two moments at which it can be interrupted
GAIN, MORE = (
    1.25,
    0.75,
)  # a ball this much wider than a place, more so when it is farther off, makes it a notch
JUDGED = 5_000  # places below a limit for which balls are looked for
ENOUGH = 250  # walls, where there is no limit
BALLS = 1_000_000_000  # boxes looked at for balls; places after that count as walls
NEAR = 1e-9  # of the size: what is nearer than that lies at 0
GOLDEN = (0.7548776662466927, 0.5698402909980532)  # 1/g, 1/g² with g³ = g + 1: evenly spread in the plane


@dataclass(frozen=True, eq=False)
class Widths:
    """Widths (mm) in rising order and the places in their middles; `measured` places were looked at.

    Where very many are below the limit, each of those here stands for `share` of them.
    """

    widths: Float[np.ndarray, "n"]
    places: Float[np.ndarray, "n 3"]
    measured: int
    share: int = 1

    @property
    def least(self) -> float | None:
        """The least width, None where nothing lies opposite anything."""
        return float(self.widths[0]) if len(self.widths) else None

    def below(self, width: float) -> Float[np.ndarray, "m 3"]:
        """The places of widths below a width (with room for rounding, a billionth)."""
        return self.places[: int(np.searchsorted(self.widths, width * (1 - NEAR)))]

    def narrowest(self, count: int, apart: float) -> list[tuple[float, Place]]:
        """The least widths that lie `apart` (mm) from each other at least."""
        chosen: list[tuple[float, Place]] = []
        for width, row in zip(self.widths[:5000].tolist(), self.places[:5000], strict=True):
            if len(chosen) == count:
                break
            place = as_place(row)
            if all(math.dist(place, other) >= apart for _, other in chosen):
                chosen.append((width, place))
        return chosen


def walls_and_gaps(
    tree: TriangleTree, most: int = MOST, wall: float | None = None, gap: float | None = None
) -> tuple[Widths, Widths]:
    """The thickness of the material under places of the surface, and the width of the space above.

    From a place on a triangle a ray goes square to it, inward for walls and outward for gaps, up
    to the first triangle that it meets. That is a wall (a gap) where the two triangles are turned against
    each other within 45 degrees; a ray that ends on a triangle turned otherwise measures nothing,
    so that the corner of a cube is no thin wall.

    A notch, a scratch or a bump is no wall either: a width w does not count where a ball that fits into
    the material (the space) and is at least `5/4 w` across contains the middle of the ray, or one of
    `(5/4 + 3/4 s) w` comes as near to it as s w, with s up to 1. So a wall reaches farther than its own
    thickness, the edge of a knife is one up to about 25 degrees, and a scratch makes a wall no thinner than
    by a fifth. Of the balls a few around the place are tried, so that a notch may be taken for a wall,
    never a wall for a notch.

    Each length is right to a billionth of the size of the mesh; the least of them is the thinnest wall at
    the places looked at, so that a thinner one may be missed, never one made up. Places are
    the middles of the triangles (of every n-th along a curve through space, above `most`), and
    more on large ones, at least 60 000. Of these, balls judge the narrowest until 250 walls are found,
    and those below `wall` and `gap` (mm), 5 000 evenly spread ones at most; the answer holds
    what was judged. In a wedge of angle a rays are longer than the way across by 1 / cos a; on curved walls
    they are longer in second order.
    """
    own, origins = _places(tree, most)
    normals = _normals(tree)
    kept = np.linalg.norm(normals[own], axis=1) > 0
    own, origins = own[kept], origins[kept]
    outward = normals[own]
    found = []
    for leaving, limit in ((True, wall), (False, gap)):
        direction = np.ascontiguousarray(-outward if leaving else outward)
        distances, hits = _follow(tree, origins, direction, own, leaving)
        met = hits >= 0
        met[met] = _opposite(outward[met], normals[hits[met]])
        measured = int((hits > -2).sum())
        found.append(_judged(tree, distances[met], origins[met], direction[met], limit, measured))
    return found[0], found[1]


def _judged(
    tree: TriangleTree,
    widths: Float[np.ndarray, "n"],
    origins: Float[np.ndarray, "n 3"],
    directions: Float[np.ndarray, "n 3"],
    limit: float | None,
    measured: int,
) -> Widths:
    """The widths that balls beside them leave standing, from the least on."""
    order = np.argsort(widths, kind="stable")
    widths, directions = widths[order], directions[order]
    middles = origins[order] + directions * widths[:, None] / 2
    low = 0 if limit is None else int(np.searchsorted(widths, limit / tree.scale))
    share = -(-low // JUDGED) or 1
    chosen = _standing(tree, widths, middles, directions, np.arange(0, low, share), BALLS)
    step, judged = 1, low
    while len(chosen) < ENOUGH and judged < len(widths):
        rows = np.arange(judged, min(judged + step * ENOUGH, len(widths)), step)
        chosen = np.concatenate([chosen, _standing(tree, widths, middles, directions, rows, BALLS)])
        judged, step = int(rows[-1]) + step, 2 * step
    return Widths(widths[chosen] * tree.scale, middles[chosen] * tree.scale, measured, share)


def _standing(
    tree: TriangleTree,
    widths: Float[np.ndarray, "n"],
    middles: Float[np.ndarray, "n 3"],
    directions: Float[np.ndarray, "n 3"],
    rows: Int[np.ndarray, "m"],
    budget: int,
) -> Int[np.ndarray, "kept"]:
    """The rows at which no larger ball fits beside."""
    from export.checks.balls import thicker_beside

    kept = []
    for start in range(0, len(rows), 1000):
        some = rows[start : start + 1000]
        thicker, budget = thicker_beside(
            *tree.parts, middles[some], directions[some], widths[some], GAIN, MORE, budget
        )
        kept.append(some[~thicker])
    return np.concatenate(kept) if kept else np.zeros(0, dtype=np.int64)


def _follow(
    tree: TriangleTree,
    origins: Float[np.ndarray, "n 3"],
    directions: Float[np.ndarray, "n 3"],
    own: Int[np.ndarray, "n"],
    leaving: bool,
) -> tuple[Float[np.ndarray, "n"], Int[np.ndarray, "n"]]:
    """The length of each ray and the triangle where it ends: -1 for none, -2 when beyond the budget."""
    from export.checks.boxes import first_hits

    distances, hits = np.full(len(own), np.inf), np.full(len(own), -2, dtype=np.int64)
    budget = WORK
    for start in range(0, len(own), CHUNK):
        part = slice(start, start + CHUNK)
        near = NEAR * tree.size
        found = distances[part], hits[part]
        budget = first_hits(
            *tree.parts, origins[part], directions[part], own[part], near, leaving, *found, budget
        )
        if budget < 0:
            break
    return distances, hits


def _opposite(one: Float[np.ndarray, "n 3"], other: Float[np.ndarray, "n 3"]) -> Bool[np.ndarray, "n"]:
    return (one * other).sum(axis=1) <= -OPPOSITE


def _normals(tree: TriangleTree) -> Float[np.ndarray, "t 3"]:
    """Unit normals; 0 for triangles without area."""
    a, b, c = (tree.points[tree.triangles[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1)
    return normals / np.where(lengths > 0, lengths, 1.0)[:, None]


def _places(tree: TriangleTree, most: int) -> tuple[Int[np.ndarray, "n"], Float[np.ndarray, "n 3"]]:
    """Triangles and places on them: in the middle first, then evenly spread, by area."""
    step = -(-len(tree.triangles) // most)
    looked = np.arange(0, len(tree.triangles), step)
    a, b, c = (tree.points[tree.triangles[looked, i]] for i in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    more = min(FEWEST, most)
    share = areas / areas.sum() if areas.sum() > 0 else np.zeros(len(areas))
    counts = 1 + (share * more).astype(np.int64) if len(looked) < more else np.ones(len(looked), np.int64)
    row = np.repeat(np.arange(len(looked)), counts)
    k = np.arange(len(row)) - np.repeat(np.cumsum(counts) - counts, counts)
    u, v = (1 / 3 + k * GOLDEN[0]) % 1.0, (1 / 3 + k * GOLDEN[1]) % 1.0
    over = u + v > 1
    u, v = np.where(over, 1 - u, u)[:, None], np.where(over, 1 - v, v)[:, None]
    return looked[row], a[row] + u * (b - a)[row] + v * (c - a)[row]
