"""How a ring shrinks: the slowest directions that control points show, and the next ones."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from fld.spectrum import Dominant, dominant
from fld.surfaces.rings import Ring

_SAMPLES = 40

Control = Float[np.ndarray, "_drawn _dim"]


@dataclass(frozen=True)
class Mode:
    """The slowest part of the differences `p - c` of a ring: `rows (p - c)` times `vectors`.

    k is the number of its directions (the dominant eigenvalues with their largest Jordan blocks, each block
    counted once). `vectors` `(k, dim)` is what they draw, in units of `exp(scale)` mm, `rows` `(k, points)`
    the linear functions that give the components, and `matrix` what M does to the components.
    """

    spectrum: Dominant
    vectors: Float[np.ndarray, "k dim"]
    rows: Float[np.ndarray, "k points"]
    matrix: Float[np.ndarray, "k k"]
    scale: float

    @property
    def spanning(self) -> int:
        """How many of the drawn vectors are independent."""
        sizes = np.linalg.svd(self.vectors, compute_uv=False)
        return int((sizes > 1e-9 * sizes.max(initial=0.0)).sum())


def slowest(ring: Ring, control: Control, size: float | None = None) -> Mode | None:
    """The slowest mode of a ring that some control points show; None where they show no movement at all.

    `size` is that of the control points, in mm, where they are what is left of larger ones.
    """
    directions, scale = ring.directions(control, size)
    spectrum = dominant(directions.linear[0])
    if not spectrum.values:
        return None
    total = np.real(np.sum(spectrum.leading, axis=0))
    left, sizes, right = np.linalg.svd(total)
    k = sum(spectrum.ranks)
    columns = left[:, :k]
    return Mode(
        spectrum,
        columns.T @ directions.control,
        sizes[:k, None] * right[:k] @ directions.basis,
        columns.T @ directions.linear[0] @ columns,
        scale,
    )


def following(ring: Ring, control: Control, mode: Mode) -> Mode | None:
    """The slowest mode of what is left when one direction, that of a mode with k = 1, is looked along.

    The control points are projected along that direction, so that it is seen as a point. What is then slowest
    tells how the surface leaves the line of that direction; None where it stays on it.
    """
    along = mode.vectors[0] / np.linalg.norm(mode.vectors[0])
    centred = control - control.mean(axis=0)
    return slowest(ring, centred - np.outer(centred @ along, along), float(np.linalg.norm(centred, 2)))


def ways(ring: Ring, mode: Mode) -> Float[np.ndarray, "ways dim"] | None:
    """Where points of the ring go, as unit vectors, when all keep their directions; None when they do not.

    That is when there is one dominant eigenvalue, real and positive. The points are some 50 of the ring;
    those without a component in the mode are left out.
    """
    if len(mode.spectrum.values) != 1 or mode.spectrum.values[0].real <= 0:
        return None
    pieces = list(ring.pieces)
    system = ring.ground.system
    while len(pieces) < _SAMPLES:
        pieces = [
            (product @ operator, target)
            for product, cell in pieces
            for operator, target in zip(
                system.states[cell].operators, system.states[cell].targets, strict=True
            )
        ]
    points = np.array([product @ ring.ground.points[cell] for product, cell in pieces])
    parts = (points - ring.point) @ mode.rows.T
    sizes = np.linalg.norm(parts, axis=1)
    moved = parts[sizes > 1e-9 * sizes.max(initial=0.0)] @ mode.vectors
    return moved / np.linalg.norm(moved, axis=1, keepdims=True)


def apart(found: Float[np.ndarray, "ways dim"]) -> tuple[int, int, float]:
    """The two unit vectors that are farthest apart, and their angle in degrees."""
    gaps = np.linalg.norm(found[:, None] - found[None, :], axis=2)
    i, j = np.unravel_index(gaps.argmax(), gaps.shape)
    return int(i), int(j), float(2 * np.degrees(np.arcsin(min(1.0, gaps[i, j] / 2))))
