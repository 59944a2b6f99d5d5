"""Around a corner of the grid: the fans of the boundary, and where filled voxels touch there only.

Around a corner of the grid lie eight voxels, the octants; octant `x + 2 y + 4 z` is the one on the
`x`, `y`, `z` side (0 low, 1 high), and the code of a corner has bit `o` set when octant `o` is
filled. The tables below have a row for each of the 256 codes.
"""

import itertools

import numpy as np
from jaxtyping import Bool, UInt8

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
