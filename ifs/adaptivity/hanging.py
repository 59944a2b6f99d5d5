"""The sides of pieces through several levels of subdivision, and polygons that take in what hangs on them."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Bool, Float, Int

from ifs.mesh import Mesh

Numbers = Int[np.ndarray, "_cells"]
Positions = Float[np.ndarray, "pieces corners dim"]


@dataclass(frozen=True)
class Leaves:
    """Pieces that are drawn: the numbers of their corners and sides, and whether a side runs around as it is.

    Side k is the one from corner k to the next; a curve has none.
    """

    corners: Int[np.ndarray, "pieces corners"]
    sides: Int[np.ndarray, "pieces sides"]
    forward: Bool[np.ndarray, "pieces sides"]
    positions: Positions


@dataclass
class History:
    """All vertices and sides ever met, in one numbering through all levels; it grows with each level.

    `ends[i]` holds the first and the last vertex of sides; `split[i]` sides, the sides that they became, in
    order from the first vertex on, and whether each of these runs the same way.
    """

    vertices: int = 0
    sides: int = 0
    ends: list[Int[np.ndarray, "_sides 2"]] = field(default_factory=list)
    split: list[tuple[Numbers, Int[np.ndarray, "_sides _parts"], Bool[np.ndarray, "_parts"]]] = field(
        default_factory=list
    )
    leaves: list[Leaves] = field(default_factory=list)

    def new_vertices(self, count: int) -> Numbers:
        self.vertices += count
        return np.arange(self.vertices - count, self.vertices)

    def new_sides(self, ends: Int[np.ndarray, "sides 2"]) -> Numbers:
        self.ends.append(ends)
        self.sides += len(ends)
        return np.arange(self.sides - len(ends), self.sides)

    def mesh(self, dimension: int) -> Mesh:
        """The leaves as polygons, each with all vertices that lie on its sides."""
        vertices = np.full((self.vertices, dimension), np.nan)
        for leaves in self.leaves:
            vertices[leaves.corners.reshape(-1)] = leaves.positions.reshape(-1, dimension)
        polygons = [
            self._with_hanging(found) if found.sides.shape[1] else found.corners for found in self.leaves
        ]
        width = max(table.shape[1] for table in polygons)
        wide = [np.pad(t, ((0, 0), (0, width - t.shape[1])), constant_values=-1) for t in polygons]
        return Mesh(vertices, np.concatenate(wide))

    def _with_hanging(self, leaves: Leaves) -> Int[np.ndarray, "faces corners"]:
        """The polygons of some leaves: sides are replaced by their parts until none is split."""
        count, each = leaves.sides.shape
        face = np.repeat(np.arange(count), each)
        side, forward = leaves.sides.reshape(-1), leaves.forward.reshape(-1)
        for sides, parts, same in self.split:
            row = np.full(self.sides, -1)
            row[sides] = np.arange(len(sides))
            found = row[side]
            cut = found >= 0
            if not cut.any():
                continue
            times = np.where(cut, parts.shape[1], 1)
            old = np.repeat(np.arange(len(side)), times)
            step = np.arange(len(old)) - np.repeat(np.cumsum(times) - times, times)
            step = np.where(forward[old], step, parts.shape[1] - 1 - step)
            inside = cut[old]
            face = face[old]
            side = np.where(inside, parts[found[old], np.where(inside, step, 0)], side[old])
            forward = np.where(inside, forward[old] == same[np.where(inside, step, 0)], forward[old])
        ends = np.concatenate(self.ends)[side]
        corner = np.where(forward, ends[:, 0], ends[:, 1])
        sizes = np.bincount(face, minlength=count)
        place = np.arange(len(face)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
        result = np.full((count, int(sizes.max(initial=0))), -1)
        result[face, place] = corner
        return result
