"""What attractors span: points of each attractor, as few as say all about its affine hull."""

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from ifs.certificates.bounds import sample
from ifs.system import System

_RANK = 1e-9  # relative: points nearer than this to a flat lie in it

Columns = Float[np.ndarray, "_points _count"]


def spanning_points(system: System) -> Mapping[str, Columns]:
    """For each cell, points of its attractor whose affine hull is that of the attractor, as columns.

    The first is `ifs.sample`'s; a point is added while some `T_i p` lies outside the hull of those found.
    A cell whose attractor is one point has one column. Raises as `sample` does.

    >>> from ifs.shape import shape
    >>> spanning_points(shape("koch-curve").system)["edge"].shape
    (3, 3)
    """
    found = {cell: column[:, None] for cell, column in sample(system).items()}
    grows = True
    while grows:
        grows = False
        for cell, state in system.states.items():
            moved = [
                operator @ found[target]
                for operator, target in zip(state.operators, state.targets, strict=True)
            ]
            larger = _extended(found[cell], np.concatenate(moved, axis=1))
            grows |= larger.shape[1] > found[cell].shape[1]
            found[cell] = larger
    return found


def configurations(
    system: System, control: Float[np.ndarray, "points dim"]
) -> Mapping[str, Float[np.ndarray, "_points _dim"]]:
    """The control points of the first piece of each cell that the shape meets, the shape itself first.

    `T_i^T P` are those of piece i of a piece with control points P. Cells that no piece is are left out.

    >>> from ifs.shape import shape
    >>> koch = shape("koch-curve")
    >>> configurations(koch.system, koch.control)["edge"][2].tolist()
    [90.0, 0.0]
    """
    found = {system.shape: np.asarray(control, dtype=float)}
    waiting = [system.shape]
    for cell in waiting:
        state = system.states[cell]
        for operator, target in zip(state.operators, state.targets, strict=True):
            if target not in found:
                found[target] = operator.T @ found[cell]
                waiting.append(target)
    return found


def _extended(own: Columns, others: Columns) -> Columns:
    """The columns, and those of the others that are farthest from the hull found so far, one at a time."""
    scale = max(1.0, float(np.abs(others).max(initial=0.0)))
    while True:
        directions = own[:, 1:] - own[:, :1]
        away = others - own[:, :1]
        basis = np.linalg.qr(directions)[0]
        for _ in range(2):
            away = away - basis @ (basis.T @ away)
        sizes = np.linalg.norm(away, axis=0)
        best = int(sizes.argmax()) if len(sizes) else 0
        if not len(sizes) or sizes[best] <= _RANK * scale or own.shape[1] == len(own):
            return own
        own = np.column_stack([own, others[:, best]])
