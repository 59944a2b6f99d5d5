"""From a shape to a part: cover, thickening, what makes it printable, surface and check in one call."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version

import numpy as np

from export.check import Report, check
from export.meshing.grading import Grading, graded
from export.meshing.patched import Wishes, check_wishes
from export.meshing.skin import skin
from export.prepare import ACROSS, BUDGET, LARGE, TooThick, TooThin, prepare
from export.printable.fitting import DoesNotFit, fits
from export.printable.frame import box_of, mm_of
from export.printable.requests import Printable
from export.printable.steps import Step
from export.voxels.estimate import Budget, Prediction
from export.voxels.voxelise import Progress
from ifs import Mesh, Shape
from trees import Tree

__all__ = ["BUDGET", "LARGE", "Part", "TooThick", "TooThin", "make_part"]


@dataclass(frozen=True)
class Part:
    """A printable mesh in millimetres, the voxels it bounds, the report of its check, and its recipe.

    `steps` say what was done to the voxels to make them printable. Where contacts are joined, the mesh bounds
    a few voxels more: those that `export.meshing.joining.join_contacts` adds.
    """

    mesh: Mesh
    tree: Tree
    report: Report
    recipe: Mapping[str, str]
    steps: tuple[Step, ...] = ()


def make_part(
    shape: Shape,
    *,
    size: float | None = None,
    resolution: int | None = None,
    pitch: float | None = None,
    thickness: float = 0.0,
    thicken_by: str = "ball",
    depth: int | None = None,
    style: str | None = None,
    contacts: str = "join",
    merge: bool = False,
    features: float | None = None,
    grading: Grading | None = None,
    printable: Printable | None = None,
    budget: Budget = BUDGET,
    predicted: Callable[[Prediction], None] | None = None,
    progress: Progress | None = None,
) -> Part:
    """Voxelise a shape, thicken it, make it printable, and mesh the boundary.

    `size` is the longest side of the shape in millimetres (by default its control points are taken as
    they are); `resolution` the voxels along that side, or `pitch` the side of a voxel (mm). Left out, it is
    200, or the grid of the pieces at `depth` where they lie on a lattice, or so much finer that walls are two
    voxels thick. `thickness` is the diameter in millimetres of the ball (or, `thicken_by="box"`, the side of
    the box) that is swept over the shape (0 keeps the voxels). In the smooth style a wall is that thick to a
    quarter of a voxel from two voxels on; below it may be up to a voxel thicker, which is told in the steps,
    and below one it is refused. In the exact style it is that thick to two voxels.
    `depth` prints the pieces of that level as solids instead of the limit: the figures that their cells state
    (tetrahedra of the Sierpinski tetrahedron; `size` is then that of these figures), else the boxes around
    them (cubes of the sponge). The surface is smooth when the shape is thickened and else shows its voxels,
    unless `style` says otherwise. Where voxels touch at an edge or a corner only they are joined, or,
    `contacts="separate"`, kept apart. `merge` makes rectangles of the squares of the exact style, `features`
    keeps edges and corners of a thickened shape from an angle in degrees on, `grading` takes blocks of voxels
    outside of regions: see `export.skin`. `printable` says what else is to be done to the voxels, from least
    walls to drains; with a grading only the build volume may be asked, for blocks would undo the rest.

    From 300 voxels a side on, or for a budget of less than 10 million triangles, amounts are predicted before
    any work, told to `predicted`, and compared with `budget`: 60 million triangles and 8 GiB unless given,
    beyond which it refuses; a budget that coarsens lowers the resolution instead. `progress(stage, share)` is
    called from time to time.

    Raises `ValueError` for lengths and counts that make no sense, `TooThin`, `OverBudget`, `TooThick`,
    `DoesNotFit` where it does not fit the build volume, `ifs.NotContracting`.

    >>> import ifs
    >>> part = make_part(ifs.shape("menger-sponge"), size=27, depth=1)
    >>> part.report.ok, part.report.genus, part.tree.count
    (True, (5,), 20)
    """
    if style not in (None, "smooth", "exact"):
        raise ValueError(f"the style is 'smooth' or 'exact', found {style!r}")
    style = style or ("smooth" if thickness else "exact")
    if features is not None and not (style == "smooth" and thickness and depth is None):
        raise ValueError(
            "features are those of a thickened shape in the smooth style: give a thickness, and no depth"
        )
    if merge and style != "exact":
        raise ValueError(
            "flat squares are merged in the exact style: ask for it, a thickened shape is smooth"
        )
    if merge or features is not None or grading is not None:
        check_wishes(Wishes(grading, merge), style, contacts, None)
    if grading is not None and printable is not None and replace(printable, fit=None).asked:
        raise ValueError(
            "blocks would undo what makes a part printable: leave out the blocks, or all steps but the build "
            "volume"
        )
    tell = progress or (lambda stage, share: None)
    prepared = prepare(
        shape,
        size=size,
        resolution=resolution,
        pitch=pitch,
        thickness=thickness,
        thicken_by=thicken_by,
        depth=depth,
        contacts=contacts,
        printable=printable,
        budget=budget,
        predicted=predicted,
        progress=tell,
    )
    tree, steps = prepared.tree, prepared.steps
    if grading is not None:
        _require_blocks(thickness, grading, tree.cell_size)
        _require_regions(grading, tree)
        tree = graded(tree, grading, prepared.field)
        steps = (*steps, _told_blocks(grading, prepared.tree, tree))
    tell("surface", 0.0)
    mesh = skin(tree, style, contacts, prepared.field, grading=grading, merge=merge, features=features)
    tell("check", 0.0)
    report = check(mesh, quick=True)
    tell("check", 1.0)
    if printable is not None and printable.fit is not None:
        _require_fit(tree, report, printable.fit)
    recipe = {
        **prepared.recipe,
        "Surface": style,
        **_told(contacts, merge, features, grading),
        "Application": f"bcifs {version('bcifs')}",
    }
    return Part(mesh, tree, report, recipe, steps)


def _require_blocks(thickness: float, grading: Grading, pitch: float) -> None:
    size = grading.block * pitch
    if 0 < thickness < ACROSS * size * (1 - 1e-9):
        most = 2 ** (max(math.floor(thickness / (ACROSS * pitch) * (1 + 1e-9)), 1).bit_length() - 1)
        advice = f"take blocks of {most} voxels, or" if most > 1 else "take no blocks, or"
        raise ValueError(
            f"walls of {thickness:.4g} mm are less than {ACROSS} blocks of {size:.4g} mm: {advice} a higher "
            "resolution"
        )


def _told_blocks(grading: Grading, fine: Tree, coarse: Tree) -> Step:
    side, before, after = grading.block * fine.cell_size, fine.measure, coarse.measure
    words = f"of {side:.4g} mm outside of {len(grading.regions)} regions; {after:.5g} mm^3, not {before:.5g}"
    return Step("blocks", words, {"side": side, "before": before, "after": after})


def _require_regions(grading: Grading, tree: Tree) -> None:
    """A region that the part does not reach is a slip: the part is elsewhere."""
    low, high = mm_of(tree, box_of(tree) + np.array([[0], [1]]))
    for number, region in enumerate(grading.regions):
        if (np.array(region.low) >= high).any() or (np.array(region.high) <= low).any():
            raise ValueError(
                f"regions[{number}] from {_place(region.low)} to {_place(region.high)} mm misses the part, "
                f"which lies from {_place(low)} to {_place(high)} mm"
            )


def _place(point: Iterable[float]) -> str:
    return "(" + ", ".join(f"{x:.4g}" for x in point) + ")"


def _told(contacts: str, merge: bool, features: float | None, grading: Grading | None) -> Mapping[str, str]:
    """What the recipe says of the surface, where it is not as usual."""
    found = {
        "Contacts": None if contacts == "join" else contacts,
        "Merged": "flat squares" if merge else None,
        "Features": None if features is None else f"{features:g} degrees",
        "Blocks": None
        if grading is None
        else f"{grading.block} voxels, {len(grading.regions)} finer regions",
    }
    return {name: words for name, words in found.items() if words is not None}


def _require_fit(tree: Tree, report: Report, room: Sequence[float]) -> None:
    """A smooth surface may stand out from its voxels by up to half a voxel."""
    over = max((high - low) / side for low, high, side in zip(report.low, report.high, room, strict=True))
    if over > 1 + 1e-9:
        raise DoesNotFit(room, fits(tree, room), f"its surface is {100 * (over - 1):.3g} % too large")
