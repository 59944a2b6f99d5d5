"""When a piece is flat enough to be drawn as it is, with certainty."""

from collections.abc import Callable, Mapping

import numpy as np
from jaxtyping import Bool, Float

from automata.topology import Topology, embedding
from ifs.certificates.bounds import sample
from ifs.certificates.reach import Parts, parts, reach
from ifs.drawing import vertex_column
from ifs.system import System
from ifs.tangency.frames import Frame, frames

Control = Float[np.ndarray, "pieces points dim"]
Rim = Bool[np.ndarray, "pieces sides"]
Flags = Bool[np.ndarray, "pieces"]

Stop = Callable[[str, Control, Rim], Flags]
"""Which pieces of a cell are drawn as they are, from their control points and which sides lie on a rim."""


def within(topology: Topology, system: System, cells: tuple[str, ...], tolerance: float) -> Stop:
    """Pieces that lie within a tolerance, in mm, of their polygon.

    A face lies with its corners between two parallel planes at most `tolerance` apart, square to the cross
    product of its diagonals; its sides on a rim (those of no other face) stay that near to their chords. A
    curve stays that near to its chord. The bounds are those of `ifs.bounds`: nothing between the points
    looked at is missed.

    Raises `ValueError` for a tolerance that is not above 0, `NotContracting` or `Undecided` where there is
    no bound.

    >>> from ifs.shape import shape
    >>> patch = shape("catmull-clark-patch")
    >>> stop = within(patch.topology, patch.system, ("face",), 1000.0)
    >>> stop("face", patch.control[None], np.zeros((1, 4), dtype=bool))
    array([ True])
    """
    if not (np.isfinite(tolerance) and tolerance > 0):
        raise ValueError(f"the tolerance is a length above 0 mm, found {tolerance}")
    found, points = frames(topology, cells), sample(system)
    known = parts(system, found)
    limits = {
        cell: np.stack([vertex_column(topology, points, cell, path) for path in frame.corners])
        for cell, frame in found.items()
    }

    def stop(cell: str, control: Control, rim: Rim) -> Flags:
        corners = np.einsum("kp,npd->nkd", limits[cell], control)
        if len(found[cell].corners) == 2:
            return _near_chord(known[cell], control, corners, tolerance)
        flat = _in_slab(known[cell], control, corners, tolerance)
        for k in range(rim.shape[1]):
            chosen = np.flatnonzero(flat & rim[:, k])
            if len(chosen):
                near = _side_is_near(
                    topology, found, known, cell, k, control[chosen], corners[chosen], tolerance
                )
                flat[chosen] = near
        return flat

    return stop


def _in_slab(
    parts: Parts, control: Control, corners: Float[np.ndarray, "pieces corners dim"], tolerance: float
) -> Flags:
    """Whether the extent square to the polygon is at most the tolerance, or the whole extent is."""
    lo, hi = reach(parts, control)
    small = np.linalg.norm(hi - lo, axis=1) <= tolerance
    if control.shape[2] < 3:
        return np.ones(len(control), dtype=bool)
    first, second = corners[:, 2] - corners[:, 0], corners[:, -1] - corners[:, 1]
    normal = np.cross(first, second)
    length = np.linalg.norm(normal, axis=1)
    some = length > 0
    normal[some] /= length[some, None]
    lo, hi = reach(parts, np.einsum("npd,nd->np", control, normal)[:, :, None])
    return small | (some & (hi[:, 0] - lo[:, 0] <= tolerance))


def _near_chord(
    parts: Parts, control: Control, corners: Float[np.ndarray, "pieces 2 dim"], tolerance: float
) -> Flags:
    """Whether a curve stays inside a tube around its chord; beyond the ends, inside a box around them."""
    chord = corners[:, 1] - corners[:, 0]
    length = np.linalg.norm(chord, axis=1)
    way = np.where(length[:, None] > 0, chord / np.where(length > 0, length, 1.0)[:, None], 0.0)
    moved = control - corners[:, :1]
    along = np.einsum("npd,nd->np", moved, way)
    lo, hi = reach(parts, moved - along[:, :, None] * way[:, None, :])
    aside = np.linalg.norm(np.maximum(np.abs(lo), np.abs(hi)), axis=1)
    low, high = reach(parts, along[:, :, None])
    beyond = np.maximum(np.maximum(-low[:, 0], high[:, 0] - length), 0.0)
    return np.hypot(aside, beyond) <= tolerance


def _side_is_near(
    topology: Topology,
    found: Mapping[str, Frame],
    known: Mapping[str, Parts],
    cell: str,
    k: int,
    control: Control,
    corners: Float[np.ndarray, "pieces corners dim"],
    tolerance: float,
) -> Flags:
    side = found[cell].sides[k]
    matrix = np.zeros((control.shape[1], topology.automaton.cells[side.cell].points))
    for column, entries in enumerate(embedding(topology.automaton, cell, (side.label,))):
        for row, value in entries:
            matrix[row, column] = float(value)
    ends = corners[:, [k, (k + 1) % corners.shape[1]]]
    return _near_chord(known[side.cell], np.einsum("pq,npd->nqd", matrix, control), ends, tolerance)
