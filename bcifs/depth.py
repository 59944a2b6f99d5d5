"""How deep a shape is subdivided to be drawn: as asked, or until the detail is fine enough to see."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from automata import Automaton
from bcifs.progress import silent
from ifs import Complex, Mesh, Shape, bounding_box, initial, uniform
from ifs import pieces as pieces_of
from ifs.drawing import drawn_boxes
from ifs.stamp import supports
from ifs.stencil import Stencils
from ifs.template import Templates

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
    """A mesh and the depth at which it was drawn; or the size in mm below which its pieces are."""

    mesh: Mesh
    depth: int
    size: float | None = None

    @property
    def detail(self) -> str:
        """How fine it is, in words."""
        return f"at depth {self.depth}" if self.size is None else f"in pieces below {self.size:.3g} mm"

    @property
    def kind(self) -> str:
        """What the faces are, in words."""
        return {1: "points", 2: "segments"}.get(self.mesh.faces.shape[1], "faces")


def drawn(
    source: Shape | Complex, depth: int | None = None, progress: Callable[[str, float], None] = silent
) -> Drawn:
    """The mesh of a shape at a depth, or at the first depth that shows all there is to see.

    Without a depth it is subdivided until its faces are smaller than 1/1500 of the whole, or would
    be more than 60 000. Raises `TooDeep` for more than three million.

    >>> from ifs import shape
    >>> drawn(shape("menger-sponge")).depth
    3
    """
    complex_ = as_complex(source)
    stencils = Stencils(Templates(complex_.topology), complex_.system)
    mesh = uniform(complex_, 0, stencils)
    each = len(mesh.faces) / sum(len(found) for found in complex_.control.values())
    if depth is not None:
        _limit(complex_, depth, each)
        progress("subdivide", 0.0)
        return Drawn(uniform(complex_, depth, stencils), depth)
    level = 0
    while level < DEEPEST:
        faces = each * _count(complex_, level + 1)
        if faces > ENOUGH or _is_fine(mesh):
            break
        level += 1
        mesh = uniform(complex_, level, stencils)
        progress("subdivide", min(faces / ENOUGH, 1.0))
    if isinstance(source, Shape) and not supports(complex_, level) and _is_uneven(mesh):
        return _of_one_size(source, level)
    return Drawn(mesh, level)


def _of_one_size(shape: Shape, level: int) -> Drawn:
    """The boxes of pieces that are all about as large: maps may shrink at very different rates."""
    low, high = bounding_box(shape)
    size, best = float((high - low).max()), Drawn(drawn_boxes(low[None], high[None]), 0)
    while size > FINE * (high - low).max():
        size /= 1.5
        found, count = [], 0
        for part in pieces_of(shape.system, shape.control, size=size):
            found.append(part)
            count += len(part.lo)
            if count > ENOUGH:
                return best
        boxes = drawn_boxes(np.concatenate([p.lo for p in found]), np.concatenate([p.hi for p in found]))
        best = Drawn(boxes, level, size)
    return best


def _is_uneven(mesh: Mesh) -> bool:
    """Whether some face is more than four times as long as another."""
    sides = np.ptp(mesh.vertices[mesh.faces], axis=1).max(axis=1)
    return bool(sides.max() > 4 * sides.min())


def as_complex(source: Shape | Complex) -> Complex:
    """The complex of a single piece, where a shape is given."""
    if isinstance(source, Complex):
        return source
    return initial(source.topology, source.system, source.control)


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
    return _descendants(shape.automaton, Counter({shape.automaton.shape: 1}), depth, most)


def _count(complex_: Complex, depth: int) -> int:
    start = Counter({cell: len(found) for cell, found in complex_.control.items()})
    return _descendants(complex_.topology.automaton, start, depth, MOST)


def _descendants(automaton: Automaton, counts: Counter[str], depth: int, most: int) -> int:
    for _ in range(depth):
        following: Counter[str] = Counter()
        for cell, count in counts.items():
            for target in automaton.cells[cell].subdivision.values():
                following[target] += count
        counts = following
        if counts.total() > most:
            break
    return counts.total()


def _limit(complex_: Complex, depth: int, each: float) -> None:
    if depth > DEEPEST or each * _count(complex_, depth) > MOST:
        fits = next(d for d in range(DEEPEST, -1, -1) if d == 0 or each * _count(complex_, d) <= MOST)
        raise TooDeep(
            f"--depth {depth} is more than can be drawn ({MOST} faces, {DEEPEST} levels); {fits} fits"
        )


def _is_fine(mesh: Mesh) -> bool:
    """Whether every face is small beside the whole."""
    whole = np.ptp(mesh.vertices, axis=0).max()
    first = mesh.vertices[mesh.faces[:, :1]]
    corners = np.where(mesh.faces[..., None] >= 0, mesh.vertices[mesh.faces], first)
    return bool(np.ptp(corners, axis=1).max() <= FINE * whole)
