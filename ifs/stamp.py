"""The mesh of a complex after any number of subdivisions, stamped from one template a state."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from automata.automaton import Word
from automata.symmetry import inverse
from ifs.asked import require_whole
from ifs.complex import Complex, Ids, Seen
from ifs.drawing import padded
from ifs.mesh import Mesh
from ifs.stencil import Stencils
from ifs.template import NotStamped, Templates

Faces = Int[np.ndarray, "_faces _corners"]
Positions = Float[np.ndarray, "_vertices dim"]
Control = Float[np.ndarray, "_cells _points dim"]

CHUNK = 1 << 16
"""How many numbers of points are looked up at a time, so that they stay in the cache."""


@dataclass(frozen=True)
class Stamped:
    """A mesh, and the piece and the address that each of its faces comes from.

    The faces stand state by state in the order of `pieces` (state to number of pieces), piece by piece, and
    within a piece in the order of addresses.
    """

    mesh: Mesh
    pieces: Mapping[str, int]
    depth: int
    templates: Templates

    def piece(self) -> Int[np.ndarray, "faces"]:
        """The number of the piece that each face comes from, counted through all states in order."""
        each = [len(self.templates.template(state, self.depth).faces) for state in self.pieces]
        counts = list(self.pieces.values())
        return np.repeat(np.arange(sum(counts)), np.repeat(each, counts))

    def addresses(self) -> Int[np.ndarray, "faces depth"]:
        """The address of each face in its piece: the numbers of its labels, first label first."""
        tables = [
            np.tile(self.templates.addresses(state, self.depth), (count, 1))
            for state, count in self.pieces.items()
        ]
        return np.concatenate(tables)

    def located(self, face: int) -> tuple[str, int, Word]:
        """The state, the number of the piece in this state, and the address of one face."""
        rest = face
        for state, count in self.pieces.items():
            each = len(self.templates.template(state, self.depth).faces)
            if 0 <= rest < count * each:
                return state, rest // each, self.templates.address(state, self.depth, rest % each)
            rest -= count * each
        raise IndexError(f"there is no face {face}: the mesh has {len(self.mesh.faces)} faces")


def supports(complex_: Complex, depth: int) -> bool:
    """Whether `stamped` draws a complex: no piece draws the box that bounds it at this depth."""
    templates = Templates(complex_.topology)
    try:
        for state in complex_.control:
            templates.own(state, depth)
    except NotStamped:
        return False
    return True


def stamped(complex_: Complex, depth: int, stencils: Stencils | None = None) -> Stamped:
    """The mesh that `draw(refined(complex_, depth))` makes, vertices and faces in another order.

    A cell of state x has the points I(x, depth) of its own (see `ifs.template`), numbered in one block for
    all cells of the state; the faces of a piece are those of its state's template with the numbers looked up
    in these blocks, and the points of all cells of a state one product with their control points.
    Lengths are in millimetres. `stencils` of the same topology and system may be handed over to be used
    again. Raises `NotStamped` where a piece draws the box that bounds it, and `ValueError` for a negative
    depth.

    >>> import ifs
    >>> curve = ifs.shape("corner-cutting")
    >>> found = stamped(ifs.initial(curve.topology, curve.system, curve.control), 3)
    >>> found.mesh.vertices.shape, found.mesh.faces.shape
    ((9, 2), (8, 2))
    >>> found.located(5)
    ('edge', 0, ('1', '0', '1'))
    """
    require_whole("depth", depth)
    stencils = stencils or Stencils(Templates(complex_.topology), complex_.system)
    templates = stencils.templates
    borders = {state: _borders(complex_, templates, state, depth) for state in complex_.control}
    control = _spread(complex_, stencils, borders)
    start, own, total = _blocks(complex_, templates, depth)
    vertices = np.empty((total, next(iter(complex_.control.values())).shape[2]))
    for state, points in control.items():
        count = templates.born(state, depth)
        _write(stencils, state, depth, points, vertices, start[state], count, False)
    for state, points in complex_.control.items():
        _write(stencils, state, depth, points, vertices, own[state], templates.own(state, depth), True)
    faces = _faces(complex_, templates, depth, borders, start, own)
    pieces = {state: len(found) for state, found in complex_.control.items()}
    return Stamped(_without_unused(vertices, faces), pieces, depth, templates)


def _borders(complex_: Complex, templates: Templates, state: str, depth: int) -> dict[Word, Seen]:
    """The boundary cells of all pieces of a state, by path."""
    ids = np.arange(len(complex_.control[state]))
    paths = [path for path in templates.template(state, depth).start if path]
    return {path: complex_.boundary_at(state, path, ids) for path in paths}


def _spread(
    complex_: Complex, stencils: Stencils, borders: Mapping[str, Mapping[Word, Seen]]
) -> dict[str, Control]:
    """The control points of all cells: those of a boundary cell are what the first piece found there says.

    A piece sees the cell through a symmetry g, and control point j of what it sees is point g[j] of the cell.
    """
    topology = complex_.topology
    dimension = next(iter(complex_.control.values())).shape[2]
    result = {}
    for state, count in complex_.counts.items():
        known = complex_.control.get(state, np.empty((0, topology.automaton.cells[state].points, dimension)))
        missing = ((0, count - len(known)), (0, 0), (0, 0))
        result[state] = np.pad(known, missing, constant_values=np.nan) if count > len(known) else known
    for state, seen in borders.items():
        for path, (ids, turn) in seen.items():
            end = topology.automaton.end(state, path)
            elements = list(topology.groups.elements[end])
            found = _first(ids, np.flatnonzero(np.isnan(result[end][ids, 0, 0])), len(result[end]))
            for number in np.unique(turn[found]):
                chosen = found[turn[found] == number]
                columns = stencils.operator(state, path)[:, inverse(elements[number])]
                result[end][ids[chosen]] = np.matmul(columns.T, complex_.control[state][chosen])
    return result


def _first(ids: Ids, pieces: Int[np.ndarray, "_chosen"], count: int) -> Int[np.ndarray, "_first"]:
    """Of the given pieces those that come first at their boundary cell, one a cell."""
    owner = np.empty(count, dtype=np.int64)
    owner[ids[pieces[::-1]]] = pieces[::-1]
    return pieces[owner[ids[pieces]] == pieces]


def _blocks(
    complex_: Complex, templates: Templates, depth: int
) -> tuple[dict[str, int], dict[str, int], int]:
    """Where the points born inside all cells of each state begin, then where those of figures do; and the
    number of all points.
    """
    start, own = {}, {}
    total = 0
    for state, count in complex_.counts.items():
        start[state] = total
        total += count * templates.born(state, depth)
    for state, pieces in complex_.control.items():
        own[state] = total
        total += len(pieces) * templates.own(state, depth)
    return start, own, total


def _write(
    stencils: Stencils,
    state: str,
    depth: int,
    control: Control,
    vertices: Float[np.ndarray, "_vertices dim"],
    first: int,
    each: int,
    own: bool,
) -> None:
    block = vertices[first : first + len(control) * each]
    stencils.positions(state, depth, control, block.reshape(len(control), each, vertices.shape[1]), own)


class _Block(NamedTuple):
    """A run of a template's points that are born inside one cell: where it begins in the template, the
    numbers of its points in the mesh for each piece, `first + row[turn]`.
    """

    begin: int
    first: Ids
    turn: Ids
    rows: Int[np.ndarray, "_turns _born"]


def _faces(
    complex_: Complex,
    templates: Templates,
    depth: int,
    borders: Mapping[str, Mapping[Word, Seen]],
    start: Mapping[str, int],
    own: Mapping[str, int],
) -> Faces:
    """The faces of all pieces, state by state."""
    found = {state: templates.template(state, depth) for state in complex_.control}
    count = sum(len(complex_.control[state]) * len(template.faces) for state, template in found.items())
    result = np.empty((count, max(template.faces.shape[1] for template in found.values())), dtype=np.int64)
    begin = 0
    for state, template in found.items():
        pieces = len(complex_.control[state])
        blocks = _looked_up(complex_, templates, state, depth, borders[state], start, own)
        end = begin + pieces * len(template.faces)
        wide = padded([template.faces], result.shape[1])
        _stamp(wide, template.size, blocks, result[begin:end].reshape(pieces, -1))
        begin = end
    return result


def _looked_up(
    complex_: Complex,
    templates: Templates,
    state: str,
    depth: int,
    borders: Mapping[Word, Seen],
    start: Mapping[str, int],
    own: Mapping[str, int],
) -> list[_Block]:
    """The blocks of a state's template; all pieces see their own points as they are."""
    template = templates.template(state, depth)
    ids = np.arange(len(complex_.control[state]))
    as_is = np.zeros_like(ids)
    result = []
    for begin, first, each in (
        (0, start[state], templates.born(state, depth)),
        (template.own, own[state], template.size - template.own),
    ):
        result.append(_Block(begin, first + ids * each, as_is, np.arange(each)[None]))
    for path, seen in borders.items():
        end = templates.automaton.end(state, path)
        elements = list(templates.topology.groups.elements[end])
        used, turn = np.unique(seen.turn, return_inverse=True)
        rows = np.stack([templates.turned(end, elements[number], depth) for number in used])
        first = start[end] + seen.ids * templates.born(end, depth)
        result.append(_Block(template.start[path], first, turn, rows))
    return result


def _stamp(
    template: Faces, size: int, blocks: Sequence[_Block], out: Int[np.ndarray, "pieces _numbers"]
) -> None:
    """Writes the template's faces, with the numbers that its points have, for each piece."""
    pattern = np.where(template < 0, size, template).ravel()
    step = max(1, CHUNK // (size + 1))
    for begin in range(0, len(out), step):
        chosen = slice(begin, begin + step)
        number = np.empty((len(out[chosen]), size + 1), dtype=np.int64)
        number[:, size] = -1
        for block in blocks:
            rows = block.rows if len(block.rows) == 1 else block.rows[block.turn[chosen]]
            last = block.begin + rows.shape[1]
            np.add(block.first[chosen, None], rows, out=number[:, block.begin : last])
        np.take(number, pattern, axis=1, out=out[chosen], mode="clip")


def _without_unused(vertices: Positions, faces: Faces) -> Mesh:
    """The mesh without the points that no face uses."""
    used = np.zeros(len(vertices) + 1, dtype=bool)
    used[faces.ravel()] = True  # the last one stands for the -1 of shorter faces
    if used[:-1].all():
        return Mesh(vertices, faces)
    number = np.append(np.cumsum(used[:-1]) - 1, -1)
    return Mesh(vertices[used[:-1]], number[faces])
