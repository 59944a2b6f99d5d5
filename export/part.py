"""From a shape to a part: cover, thickening, surface and check in one call."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from typing import Literal

from export.check import Report, check
from export.facets import Facets
from export.meshing.skin import skin
from export.thicken import thicken
from export.voxels.estimate import Budget
from export.voxels.frame import lattice_resolution
from export.voxels.voxelise import Cover, Progress, voxelise
from ifs import Mesh, Shape, bounding_box, draw, initial, refine
from trees import Tree

RESOLUTION = 200
BUDGET = Budget(triangles=60_000_000, memory=8 * 2**30)
MOST_THICKENED = 2_000_000_000
LARGE = 300  # voxels along a side from which on the amounts are predicted first
MOST_FACETS = 100_000
DEEPEST = 29


@dataclass(frozen=True)
class Part:
    """A printable mesh in millimetres, the voxels it bounds, the report of its check, and its recipe."""

    mesh: Mesh
    tree: Tree
    report: Report
    recipe: Mapping[str, str]


def make_part(
    shape: Shape,
    *,
    size: float | None = None,
    resolution: int | None = None,
    thickness: float = 0.0,
    depth: int | None = None,
    style: Literal["smooth", "exact"] | None = None,
    budget: Budget = BUDGET,
    progress: Progress | None = None,
) -> Part:
    """Voxelise a shape, thicken it, and mesh the boundary.

    `size` is the longest side of the shape in millimetres (by default its control points are taken as
    they are); `resolution` the voxels along that side, 200 unless the pieces at `depth` lie on a
    lattice, whose own grid is then taken; `thickness` the diameter in millimetres of the ball that
    is swept over the shape, so that walls are that thick to within about a voxel (0 keeps the voxels);
    `depth` prints the solid pieces of that level instead of the limit. The surface is smooth when the
    shape is thickened and else shows its voxels, unless `style` says otherwise. Where voxels touch at an
    edge or a corner only they are joined. From 300 voxels a side on, amounts are predicted before any
    work, and compared with `budget`: 60 million triangles and 8 GiB unless given, beyond which it refuses; a
    budget that coarsens lowers the resolution instead. `progress(stage, share)` is called from time to time.

    Raises `ValueError` for lengths and counts that make no sense, `OverBudget`, `TooThick`,
    `ifs.NotContracting`.

    >>> import ifs
    >>> part = make_part(ifs.shape("menger-sponge"), size=27, depth=1)
    >>> part.report.ok, part.report.genus, part.tree.count
    (True, (5,), 20)
    """
    _require(size is None or (math.isfinite(size) and size > 0), f"the size is above 0 mm, found {size}")
    _require(math.isfinite(thickness) and thickness >= 0, f"the thickness is 0 mm or more, found {thickness}")
    _require(resolution is None or 1 <= resolution <= 20_000, f"resolutions go from 1 to 20000: {resolution}")
    _require(depth is None or depth >= 0, f"the depth is 0 or more, found {depth}")
    shape = _resized(shape, size)
    if resolution is None:
        resolution = (lattice_resolution(shape, depth) if depth is not None else None) or RESOLUTION
    style = style or ("smooth" if thickness else "exact")
    tell = progress or (lambda stage, share: None)
    budget_now = budget if resolution >= LARGE else None
    covered = voxelise(shape, resolution, depth=depth, budget=budget_now, progress=tell)
    tree, field = covered.tree, None
    if thickness:
        _require_room(covered, thickness)
        tell("thickness", 0.0)
        facets = _facets(shape, covered.pitch) if depth is None else None
        solid = thicken(tree, thickness / 2, facets)
        tree, field = solid.tree, solid.field
    tell("surface", 0.0)
    mesh = skin(tree, style, contacts="join", field=field)
    tell("check", 0.0)
    report = check(mesh, quick=True)
    tell("check", 1.0)
    recipe = {
        "Name": shape.name,
        "Size": f"{covered.pitch * covered.resolution:.6g} mm",
        "Resolution": str(covered.resolution),
        "Thickness": f"{thickness:.6g} mm",
        "Depth": "limit" if depth is None else str(depth),
        "Surface": style,
        "Application": f"bcifs {version('bcifs')}",
    }
    return Part(mesh, tree, report, recipe)


def _facets(shape: Shape, pitch: float) -> Mesh | None:
    """The mesh of the shape with edges no longer than a voxel; None where that takes too many faces."""
    complex_ = initial(shape.topology, shape.system, shape.control)
    for _ in range(DEEPEST):
        complex_ = refine(complex_)
        found = draw(complex_)
        if Facets(found).longest <= pitch:
            return found
        if len(found.faces) > MOST_FACETS:
            return None
    return None


def _require(condition: bool, message: str) -> None:
    if not condition:
        raise ValueError(message)


class TooThick(MemoryError):
    """A thickness that makes more voxels than can be worked on: `voxels`, black or not."""

    def __init__(self, thickness: float, voxels: int):
        self.thickness, self.voxels = thickness, voxels
        super().__init__(
            f"a thickness of {thickness:.6g} mm makes a grid of {voxels:.3g} voxels, and "
            f"{MOST_THICKENED:.3g} are possible: ask for a smaller one, or for a lower resolution"
        )


def _require_room(covered: Cover, thickness: float) -> None:
    more = math.ceil(thickness / covered.pitch) + 4
    voxels = math.prod(side + more for side in covered.size)
    if voxels > MOST_THICKENED:
        raise TooThick(thickness, voxels)


def _resized(shape: Shape, size: float | None) -> Shape:
    low, high = bounding_box(shape)
    longest = float((high - low).max())
    _require(longest > 0, "the shape is a single point: nothing to print")
    return shape if size is None else shape.scaled(size / longest)
