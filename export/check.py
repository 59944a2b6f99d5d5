"""Whether a triangle mesh can be printed, and what is wrong where."""

from dataclasses import asdict, dataclass, field

import numpy as np
from jaxtyping import Float, Int

from export.adjacency import (
    closed_shells,
    euler_characteristics,
    find_edges,
    find_fans,
    find_shells,
)
from export.nesting import misplaced_shells
from ifs.mesh import Mesh

PLACES = 5  # of each fault, so many are reported with their position
FLAT = 1e-9  # a triangle is degenerate when its height is below this share of its longest side


@dataclass(frozen=True)
class Fault:
    """One kind of fault: how often, what it means, and where (mm, the first few)."""

    kind: str
    count: int
    meaning: str
    places: tuple[tuple[float, float, float], ...]

    def __str__(self) -> str:
        where = "; ".join(f"({x:.4g}, {y:.4g}, {z:.4g})" for x, y, z in self.places)
        return f"{self.count} {self.meaning}" + (f", at {where}" if where else "")


@dataclass(frozen=True)
class Report:
    """What `check` found. Lengths in mm, area in mm², volume in mm³.

    `components` counts shells: triangles that hang together by edges (a cavity is a shell of its
    own). `genus` is the number of handles of each shell, largest first by triangles, and None for
    a shell that is not closed and consistently oriented. `euler` is vertices - edges + triangles,
    where a vertex counts once for each fan of triangles around it. `nesting_tested` is False where
    there were too many shells within shells to look through.
    """

    triangles: int
    vertices: int
    components: int
    euler: int
    genus: tuple[int | None, ...]
    volume: float
    area: float
    low: tuple[float, float, float]
    high: tuple[float, float, float]
    boundary_edges: int
    nonmanifold_edges: int
    nonmanifold_vertices: int
    misoriented_edges: int
    degenerate_triangles: int
    duplicate_triangles: int
    inverted_shells: int
    nested_shells: int
    nesting_tested: bool
    details: tuple[Fault, ...] = field(default=())

    @property
    def ok(self) -> bool:
        """No fault was found."""
        return not self.details

    @property
    def faults(self) -> tuple[str, ...]:
        """The faults in words."""
        return tuple(str(fault) for fault in self.details)

    def to_dict(self) -> dict[str, object]:
        """Plain values for JSON: the fields, `ok`, and that self-intersections were not looked for.

        `size` is the extent of the bounding box; `details` stands under `faults`.
        """
        values = asdict(self)
        details = values.pop("details")
        size = [high - low for low, high in zip(self.low, self.high, strict=True)]
        return {
            "ok": self.ok,
            **{key: list(v) if isinstance(v, tuple) else v for key, v in values.items()},
            "size": size,
            "self_intersections": "not tested",
            "faults": [{**d, "places": [list(p) for p in d["places"]]} for d in details],
        }

    def __str__(self) -> str:
        size = " x ".join(f"{h - b:.6g}" for b, h in zip(self.low, self.high, strict=True))
        genus = ", ".join("?" if g is None else str(g) for g in self.genus[:8])
        lines = [
            "printable" if self.ok else "not printable",
            f"{self.triangles} triangles, {self.vertices} vertices, {self.components} shells",
            f"genus {genus}{', ...' if len(self.genus) > 8 else ''}",
            f"volume {self.volume:.6g} mm³, area {self.area:.6g} mm², size {size} mm",
            *self.faults,
            "self-intersections: not tested",
        ]
        if not self.nesting_tested:
            lines.append("shells within shells: not tested, too many")
        return "\n".join(lines)


def check(mesh: Mesh) -> Report:
    """Find what keeps a triangle mesh (mm) from being the boundary of a solid.

    Edges must lie in two triangles that pass them in opposite directions, the triangles around a
    vertex must form one fan, no triangle may be flat or stand twice, and shells must face outward
    (inward when they bound a cavity). Vertices are told apart by number, not by position: `weld`
    first if they do not say how triangles hang together. Self-intersections are not looked for.

    `ValueError` when a triangle names a vertex that is missing or a position is not finite, or
    when there is no triangle.

    >>> import numpy as np
    >>> corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    >>> faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    >>> report = check(Mesh(corners, faces))
    >>> report.ok, report.genus, round(6 * report.volume)
    (True, (0,), 1)
    >>> check(Mesh(corners, faces[1:])).faults
    ('3 edges with a triangle on one side only, at (0.5, 0, 0); (0, 0.5, 0); (0.5, 0.5, 0)',)
    """
    points, triangles = mesh.points_3d(), mesh.triangles()
    _validate(points, triangles)
    edges = find_edges(triangles, len(points))
    fans, fan_vertices = find_fans(triangles, edges)
    shells, shell = find_shells(len(triangles), edges)
    corners = points[triangles]
    flat = _degenerate(triangles, corners)
    twice = _duplicates(triangles)
    fan_count = np.bincount(fan_vertices, minlength=len(points))
    closed = closed_shells(edges, shells, shell)
    euler = euler_characteristics(edges, fans, shells, shell)
    genus = [int(2 - e) // 2 if c else None for e, c in zip(euler, closed, strict=True)]
    sizes = np.bincount(shell, minlength=shells)
    volumes = _volumes(corners, shell, shells)
    inverted, nested, tested = misplaced_shells(corners, shell, volumes, closed)
    first = np.unique(shell, return_index=True)[1]
    middle, starts = corners.mean(axis=1), edges.middles(points)
    split = np.flatnonzero(fan_count > 1)
    details = [
        _fault("boundary_edges", "edges with a triangle on one side only", starts[edges.open]),
        _fault("nonmanifold_edges", "edges in more than two triangles", starts[edges.crowded]),
        _fault("nonmanifold_vertices", "vertices at which parts only touch", points[split]),
        _fault("misoriented_edges", "edges whose triangles face opposite ways", starts[edges.bent]),
        _fault("degenerate_triangles", "triangles without area", middle[flat]),
        _fault("duplicate_triangles", "triangles that stand twice", middle[twice]),
        _fault("inverted_shells", "shells that are inside out", points[triangles[first[inverted], 0]]),
        _fault("nested_shells", "shells inside solid material", points[triangles[first[nested], 0]]),
    ]
    counts = {fault.kind: fault.count for fault in details}
    order = np.lexsort((np.arange(shells), -sizes))
    used = points[np.unique(triangles)]
    return Report(
        triangles=len(triangles),
        vertices=len(used),
        components=shells,
        euler=int(euler.sum()),
        genus=tuple(genus[s] for s in order),
        volume=float(volumes.sum()),
        area=float(np.linalg.norm(_normals(corners), axis=1).sum() / 2),
        low=_place(used.min(axis=0)),
        high=_place(used.max(axis=0)),
        **counts,
        nesting_tested=tested,
        details=tuple(fault for fault in details if fault.count),
    )


def _validate(points: Float[np.ndarray, "v 3"], triangles: Int[np.ndarray, "t 3"]) -> None:
    if not len(triangles):
        raise ValueError("the mesh has no triangles: nothing to check")
    if triangles.min() < 0 or triangles.max() >= len(points):
        raise ValueError(f"triangles name vertices {triangles.min()} to {triangles.max()} of {len(points)}")
    if not np.isfinite(points).all():
        raise ValueError("some vertices have positions that are not finite")


def _normals(corners: Float[np.ndarray, "t 3 3"]) -> Float[np.ndarray, "t 3"]:
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def _volumes(
    corners: Float[np.ndarray, "t 3 3"], shell: Int[np.ndarray, "t"], shells: int
) -> Float[np.ndarray, "shells"]:
    """Signed volumes, measured from the middle of the mesh for precision."""
    moved = corners - corners.reshape(-1, 3).mean(axis=0)
    pieces = (moved[:, 0] * np.cross(moved[:, 1], moved[:, 2])).sum(axis=1) / 6
    return np.bincount(shell, pieces, minlength=shells)


def _degenerate(
    triangles: Int[np.ndarray, "t 3"], corners: Float[np.ndarray, "t 3 3"]
) -> Int[np.ndarray, "flat"]:
    repeated = (triangles == triangles[:, [1, 2, 0]]).any(axis=1)
    longest = ((corners - corners[:, [1, 2, 0]]) ** 2).sum(axis=2).max(axis=1)
    return np.flatnonzero(repeated | (np.linalg.norm(_normals(corners), axis=1) <= FLAT * longest))


def _duplicates(triangles: Int[np.ndarray, "t 3"]) -> Int[np.ndarray, "again"]:
    """Triangles with the same three vertices as an earlier one."""
    same = np.sort(triangles, axis=1)
    order = np.lexsort(same.T[::-1])
    equal = (np.diff(same[order], axis=0) == 0).all(axis=1)
    return np.sort(order[1:][equal])


def _place(point: np.ndarray) -> tuple[float, float, float]:
    return float(point[0]), float(point[1]), float(point[2])


def _fault(kind: str, meaning: str, places: Float[np.ndarray, "n 3"]) -> Fault:
    return Fault(kind, len(places), meaning, tuple(_place(p) for p in places[:PLACES]))
