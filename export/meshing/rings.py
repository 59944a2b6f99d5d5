"""The vertices of rectangles that tile a boundary: each is in the rings of all rectangles it lies on."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int

from export.meshing.patches import FIELD, Patches
from trees.errors import TreeError


@dataclass(frozen=True, eq=False)
class Rings:
    """Corners of rectangles, in cells, and around each rectangle those on its border.

    `ring[starts[f] : starts[f + 1]]` are the rows of `corners` around rectangle f, counter-clockwise from
    outside, and `turns[f]` the places in it of the four corners of f.
    """

    corners: Int[np.ndarray, "vertices 3"]
    starts: Int[np.ndarray, " _offsets"]
    ring: Int[np.ndarray, " incidences"]
    turns: Int[np.ndarray, "patches 4"]


def rings_of(patches: Patches, bits: int) -> Rings:
    """The rings of rectangles that tile a boundary whose sheets do not touch.

    A vertex is a corner of any rectangle; as sheets do not touch, there is one fan at it, which holds the
    sides on which it lies. So a side is cut at the same vertices in the rings of both its neighbours.

    Raises `TreeError` above 20 bits an axis.
    """
    if bits >= FIELD:
        raise TreeError(f"a tree of {bits} bits an axis: blocks of several sizes take at most {FIELD - 1}")
    from export.meshing.rings_kernels import fill_rings, lengths_of

    keys = _corner_keys(patches)
    names, places = np.unique(keys, return_inverse=True)
    quads = places.reshape(-1, 4)
    mask = (1 << FIELD) - 1
    corners = np.stack([names >> 2 * FIELD, names >> FIELD & mask, names & mask], axis=1)
    orders = np.empty((3, len(names)), dtype=np.int32)
    ranks = np.empty((3, len(names)), dtype=np.int32)
    count = np.arange(len(names), dtype=np.int32)
    for axis in range(3):
        one, two = (axis + 1) % 3, (axis + 2) % 3
        along = corners[:, one] << 2 * FIELD | corners[:, two] << FIELD | corners[:, axis]
        orders[axis] = np.argsort(along, kind="stable")
        ranks[axis, orders[axis]] = count
    starts = np.empty(len(quads) + 1, dtype=np.int64)
    lengths_of(patches.axis, patches.out, quads, ranks, starts)
    ring, turns = np.empty(starts[-1], dtype=np.int32), np.empty((len(quads), 4), dtype=np.int32)
    fill_rings(patches.axis, patches.out, quads, ranks, orders, starts, ring, turns)
    return Rings(corners, starts, ring, turns)


def _corner_keys(patches: Patches) -> Int[np.ndarray, "patches 4"]:
    """The four corners of each rectangle, counter-clockwise from outside, from the lowest on."""
    unit = np.array([1 << 2 * FIELD, 1 << FIELD, 1])
    low = patches.low @ unit
    along_u = patches.size[:, 0] * unit[(patches.axis + 1) % 3]
    along_v = patches.size[:, 1] * unit[(patches.axis + 2) % 3]
    second = np.where(patches.out, along_u, along_v)
    fourth = np.where(patches.out, along_v, along_u)
    return np.stack([low, low + second, low + along_u + along_v, low + fourth], axis=1)
