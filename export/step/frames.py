"""Parameter frames, read from the gluing alone: which child of an edge or a quadrangle lies where."""

from collections import Counter
from dataclasses import dataclass

from automata.automaton import Word
from automata.topology import Topology
from ifs.drawing import corner_paths

Point = tuple[int, int]

CORNERS: tuple[Point, ...] = ((0, 0), (2, 0), (2, 2), (0, 2))
MIDDLES: tuple[Point, ...] = ((1, 0), (2, 1), (1, 2), (0, 1))


@dataclass(frozen=True)
class SegmentFrame:
    """An edge with two ends and two halves; it runs from the first end to the second one.

    `halves` names the half at the first end, then the one at the second end, each with whether it runs as
    the edge does.
    """

    ends: tuple[Word, Word]
    halves: tuple[tuple[str, bool], tuple[str, bool]]


@dataclass(frozen=True)
class SideFrame:
    """The side of a quadrangle from one corner to the next: its boundary, and whether the edge runs so."""

    label: str
    edge: str
    forward: bool


@dataclass(frozen=True)
class QuadFrame:
    """A quadrangle with corners (0, 0), (1, 0), (1, 1), (0, 1), four sides and four children.

    `children[label]` gives the positions of the child's own corners, in halves of the parent's side.
    """

    corners: tuple[Word, ...]
    sides: tuple[SideFrame, ...]
    children: dict[str, tuple[Point, ...]]


def segment_frame(topology: Topology, cell: str) -> SegmentFrame | None:
    """The frame of an edge; nothing where the cell is no edge of two ends that becomes two such edges.

    >>> import ifs
    >>> segment_frame(ifs.shape("corner-cutting").topology, "edge").halves
    (('0', True), ('1', True))
    """
    ends = corner_paths(topology, cell)
    children = topology.automaton.cells[cell].subdivision
    if len(ends) != 2 or len(children) != 2:
        return None
    at = [_class_of_corner(topology, cell, end) for end in ends]
    found: dict[int, tuple[str, bool]] = {}
    middles = []
    for label, target in children.items():
        inner = _classes_of_child(topology, cell, label, target)
        for side, here in enumerate(at):
            if len(inner) == 2 and here in inner:
                found[side] = (label, (inner[0] == here) == (side == 0))
                middles.append(inner[1 - inner.index(here)])
    if len(found) != 2 or found[0][0] == found[1][0] or len(middles) != 2 or middles[0] != middles[1]:
        return None
    return SegmentFrame((ends[0], ends[1]), (found[0], found[1]))


def quad_frame(topology: Topology, cell: str) -> QuadFrame | None:
    """The frame of a quadrangle; nothing where the cell is none, or its children do not tile it in halves.

    The corners run as the cell's figure does, so that the normal of the frame is that of the drawn face.

    >>> import ifs
    >>> frame = quad_frame(ifs.shape("doo-sabin-patch").topology, "face")
    >>> [side.label for side in frame.sides], sorted(frame.children)
    (['bottom', 'right', 'top', 'left'], ['0', '1', '2', '3'])
    """
    corners = frame_corners(topology, cell)
    children = topology.automaton.cells[cell].subdivision
    if corners is None or len(children) != 4:
        return None
    sides = _sides(topology, cell, corners)
    if sides is None:
        return None
    inner = {label: _classes_of_child(topology, cell, label, target) for label, target in children.items()}
    position = _positions([_class_of_corner(topology, cell, corner) for corner in corners], inner)
    if position is None:
        return None
    placed = {label: tuple(position[word] for word in words) for label, words in inner.items()}
    if not all(_is_square(square) for square in placed.values()):
        return None
    return QuadFrame(corners, sides, placed)


def frame_corners(topology: Topology, cell: str) -> tuple[Word, ...] | None:
    """The four corners of a quadrangle in the order of its figure; nothing for other cells."""
    walk = corner_paths(topology, cell)
    borders = topology.automaton.cells[cell].boundary
    if len(walk) != 4 or len(borders) != 4:
        return None
    figure = topology.automaton.cells[cell].figure
    order = (0, 1, 2, 3)
    if figure and not figure.points and len(figure.faces) == 1 and len(figure.faces[0]) == 4:
        order = figure.faces[0]
    steps = {(b - a) % 4 for a, b in zip(order, (*order[1:], order[0]), strict=True)}
    return tuple(walk[i] for i in order) if steps in ({1}, {3}) else None


def _classes_of_child(topology: Topology, cell: str, label: str, target: str) -> list[Word]:
    """What the corners of a child are in its parent, in the order of the child's own frame."""
    place = topology.subdivided(cell).place
    ends = len(topology.automaton.cells[target].boundary)
    corners = corner_paths(topology, target) if ends == 2 else frame_corners(topology, target)
    return [place[(label, *corner)][0] for corner in corners or ()]


def _class_of_corner(topology: Topology, cell: str, corner: Word) -> Word:
    point = topology.automaton.end(cell, corner)
    (label,) = topology.automaton.cells[point].subdivision
    return topology.subdivided(cell).place[(*corner, label)][0]


def _sides(topology: Topology, cell: str, corners: tuple[Word, ...]) -> tuple[SideFrame, ...] | None:
    coincident = topology.coincident(cell)
    found: dict[int, SideFrame] = {}
    for label, border in topology.automaton.cells[cell].boundary.items():
        ends = [coincident[(label, *path)][0] for path in corner_paths(topology, border.cell)]
        for i in range(4):
            pair = [corners[i], corners[(i + 1) % 4]]
            if ends in (pair, pair[::-1]):
                found[i] = SideFrame(label, border.cell, ends == pair)
    return tuple(found[i] for i in range(4)) if len(found) == 4 else None


def _positions(corners: list[Word], inner: dict[str, list[Word]]) -> dict[Word, Point] | None:
    """Where each corner of a child lies: at a corner (one child), mid-side (two) or in the centre (four)."""
    times = Counter(word for words in inner.values() for word in set(words))
    holder = {word: set(words) for words in inner.values() for word in words if times[word] == 1}
    if sorted(times.values()) != [1, 1, 1, 1, 2, 2, 2, 2, 4] or set(holder) != set(corners):
        return None
    position = dict(zip(corners, CORNERS, strict=True))
    for i, middle in enumerate(MIDDLES):
        shared = holder[corners[i]] & holder[corners[(i + 1) % 4]]
        for word in shared:
            position[word] = middle if times[word] == 2 else (1, 1)
    return position if len(position) == 9 and len(set(position.values())) == 9 else None


def _is_square(square: tuple[Point, ...]) -> bool:
    """Whether four points, in order, go around a square of side 1."""
    steps = [(b[0] - a[0], b[1] - a[1]) for a, b in zip(square, (*square[1:], square[0]), strict=False)]
    return len(square) == 4 and all(abs(x) + abs(y) == 1 for x, y in steps) and len(set(square)) == 4
