"""From a shape to the voxels of a part: cover, thickening, and what makes it printable."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from export.facets import Facets
from export.meshing.skin import Field
from export.printable.requests import Printable
from export.printable.steps import Step, made_printable
from export.thicken import thicken
from export.voxels.estimate import Budget, Prediction
from export.voxels.frame import lattice_resolution
from export.voxels.level import level_size
from export.voxels.voxelise import Cover, Progress, voxelise
from ifs import Mesh, Shape, bounding_box, draw, initial, refine
from trees import Tree

RESOLUTION = 200
FINEST = 20_000
BUDGET = Budget(triangles=60_000_000, memory=8 * 2**30)
MOST_THICKENED = 2_000_000_000
LARGE = 300  # voxels along a side from which on the amounts are predicted first
MANY = 10_000_000  # triangles, more than a part below that has
MOST_FACETS = 100_000
DEEPEST = 29
ACROSS = 2  # voxels across a wall that comes out as thick as it was asked
CONTACTS = ("join", "separate")


@dataclass(frozen=True, eq=False)
class Prepared:
    """The voxels of a part, ready to be meshed or sliced, what was done to them, and the recipe so far.

    `field` is the distance to a thickened surface, in mm: see `export.skin`. `cover` are the voxels of the
    shape itself, with their certificate.
    """

    tree: Tree
    field: Field | None
    cover: Cover
    steps: tuple[Step, ...]
    recipe: Mapping[str, str]


class TooThin(ValueError):
    """A `length` in mm (of what `name` says) below the side of a voxel, `pitch`; `resolution` would do."""

    def __init__(self, name: str, length: float, pitch: float, resolution: int):
        self.name, self.length, self.pitch, self.resolution = name, length, pitch, resolution
        super().__init__(
            f"{name} of {length:.6g} mm is less than a voxel of {pitch:.4g} mm: ask for "
            f"{ACROSS * pitch:.4g} mm or more, or for a resolution of {resolution} or more"
        )


class TooThick(MemoryError):
    """A thickness that makes more voxels than can be worked on: `voxels`, black or not."""

    def __init__(self, thickness: float, voxels: int):
        self.thickness, self.voxels = thickness, voxels
        super().__init__(
            f"a thickness of {thickness:.6g} mm makes a grid of {voxels:.3g} voxels, and "
            f"{MOST_THICKENED:.3g} are possible: ask for a smaller one, or for a lower resolution"
        )


def prepare(
    shape: Shape,
    *,
    size: float | None = None,
    resolution: int | None = None,
    pitch: float | None = None,
    thickness: float = 0.0,
    thicken_by: str = "ball",
    depth: int | None = None,
    contacts: str = "join",
    printable: Printable | None = None,
    budget: Budget = BUDGET,
    predicted: Callable[[Prediction], None] | None = None,
    progress: Progress | None = None,
) -> Prepared:
    """Voxelise a shape, thicken it, and make it printable: all that `make_part` does before it meshes.

    The arguments and the errors are those of `make_part`.

    >>> import ifs
    >>> sponge, asked = ifs.shape("menger-sponge"), Printable(base=3)
    >>> prepared = prepare(sponge, size=27, depth=1, resolution=9, printable=asked)
    >>> prepared.tree.measure / 27
    621.0
    >>> [str(step) for step in prepared.steps]
    ['base: 27 x 27 mm, 3 mm high; the part stands on 648 of 729 mm^2']
    """
    _check(size, resolution, pitch, thickness, depth, contacts)
    asked = printable or Printable()
    shape, longest = _resized(shape, size, depth)
    lengths = asked.lengths | ({"a thickness": thickness} if thickness else {})
    steps = []
    if resolution is None and pitch is None:
        resolution, steps = _chosen_resolution(shape, depth, longest, lengths)
    tell = progress or (lambda stage, share: None)
    large = (longest / pitch if pitch else resolution or 0) >= LARGE or (budget.triangles or MANY) < MANY
    covered = voxelise(
        shape,
        resolution,
        pitch=pitch,
        depth=depth,
        budget=budget if large else None,
        progress=tell,
        predicted=predicted if large else None,
    )
    _require_fine(covered, lengths, longest)
    tree, field = covered.tree, None
    if thickness:
        steps += _told_width(covered, thickness, longest)
        _require_room(covered, thickness)
        tell("thickness", 0.0)
        facets = _facets(shape, covered.pitch) if depth is None else None
        solid = thicken(tree, thickness / 2, facets, thicken_by)
        tree, field = solid.tree, solid.field
    recipe = {
        "Name": shape.name,
        "Size": f"{covered.pitch * covered.resolution:.6g} mm",
        "Resolution": str(covered.resolution),
        "Thickness": f"{thickness:.6g} mm" + (" by a box" if thickness and thicken_by == "box" else ""),
        "Depth": "limit" if depth is None else str(depth),
    }
    if asked.asked:
        made = made_printable(tree, asked, field, contacts, tell)
        tree, field = made.tree, made.field
        steps += made.steps
        recipe |= {step.name.capitalize(): step.words for step in made.steps}
    return Prepared(tree, field, covered, tuple(steps), recipe)


def _check(
    size: float | None,
    resolution: int | None,
    pitch: float | None,
    thickness: float,
    depth: int | None,
    contacts: str,
) -> None:
    _require(size is None or (math.isfinite(size) and size > 0), f"the size is above 0 mm, found {size}")
    _require(math.isfinite(thickness) and thickness >= 0, f"the thickness is 0 mm or more, found {thickness}")
    _require(
        resolution is None or 1 <= resolution <= FINEST, f"resolutions go from 1 to {FINEST}: {resolution}"
    )
    _require(pitch is None or (math.isfinite(pitch) and pitch > 0), f"the pitch is above 0 mm, found {pitch}")
    _require(
        resolution is None or pitch is None, "a resolution and a pitch are two answers: give one of them"
    )
    _require(depth is None or depth >= 0, f"the depth is 0 or more, found {depth}")
    _require(
        contacts in CONTACTS, f"contacts are treated by one of {', '.join(CONTACTS)}; found {contacts!r}"
    )


def _chosen_resolution(
    shape: Shape, depth: int | None, longest: float, lengths: Mapping[str, float]
) -> tuple[int, list[Step]]:
    """The usual resolution or that of the lattice, or as many times that as short lengths need."""
    lattice = lattice_resolution(shape, depth) if depth is not None else None
    usual = lattice or RESOLUTION
    if not lengths:
        return usual, []
    name = min(lengths, key=lambda each: lengths[each])
    need = _resolution_for(lengths[name], longest)
    if need <= usual:
        return usual, []
    chosen = usual * math.ceil(need / usual) if lattice else need
    if chosen > FINEST:
        raise TooThin(name, lengths[name], longest / FINEST, chosen)
    words = f"{chosen} voxels along the longest side, of which {name} of {lengths[name]:.4g} mm has {ACROSS}"
    return chosen, [Step("resolution", words, {"resolution": chosen})]


def _resolution_for(length: float, longest: float) -> int:
    return math.ceil(ACROSS * longest / length * (1 - 1e-9))


def _require_fine(covered: Cover, lengths: Mapping[str, float], longest: float) -> None:
    for name, length in lengths.items():
        if length < covered.pitch * (1 - 1e-9):
            raise TooThin(name, length, covered.pitch, _resolution_for(length, longest))


def _told_width(covered: Cover, thickness: float, longest: float) -> list[Step]:
    across = thickness / covered.pitch * (1 + 1e-9)
    if across >= ACROSS:
        return []
    low, high = (thickness - covered.pitch / 4, thickness + covered.pitch)
    words = (
        f"walls of {thickness:.4g} mm are {across:.2g} voxels and come out {low:.3g} to {high:.3g} mm thick; "
        f"from a resolution of {_resolution_for(thickness, longest)} on they are right"
    )
    return [Step("thickness", words, {"thickness": thickness, "least": low, "most": high})]


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


def _require_room(covered: Cover, thickness: float) -> None:
    more = math.ceil(thickness / covered.pitch) + 4
    voxels = math.prod(side + more for side in covered.size)
    if voxels > MOST_THICKENED:
        raise TooThick(thickness, voxels)


def _resized(shape: Shape, size: float | None, depth: int | None) -> tuple[Shape, float]:
    longest = level_size(shape, depth) if depth is not None else None
    if longest is None:
        low, high = bounding_box(shape)
        longest = float((high - low).max())
    _require(longest > 0, "the shape is a single point: nothing to print")
    return (shape, longest) if size is None else (shape.scaled(size / longest), size)
