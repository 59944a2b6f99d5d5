"""The limit surface of any control mesh: its patches found, and drawn by the automaton."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
from jaxtyping import Float, Int

import subdivision
from automata import Automaton
from automata.topology import Topology
from ifs.certificates.convergence import require_no_growth
from ifs.complex import Complex
from ifs.mesh import Mesh
from ifs.patchwork import patchwork
from ifs.shape import system
from ifs.surfaces.polygon_mesh import Pair, PolygonMesh, Polygons, polygon_mesh
from ifs.surfaces.polygon_step import catmull_clark_step, doo_sabin_step, ribboned
from ifs.uniform import require_depth, uniform
from subdivision.schemes import catmull_clark, doo_sabin
from subdivision.schemes.catmull_clark import Corner, Edge
from subdivision.schemes.patches import Corners, Scheme, Star, automaton, cell_name, face_seen

Rows = Int[np.ndarray, "_patches _points"]

WEIGHTS = {"doo-sabin": doo_sabin.coefficients, "doo-sabin-rational": doo_sabin.rational_coefficients}
SCHEMES = ("catmull-clark", *WEIGHTS)


@dataclass(frozen=True)
class Region:
    """Some faces of a control mesh, counted from 0, and the coefficients that they have.

    For Catmull and Clark's scheme `coefficients` is a `catmull_clark.Coefficients`, for Doo and Sabin's a
    function that gives the weights of a face of n corners.

    >>> from subdivision.schemes.catmull_clark import Coefficients
    >>> Region([0, 1], Coefficients(end=Fraction(1, 4))).faces
    [0, 1]
    """

    faces: Iterable[int]
    coefficients: catmull_clark.Coefficients | doo_sabin.Weights


@dataclass(frozen=True)
class Surface:
    """The patches of a control mesh: control points in millimetres, and which of them each patch uses.

    `patches[cell]` is `(patches, points)`; the topology's automaton has a cell for each kind of patch.
    """

    topology: Topology
    control: Float[np.ndarray, "control 3"]
    patches: Mapping[str, Rows]

    def complex(self, member: Automaton | None = None) -> Complex:
        """The patches with their shared edges and vertices, to be refined and drawn.

        With the scheme's coefficients, or with those of a `member` of the `family`, which must leave nothing
        open (`subdivision.Undetermined`).
        """
        whole = self.topology.automaton
        if member is not None:
            numbers = subdivision.solve(member).numbers()
        else:
            numbers = {
                name: {label: _numbers(rows) for label, rows in cell.matrices.items()}
                for name, cell in whole.cells.items()
            }
        return patchwork(self.topology, system(whole, numbers), self.control, self.patches)

    def family(self) -> Automaton:
        """The automaton of the same states with all coefficients that fit its constraints.

        What these leave open is set to the scheme's own coefficients; `subdivision.overridden` changes them,
        for each kind of patch by itself.

        >>> corners = [(x, y, z) for z in (0, 9) for y in (0, 9) for x in (0, 9)]
        >>> sides = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
        >>> len(surface(corners, sides, "doo-sabin").family().values)
        5
        """
        given = self.topology.automaton.cells
        free = {name: replace(cell, matrices={}) for name, cell in given.items()}
        family = replace(self.topology.automaton, cells=free)
        entries = [parameter.entry for parameter in subdivision.solve(family).parameters]
        numbers = {(e.cell, e.label): _numbers(given[e.cell].matrices[e.label]) for e in entries}
        values = {str(e): numbers[e.cell, e.label][e.row][e.column] for e in entries}
        return replace(family, values=values)


def surface(
    vertices: Any,
    faces: Polygons,
    scheme: str = "catmull-clark",
    *,
    boundary: str | None = None,
    creases: Mapping[Pair, float | Fraction] | None = None,
    corners: Iterable[int] = (),
    regions: Sequence[Region] = (),
) -> Surface:
    """The patches of a mesh of polygons, for the scheme "catmull-clark", "doo-sabin" or "doo-sabin-rational".

    `vertices` is `(n, 3)` in millimetres; faces are lists of vertex numbers, or rows that end in -1,
    counterclockwise seen from outside. A Catmull-Clark patch is a quadrangle; where the mesh has other faces,
    one step of subdivision makes it quadrangles. A Doo-Sabin patch is a vertex with four faces; where the
    mesh has other vertices, one step gives it four faces at each. The control points are then those after
    the step.

    - `boundary`: None for a closed mesh; for an open one "smooth", the surface ends in the B-spline curve of
      the boundary polygon, or "corners", and vertices of a single face stay where they are.
    - `creases[v, w]`: the sharpness of an edge: as many subdivisions it is a crease, for ever from 10 on.
    - `corners`: vertices that stay where they are.
    - `regions`: faces with coefficients of their own. Where two regions meet, the surface is continuous
      because they share the states of their joint, which has the scheme's own coefficients.

    Raises `WrongMesh` with the face that is wrong, and `ValueError` for an unknown scheme, or creases and
    corners with Doo and Sabin's schemes, which have none.

    >>> corners = [(x, y, z) for z in (0, 9) for y in (0, 9) for x in (0, 9)]
    >>> sides = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    >>> {cell: rows.shape for cell, rows in surface(corners, sides).patches.items()}
    {'face-3-3-3-3': (6, 8)}
    """
    if scheme not in SCHEMES:
        raise ValueError(f"unknown scheme {scheme!r}: expected one of {', '.join(SCHEMES)}")
    corners = tuple(corners)
    if scheme in WEIGHTS and (creases or corners):
        raise ValueError(f"the scheme {scheme!r} has no creases and no corners: use 'catmull-clark'")
    named = {f"region{i + 1}": region for i, region in enumerate(regions)}
    faces_of = {name: tuple(region.faces) for name, region in named.items()}
    mesh = polygon_mesh(vertices, faces, boundary, creases, corners, faces_of)
    coefficients: dict[str, Any] = {name: region.coefficients for name, region in named.items()}
    if scheme in WEIGHTS:
        weights = WEIGHTS[scheme]
        mesh = _crossings(mesh, {"": weights, **coefficients}, boundary == "corners")
        return _surface(doo_sabin.scheme(weights, coefficients), mesh, _vertex_patches(mesh))
    if (mesh.sizes != 4).any():
        mesh = catmull_clark_step(mesh)
    return _surface(catmull_clark.scheme(coefficients), mesh, _face_patches(mesh))


def smooth(vertices: Any, faces: Polygons, depth: int, scheme: str = "catmull-clark", **marks: Any) -> Mesh:
    """The conformal mesh of the limit surface of a control mesh, each patch in `4^depth` faces.

    Its vertices are limit points, exact to rounding at any depth. Arguments and errors as for `surface`; also
    `ValueError` for a negative depth, and `NotContracting` for regions whose coefficients give no surface.

    >>> corners = [(x, y, z) for z in (0, 9) for y in (0, 9) for x in (0, 9)]
    >>> sides = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    >>> ball = smooth(corners, sides, 3)
    >>> len(ball.vertices), len(ball.faces)
    (386, 384)
    """
    require_depth(depth)
    found = surface(vertices, faces, scheme, **marks).complex()
    if marks.get("regions"):
        require_no_growth(found.system)
    return uniform(found, depth)


def _numbers(rows: Sequence[Sequence[Any]]) -> tuple:
    return tuple(tuple(entry.value for entry in row) for row in rows)


Stars = tuple[Star, Star, Star, Star]


def _surface(scheme: Scheme, mesh: PolygonMesh, groups: Iterable[Stars]) -> Surface:
    """The surface of groups of patches; the points of each star are arrays, an entry for each patch."""
    rows: dict[Corners, list[Rows]] = {}
    for stars in groups:
        seen = face_seen(scheme, stars)
        rows.setdefault(seen.corners, []).append(np.stack(seen.points, axis=1))
    if not rows:
        raise ValueError("the mesh is too small: no vertex of it has four faces around it")
    patches = {cell_name(scheme, corners): np.concatenate(found) for corners, found in rows.items()}
    return Surface(Topology(automaton(scheme, rows)), mesh.vertices, dict(sorted(patches.items())))


# ---- Catmull and Clark: a patch is a face ------------------------------------------------------------------


def _face_patches(mesh: PolygonMesh) -> Iterable[Stars]:
    """The stars of the corners of the quadrangles, those of a kind together."""
    halves = np.arange(len(mesh.origin)).reshape(-1, 4)
    plain, region = _plain(mesh)
    whole = plain[mesh.origin[halves]].all(axis=1)
    kinds = np.stack([mesh.valences[mesh.origin[halves]], region[mesh.origin[halves]]], axis=2)[whole]
    names, _ = _regions(mesh)
    for kind, chosen in _grouped(kinds.reshape(len(kinds), 8), halves[whole]):
        corners = [catmull_clark.ring(kind[2 * i], names[kind[2 * i + 1]]) for i in range(4)]
        yield _four(
            Star(corner, tuple(_star_of_vertex(mesh, chosen[:, i], len(corner.edges))))
            for i, corner in enumerate(corners)
        )
    yield from _one_by_one(mesh, halves[~whole])


def _four(stars: Iterable[Star]) -> Stars:
    a, b, c, d = stars
    return a, b, c, d


def _plain(mesh: PolygonMesh) -> tuple[np.ndarray, np.ndarray]:
    """Whether nothing is marked at a vertex, all its faces being of one region; which region that is."""
    names, of_face = _regions(mesh)
    low = np.full(len(mesh.vertices), len(names))
    high = np.zeros(len(mesh.vertices), dtype=np.int64)
    np.minimum.at(low, mesh.origin, of_face[mesh.face])
    np.maximum.at(high, mesh.origin, of_face[mesh.face])
    plain = (low == high) & ~mesh.at_boundary
    plain[[*(v for pair in mesh.marks.creases for v in pair), *mesh.marks.fixed]] = False
    return plain, high


def _regions(mesh: PolygonMesh) -> tuple[tuple[str, ...], Int[np.ndarray, "faces"]]:
    """The names of the regions, first that of none, and the number of the region of each face."""
    names = ("", *sorted(set(mesh.marks.regions.values())))
    number = {name: i for i, name in enumerate(names)}
    of_face = np.zeros(len(mesh.sizes), dtype=np.int64)
    for face, name in mesh.marks.regions.items():
        of_face[face] = number[name]
    return names, of_face


def _grouped(kinds: np.ndarray, rows: np.ndarray) -> Iterable[tuple[list[int], np.ndarray]]:
    """Each distinct kind, with the rows of that kind."""
    if not len(kinds):
        return
    distinct, number = np.unique(kinds, axis=0, return_inverse=True)
    order = np.argsort(number.reshape(-1), kind="stable")
    counts = np.bincount(number.reshape(-1))
    yield from zip(distinct.tolist(), np.split(rows[order], np.cumsum(counts)[:-1]), strict=True)


def _star_of_vertex(mesh: PolygonMesh, halves: np.ndarray, valence: int) -> list[np.ndarray]:
    """The vertex, then its neighbours and the corners opposite it, counterclockwise from a half-edge on."""
    star = [mesh.origin[halves]]
    for _ in range(valence):
        star += [mesh.ends[halves], mesh.origin[mesh.before[mesh.before[halves]]]]
        halves = mesh.around(halves)
    return star


def _one_by_one(mesh: PolygonMesh, faces: np.ndarray) -> Iterable[Stars]:
    """The stars of quadrangles beside boundaries, creases, corners and borders of regions."""
    stars: dict[int, Star] = {}
    for half in np.unique(mesh.origin[faces], return_index=True)[1].tolist():
        stars |= _around_vertex(mesh, int(faces.reshape(-1)[half]))
    groups: dict[tuple[Corner, ...], list[list[tuple]]] = {}
    for face in faces.tolist():
        found = [stars[half] for half in face]
        groups.setdefault(tuple(star.corner for star in found), []).append([star.points for star in found])
    for corners, points in groups.items():
        columns = [zip(*(patch[i] for patch in points), strict=True) for i in range(4)]
        yield _four(
            Star(corner, tuple(None if place[0] is None else np.array(place) for place in column))
            for corner, column in zip(corners, columns, strict=True)
        )


def _around_vertex(mesh: PolygonMesh, half: int) -> dict[int, Star]:
    """For each half-edge from a vertex, the star that begins with it."""
    marks, vertex = mesh.marks, int(mesh.origin[half])
    first = half
    while mesh.twin[half] >= 0 and (back := int(mesh.after[mesh.twin[half]])) != first:
        half = back
    halves = _round(mesh, half)
    edges, points = [], []
    for h in halves:
        end = int(mesh.ends[h])
        sharp = float("inf") if mesh.twin[h] < 0 else marks.sharpness(vertex, end)
        edges.append(Edge(sharp, marks.regions.get(int(mesh.face[h]), "")))
        points += [end, int(mesh.origin[mesh.before[mesh.before[h]]])]
    last = int(mesh.before[halves[-1]])
    if mesh.twin[last] < 0:
        edges.append(Edge(float("inf"), None))
        points += [int(mesh.origin[last]), None]
    result = {}
    for k, h in enumerate(halves):
        turned = Corner((*edges[k:], *edges[:k]), vertex in marks.fixed)
        result[h] = Star(turned, (vertex, *points[2 * k :], *points[: 2 * k]))
    return result


def _round(mesh: PolygonMesh, half: int) -> list[int]:
    """The half-edges from one vertex, counterclockwise until the first or a boundary comes."""
    found = [half]
    while (following := int(mesh.around(np.array([found[-1]]))[0])) not in (-1, half):
        found.append(following)
    return found


# ---- Doo and Sabin: a patch is a vertex with four faces ----------------------------------------------------


def _crossings(mesh: PolygonMesh, weights: Mapping[str, doo_sabin.Weights], corners: bool) -> PolygonMesh:
    """The mesh with four faces around each inner vertex."""
    mesh = ribboned(mesh, corners)
    inner = ~mesh.at_boundary[mesh.origin]
    if (mesh.valences[mesh.origin[inner]] != 4).any():
        mesh = doo_sabin_step(mesh, weights.__getitem__)
    return mesh


def _vertex_patches(mesh: PolygonMesh) -> Iterable[Stars]:
    """The stars of the four faces around each inner vertex, those of a kind together."""
    used, first = np.unique(mesh.origin, return_index=True)
    halves = [first[~mesh.at_boundary[used]]]
    for _ in range(3):
        halves.append(mesh.around(halves[-1]))
    corners = np.stack(halves, axis=1)
    names, of_face = _regions(mesh)
    around = mesh.face[corners]
    kinds = np.stack([mesh.sizes[around], of_face[around]], axis=2)
    for kind, chosen in _grouped(kinds.reshape(len(kinds), 8), corners):
        yield _four(
            Star(
                doo_sabin.Corner(kind[2 * i], names[kind[2 * i + 1]]),
                tuple(_star_of_face(mesh, chosen[:, i], kind[2 * i])),
            )
            for i in range(4)
        )


def _star_of_face(mesh: PolygonMesh, halves: np.ndarray, size: int) -> list[np.ndarray]:
    """The corners of a face, from the one before the half-edge on."""
    halves = mesh.before[halves]
    star = []
    for _ in range(size):
        star.append(mesh.origin[halves])
        halves = mesh.after[halves]
    return star
