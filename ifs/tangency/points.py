"""The point of a piece at any parameter, by walking the automaton along the digits of the parameter."""

from collections.abc import Mapping

import numpy as np
from jaxtyping import Bool, Float, Int, Real

from ifs.certificates.bounds import sample
from ifs.complex import Complex
from ifs.drawing import vertex_column
from ifs.system import System
from ifs.tangency.frames import Frame, frames

_STEPS = 300  # at most; a parameter in double precision is a vertex after some 60 halvings
_SMALL = 1e-15  # control points that differ by less, relative to their coordinates, are one
_OUTSIDE = 1e-9  # a parameter farther than this from every sub-piece lies in a hole

Walkers = dict[str, tuple[Int[np.ndarray, "_walkers"], np.ndarray, np.ndarray]]
"""By cell: which parameters walk there, the control points of their pieces, the rest of the parameters."""


def at(
    complex_: Complex, cell: str, pieces: Int[np.ndarray, "n"], parameters: Real[np.ndarray, "n directions"]
) -> Float[np.ndarray, "n dim"]:
    """The points, in mm, of pieces of one cell at parameters: `(n, 1)` for curves, `(n, 2)` for faces.

    `pieces[i]` is the number of a piece among those of the cell. A quadrangle has its corners, in the order
    in which `draw` lists them, at (0, 0), (1, 0), (1, 1) and (0, 1); a triangle at (0, 0), (1, 0) and (0, 1),
    and u + v <= 1; a curve runs from 0 to 1. The digits of a parameter choose the sub-pieces:
    `phi(t) = lim T_s1 T_s2 ... T_sk p`, as `frames` places them. The result is exact to rounding;
    where no sub-piece lies (a hole of a fractal) it is NaN.

    Raises `NotParametrised` for cells that are no curves, triangles or quadrangles, and
    `ValueError` for a piece or a parameter out of range.

    >>> from ifs.complex import initial
    >>> from ifs.shape import shape
    >>> curve = shape("koch-curve")
    >>> whole = initial(curve.topology, curve.system, curve.control)
    >>> at(whole, "edge", np.array([0, 0]), np.array([[0.25], [1.0]])).round(9)
    array([[30.,  0.],
           [90.,  0.]])
    """
    if cell not in complex_.control:
        raise ValueError(f"there are no pieces of cell {cell!r}; there are {', '.join(complex_.control)}")
    found = frames(complex_.topology, [cell])
    control = np.asarray(complex_.control[cell])
    parameters = np.asarray(parameters, dtype=float)
    _validate(found[cell], cell, len(control), pieces, parameters)
    limits = _limits(complex_, found)
    small = _SMALL * float(np.abs(control).max(initial=0.0))
    result = np.full((len(pieces), control.shape[2]), np.nan)
    walking: Walkers = {cell: (np.arange(len(pieces)), control[pieces], parameters)}
    for step in range(_STEPS + 1):
        onward: Walkers = {}
        for state, (numbers, points, rest) in walking.items():
            done = _at_corner(rest) | (_spread(points) <= small) | (step == _STEPS)
            result[numbers[done]] = _between(limits[state], points[done], rest[done])
            onward[state] = (numbers[~done], points[~done], rest[~done])
        walking = _stepped(complex_.system, found, onward)
        if not walking:
            break
    return result


def _validate(
    frame: Frame,
    cell: str,
    count: int,
    pieces: Int[np.ndarray, "n"],
    parameters: Float[np.ndarray, "n directions"],
) -> None:
    directions = frame.reference.shape[1]
    if parameters.shape[1] != directions:
        raise ValueError(f"cell {cell!r} takes {directions} parameters a point, found {parameters.shape[1]}")
    wrong = np.flatnonzero((pieces < 0) | (pieces >= count))
    if len(wrong):
        raise ValueError(f"point {wrong[0]} names piece {pieces[wrong[0]]}; there are {count}, from 0")
    outside = ~(_slack(frame.reference, parameters) >= -_OUTSIDE)
    if outside.any():
        row = int(np.flatnonzero(outside)[0])
        raise ValueError(f"parameter {row} lies outside the piece: {parameters[row]}")


def _slack(
    reference: Float[np.ndarray, "corners directions"], parameters: Float[np.ndarray, "n directions"]
) -> Float[np.ndarray, "n"]:
    """How far inside the interval, square or triangle: negative outside."""
    if len(reference) == 3:
        return np.minimum(parameters.min(axis=1), 1 - parameters.sum(axis=1))
    return np.minimum(parameters, 1 - parameters).min(axis=1)


def _limits(
    complex_: Complex, found: Mapping[str, Frame]
) -> dict[str, Float[np.ndarray, "_corners _points"]]:
    points = sample(complex_.system)
    return {
        cell: np.stack([vertex_column(complex_.topology, points, cell, path) for path in frame.corners])
        for cell, frame in found.items()
    }


def _spread(points: Float[np.ndarray, "n points dim"]) -> Float[np.ndarray, "n"]:
    return np.linalg.norm(points - points[:, :1], axis=2).max(axis=1)


def _at_corner(parameters: Float[np.ndarray, "n directions"]) -> Bool[np.ndarray, "n"]:
    return ((parameters == 0) | (parameters == 1)).all(axis=1)


def _between(
    limits: Float[np.ndarray, "corners points"],
    points: Float[np.ndarray, "n points dim"],
    parameters: Float[np.ndarray, "n directions"],
) -> Float[np.ndarray, "n dim"]:
    """The limit corners, weighted by what is left of the parameters."""
    u, v = parameters[:, 0], parameters[:, -1]
    match len(limits):
        case 2:
            weights = [1 - u, u]
        case 3:
            weights = [1 - u - v, u, v]
        case _:
            weights = [(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v]
    return np.einsum("nc,cp,npd->nd", np.stack(weights, axis=1), limits, points)


def _stepped(system: System, found: Mapping[str, Frame], walking: Walkers) -> Walkers:
    """Every parameter seen from the sub-piece in which it lies; those in holes are dropped."""
    moved: dict[str, list] = {}
    for cell, (numbers, points, rest) in walking.items():
        if not len(numbers):
            continue
        parts = found[cell].parts
        local = [(rest - part.origin) @ np.linalg.inv(part.axes).T for part in parts]
        inside = [_slack(found[part.cell].reference, t) for part, t in zip(parts, local, strict=True)]
        best = np.argmax(inside, axis=0)
        for i, part in enumerate(parts):
            chosen = np.flatnonzero((best == i) & (inside[i] >= -_OUTSIDE))
            if len(chosen):
                control = system.states[cell].operators[i].T @ points[chosen]
                t = np.clip(local[i][chosen], 0.0, 1.0)
                moved.setdefault(part.cell, []).append((numbers[chosen], control, t))
    return {cell: _joined(parts) for cell, parts in moved.items()}


def _joined(parts: list[tuple]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    numbers, control, rest = (np.concatenate(column) for column in zip(*parts, strict=True))
    return numbers, control, rest
