"""Where filled voxels touch at an edge or a corner only: finding it and filling it up.

Around a corner of the grid lie eight voxels, the octants; octant `x + 2 y + 4 z` is the one on the
`x`, `y`, `z` side (0 low, 1 high), and the code of a corner has bit `o` set when octant `o` is
filled. The tables below have a row for each of the 256 codes.
"""

import itertools
from typing import no_type_check

import numba
import numpy as np
from jaxtyping import Bool, UInt8

from export.voxels import Voxels

NO_FAN = 255


def face_slots() -> list[tuple[int, int]]:
    """The twelve unit faces that meet at a corner, each as its (low, high) octants.

    Slot `4 a + p + 2 q` is the face across axis `a` on side `p` of the next axis and `q` of the
    one after.
    """
    slots = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for q, p in itertools.product((0, 1), (0, 1)):
            low = (p << u) | (q << v)
            slots.append((low, low | (1 << axis)))
    return slots


def edges_at_corner() -> list[list[int]]:
    """The six unit edges that meet at a corner, each as the slots of the four faces around it."""
    slots = face_slots()
    edges = []
    for axis, side in itertools.product(range(3), (0, 1)):
        around = {octant for octant in range(8) if (octant >> axis) & 1 == side}
        edges.append([slot for slot, pair in enumerate(slots) if around.issuperset(pair)])
    return edges


def fans_of(code: int) -> tuple[list[int], bool]:
    """The fan of each face slot (`NO_FAN` where no surface passes), and if a contact edge ends here.

    Boundary faces that meet at an edge belong to one fan. Where four meet, two filled voxels touch
    there: each keeps its own two.
    """
    slots = face_slots()
    filled = [(code >> octant) & 1 for octant in range(8)]
    inner = [low if filled[low] else high for low, high in slots]
    fan = [s if filled[low] != filled[high] else NO_FAN for s, (low, high) in enumerate(slots)]
    contact = False
    for edge in edges_at_corner():
        faces = [slot for slot in edge if fan[slot] != NO_FAN]
        contact = contact or len(faces) == 4
        for one, other in itertools.combinations(faces, 2):
            if len(faces) == 2 or inner[one] == inner[other]:
                old, new = fan[other], fan[one]
                fan = [new if name == old else name for name in fan]
    names = sorted(set(fan) - {NO_FAN})
    return [names.index(name) if name != NO_FAN else NO_FAN for name in fan], contact


def _tables() -> tuple[UInt8[np.ndarray, "256 12"], UInt8[np.ndarray, "256"], Bool[np.ndarray, "256"]]:
    rows = [fans_of(code) for code in range(256)]
    fans = np.array([fan for fan, _ in rows], dtype=np.uint8)
    counts = np.array([len(set(fan) - {NO_FAN}) for fan, _ in rows], dtype=np.uint8)
    contact = np.array([edge for _, edge in rows]) | (counts > 1)
    return fans, counts, contact


def _repairs(contact: Bool[np.ndarray, "256"]) -> UInt8[np.ndarray, "256"]:
    """For each code the fewest octants to fill so that no contact is left, the lowest of these."""
    masks = sorted(range(256), key=lambda mask: (mask.bit_count(), mask))
    return np.array([next(m for m in masks if not contact[code | m]) for code in range(256)], dtype=np.uint8)


FANS, FAN_COUNT, CONTACT = _tables()
REPAIR = _repairs(CONTACT)


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
