"""Refinement only where it is needed, without gaps: a coarse face takes in what hangs on its sides."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int

from automata.automaton import Word
from automata.topology import Topology
from ifs.adaptivity.flatness import Stop, within
from ifs.adaptivity.hanging import History, Leaves
from ifs.asked import require_whole
from ifs.certificates.bounds import sample
from ifs.complex import Complex, refine_traced
from ifs.drawing import vertex_column
from ifs.mesh import Mesh
from ifs.subcomplex import subcomplex
from ifs.tangency.frames import Frame, frames

Numbers = Int[np.ndarray, "_cells"]
Table = Mapping[str, Numbers]


@dataclass(frozen=True)
class _Level:
    """The pieces of one level that are not drawn yet, with the numbers of their vertices and sides.

    `rims` tells which sides belong to one piece of the shape alone.
    """

    complex: Complex
    vertices: Table
    sides: Table
    rims: Mapping[str, Bool[np.ndarray, "_cells"]]


def adaptive(complex_: Complex, stop: float | Stop, depth: int = 10) -> Mesh:
    """The conformal mesh of a complex whose pieces are subdivided until flat, at most `depth` times.

    `stop` is a tolerance in mm, as `flatness.within` reads it, or a function that says which pieces of
    a cell are drawn as they are. All vertices are limit points. Where a face has finer neighbours, their
    vertices on its sides are corners of its polygon too: the mesh has the gaps that the shape has, and no
    others. Faces with fewer corners end in -1.

    Raises `NotParametrised` for pieces that are no curves, triangles or quadrangles, `ValueError` for a
    negative depth or a tolerance that is not above 0.

    >>> from ifs.complex import initial
    >>> from ifs.shape import shape
    >>> curve = shape("corner-cutting")
    >>> whole = initial(curve.topology, curve.system, curve.control)
    >>> len(adaptive(whole, 5.0).faces), len(adaptive(whole, 0.01).faces)
    (2, 50)
    """
    require_whole("depth", depth)
    topology = complex_.topology
    found = frames(topology, complex_.control)
    if not callable(stop):
        stop = within(topology, complex_.system, tuple(complex_.control), stop)
    points = sample(complex_.system)
    limits = {
        cell: np.stack([vertex_column(topology, points, cell, path) for path in frame.corners])
        for cell, frame in found.items()
    }
    history = History()
    level = _first(complex_, found, history)
    for step in range(depth + 1):
        going: dict[str, np.ndarray] = {}
        for cell in level.complex.control:
            control = np.asarray(level.complex.control[cell])
            sides, forward, rim = _sides(level, found[cell], cell)
            done = stop(cell, control, rim) if step < depth else np.ones(len(control), dtype=bool)
            corners = _corners(level, found[cell], cell)
            positions = np.einsum("kp,npd->nkd", limits[cell], control[done])
            history.leaves.append(Leaves(corners[done], sides[done], forward[done], positions))
            going[cell] = np.flatnonzero(~done)
        if not any(len(chosen) for chosen in going.values()):
            break
        level = _next(_restricted(level, going), found, history)
    return history.mesh(next(iter(complex_.control.values())).shape[2])


def _first(complex_: Complex, found: Mapping[str, Frame], history: History) -> _Level:
    vertices = {
        cell: history.new_vertices(count)
        for cell, count in complex_.counts.items()
        if complex_.topology.is_point(cell)
    }
    uses = {cell: np.zeros(complex_.counts[cell], dtype=np.int64) for cell in _side_cells(complex_, found)}
    for cell, control in complex_.control.items():
        for side in found[cell].sides:
            np.add.at(uses[side.cell], complex_.boundary[cell][side.label].ids[: len(control)], 1)
    sides = {cell: history.new_sides(_ends(complex_, found[cell], vertices, cell)) for cell in uses}
    return _Level(complex_, vertices, sides, {cell: times == 1 for cell, times in uses.items()})


def _side_cells(complex_: Complex, found: Mapping[str, Frame]) -> list[str]:
    cells = dict.fromkeys(side.cell for frame in found.values() for side in frame.sides)
    return [cell for cell in cells if cell in complex_.counts]


def _ends(complex_: Complex, frame: Frame, vertices: Table, cell: str) -> Int[np.ndarray, "sides 2"]:
    ids = np.arange(complex_.counts[cell])
    return np.stack([_at(complex_, vertices, cell, path, ids) for path in frame.corners], axis=1)


def _at(complex_: Complex, vertices: Table, cell: str, path: Word, ids: Numbers) -> Numbers:
    return vertices[complex_.topology.automaton.end(cell, path)][complex_.boundary_at(cell, path, ids).ids]


def _corners(level: _Level, frame: Frame, cell: str) -> Int[np.ndarray, "pieces corners"]:
    ids = np.arange(len(level.complex.control[cell]))
    columns = [_at(level.complex, level.vertices, cell, path, ids) for path in frame.corners]
    return np.stack(columns, axis=1)


def _sides(
    level: _Level, frame: Frame, cell: str
) -> tuple[
    Int[np.ndarray, "pieces sides"], Bool[np.ndarray, "pieces sides"], Bool[np.ndarray, "pieces sides"]
]:
    """The numbers of the sides of all pieces of a cell, whether each runs around, and which lie on a rim."""
    count = len(level.complex.control[cell])
    numbers = np.empty((count, len(frame.sides)), dtype=np.int64)
    forward = np.empty(numbers.shape, dtype=bool)
    rim = np.empty(numbers.shape, dtype=bool)
    for k, side in enumerate(frame.sides):
        seen = level.complex.boundary[cell][side.label]
        ids = seen.ids[:count]
        numbers[:, k] = level.sides[side.cell][ids]
        rim[:, k] = level.rims[side.cell][ids]
        forward[:, k] = _keeps_its_way(level.complex.topology, side.cell)[seen.turn[:count]] == side.forward
    return numbers, forward, rim


def _keeps_its_way(topology: Topology, cell: str) -> Bool[np.ndarray, "turns"]:
    """For each symmetry of a side, whether its first end stays the first."""
    coincident = topology.coincident(cell)
    first = next(path for path in coincident if topology.is_point(topology.automaton.end(cell, path)))
    images = [topology.groups.normal(cell, first, element)[0] for element in topology.groups.elements[cell]]
    return np.array([coincident[image][0] == first for image in images])


def _restricted(level: _Level, going: Mapping[str, np.ndarray]) -> _Level:
    """The given pieces with their boundaries, without all others."""
    part, was = subcomplex(level.complex, going)
    vertices, sides, rims = (
        {cell: table[cell][was[cell]] for cell in table if cell in was}
        for table in (level.vertices, level.sides, level.rims)
    )
    return _Level(part, vertices, sides, rims)


def _next(level: _Level, found: Mapping[str, Frame], history: History) -> _Level:
    """One subdivision: vertices keep their numbers, sides are split, and what is born gets new numbers."""
    old, cells = level.complex, level.complex.topology.automaton.cells
    new, numbered = refine_traced(old)
    vertices = {c: np.full(n, -1) for c, n in new.counts.items() if old.topology.is_point(c)}
    for cell, numbers in level.vertices.items():
        for label, target in cells[cell].subdivision.items():
            vertices[target][numbered(cell, label, np.arange(len(numbers)))] = numbers
    for numbers in vertices.values():
        numbers[numbers < 0] = history.new_vertices(int((numbers < 0).sum()))
    side_cells = _side_cells(new, found)
    sides = {cell: history.new_sides(_ends(new, found[cell], vertices, cell)) for cell in side_cells}
    rims = {cell: np.zeros(new.counts[cell], dtype=bool) for cell in side_cells}
    for cell, numbers in level.sides.items():
        frame = found[cell]
        ways = np.array([part.axes[0, 0] > 0 for part in frame.parts])
        order = np.argsort([part.origin[0] + part.axes[0, 0] / 2 for part in frame.parts])
        parts = []
        for label, part in zip(cells[cell].subdivision, frame.parts, strict=True):
            ids = numbered(cell, label, np.arange(len(numbers)))
            rims[part.cell][ids] = level.rims[cell]
            parts.append(sides[part.cell][ids])
        history.split.append((numbers, np.stack(parts, axis=1)[:, order], ways[order]))
    return _Level(new, vertices, sides, rims)
