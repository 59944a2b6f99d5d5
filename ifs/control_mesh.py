"""The smooth surface of any closed control mesh: its patches found, and drawn by the automaton."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float, Int

from automata.topology import Topology
from ifs.closed_mesh import ClosedMesh, Numbers, Polygons, closed_mesh
from ifs.complex import Complex, refined
from ifs.drawing import draw
from ifs.mesh import Mesh
from ifs.patchwork import patchwork
from ifs.polygon_step import catmull_clark_step, doo_sabin_step
from ifs.shape import system
from subdivision.schemes import catmull_clark, doo_sabin
from subdivision.schemes.quad_patches import REGULAR, Scheme, automaton, canonical, face_name

Rows = Int[np.ndarray, "_patches _points"]


@dataclass(frozen=True)
class _Way:
    """How a scheme reads a mesh: the first step that it may need, and its patches' corners and stars.

    `corners(mesh)` gives two tables `(patches, 4)`: the half-edge of each corner of each patch, and the
    valence there. `star(mesh, halves, valence)` lists the star of a corner, from the side after it on.
    """

    scheme: Scheme
    step: Callable[[ClosedMesh], ClosedMesh]
    corners: Callable[[ClosedMesh], tuple[Numbers, Numbers] | None]
    star: Callable[[ClosedMesh, Numbers, int], list[Numbers]]


@dataclass(frozen=True)
class Surface:
    """The patches of a control mesh: control points in millimetres, and which of them each patch uses.

    `patches[cell]` is `(patches, points)`; the topology's automaton has a cell for each kind of patch.
    """

    topology: Topology
    control: Float[np.ndarray, "control 3"]
    patches: Mapping[str, Rows]

    def complex(self) -> Complex:
        """The patches with their shared edges and vertices, to be refined and drawn."""
        whole = self.topology.automaton
        numbers = {
            name: {label: _numbers(rows) for label, rows in cell.matrices.items()}
            for name, cell in whole.cells.items()
        }
        return patchwork(self.topology, system(whole, numbers), self.control, self.patches)


def surface(vertices: Any, faces: Polygons, scheme: str = "catmull-clark") -> Surface:
    """The patches of a closed mesh of polygons, for the scheme "catmull-clark" or "doo-sabin".

    `vertices` is `(n, 3)` in millimetres; faces are lists of vertex numbers, or rows that end in -1,
    counterclockwise seen from outside. A Catmull-Clark patch is a quadrangle; where the mesh has other faces,
    one step of subdivision makes it quadrangles. A Doo-Sabin patch is a vertex with four faces; where the
    mesh has other vertices, one step gives it four faces at each. The control points are then those after
    the step.

    Raises `WrongMesh` with the face that is wrong, and `ValueError` for an unknown scheme.

    >>> corners = [(x, y, z) for z in (0, 9) for y in (0, 9) for x in (0, 9)]
    >>> sides = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    >>> {cell: rows.shape for cell, rows in surface(corners, sides).patches.items()}
    {'face-3-3-3-3': (6, 8)}
    """
    if scheme not in _WAYS:
        raise ValueError(f"unknown scheme {scheme!r}: expected one of {', '.join(_WAYS)}")
    way = _WAYS[scheme]
    mesh = closed_mesh(vertices, faces)
    found = way.corners(mesh)
    if found is None:
        mesh = way.step(mesh)
        found = way.corners(mesh)
        assert found is not None
    patches = _patches(way, mesh, *found)
    return Surface(
        Topology(automaton(way.scheme, patches)), mesh.vertices, {face_name(k): v for k, v in patches.items()}
    )


def smooth(vertices: Any, faces: Polygons, depth: int, scheme: str = "catmull-clark") -> Mesh:
    """The conformal mesh of the limit surface of a closed control mesh, each patch in `4^depth` faces.

    Its vertices are limit points, exact to rounding at any depth. Arguments and errors as for `surface`; also
    `ValueError` for a negative depth.

    >>> corners = [(x, y, z) for z in (0, 9) for y in (0, 9) for x in (0, 9)]
    >>> sides = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    >>> ball = smooth(corners, sides, 3)
    >>> len(ball.vertices), len(ball.faces)
    (386, 384)
    """
    if depth < 0:
        raise ValueError(f"the depth is 0 or more, found {depth}")
    return draw(refined(surface(vertices, faces, scheme).complex(), depth))


def _numbers(rows: Sequence[Sequence[Any]]) -> tuple:
    return tuple(tuple(entry.value for entry in row) for row in rows)


def _patches(way: _Way, mesh: ClosedMesh, corners: np.ndarray, valences: np.ndarray) -> dict[tuple, Rows]:
    """The control points of each patch, by the kind of the patch."""
    distinct, kind_of = np.unique(valences, axis=0, return_inverse=True)
    kind_of = kind_of.reshape(-1)
    turns = [canonical((int(a), int(b), int(c), int(d))) for a, b, c, d in distinct]
    result: dict[tuple, list[Rows]] = {}
    for number, (kind, first) in enumerate(turns):
        chosen = np.roll(corners[kind_of == number], -first, axis=1)
        stars = [way.star(mesh, chosen[:, i], n) for i, n in enumerate(kind)]
        result.setdefault(kind, []).append(np.stack(way.scheme.face_row(stars), axis=1))
    return {kind: np.concatenate(result[kind]) for kind in sorted(result)}


def _quadrangles(mesh: ClosedMesh) -> tuple[np.ndarray, np.ndarray] | None:
    """The corners of the faces and the faces around each; nothing unless all faces are quadrangles."""
    if (mesh.sizes != REGULAR).any():
        return None
    halves = np.arange(len(mesh.origin)).reshape(-1, 4)
    return halves, mesh.valences[mesh.origin[halves]]


def _star_of_vertex(mesh: ClosedMesh, halves: Numbers, valence: int) -> list[Numbers]:
    """The vertex, then its neighbours and the corners opposite it, counterclockwise from a half-edge on."""
    star = [mesh.origin[halves]]
    for _ in range(valence):
        star += [mesh.origin[mesh.after[halves]], mesh.origin[mesh.before[mesh.before[halves]]]]
        halves = mesh.around(halves)
    return star


def _crossings(mesh: ClosedMesh) -> tuple[np.ndarray, np.ndarray] | None:
    """The half-edges from each vertex and the sizes of their faces; nothing unless all vertices have four."""
    valences = mesh.valences
    if (valences[mesh.origin] != REGULAR).any():
        return None
    first = np.unique(mesh.origin, return_index=True)[1]
    halves = [first]
    for _ in range(3):
        halves.append(mesh.around(halves[-1]))
    corners = np.stack(halves, axis=1)
    return corners, mesh.sizes[mesh.face[corners]]


def _star_of_face(mesh: ClosedMesh, halves: Numbers, size: int) -> list[Numbers]:
    """The corners of a face, from the one before the half-edge on."""
    halves = mesh.before[halves]
    star = []
    for _ in range(size):
        star.append(mesh.origin[halves])
        halves = mesh.after[halves]
    return star


_WAYS = {
    "catmull-clark": _Way(catmull_clark.SCHEME, catmull_clark_step, _quadrangles, _star_of_vertex),
    "doo-sabin": _Way(doo_sabin.SCHEME, doo_sabin_step, _crossings, _star_of_face),
}
