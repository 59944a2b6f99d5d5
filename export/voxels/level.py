"""The figures that the cells of a level draw, as solids: a system whose limit they are."""

from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise

import numpy as np
from jaxtyping import Float

from automata.automaton import Cell
from automata.topology import Topology
from export.voxels.frame import Model, Roots, Subject, corners_of, subject
from ifs import Complex, Shape, Surface, bounds, sample
from ifs.certificates.bounds import Box, extent
from ifs.drawing import check_figure, corner_paths, uses_corners, vertex_column
from ifs.system import State, System

Simplices = tuple[Float[np.ndarray, "_points _corners"], ...]
Faces = Sequence[tuple[int, ...]]

_WIDEST = 4096  # pieces of a level that are looked at for the largest one
_SAME = 12  # decimals within which two points of a figure are one

HALVES = (((0,), (0, 1)), ((0, 1), (1,)))
QUARTERS = (
    ((0,), (0, 1), (0, 2)),
    ((0, 1), (1,), (1, 2)),
    ((0, 2), (1, 2), (2,)),
    ((0, 1), (1, 2), (0, 2)),
)
EIGHTHS = (
    ((0,), (0, 1), (0, 2), (0, 3)),
    ((0, 1), (1,), (1, 2), (1, 3)),
    ((0, 2), (1, 2), (2,), (2, 3)),
    ((0, 3), (1, 3), (2, 3), (3,)),
    ((0, 1), (0, 2), (0, 3), (1, 3)),
    ((0, 1), (0, 2), (1, 2), (1, 3)),
    ((0, 2), (0, 3), (1, 3), (2, 3)),
    ((0, 2), (1, 2), (1, 3), (2, 3)),
)
"""The eight parts of a tetrahedron, their corners as the means of its own (Bey, Computing 55, 1995)."""

_PARTS = {1: (((0,),),), 2: HALVES, 3: QUARTERS, 4: EIGHTHS}


def level_of(found: Subject, model: Model | Subject, depth: int) -> Subject | None:
    """What a level of a shape draws, filled, as a subject whose limit it is; None where it is to be boxes.

    Every cell that is reached after `depth` subdivisions must have a stated figure that is no box. A segment
    is itself, a polygon is cut into triangles from its first corner on; faces that close (each edge twice,
    opposite ways) are filled with tetrahedra from the mean of their corners, connected faces alone, and a
    tetrahedron is one of these; other faces are cut into triangles. So a polygon must be seen whole from its
    first corner, a closed figure from the mean of its corners: else more is filled.

    The states of the new system are the old ones with the number of levels left, and simplices, which are
    made of copies of half their size: their operators have the entries 0, 1/2 and 1.

    Raises `automata.AutomatonError` for a face on a corner that the cell has not.

    >>> import ifs
    >>> from export.voxels.frame import subject
    >>> shape = ifs.shape("sierpinski-tetrahedron")
    >>> level = level_of(subject(shape), shape, 1)
    >>> [len(state.targets) for state in level.system.states.values()]
    [4, 1, 8]
    """
    topology = _topology(model)
    names = _reached(found.system, found.roots, depth)
    last = [cell for cell, left in names if not left]
    if topology is None or not _all_drawn(topology, last):
        return None
    points = sample(found.system)
    figures = {cell: _simplices(topology, points, topology.automaton.cells[cell]) for cell in last}
    system = _system(found.system, names, figures)
    boxes = bounds(system)
    roots = {_name(cell, depth): pieces for cell, pieces in found.roots.items()}
    sides = max(operator.shape[1] for made in figures.values() for operator in made) - 1
    grain = _largest(system, boxes, roots, depth + 1), min(sides, found.dimension)
    return Subject(
        found.name,
        system,
        roots,
        found.dimension,
        boxes,
        corners_of(system, boxes, roots),
        None,
        grain,
    )


def at_depth(found: Subject, model: Model | Subject, depth: int | None) -> tuple[Subject, int | None]:
    """The subject to voxelise, and the depth at which the boxes of its pieces are to be filled, if they are.

    The figures of a level take the place of a subject, and are voxelised without a depth.
    """
    level = None if depth is None else level_of(found, model, depth)
    return (found, depth) if level is None else (level, None)


def level_size(shape: Shape, depth: int) -> float | None:
    """The longest side, in mm, of a box around the figures of a level; None where they are to be boxes.

    >>> import ifs
    >>> level_size(ifs.shape("sierpinski-tetrahedron"), 1), level_size(ifs.shape("menger-sponge"), 1)
    (60.0, None)
    """
    reached = _reached(shape.system, [shape.system.shape], depth)
    if not _all_drawn(shape.topology, [cell for cell, left in reached if not left]):
        return None
    level = level_of(subject(shape), shape, depth)
    if level is None:
        return None
    return float(max(high - low for low, high in zip(*level.corners, strict=True)))


def _topology(model: Model | Subject) -> Topology | None:
    return model.topology if isinstance(model, Shape | Complex | Surface) else None


def _all_drawn(topology: Topology, names: Iterable[str]) -> bool:
    cells = topology.automaton.cells
    return all(name in cells and _drawn(topology, cells[name]) for name in names)


def _drawn(topology: Topology, cell: Cell) -> bool:
    """Whether a cell has a figure of its own, that is no box, and points for it to stand on."""
    figure = cell.figure
    if figure is None or figure.kind == "box":
        return False
    if figure.points or figure.kind in ("segment", "polygon"):
        return True
    return uses_corners(cell, corner_paths(topology, cell.name))


def _reached(system: System, roots: Iterable[str], depth: int) -> list[tuple[str, int]]:
    """The cells met with the levels left below them, from above, each once."""
    waiting = deque((cell, depth) for cell in roots)
    found = dict.fromkeys(waiting)
    while waiting:
        cell, left = waiting.popleft()
        for target in system.states[cell].targets if left else ():
            if (target, left - 1) not in found:
                found[target, left - 1] = None
                waiting.append((target, left - 1))
    return list(found)


def _name(cell: str, left: int) -> str:
    return f"{cell}, {left} left"


def _simplex(points: int) -> str:
    return f"simplex of {points}"


def _system(whole: System, names: Sequence[tuple[str, int]], figures: Mapping[str, Simplices]) -> System:
    states = {}
    for cell, left in names:
        state = whole.states[cell]
        if left:
            targets = tuple(_name(target, left - 1) for target in state.targets)
            labels, operators = state.labels, state.operators
        else:
            operators = figures[cell]
            targets = tuple(_simplex(operator.shape[1]) for operator in operators)
            labels = tuple(str(number) for number in range(len(operators)))
        states[_name(cell, left)] = State(_name(cell, left), state.points, labels, targets, operators)
    for size in sorted({operator.shape[1] for made in figures.values() for operator in made}):
        name, operators = _simplex(size), _halved(size)
        labels = tuple(str(number) for number in range(len(operators)))
        states[name] = State(name, size, labels, (name,) * len(operators), operators)
    return System(next(iter(states)), states)


def _halved(size: int) -> Simplices:
    """The operators of a simplex of so many points into its parts."""
    operators = []
    for part in _PARTS[size]:
        operator = np.zeros((size, size))
        for column, means in enumerate(part):
            operator[list(means), column] = 1 / len(means)
        operators.append(operator)
    return tuple(operators)


def _simplices(topology: Topology, points: Mapping[str, np.ndarray], cell: Cell) -> Simplices:
    """The simplices that a cell's figure is made of, a column of barycentric coordinates for each corner."""
    corners, faces = _figure(topology, points, cell)
    corners, faces = _merged(corners, faces)
    made: list[np.ndarray] = []
    for patch in _connected(faces):
        if _closed(patch):
            made += _filled(corners, patch)
        else:
            made += [corners[:, list(each)] for face in patch for each in _fan(face)]
    return tuple(made)


def _figure(
    topology: Topology, points: Mapping[str, np.ndarray], cell: Cell
) -> tuple[Float[np.ndarray, "_points _corners"], Faces]:
    """The corners of a cell's figure as columns, and its faces, as `ifs.draw` draws them."""
    figure = cell.figure
    assert figure is not None
    paths = corner_paths(topology, cell.name)
    check_figure(cell, len(paths))
    if uses_corners(cell, paths):
        columns = np.stack([vertex_column(topology, points, cell.name, path) for path in paths], axis=1)
    elif figure.points:
        columns = np.array(figure.points, dtype=float).T
    else:
        columns = np.eye(cell.points)
    count = columns.shape[1]
    if figure.kind == "segment":
        return columns, ((0, count - 1),)
    return columns, figure.faces or (tuple(range(count)),)


def _merged(
    corners: Float[np.ndarray, "points _corners"], faces: Faces
) -> tuple[Float[np.ndarray, "points _kept"], Faces]:
    """Corners at one place as one, and faces without corners that follow themselves."""
    number: dict[bytes, int] = {}
    first = []
    place = []
    for column in corners.T:
        key = (np.round(column, _SAME) + 0.0).tobytes()
        if key not in number:
            number[key] = len(number)
            first.append(column)
        place.append(number[key])
    merged = []
    for face in faces:
        walk = [place[corner] for corner in face]
        kept = [here for before, here in zip([walk[-1], *walk], walk, strict=False) if here != before]
        merged.append(tuple(kept) or (walk[0],))
    return np.stack(first, axis=1), merged


def _connected(faces: Faces) -> list[list[tuple[int, ...]]]:
    """The faces in patches that share corners."""
    patches: list[tuple[set[int], list[tuple[int, ...]]]] = []
    for face in faces:
        corners, joined = set(face), [face]
        apart = []
        for known, others in patches:
            if known & corners:
                corners |= known
                joined = others + joined
            else:
                apart.append((known, others))
        patches = [*apart, (corners, joined)]
    return [joined for _, joined in patches]


def _closed(faces: Faces) -> bool:
    """Whether every edge is there twice, opposite ways."""
    edges = [edge for face in faces for edge in pairwise((*face, face[0]))]
    known = set(edges)
    whole = len(known) == len(edges) and all((b, a) in known for a, b in edges)
    return whole and min(len(face) for face in faces) > 2


def _fan(face: tuple[int, ...]) -> list[tuple[int, ...]]:
    if len(face) < 4:
        return [face]
    return [(face[0], *edge) for edge in pairwise(face[1:])]


def _filled(corners: Float[np.ndarray, "points _corners"], faces: Faces) -> list[np.ndarray]:
    """The tetrahedra within a closed surface, which the mean of its corners sees whole."""
    used = sorted({corner for face in faces for corner in face})
    if len(used) == 4:
        return [corners[:, used]]
    middle = corners[:, used].mean(axis=1, keepdims=True)
    return [np.hstack([middle, corners[:, list(each)]]) for face in faces for each in _fan(face)]


def _largest(system: System, boxes: Mapping[str, Box], roots: Roots, levels: int) -> float:
    """The longest diagonal in mm of the boxes of the simplices; of many the largest pieces are followed."""
    pieces = dict(roots)
    for _ in range(levels):
        below: dict[str, list[np.ndarray]] = {}
        for name, control in pieces.items():
            lo, hi = extent(boxes[name], control)
            order = np.argsort(-np.linalg.norm(hi - lo, axis=1), kind="stable")[:_WIDEST]
            state = system.states[name]
            for target, operator in zip(state.targets, state.operators, strict=True):
                below.setdefault(target, []).append(operator.T @ control[order])
        pieces = {name: np.concatenate(parts) for name, parts in below.items()}
    ends = [extent(boxes[name], control) for name, control in pieces.items()]
    return max(float(np.linalg.norm(hi - lo, axis=1).max()) for lo, hi in ends)
