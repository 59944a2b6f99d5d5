"""What a check found: faults, notes and measures, as values, text and JSON."""

from dataclasses import asdict, dataclass, field

import numpy as np
from jaxtyping import Float

from export.checks.overhangs import Overhang
from export.checks.slicer import duration

PLACES = 5  # of each fault, so many are told
MARKS = 500  # and so many are marked in a picture

Place = tuple[float, float, float]


@dataclass(frozen=True)
class Fault:
    """One kind of fault: how often, what it means, and where (mm): the first few, and more to be marked."""

    kind: str
    count: int
    meaning: str
    places: tuple[Place, ...]
    marks: tuple[Place, ...] = field(default=(), repr=False)

    def __str__(self) -> str:
        where = "; ".join(f"({x:.4g}, {y:.4g}, {z:.4g})" for x, y, z in self.places)
        return f"{self.count} {self.meaning}" + (f", at {where}" if where else "")

    def to_dict(self) -> dict[str, object]:
        """Plain values: kind, count, meaning, places."""
        places = [list(place) for place in self.places]
        return {"kind": self.kind, "count": self.count, "meaning": self.meaning, "places": places}


def fault(kind: str, meaning: str, places: Float[np.ndarray, "n 3"], count: int | None = None) -> Fault:
    """A fault at these places, all of them unless a count says that there are more.

    >>> str(fault("holes", "holes", np.zeros((1, 3)), 2))
    '2 holes, at (0, 0, 0)'
    """
    step = max(1, -(-len(places) // MARKS))
    told = tuple(as_place(place) for place in places[:PLACES])
    marks = tuple(as_place(place) for place in places[::step])
    return Fault(kind, len(places) if count is None else count, meaning, told, marks)


def as_place(point: np.ndarray) -> Place:
    return float(point[0]), float(point[1]), float(point[2])


@dataclass(frozen=True)
class Narrow:
    """A thin wall or a narrow gap: its width (mm), and its middle."""

    width: float
    place: Place

    def __str__(self) -> str:
        x, y, z = self.place
        return f"{self.width:.4g} mm at ({x:.4g}, {y:.4g}, {z:.4g})"


@dataclass(frozen=True)
class Report:
    """What `check` found. Lengths in mm, areas in mm², volumes in mm³.

    `components` counts shells: triangles that hang together by edges (a cavity is a shell of its
    own). `genus` is the number of handles of each shell, largest first by triangles, and None for
    a shell that is not closed and consistently oriented. `euler` is vertices - edges + triangles,
    where a vertex counts once for each fan of triangles around it. `nesting_tested` is False where
    not all shells within shells could be told.

    `self_intersections` counts pairs of triangles, None when they were not looked for;
    `intersections_complete` is False where the search was given up, so that there may be more.
    `walls` and `gaps` are the thinnest and narrowest ones, empty where nothing lies opposite
    anything or nothing was measured, among `measured` places. `overlapping_shells` counts pairs of
    shells that cross among the pairs of triangles that are named (10 000 at most).
    `trapped_voids` are cavities without way out, of `void_volume` together.
    `tree_volume` is that of the set of cells the mesh should bound.
    `overhangs` has six positions, the best first. `print_time` is in seconds.

    `details` are the faults; `notes` are no faults, but worth knowing.
    """

    triangles: int
    vertices: int
    components: int
    euler: int
    genus: tuple[int | None, ...]
    volume: float
    area: float
    low: Place
    high: Place
    boundary_edges: int
    nonmanifold_edges: int
    nonmanifold_vertices: int
    misoriented_edges: int
    degenerate_triangles: int
    duplicate_triangles: int
    inverted_shells: int
    nested_shells: int
    nesting_tested: bool
    flat_shells: int = 0
    overlapping_shells: int = 0
    unused_vertices: int = 0
    sliver_triangles: int = 0
    touching_vertices: int = 0
    self_intersections: int | None = None
    intersections_complete: bool = True
    trapped_voids: int = 0
    void_volume: float = 0.0
    walls: tuple[Narrow, ...] = ()
    gaps: tuple[Narrow, ...] = ()
    thin_walls: int | None = None
    narrow_gaps: int | None = None
    measured: int = 0
    tree_volume: float | None = None
    overhangs: tuple[Overhang, ...] = ()
    print_time: int | None = None
    details: tuple[Fault, ...] = field(default=())
    notes: tuple[Fault, ...] = field(default=())

    @property
    def ok(self) -> bool:
        """No fault was found."""
        return not self.details

    @property
    def faults(self) -> tuple[str, ...]:
        """The faults in words."""
        return tuple(str(fault) for fault in self.details)

    def to_dict(self) -> dict[str, object]:
        """Plain values for JSON: the fields and `ok`.

        `size` is the extent of the bounding box; `details` stands under `faults`; of `genus` the
        first thousand are named.
        """
        values = {key: getattr(self, key) for key in self.__dataclass_fields__}
        details, notes = values.pop("details"), values.pop("notes")
        size = [high - low for low, high in zip(self.low, self.high, strict=True)]
        nested = {key: [asdict(one) for one in values.pop(key)] for key in ("walls", "gaps", "overhangs")}
        return {
            "ok": self.ok,
            **{key: list(v) if isinstance(v, tuple) else v for key, v in values.items()},
            "genus": list(self.genus[:1000]),
            "size": size,
            **nested,
            "faults": [one.to_dict() for one in details],
            "notes": [one.to_dict() for one in notes],
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
            *(f"note: {note}" for note in self.notes),
            *self._unknown(),
            *self._measures(),
        ]
        return "\n".join(lines)

    def _unknown(self) -> list[str]:
        """What was not looked at, or not to the end."""
        lines = []
        if self.self_intersections is None:
            lines.append("self-intersections: not tested")
        elif not self.intersections_complete:
            lines.append("self-intersections: given up before the end, there may be more")
        if not self.nesting_tested:
            lines.append("shells within shells: not all could be told")
        return lines

    def _measures(self) -> list[str]:
        lines = []
        for name, found in (("thinnest walls", self.walls), ("narrowest gaps", self.gaps)):
            if found:
                lines.append(f"{name} (of {self.measured} places): {'; '.join(map(str, found[:3]))}")
        if self.tree_volume is not None:
            lines.append(f"volume of the cells {self.tree_volume:.6g} mm³")
        if self.overhangs:
            best = self.overhangs[0]
            others = ", ".join(f"{one.up} {100 * one.share:.1f} %" for one in self.overhangs)
            word = (
                "free of supports" if best.share == 0 else f"{100 * best.share:.1f} % of the area hangs over"
            )
            lines.append(f"best with {best.up} up: {word} (beyond 45 degrees: {others})")
        if self.print_time is not None:
            lines.append(f"print time {duration(self.print_time)}")
        return lines
