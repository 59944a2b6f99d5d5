"""Parameter frames in whole numbers: which child of an edge is which half, of a quadrangle which quarter."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from automata.automaton import Word
from automata.topology import Topology
from ifs.tangency.frames import Frame, NotParametrised, Side, frames

Point = tuple[int, ...]

CORNERS: tuple[Point, ...] = ((0, 0), (2, 0), (2, 2), (0, 2))
_NEAR = 1e-9


@dataclass(frozen=True)
class SegmentFrame:
    """An edge with two ends and two halves; it runs from the first end to the second one.

    `halves` names the half at the first end, then the one at the second end, each with whether it runs as
    the edge does.
    """

    ends: tuple[Word, Word]
    halves: tuple[tuple[str, bool], tuple[str, bool]]


@dataclass(frozen=True)
class QuadFrame:
    """A quadrangle with corners (0, 0), (1, 0), (1, 1), (0, 1), four sides and four children.

    The corners run as the cell's figure does, so that the normal of the frame is that of the drawn face.
    `children[label]` gives the positions of the child's own corners, in halves of the parent's side.
    """

    corners: tuple[Word, ...]
    sides: tuple[Side, ...]
    children: dict[str, tuple[Point, ...]]


def halved_frames(
    topology: Topology, cells: Iterable[str]
) -> tuple[dict[str, QuadFrame], dict[str, SegmentFrame]]:
    """The frames of the quadrangles that become four quarters, and of the edges that become two halves.

    Other cells are left out.

    >>> import ifs
    >>> quads, segments = halved_frames(ifs.shape("doo-sabin-patch").topology, ["face", "edge"])
    >>> [side.label for side in quads["face"].sides], sorted(quads["face"].children)
    (['bottom', 'right', 'top', 'left'], ['0', '1', '2', '3'])
    >>> segments["edge"].halves
    (('0', True), ('1', True))
    """
    known: dict[str, Frame] = {}
    quads, segments = {}, {}
    for cell in cells:
        try:
            if cell not in known:
                known.update(frames(topology, [cell]))
        except NotParametrised:
            continue
        labels = tuple(topology.automaton.cells[cell].subdivision)
        if quad := _quad(known[cell], labels):
            quads[cell] = quad
        if segment := _segment(known[cell], labels):
            segments[cell] = segment
    return quads, segments


def _quad(frame: Frame, labels: tuple[str, ...]) -> QuadFrame | None:
    if len(frame.corners) != 4 or len(labels) != 4:
        return None
    squares = [_in_halves(frame, part.corners) for part in frame.parts]
    if any(square is None for square in squares):
        return None
    children = {label: square for label, square in zip(labels, squares, strict=True) if square}
    if {min(square) for square in children.values()} != {(0, 0), (0, 1), (1, 0), (1, 1)}:
        return None
    if not all(_is_unit(square) for square in children.values()):
        return None
    return QuadFrame(frame.corners, frame.sides, children)


def _segment(frame: Frame, labels: tuple[str, ...]) -> SegmentFrame | None:
    if len(frame.corners) != 2 or len(labels) != 2:
        return None
    found: dict[Point, tuple[str, bool]] = {}
    for label, part in zip(labels, frame.parts, strict=True):
        ends = _in_halves(frame, part.corners)
        if ends is None:
            return None
        found[min(ends)] = label, ends[0] < ends[1]
    if set(found) != {(0,), (1,)}:
        return None
    first, last = frame.corners
    return SegmentFrame((first, last), (found[0,], found[1,]))


def _in_halves(frame: Frame, corners: tuple[Word, ...]) -> tuple[Point, ...] | None:
    """The parameters of a child's corners in halves; nothing where they are no whole numbers of these."""
    exact = [2 * frame.vertices[word] for word in corners]
    if any(np.abs(place - place.round()).max() > _NEAR for place in exact):
        return None
    return tuple(tuple(int(x) for x in place.round()) for place in exact)


def _is_unit(square: tuple[Point, ...]) -> bool:
    """Whether four points, in order, go around a square of side 1."""
    steps = [(b[0] - a[0], b[1] - a[1]) for a, b in zip(square, (*square[1:], square[0]), strict=True)]
    return len(square) == 4 and all(abs(x) + abs(y) == 1 for x, y in steps) and len(set(square)) == 4
