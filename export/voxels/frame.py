"""The grid of voxels around a shape, and the shape as pieces in units of this grid."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
from jaxtyping import Float

from ifs import Complex, Shape, Surface, bounding_box, bounds, extent, pieces, require_contraction, sample
from ifs.certificates.bounds import Box
from ifs.system import System
from trees import Cube

TOLERANCE = 1e-7
"""How far, in pitches, a point may lie outside the closed voxels of its cover: room for rounding where the
pieces of a lattice fractal end exactly on the faces of voxels."""

MOST_BITS = 21
_SEARCHED = 200_000
_LOOSE = 1e-3
_SIMPLE = 4096
_SAME = 1e-13
_POINT = 1e-12  # of the coordinates: smaller shapes are single points

Model = Shape | Complex | Surface
Corner = tuple[Fraction, ...]
Roots = Mapping[str, Float[np.ndarray, "_pieces _points 3"]]


class TooFine(ValueError):
    """Voxels so small that double precision does not place them; `pitch` and `least` are in mm."""

    def __init__(self, pitch: float, least: float):
        self.pitch, self.least = pitch, least
        super().__init__(
            f"voxels of {pitch:.3g} mm are too small for double precision: ask for {least:.3g} mm or more"
        )


@dataclass(frozen=True, eq=False)
class Subject:
    """What is voxelised: pieces of the cells of a system, their control points in mm with z = 0 in the plane.

    `dimension` is 1, 2 or 3: that of the space in which the shape was given. `boxes` are those of the cells,
    `corners` those of the bounding box in mm, simple fractions where they are near. `shape` is the one shape
    that it is, if it is one. `grain`, of the figures of a level, is how long the diagonals of their simplices
    are (mm) and of which dimension these are.
    """

    name: str
    system: System
    roots: Roots
    dimension: int
    boxes: Mapping[str, Box]
    corners: tuple[Corner, Corner]
    shape: Shape | None
    grain: tuple[float, int] | None = None


@dataclass(frozen=True)
class Frame:
    """The voxels `[origin + pitch i, origin + pitch (i + 1)]`, `0 <= i < size`, in mm, exact too.

    The cube of `2^bits` voxels a side that begins at the origin is the reference cube of the tree.
    """

    exact_origin: tuple[Fraction, ...]
    exact_pitch: Fraction
    size: tuple[int, int, int]

    @property
    def origin(self) -> tuple[float, ...]:
        return tuple(float(x) for x in self.exact_origin)

    @property
    def pitch(self) -> float:
        return float(self.exact_pitch)

    @property
    def bits(self) -> int:
        """Bits an axis, at least 2, so that a brick has 4 voxels a side."""
        return max((max(self.size) - 1).bit_length(), 2)

    @property
    def cube(self) -> Cube:
        return Cube(self.origin, self.pitch * 2.0**self.bits)

    @property
    def rounding(self) -> float:
        """How far, in mm, the tree's voxels may lie from the exact ones."""
        moved = [abs(float(Fraction(x) - y)) for x, y in zip(self.origin, self.exact_origin, strict=True)]
        return max(moved) + float(abs(Fraction(self.pitch) - self.exact_pitch)) * max(self.size)


def subject(model: Model | Subject) -> Subject:
    """The pieces to voxelise of a shape, of a complex of patches or of a surface over a control mesh.

    Raises `TypeError` for anything else, `ValueError` for a shape of more than 3 coordinates or control
    points that are not finite, `NotContracting` or `Undecided`.
    """
    if isinstance(model, Subject):
        return model
    if isinstance(model, Surface):
        model = model.complex()
    if not isinstance(model, Shape | Complex):
        raise TypeError(
            f"voxels are made of an ifs.Shape, ifs.Complex or ifs.Surface, found {_described(model)}"
        )
    if isinstance(model, Complex):
        name, given = model.topology.automaton.name, model.control
    else:
        name, given = model.name, {model.system.shape: np.asarray(model.control, dtype=float)[None]}
    given = {cell: points for cell, points in given.items() if len(points)}
    dimension = max((points.shape[2] for points in given.values()), default=0)
    if not 1 <= dimension <= 3:
        raise ValueError(f"voxels are for shapes of 1 to 3 coordinates, found {dimension}")
    for cell, points in given.items():
        if not np.isfinite(points).all():
            raise ValueError(f"control points of cell {cell!r} are not finite")
    require_contraction(model.system)
    roots = {
        cell: np.pad(np.asarray(points, dtype=np.float64), ((0, 0), (0, 0), (0, 3 - dimension)))
        for cell, points in given.items()
    }
    boxes = bounds(model.system)
    shape = model if isinstance(model, Shape) else None
    if shape is not None:
        low, high = (np.pad(side, (0, 3 - dimension)) for side in bounding_box(shape))
        corners = _simple_corners(low, high)
    else:
        corners = corners_of(model.system, boxes, roots)
    return Subject(name, model.system, roots, dimension, boxes, corners, shape)


def corners_of(system: System, boxes: Mapping[str, Box], roots: Roots) -> tuple[Corner, Corner]:
    """The lower and the upper corner, in mm, of a box around pieces."""
    return _simple_corners(*_box_of_pieces(system, boxes, roots))


def _simple_corners(low: Float[np.ndarray, "3"], high: Float[np.ndarray, "3"]) -> tuple[Corner, Corner]:
    scale = float(max(np.abs(low).max(), np.abs(high).max()))
    return tuple(simple(x, scale) for x in low), tuple(simple(x, scale) for x in high)


def frame_around(model: Model | Subject, resolution: int | None = None, pitch: float | None = None) -> Frame:
    """The grid around the bounding box of a shape: so many voxels along the longest side, or of a size.

    The box is in the middle of the grid; a plane shape lies in the middle of one layer. Raises `ValueError`
    for both or neither, numbers out of range, over 2^21 voxels a side, and a shape that is a single point.

    >>> import ifs
    >>> frame_around(ifs.shape("menger-sponge"), 27).size
    (27, 27, 27)
    """
    if (resolution is None) == (pitch is None):
        raise ValueError("give either a resolution, in voxels along the longest side, or a pitch in mm")
    if resolution is not None and not isinstance(resolution, int | np.integer):
        raise TypeError(f"the resolution is a whole number of voxels, found {_described(resolution)}")
    if resolution is not None and resolution < 1:
        raise ValueError(f"the resolution is 1 or more, found {resolution}")
    if pitch is not None and not isinstance(pitch, int | float | np.number | Fraction):
        raise TypeError(f"the pitch is a length in mm, found {_described(pitch)}")
    if pitch is not None and not (math.isfinite(pitch) and pitch > 0):
        raise ValueError(f"the pitch is a length above 0 mm, found {pitch}")
    found = subject(model)
    lows, highs = found.corners
    longest = max(b - a for a, b in zip(lows, highs, strict=True))
    most = max(float(np.abs(points).max()) for points in found.roots.values())
    if not longest > _POINT * most:
        raise ValueError("the shape is a single point: nothing to voxelise")
    side = longest / resolution if resolution is not None else Fraction(pitch or 0)
    counts = [
        max(math.ceil((b - a) / side - Fraction(TOLERANCE)), 1) for a, b in zip(lows, highs, strict=True)
    ]
    if max(counts) > 1 << MOST_BITS:
        raise ValueError(
            f"{max(counts)} voxels along a side, more than {1 << MOST_BITS}: a pitch of "
            f"{float(longest) / (1 << MOST_BITS):.3g} mm or more is possible here"
        )
    origin = tuple((a + b - n * side) / 2 for a, b, n in zip(lows, highs, counts, strict=True))
    return Frame(origin, side, (counts[0], counts[1], counts[2]))


def simple(x: float, scale: float = 1.0) -> Fraction:
    """The fraction with a denominator of at most 4096 within 1e-13 of the scale, else the float itself."""
    near = Fraction(float(x)).limit_denominator(_SIMPLE)
    return near if abs(float(near) - float(x)) <= _SAME * scale else Fraction(float(x))


def lattice_resolution(shape: Shape, depth: int) -> int | None:
    """How many voxels along the longest side make every piece at a depth a whole number of voxels.

    None when the pieces' boxes are not equal cubes on a lattice.

    >>> import ifs
    >>> lattice_resolution(ifs.shape("menger-sponge"), 2)
    9
    """
    low, high = bounding_box(shape)
    longest = float((high - low).max())
    side = None
    for batch in pieces(shape.system, shape.control, depth=depth):
        sides = batch.hi - batch.lo
        side = float(sides[0, 0]) if side is None else side
        places = (batch.lo - low) / side if side > 0 else np.full_like(sides, 0.5)
        if np.abs(sides - side).max() > 1e-9 * longest or np.abs(places - np.round(places)).max() > 1e-6:
            return None
    return round(longest / side) if side else None


def in_grid(model: Model | Subject, frame: Frame) -> Subject:
    """The pieces in units of the grid, where voxel i is [i, i + 1]; plane shapes half-way up their layer."""
    found = subject(model)
    roots = {}
    for cell, points in found.roots.items():
        placed = (points - np.array(frame.origin)) / frame.pitch
        for axis in range(found.dimension, 3):
            placed[:, :, axis] = 0.5
        roots[cell] = placed
    return replace(found, roots=roots, shape=None)


def _box_of_pieces(
    system: System, boxes: Mapping[str, Box], roots: Roots
) -> tuple[Float[np.ndarray, "3"], Float[np.ndarray, "3"]]:
    """A box around many pieces: those that reach beyond known points by over a tolerance are subdivided."""
    points = sample(system)
    pieces = dict(roots)
    known_low, known_high = np.full(3, np.inf), np.full(3, -np.inf)
    low, high = known_low.copy(), known_high.copy()
    slack = 0.0
    while pieces:
        ends = {cell: extent(boxes[cell], control) for cell, control in pieces.items()}
        for cell, control in pieces.items():
            places = np.einsum("p,npd->nd", points[cell], control)
            known_low = np.minimum(known_low, places.min(axis=0))
            known_high = np.maximum(known_high, places.max(axis=0))
        if not slack:
            slack = _LOOSE * float(max((hi - lo).max() for lo, hi in ends.values())) + 1e-300
            slack = max(slack, _LOOSE * float((known_high - known_low).max()))
        many = sum(len(control) for control in pieces.values()) > _SEARCHED
        children: dict[str, list[np.ndarray]] = {}
        for cell, (lo, hi) in ends.items():
            beyond = ((lo < known_low - slack) | (hi > known_high + slack)).any(axis=1) & (not many)
            low = np.minimum(low, lo[~beyond].min(axis=0, initial=np.inf))
            high = np.maximum(high, hi[~beyond].max(axis=0, initial=-np.inf))
            state = system.states[cell]
            for operator, target in zip(state.operators, state.targets, strict=True):
                if beyond.any():
                    children.setdefault(target, []).append(operator.T @ pieces[cell][beyond])
        pieces = {cell: np.concatenate(parts) for cell, parts in children.items()}
    return low, high


def _described(value: object) -> str:
    return f"{value!r}, of type {type(value).__name__}"[:200]
