"""A set of equal cubes on a grid, and a solid sampled on the same grid."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float

from export.meshing.skin import EmptySolid as EmptySolid

Connectivity = Literal[6, 18, 26]


@dataclass(frozen=True, eq=False)
class Voxels:
    """The cubes `[origin + pitch * (i, j, k), origin + pitch * (i + 1, j + 1, k + 1)]` that are filled.

    `filled` is `(x, y, z)`, `origin` is the low corner of cube (0, 0, 0) and `pitch` the side of a
    cube, both in millimetres. `ValueError` when the array has not three non-empty axes of booleans,
    or when a length is not finite or the pitch not positive.

    >>> import numpy as np
    >>> two = Voxels(np.ones((2, 1, 1), dtype=bool), np.zeros(3), 0.5)
    >>> two.count, two.volume, two.euler
    (2, 0.25, 1)
    """

    filled: Bool[np.ndarray, "x y z"]
    origin: Float[np.ndarray, "3"]
    pitch: float

    def __post_init__(self) -> None:
        if self.filled.ndim != 3 or self.filled.dtype != np.bool_ or 0 in self.filled.shape:
            raise ValueError(
                f"voxels need a boolean array with three non-empty axes, not {self.filled.dtype} "
                f"of shape {self.filled.shape}"
            )
        origin = np.asarray(self.origin, dtype=np.float64)
        if origin.shape != (3,) or not np.isfinite(origin).all():
            raise ValueError(f"the origin must be three finite lengths in mm, not {self.origin}")
        if not (np.isfinite(self.pitch) and self.pitch > 0):
            raise ValueError(f"the pitch must be a positive length in mm, not {self.pitch}")
        object.__setattr__(self, "origin", origin)
        object.__setattr__(self, "pitch", float(self.pitch))

    @property
    def count(self) -> int:
        """How many cubes are filled."""
        return int(np.count_nonzero(self.filled))

    @property
    def volume(self) -> float:
        """Their volume in mm³: `count * pitch**3`."""
        return self.count * self.pitch**3

    def centres(self) -> Float[np.ndarray, "filled 3"]:
        """The centres of the filled cubes in mm, in the order of `np.argwhere(filled)`."""
        return self.origin + (np.argwhere(self.filled) + 0.5) * self.pitch

    def components(self, connectivity: Connectivity = 6) -> int:
        """The pieces of the set; cubes hang together by faces (6), edges (18) or corners (26).

        >>> import numpy as np
        >>> diagonal = Voxels(np.eye(3, dtype=bool)[:, :, None], np.zeros(3), 1.0)
        >>> diagonal.components(6), diagonal.components(18)
        (3, 1)
        """
        return _pieces(self.filled, connectivity)

    @property
    def cavities(self) -> int:
        """The voids closed off by the set (empty cubes hang together by corners)."""
        return _pieces(~np.pad(self.filled, 1), 26) - 1

    @property
    def euler(self) -> int:
        """The Euler characteristic of the interior, where cubes hang together by faces only.

        `cubes - inner faces + inner edges - inner corners`, which equals components - holes +
        cavities; the boundary surface has twice this characteristic.
        """
        block, total, sign = self.filled, self.count, 1
        for axes in ([(0,), (1,), (2,)], [(0, 1), (0, 2), (1, 2)], [(0, 1, 2)]):
            sign = -sign
            for along in axes:
                inner = block
                for axis in along:
                    inner = _both(inner, axis)
                total += sign * int(np.count_nonzero(inner))
        return total

    @property
    def holes(self) -> int:
        """The tunnels through the set: the genus of its boundary, summed over all its sheets.

        >>> import numpy as np
        >>> ring = np.ones((3, 3, 1), dtype=bool)
        >>> ring[1, 1, 0] = False
        >>> Voxels(ring, np.zeros(3), 1.0).holes
        1
        """
        return self.components(6) + self.cavities - self.euler


@dataclass(frozen=True, eq=False)
class Solid:
    """Voxels with a distance to the surface at their centres.

    `field` is float32 `(x, y, z)` in mm, at most 0 in filled voxels and positive in empty ones
    (`ValueError` otherwise); without it the surface passes half-way between centres.
    """

    voxels: Voxels
    field: Float[np.ndarray, "x y z"] | None = None

    def __post_init__(self) -> None:
        if self.field is None:
            return
        if self.field.shape != self.voxels.filled.shape:
            raise ValueError(f"the field has shape {self.field.shape}, the voxels {self.voxels.filled.shape}")
        wrong = int(np.count_nonzero((self.field <= 0) != self.voxels.filled))
        if wrong:
            raise ValueError(f"the sign of the field disagrees with the voxels in {wrong} places")


def _both(filled: Bool[np.ndarray, "x y z"], axis: int) -> Bool[np.ndarray, "_ _ _"]:
    """Which cubes are filled together with their next one along an axis."""
    low = [slice(None)] * 3
    high = [slice(None)] * 3
    low[axis], high[axis] = slice(None, -1), slice(1, None)
    return filled[tuple(low)] & filled[tuple(high)]


def _pieces(filled: Bool[np.ndarray, "x y z"], connectivity: Connectivity) -> int:
    from scipy import ndimage

    steps = {6: 1, 18: 2, 26: 3}
    if connectivity not in steps:
        raise ValueError(f"the connectivity of voxels is 6, 18 or 26, not {connectivity}")
    structure = ndimage.generate_binary_structure(3, steps[connectivity])
    labels = np.empty(filled.shape, dtype=np.int32)
    ndimage.label(filled, structure, output=labels)
    return int(labels.max())
