"""How deep a shape is subdivided to be drawn: as asked, or until the detail is fine enough to see."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from bcifs.progress import silent
from ifs import Mesh, Shape, draw, initial, refine

ENOUGH = 60_000  # faces of a drawing whose depth is not asked for
MOST = 3_000_000  # faces of any drawing
FINE = 1 / 1500  # faces of that share of the whole are small enough
DEEPEST = 24
MOST_PRINTED = 100_000_000  # solid pieces of a part, which are looked at in batches
DEEPEST_PRINTED = 64


class TooDeep(ValueError):
    """More faces than a drawing holds, or more pieces than a part."""


@dataclass(frozen=True)
class Drawn:
    """A mesh and the depth at which it was drawn."""

    mesh: Mesh
    depth: int

    @property
    def kind(self) -> str:
        """What the faces are, in words."""
        return {1: "points", 2: "segments"}.get(self.mesh.faces.shape[1], "faces")


def drawn(shape: Shape, depth: int | None = None, progress: Callable[[str, float], None] = silent) -> Drawn:
    """The mesh of a shape at a depth, or at the first depth that shows all there is to see.

    Without a depth it is subdivided until its faces are smaller than 1/1500 of the whole, or would
    be more than 60 000. Raises `TooDeep` for more than three million.

    >>> from ifs import shape
    >>> drawn(shape("menger-sponge")).depth
    3
    """
    complex_ = initial(shape.topology, shape.system, shape.control)
    mesh = draw(complex_)
    each = len(mesh.faces)
    if depth is not None:
        _limit(shape, depth, each)
    level = 0
    while level < DEEPEST if depth is None else level < depth:
        faces = each * pieces(shape, level + 1)
        if depth is None and (faces > ENOUGH or _is_fine(mesh)):
            break
        complex_ = refine(complex_)
        level += 1
        if depth is None:
            mesh = draw(complex_)
        progress("subdivide", min(faces / ENOUGH, 1.0) if depth is None else level / depth)
    return Drawn(draw(complex_) if depth is not None else mesh, level)


def require_printable_depth(shape: Shape, depth: int) -> None:
    """Raises `TooDeep` for more solid pieces than a part is made of.

    >>> from ifs import shape
    >>> require_printable_depth(shape("menger-sponge"), 5)
    """
    if depth > DEEPEST_PRINTED or pieces(shape, depth, MOST_PRINTED) > MOST_PRINTED:
        depths = range(DEEPEST_PRINTED, -1, -1)
        fits = next(d for d in depths if pieces(shape, d, MOST_PRINTED) <= MOST_PRINTED)
        raise TooDeep(
            f"--depth {depth} is more than can be printed ({MOST_PRINTED} pieces, {DEEPEST_PRINTED} levels); "
            f"{fits} fits; without --depth the limit itself is printed"
        )


def pieces(shape: Shape, depth: int, most: int = MOST) -> int:
    """How many pieces a shape has after `depth` subdivisions; counting ends beyond `most`.

    >>> from ifs import shape
    >>> pieces(shape("menger-sponge"), 3)
    8000
    """
    counts = Counter({shape.automaton.shape: 1})
    for _ in range(depth):
        following: Counter[str] = Counter()
        for cell, count in counts.items():
            for target in shape.automaton.cells[cell].subdivision.values():
                following[target] += count
        counts = following
        if counts.total() > most:
            break
    return counts.total()


def _limit(shape: Shape, depth: int, each: int) -> None:
    if depth > DEEPEST or each * pieces(shape, depth) > MOST:
        fits = next(d for d in range(DEEPEST, -1, -1) if d == 0 or each * pieces(shape, d) <= MOST)
        raise TooDeep(
            f"--depth {depth} is more than can be drawn ({MOST} faces, {DEEPEST} levels); {fits} fits"
        )


def _is_fine(mesh: Mesh) -> bool:
    """Whether every face is small beside the whole."""
    whole = np.ptp(mesh.vertices, axis=0).max()
    first = mesh.vertices[mesh.faces[:, :1]]
    corners = np.where(mesh.faces[..., None] >= 0, mesh.vertices[mesh.faces], first)
    return bool(np.ptp(corners, axis=1).max() <= FINE * whole)
