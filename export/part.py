"""From a shape to a part: cover, thickening, surface and check in one call."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from typing import Literal

from export.check import Report, check
from export.cover import Progress, TooManyVoxels, cover, lattice_resolution, space_box
from export.facets import Facets
from export.surface import surface
from export.thicken import thicken
from export.voxels import Solid, Voxels
from ifs import Mesh, Shape, draw, initial, refine

RESOLUTION = 200
MOST_THICKENED = 600_000_000
MOST_FACETS = 100_000
DEEPEST = 29


@dataclass(frozen=True)
class Part:
    """A printable mesh in millimetres, the voxels it bounds, the report of its check, and its recipe."""

    mesh: Mesh
    voxels: Voxels
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
    progress: Progress | None = None,
) -> Part:
    """Voxelise a shape, thicken it, and mesh the boundary.

    `size` is the longest side of the shape in millimetres (by default its control points are taken as
    they are); `resolution` the voxels along that side, 200 unless the pieces at `depth` lie on a
    lattice, whose own grid is then taken; `thickness` the diameter in millimetres of the ball that
    is swept over the shape, so that walls are at least that thick (0 keeps the voxels as they are);
    `depth` prints the solid pieces of that level instead of the limit. The surface is smooth when the
    shape is thickened and else shows its voxels, unless `style` says otherwise. Where voxels touch at an
    edge or a corner only they are joined. `progress(stage, share)` is called from time to time.

    Raises `ValueError` for lengths and counts that make no sense, `TooManyVoxels`, `ifs.NotContracting`.

    >>> import ifs
    >>> part = make_part(ifs.shape("menger-sponge"), size=27, depth=1)
    >>> part.report.ok, part.report.genus, part.voxels.count
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
    _require_room(shape, resolution, thickness)
    tell = progress or (lambda stage, share: None)
    tell("voxels", 0.0)
    covered = cover(shape, resolution, depth, tell)
    tell("thickness", 0.0)
    solid: Solid | Voxels = covered.voxels
    if thickness:
        facets = _facets(shape, covered.voxels.pitch) if depth is None else None
        solid = thicken(covered.voxels, thickness / 2, facets)
    tell("surface", 0.0)
    skin = surface(solid, style, contacts="join")
    tell("check", 0.0)
    report = check(skin)
    tell("check", 1.0)
    voxels = solid.voxels if isinstance(solid, Solid) else solid
    recipe = {
        "Name": shape.name,
        "Size": f"{covered.voxels.pitch * resolution:.6g} mm",
        "Resolution": str(resolution),
        "Thickness": f"{thickness:.6g} mm",
        "Depth": "limit" if depth is None else str(depth),
        "Surface": style,
        "Application": f"bcifs {version('bcifs')}",
    }
    return Part(skin, voxels, report, recipe)


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


def _longest(shape: Shape) -> float:
    low, high = space_box(shape)
    return float((high - low).max())


def _resized(shape: Shape, size: float | None) -> Shape:
    longest = _longest(shape)
    _require(longest > 0, "the shape is a single point: nothing to print")
    return shape if size is None else shape.scaled(size / longest)


def _require_room(shape: Shape, resolution: int, thickness: float) -> None:
    """Refuse a thickening that would not fit in memory before any work is done."""
    if not thickness:
        return
    low, high = space_box(shape)
    pitch = float((high - low).max()) / resolution
    grown = math.prod(math.ceil(side / pitch + thickness / pitch + 4) for side in (high - low).tolist())
    if grown > MOST_THICKENED:
        raise TooManyVoxels(resolution, grown)
