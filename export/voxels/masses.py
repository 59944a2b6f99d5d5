"""The invariant measure of a shape, voxel by voxel of its cover."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from export.voxels.voxelise import Cover
from ifs import Shape
from ifs.measures.density import density
from ifs.measures.grid import Grid
from ifs.orbits.chaos import Given
from trees import to_points


@dataclass(frozen=True, eq=False)
class Masses:
    """How much of a measure of total 1 lies in each black voxel, in Morton order (`trees.to_points`).

    No set of voxels has a mass that is wrong by more than `error`.
    """

    amounts: Float[np.ndarray, "voxels"]
    error: float


def masses(shape: Shape, cover: Cover, probabilities: Given | None = None, part: float = 1 / 8) -> Masses:
    """The invariant measure of a shape of two or three coordinates on the voxels that cover it.

    See `ifs.measures.density.density`, which it is worked out by, on a dense grid of up to 2^28 cells:
    `probabilities` of the labels, and the `part` of a voxel below which pieces are no longer cut. Divide by
    the volume of a voxel for a density. Raises what `density` raises.

    >>> import ifs
    >>> from export.voxels.voxelise import voxelise
    >>> sponge = ifs.shape("menger-sponge")
    >>> found = masses(sponge, voxelise(sponge, 9))
    >>> len(found.amounts), round(float(found.amounts.min()) * 400, 9), found.error
    (400, 1.0, 0.0)
    """
    axes = shape.control.shape[1]
    grid = Grid(np.array(cover.tree.origin[:axes]), cover.pitch, cover.size[:axes])
    found = density(shape, grid=grid, probabilities=probabilities, part=part)
    cells = to_points(cover.tree).astype(np.int64)[:, :axes]
    amounts = found.amounts[tuple(cells.T)]
    lost = max(found.total - float(amounts.sum()), 0.0)
    return Masses(amounts, found.error + (lost if lost > 1e-12 else 0.0))
