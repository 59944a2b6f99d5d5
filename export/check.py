"""Whether a triangle mesh can be printed, and what is wrong where."""

import math

import numpy as np
from jaxtyping import Float, Int

from export.checks.adjacency import (
    closed_shells,
    euler_characteristics,
    find_edges,
    find_fans,
    find_shells,
)
from export.checks.crossings import crossed_edges, crossings, meeting_places
from export.checks.nesting import misplaced_shells
from export.checks.overhangs import overhangs
from export.checks.places import representatives
from export.checks.report import PLACES, Fault, Narrow, Report, as_place, fault
from export.checks.triangle_tree import TriangleTree, triangle_tree
from export.checks.widths import Widths, walls_and_gaps
from ifs.mesh import Mesh
from trees.tree import Tree

__all__ = ["Fault", "Narrow", "Report", "check"]

FLAT = 1e-9  # a triangle is degenerate when its height is below this share of its longest side
SLIVER = 1e-2  # and a sliver below this one
NO_PAIRS = np.zeros((0, 2), dtype=np.int64)
LARGEST = 1e100  # mm: beyond that volumes overflow


def check(
    mesh: Mesh,
    *,
    tree: Tree | None = None,
    wall: float | None = None,
    gap: float | None = None,
    quick: bool = False,
) -> Report:
    """Find what keeps a triangle mesh (mm) from being the boundary of a solid.

    Edges must lie in two triangles that pass them in opposite directions, the triangles around a
    vertex must form one fan, no triangle may be flat or stand twice, shells must have a volume and face
    outward (inward when they bound a cavity), and triangles must not meet but in common corners and
    edges, which is decided exactly (`export.checks.crossings`). Vertices are told apart by number, not by
    position: `weld` first if they do not say how triangles hang together.

    `tree` is the set of cells that the mesh should bound: the volumes may then differ by half a cell
    over the whole area. `wall` and `gap` (mm) make faults of walls and gaps below them, as
    `export.checks.widths` measures these. `quick` looks for neither self-intersections nor widths.
    Slivers, unused vertices, sheets that touch, cavities without way out, and which shells pass through each
    other are notes, no faults. Widths are measured as `export.checks.widths` tells: notches are no walls.

    `ValueError` when a triangle names a vertex that is missing, a position is not finite or beyond 1e100,
    there is no triangle, or a wall or gap is not above 0.

    >>> import numpy as np
    >>> corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    >>> faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    >>> report = check(Mesh(corners, faces))
    >>> report.ok, report.genus, round(6 * report.volume), report.self_intersections
    (True, (0,), 1, 0)
    >>> check(Mesh(corners, faces[1:])).faults
    ('3 edges with a triangle on one side only, at (0.5, 0, 0); (0, 0.5, 0); (0.5, 0.5, 0)',)
    """
    if not isinstance(mesh, Mesh):
        raise ValueError(f"a Mesh is checked, found a {type(mesh).__name__}: mesh it first")
    if not (tree is None or isinstance(tree, Tree)):
        raise ValueError(f"the cells are a trees.Tree, found a {type(tree).__name__}")
    points, triangles = mesh.points_3d(), mesh.triangles()
    _validate(points, triangles, wall, gap)
    used = np.zeros(len(points), dtype=bool)
    used[triangles.ravel()] = True
    idle = points[~used & np.isfinite(points).all(axis=1)]
    points = points if used.all() else np.where(used[:, None], points, points[triangles[0, 0]])
    boxes = triangle_tree(points, triangles)
    edges = find_edges(triangles, len(points))
    fans, fan_vertices = find_fans(triangles, edges)
    shells, shell = find_shells(len(triangles), edges)
    corners = points[triangles]
    normals = _normals(corners)
    flat, sliver = _thin(triangles, corners, normals)
    areas = _lengths(normals) / 2
    area = float(areas.sum())
    closed = closed_shells(edges, shells, shell)
    euler = euler_characteristics(edges, fans, shells, shell)
    genus = [int(2 - e) // 2 if c else None for e, c in zip(euler, closed, strict=True)]
    volumes = _volumes(corners, shell, shells)
    empty = closed & (np.abs(volumes) <= FLAT * np.bincount(shell, areas, minlength=shells) ** 1.5)
    inverted, nested, told = misplaced_shells(boxes, shell, volumes, closed & ~empty)
    first = points[triangles[np.unique(shell, return_index=True)[1], 0]]
    voids = np.setdiff1d(np.flatnonzero(closed & ~empty & (volumes < 0)), np.union1d(inverted, nested))
    split = np.flatnonzero(np.bincount(fan_vertices, minlength=len(points)) > 1)
    same = representatives(points, triangles)
    touching = np.flatnonzero(same != np.arange(len(points)))
    faults = [
        fault("boundary_edges", "edges with a triangle on one side only", edges.middles(points, edges.open)),
        fault("nonmanifold_edges", "edges in more than two triangles", edges.middles(points, edges.crowded)),
        fault("nonmanifold_vertices", "vertices at which parts only touch", points[split]),
        fault(
            "misoriented_edges", "edges whose triangles face opposite ways", edges.middles(points, edges.bent)
        ),
        fault("degenerate_triangles", "triangles without area", corners[flat].mean(axis=1)),
        fault(
            "duplicate_triangles", "triangles that stand twice", corners[_duplicates(triangles)].mean(axis=1)
        ),
        fault("flat_shells", "shells without volume", first[empty]),
        fault("inverted_shells", "shells that are inside out", first[inverted]),
        fault("nested_shells", "shells inside solid material", first[nested]),
    ]
    notes = [
        fault(
            "sliver_triangles",
            "triangles less than a hundredth as high as long",
            corners[sliver].mean(axis=1),
        ),
        fault("unused_vertices", "vertices that no triangle names", idle, int((~used).sum())),
        fault("touching_vertices", "vertices at the place of another one", points[touching]),
        fault("trapped_voids", "cavities without way out", first[voids]),
    ]
    deep = {}
    if not quick:
        edge_pairs = crossed_edges(boxes, triangles, edges, same) if len(touching) else NO_PAIRS
        deep = _deep(boxes, corners, shell, edge_pairs, wall, gap, faults, notes)
    counts = {one.kind: one.count for one in faults + notes}
    if tree is not None:
        faults += _against(tree, float(volumes.sum()), area)
    order = np.lexsort((np.arange(shells), -np.bincount(shell, minlength=shells)))
    return Report(
        triangles=len(triangles),
        vertices=int(used.sum()),
        components=shells,
        euler=int(euler.sum()),
        genus=tuple(genus[s] for s in order),
        volume=float(volumes.sum()),
        area=area,
        low=as_place(points[used].min(axis=0)),
        high=as_place(points[used].max(axis=0)),
        **{**counts, **deep},
        nesting_tested=told,
        void_volume=float(-volumes[voids].sum()) if len(voids) else 0.0,
        tree_volume=None if tree is None else tree.measure,
        overhangs=overhangs(corners, normals),
        details=tuple(one for one in faults if one.count),
        notes=tuple(one for one in notes if one.count),
    )


def _deep(
    boxes: TriangleTree,
    corners: Float[np.ndarray, "t 3 3"],
    shell: Int[np.ndarray, "t"],
    edge_pairs: Int[np.ndarray, "pairs 2"],
    wall: float | None,
    gap: float | None,
    faults: list[Fault],
    notes: list[Fault],
) -> dict:
    """Self-intersections and widths: fields of the report; their faults and notes are appended."""
    met = crossings(boxes)
    pairs = np.concatenate([met.pairs, edge_pairs])
    places = meeting_places(corners, pairs)
    between = np.sort(shell[pairs], axis=1)
    apart = between[:, 0] != between[:, 1]
    one_each = np.unique(between[apart], axis=0, return_index=True)[1]
    meaning = "pairs of shells that pass through each other"
    notes.append(fault("overlapping_shells", meaning, places[apart][one_each]))
    meaning = "pairs of triangles that meet elsewhere than in common corners and edges"
    faults.append(fault("self_intersections", meaning, places, met.count + len(edge_pairs)))
    walls, gaps = walls_and_gaps(boxes, wall=wall, gap=gap)
    found = {
        "intersections_complete": met.complete,
        "walls": _narrow(walls, boxes),
        "gaps": _narrow(gaps, boxes),
        "measured": walls.measured,
    }
    for kind, widths, least, word in (
        ("thin_walls", walls, wall, "walls"),
        ("narrow_gaps", gaps, gap, "gaps"),
    ):
        if least is not None:
            meaning = f"places of {widths.measured} with {word} below {least:g} mm"
            places = widths.below(least)
            faults.append(fault(kind, meaning, places, len(places) * widths.share))
    return found


def _narrow(widths: Widths, boxes: TriangleTree) -> tuple[Narrow, ...]:
    apart = boxes.size * boxes.scale / 20
    return tuple(Narrow(width, place) for width, place in widths.narrowest(PLACES, apart))


def _against(tree: Tree, volume: float, area: float) -> list[Fault]:
    """The fault of a mesh whose volume is not that of its cells."""
    cells = tree.measure
    if abs(volume - cells) <= area * tree.cell_size / 2 + FLAT * cells:
        return []
    meaning = f"volume: {volume:.9g} mm³ in the mesh, {cells:.9g} mm³ in its cells"
    return [Fault("other_volume", 1, meaning, ())]


def _validate(
    points: Float[np.ndarray, "v 3"], triangles: Int[np.ndarray, "t 3"], wall: float | None, gap: float | None
) -> None:
    if not len(triangles):
        raise ValueError("the mesh has no triangles: nothing to check")
    if triangles.min() < 0 or triangles.max() >= len(points):
        row = int(np.argmax(((triangles < 0) | (triangles >= len(points))).any(axis=1)))
        raise ValueError(f"triangle {row} names vertices {triangles[row].tolist()} of {len(points)}")
    sound = (np.abs(points) <= LARGEST).all(axis=1)
    if not sound.all():
        used = np.zeros(len(points), dtype=bool)
        used[triangles.ravel()] = True
        if (used & ~sound).any():
            row = int(np.argmax(used & ~sound))
            raise ValueError(
                f"vertex {row} is at {points[row].tolist()}: finite lengths up to {LARGEST:g} mm are needed"
            )
    for name, width in (("wall", wall), ("gap", gap)):
        if width is None:
            continue
        if not isinstance(width, (int, float, np.number)) or not (math.isfinite(width) and width > 0):
            raise ValueError(f"the least {name} is a length above 0 mm, found {width!r}")


def _normals(corners: Float[np.ndarray, "t 3 3"]) -> Float[np.ndarray, "t 3"]:
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def _lengths(rows: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n"]:
    return np.sqrt(np.einsum("nx,nx->n", rows, rows))


def _volumes(
    corners: Float[np.ndarray, "t 3 3"], shell: Int[np.ndarray, "t"], shells: int
) -> Float[np.ndarray, "shells"]:
    """Signed volumes, measured from the middle of the mesh for precision."""
    moved = corners - corners.reshape(-1, 3).mean(axis=0)
    pieces = np.einsum("tx,tx->t", moved[:, 0], np.cross(moved[:, 1], moved[:, 2])) / 6
    return np.bincount(shell, pieces, minlength=shells)


def _thin(
    triangles: Int[np.ndarray, "t 3"],
    corners: Float[np.ndarray, "t 3 3"],
    normals: Float[np.ndarray, "t 3"],
) -> tuple[Int[np.ndarray, "flat"], Int[np.ndarray, "slivers"]]:
    """Triangles without area, and thin ones among the others."""
    repeated = (triangles == triangles[:, [1, 2, 0]]).any(axis=1)
    sides = corners - corners[:, [1, 2, 0]]
    squares = np.einsum("tsx,tsx->ts", sides, sides)
    longest = np.maximum(np.maximum(squares[:, 0], squares[:, 1]), squares[:, 2])
    doubled = _lengths(normals)
    flat = repeated | (doubled <= FLAT * longest)
    return np.flatnonzero(flat), np.flatnonzero(~flat & (doubled < SLIVER * longest))


def _duplicates(triangles: Int[np.ndarray, "t 3"]) -> Int[np.ndarray, "again"]:
    """Triangles with the same three vertices as an earlier one."""
    same = np.sort(triangles, axis=1)
    order = np.lexsort(same.T[::-1])
    equal = (np.diff(same[order], axis=0) == 0).all(axis=1)
    return np.sort(order[1:][equal])
