"""What each piece of a shape draws, and the mesh of all pieces with shared vertices."""

from collections.abc import Mapping
from itertools import pairwise, product

import numpy as np
from jaxtyping import Float, Int

from automata.automaton import Cell, Word
from automata.error import AutomatonError
from automata.topology import Topology, embedding
from ifs.certificates.bounds import bounds, extent, sample
from ifs.complex import Complex
from ifs.mesh import Mesh

_BOX_FACES = {  # by dimension; corner i of a box has the upper end of axis a where bit a of i is set
    1: ((0, 1),),
    2: ((0, 1, 3, 2),),
    3: ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)),
}

Positions = Float[np.ndarray, "vertices dim"]
Faces = Int[np.ndarray, "faces corners"]


def draw(complex_: Complex) -> Mesh:
    """The mesh of the figures of all pieces of a complex: shared vertices first, then unshared ones."""
    topology = complex_.topology
    start: dict[str, int] = {}
    total = 0
    for state, count in complex_.counts.items():
        if topology.is_point(state):
            start[state] = total
            total += count
    dimension = next(iter(complex_.control.values())).shape[2]
    vertices = [np.full((total, dimension), np.nan)]
    faces: list[Faces] = []
    for state, control in complex_.control.items():
        cell = topology.automaton.cells[state]
        corners = corner_paths(topology, state)
        check_figure(cell, len(corners))
        if uses_corners(cell, corners):
            faces.append(_corner_faces(complex_, cell, corners, start, vertices[0]))
        else:
            own, table = _own_figure(complex_, cell, control)
            faces.append(np.where(table >= 0, table + total, -1))
            vertices.append(own)
            total += len(own)
    return _without_unused(np.concatenate(vertices), padded(faces))


def uses_corners(cell: Cell, corners: tuple[Word, ...]) -> bool:
    """Whether a cell draws the limit vertices of its boundary: when it has some and no figure of its own."""
    figure = cell.figure
    return len(corners) > 1 and (figure is None or not (figure.points or figure.kind == "box"))


def check_figure(cell: Cell, corners: int) -> None:
    """Raise `AutomatonError` for a face on a corner that the cell has not."""
    figure = cell.figure
    if figure is None or figure.points or not figure.faces:
        return
    most = max(max(face) for face in figure.faces)
    if most >= corners:
        path = ("cells", cell.name, "figure")
        raise AutomatonError(f"a face names corner {most}; the cell has {corners}, counted from 0", path=path)


def corner_paths(topology: Topology, cell: str) -> tuple[Word, ...]:
    """The boundary paths to the corners of a cell, in order around it.

    Where every boundary is an edge with two ends, the edges are chained into a cycle; otherwise the
    corners come in the order in which the boundaries list them, each once.
    """
    coincident = topology.coincident(cell)
    ends = {p: topology.automaton.end(cell, p) for p in topology.boundaries(cell)}
    corners = list(dict.fromkeys(coincident[p][0] for p, end in ends.items() if topology.is_point(end)))
    edges = []
    for label in topology.automaton.cells[cell].boundary:
        inner = corner_paths(topology, topology.automaton.cells[cell].boundary[label].cell)
        edges.append([coincident[(label, *path)][0] for path in inner])
    if len(edges) > 2 and all(len(edge) == 2 for edge in edges):
        return _cycle(edges) or tuple(corners)
    return tuple(corners)


def _cycle(edges: list[list[Word]]) -> tuple[Word, ...]:
    """The corners met when the edges are walked end to end; nothing when they form no single cycle."""
    rest = [list(edge) for edge in edges[1:]]
    walk = list(edges[0])
    while rest:
        step = next((edge for edge in rest if walk[-1] in edge), None)
        if step is None:
            return ()
        rest.remove(step)
        walk.append(step[0] if step[1] == walk[-1] else step[1])
    return tuple(walk[:-1]) if walk[0] == walk[-1] else ()


def _corner_faces(
    complex_: Complex, cell: Cell, corners: tuple[Word, ...], start: dict[str, int], vertices: Positions
) -> Faces:
    """The faces on shared vertices of all pieces of one state; fills in the vertices' positions."""
    control = complex_.control[cell.name]
    ids = np.arange(len(control))
    points = sample(complex_.system)
    columns = []
    for path in corners:
        end = complex_.topology.automaton.end(cell.name, path)
        numbers = start[end] + complex_.boundary_at(cell.name, path, ids).ids
        vertices[numbers] = np.einsum(
            "j,cjd->cd", vertex_column(complex_.topology, points, cell.name, path), control
        )
        columns.append(numbers)
    table = np.stack(columns, axis=1)
    stated = cell.figure.faces if cell.figure and cell.figure.faces else (tuple(range(len(corners))),)
    if cell.figure and cell.figure.kind == "segment":
        stated = ((0, len(corners) - 1),)
    return padded([table[:, list(face)] for face in stated])


def vertex_column(
    topology: Topology, points: Mapping[str, Float[np.ndarray, "_points"]], cell: str, path: Word
) -> Float[np.ndarray, "_cell_points"]:
    """The barycentric limit, in a cell, of the vertex at the end of a boundary path.

    `points` holds the limit point of each vertex cell, as `ifs.sample` gives it. `column @ control` is the
    point in space.
    """
    column = np.zeros(topology.automaton.cells[cell].points)
    columns = embedding(topology.automaton, cell, path)
    for entries, weight in zip(columns, points[topology.automaton.end(cell, path)], strict=True):
        for row, value in entries:
            column[row] += float(value) * weight
    return column


def _own_figure(complex_: Complex, cell: Cell, control: np.ndarray) -> tuple[Positions, Faces]:
    """Unshared vertices and faces of all pieces of one state: its own points, or its box."""
    if cell.figure and cell.figure.points:
        weights = np.array(cell.figure.points, dtype=float)
        corners = np.einsum("kj,cjd->ckd", weights, control)
        faces = cell.figure.faces
    elif cell.figure and cell.figure.kind in ("segment", "polygon"):
        corners = control
        size = control.shape[1]
        faces = ((0, size - 1),) if cell.figure.kind == "segment" else (tuple(range(size)),)
    else:
        corners = _box_corners(*extent(bounds(complex_.system)[cell.name], control))
        faces = _BOX_FACES.get(control.shape[2], tuple(pairwise(range(corners.shape[1]))))
    count, each, dimension = corners.shape
    base = each * np.arange(count)[:, None]
    table = padded([base + np.array(face) for face in faces])
    return corners.reshape(count * each, dimension), table


def drawn_boxes(lo: Positions, hi: Positions) -> Mesh:
    """The mesh of boxes with the given lower and upper corners, `(boxes, dim)` in mm, which share nothing.

    >>> drawn_boxes(np.zeros((1, 3)), np.ones((1, 3))).faces.shape
    (6, 4)
    """
    count, dimension = lo.shape
    corners = _box_corners(lo, hi)
    faces = np.array(_BOX_FACES.get(dimension, tuple(pairwise(range(2**dimension)))))
    table = (2**dimension * np.arange(count))[:, None, None] + faces
    return Mesh(corners.reshape(-1, dimension), table.reshape(-1, faces.shape[1]))


def _box_corners(lo: Positions, hi: Positions) -> Float[np.ndarray, "boxes corners dim"]:
    choices = [choice[::-1] for choice in product((0, 1), repeat=lo.shape[1])]
    return np.where(np.array(choices)[None] == 1, hi[:, None], lo[:, None])


def padded(tables: list[Int[np.ndarray, "_ _"]], width: int | None = None) -> Faces:
    """Tables of faces one after the other, the narrow ones filled up with -1 to a width or the widest."""
    width = width or max(table.shape[1] for table in tables)
    wide = [np.pad(t, ((0, 0), (0, width - t.shape[1])), constant_values=-1) for t in tables]
    return np.concatenate(wide)


def _without_unused(vertices: Positions, faces: Faces) -> Mesh:
    """The mesh without the vertices that no face uses."""
    used = np.zeros(len(vertices), dtype=bool)
    used[faces[faces >= 0]] = True
    number = np.cumsum(used) - 1
    return Mesh(vertices[used], np.where(faces >= 0, number[faces], -1))
