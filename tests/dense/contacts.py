"""Contacts of voxels on dense arrays: found and filled corner by corner."""

from typing import no_type_check

import numba
import numpy as np
from dense.voxels import Voxels
from jaxtyping import Bool

from export.meshing.contacts import CONTACT, REPAIR


def pad(filled: Bool[np.ndarray, "x y z"]) -> Bool[np.ndarray, "a b c"]:
    """The voxels with an empty layer all round, last axis contiguous whatever theirs was."""
    return np.pad(np.ascontiguousarray(filled), 1)


def join_contacts(voxels: Voxels) -> Voxels:
    """Fill voxels until no two sheets of the boundary touch.

    Afterwards no two filled voxels, and no two empty ones, meet at an edge or a corner alone: the
    boundary is a manifold as a set of points, also after a program has welded equal positions. At
    each corner in turn the fewest voxels that help are filled (of equally few, those on the low
    side), again and again until none is left; a set without contacts comes back as it is.

    >>> import numpy as np
    >>> touching = Voxels(np.eye(2, dtype=bool)[:, :, None], np.zeros(3), 1.0)
    >>> join_contacts(touching).count
    3
    """
    padded = pad(voxels.filled)
    sizes = np.array(padded.shape)
    if not _join(padded.ravel(), sizes, CONTACT, REPAIR):
        return voxels
    return Voxels(padded[1:-1, 1:-1, 1:-1].copy(), voxels.origin, voxels.pitch)


def has_contacts(voxels: Voxels) -> bool:
    """Whether filled (or empty) voxels meet at an edge or a corner alone."""
    padded = pad(voxels.filled)
    return bool(_touches(padded.ravel(), np.array(padded.shape), CONTACT))


@numba.njit(cache=True, inline="always")
@no_type_check
def corner_code(padded, corner, step_x, step_y):
    """The code of the corner above voxel `corner` of a flat array."""
    code = 0
    for octant in range(8):
        place = corner + (octant & 1) * step_x + ((octant >> 1) & 1) * step_y + (octant >> 2)
        if padded[place]:
            code |= 1 << octant
    return code


@numba.njit(cache=True)
@no_type_check
def _touches(padded, sizes, contact):
    step_y = sizes[2]
    step_x = sizes[1] * sizes[2]
    for x in range(sizes[0] - 1):
        for y in range(sizes[1] - 1):
            for z in range(sizes[2] - 1):
                if contact[corner_code(padded, x * step_x + y * step_y + z, step_x, step_y)]:
                    return True
    return False


@numba.njit(cache=True)
@no_type_check
def _join(padded, sizes, contact, repair):
    """Fill in place; returns how many voxels were filled."""
    step_y = sizes[2]
    step_x = sizes[1] * sizes[2]
    total = 0
    added = 1
    while added > 0:
        added = 0
        for x in range(sizes[0] - 1):
            for y in range(sizes[1] - 1):
                for z in range(sizes[2] - 1):
                    corner = x * step_x + y * step_y + z
                    code = corner_code(padded, corner, step_x, step_y)
                    if not contact[code]:
                        continue
                    for octant in range(8):
                        if (repair[code] >> octant) & 1:
                            padded[
                                corner + (octant & 1) * step_x + ((octant >> 1) & 1) * step_y + (octant >> 2)
                            ] = True
                            added += 1
        total += added
    return total
