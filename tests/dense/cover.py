"""The voxels that an attractor touches."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import no_type_check

import numba
import numpy as np
from dense.voxels import Voxels
from jaxtyping import Bool, Float

from ifs import Shape, bounding_box, pieces

TOLERANCE = 1e-7
"""How far, in pitches, a point may lie outside the closed voxels of its cover: the rounding allowed for when
the pieces of a lattice fractal end exactly on the faces of voxels."""

MOST_VOXELS = 1_500_000_000

Progress = Callable[[str, float], None]


class TooManyVoxels(MemoryError):
    """The grid would not fit in memory; `voxels` says how many there would be."""

    def __init__(self, resolution: int, voxels: int):
        self.voxels = voxels
        super().__init__(
            f"a resolution of {resolution} needs a grid of {voxels:.3g} voxels; "
            f"the limit is {MOST_VOXELS:.3g}. Lower the resolution"
        )


@dataclass(frozen=True)
class Cover:
    """A cover of an attractor: every point of it lies in a filled voxel.

    `distance` bounds how far any point of the filled voxels is from the attractor (mm).
    """

    voxels: Voxels
    distance: float


def cover(
    shape: Shape,
    resolution: int = 200,
    depth: int | None = None,
    progress: Progress | None = None,
) -> Cover:
    """The voxels met by the boxes of the pieces of a shape, on a grid of its own bounding box.

    The longest side of the box has `resolution` voxels; a plane shape lies in the middle of one layer.
    Pieces are subdivided until their certified box is no larger than a voxel, so that no filled voxel
    is farther than `2 sqrt(3)` pitches from the attractor; with `depth`, the boxes of the pieces at
    exactly that level are filled (the sponge at level n, as a solid). A box that ends on the face of a
    voxel, to within `TOLERANCE`, does not fill the voxel behind it.

    Raises `ValueError` for a shape that is a single point or has more than 3 dimensions, `TooManyVoxels`,
    `ifs.NotContracting`.

    >>> import ifs
    >>> cover(ifs.shape("menger-sponge"), 27, depth=3).voxels.count
    8000
    """
    control = shape.control
    if control.shape[1] > 3:
        raise ValueError(f"voxels are for shapes of up to 3 dimensions, found {control.shape[1]}")
    control = np.pad(control, ((0, 0), (0, 3 - control.shape[1])))
    low, high = space_box(shape)
    pitch = float((high - low).max()) / resolution
    if not pitch > 0:
        raise ValueError("the shape is a single point: nothing to voxelise")
    size = np.maximum(np.ceil((high - low) / pitch - TOLERANCE), 1).astype(int)
    if math.prod(size.tolist()) > MOST_VOXELS:
        raise TooManyVoxels(resolution, math.prod(size.tolist()))
    origin = (low + high - size * pitch) / 2
    filled = np.zeros(tuple(size), dtype=np.bool_)

    def covered(lo: np.ndarray, hi: np.ndarray) -> Bool[np.ndarray, "count"]:
        return _all_filled(filled, *_ranges(lo, hi, origin, pitch, filled.shape))

    wanted = pitch * (1 + TOLERANCE) if depth is None else None
    skip = covered if depth is None else None
    reach = 0.0
    for batch in pieces(shape.system, control, wanted, depth, skip=skip):
        reach = max(reach, float((batch.hi - batch.lo).max()))
        first, last = _ranges(batch.lo, batch.hi, origin, pitch, filled.shape)
        _fill(filled, first, last)
        if progress:
            progress("voxels", batch.done)
    voxels = Voxels(filled, origin, pitch)
    if depth is None:
        reach = pitch  # also for the pieces that were skipped
    return Cover(voxels, (reach + pitch) * math.sqrt(3))


def space_box(shape: Shape) -> tuple[Float[np.ndarray, "3"], Float[np.ndarray, "3"]]:
    """The corners, in mm, of the box that bounds a shape; a plane shape has z = 0."""
    low, high = bounding_box(shape)
    missing = 3 - len(low)
    return np.pad(low, (0, missing)), np.pad(high, (0, missing))


def _ranges(lo, hi, origin, pitch: float, grid: tuple[int, ...]):
    """First and last voxel of boxes along each axis."""
    top = np.array(grid) - 1
    first = np.floor((lo - origin) / pitch + TOLERANCE).astype(np.int64)
    last = np.ceil((hi - origin) / pitch - TOLERANCE).astype(np.int64) - 1
    first = np.clip(first, 0, top)
    return first, np.clip(last, first, top)


@numba.njit(cache=True)
@no_type_check
def _fill(filled, first, last):
    for n in range(len(first)):
        for i in range(first[n, 0], last[n, 0] + 1):
            for j in range(first[n, 1], last[n, 1] + 1):
                for k in range(first[n, 2], last[n, 2] + 1):
                    filled[i, j, k] = True


@numba.njit(cache=True)
@no_type_check
def _all_filled(filled, first, last):
    result = np.ones(len(first), dtype=np.bool_)
    for n in range(len(first)):
        # Large boxes are not worth searching: their pieces are asked about later.
        if (last[n] - first[n]).max() > 3:
            result[n] = False
            continue
        for i in range(first[n, 0], last[n, 0] + 1):
            for j in range(first[n, 1], last[n, 1] + 1):
                for k in range(first[n, 2], last[n, 2] + 1):
                    if not filled[i, j, k]:
                        result[n] = False
    return result
