"""How far attractors reach in given directions: bounds that are tight where the attractor is thin."""

from collections.abc import Iterable, Mapping

import numpy as np
from jaxtyping import Float

from ifs.certificates.bounds import Box, bounds, extent, sample
from ifs.system import System

_WORDS = 16  # sub-pieces that bound a piece together, about
_RANK = 1e-11  # singular values below this are 0

Parts = list[tuple[Box, Float[np.ndarray, "_part_points _points"]]]


def parts(system: System, cells: Iterable[str]) -> Mapping[str, Parts]:
    """For each cell some boxes and matrices: `A @ control` has in its box the extent of one sub-piece.

    The matrices take out what is constant on an attractor. Where an edge depends on three rows of control
    points of a surface but is a curve, its extent across is that of the curve.
    """
    boxes, flat = bounds(system), _flattened(system)
    result: dict[str, Parts] = {}
    for cell in cells:
        words = [(cell, np.eye(system.states[cell].points))]
        while len(words) < _WORDS:
            words = [
                (target, product @ operator)
                for state, product in words
                for target, operator in zip(
                    system.states[state].targets, system.states[state].operators, strict=True
                )
            ]
        result[cell] = [(boxes[target], flat[target] @ product.T) for target, product in words]
    return result


def reach(
    parts: Parts, control: Float[np.ndarray, "pieces points dim"]
) -> tuple[Float[np.ndarray, "pieces dim"], Float[np.ndarray, "pieces dim"]]:
    """The bounding boxes (lo, hi) of pieces of one cell, from its parts."""
    found = [extent(box, np.matmul(matrix, control)) for box, matrix in parts]
    return np.min([lo for lo, _ in found], axis=0), np.max([hi for _, hi in found], axis=0)


def _flattened(system: System) -> dict[str, Float[np.ndarray, "_points _points"]]:
    """For each cell R with `p . R P = p . P` for all points p of the attractor, R P constant where it may be.

    With c a point of the attractor and Q an orthonormal basis of the differences p - c:
    `R = 1 c' + (1 - 1 c') Q Q' (1 - 1 c')`, the first 1 in a product with c' being the column of ones.
    """
    centres = sample(system)
    bases = {cell: np.zeros((state.points, 0)) for cell, state in system.states.items()}
    while True:
        sizes = {cell: basis.shape[1] for cell, basis in bases.items()}
        for cell, state in system.states.items():
            moved = [bases[cell]]
            for target, operator in zip(state.targets, state.operators, strict=True):
                moved += [operator @ bases[target], (operator @ centres[target] - centres[cell])[:, None]]
            left, values, _ = np.linalg.svd(np.concatenate(moved, axis=1), full_matrices=False)
            bases[cell] = left[:, values > _RANK]
        if sizes == {cell: basis.shape[1] for cell, basis in bases.items()}:
            break
    result = {}
    for cell, basis in bases.items():
        constant = np.tile(centres[cell], (len(basis), 1))
        away = np.eye(len(basis)) - constant
        result[cell] = constant + away @ basis @ basis.T @ away
    return result
