"""Curves for the edges of fitted patches: exact where they can be, else the closest cubics."""

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from export.step.polynomial import Limits, Row, bernstein, elevation

LEVEL = 4  # fits are made on grids of 2^4 + 1 limit points in each direction


def edge_curves(limits: Limits, exact: Mapping[str, Row], degree: int) -> dict[str, Row]:
    """The Bernstein control points `(points, degree + 1)` of every edge.

    A polynomial edge is kept. Any other one gets a curve with the same ends, and with the same derivative at
    an end whose half is polynomial; what is left is the closest in the mean.

    >>> import ifs
    >>> patch = ifs.shape("doo-sabin-patch")
    >>> edge_curves(Limits(patch.topology, patch.system), {}, 3)["edge"].shape
    (6, 4)
    """
    result = {}
    for cell in limits.segments:
        if cell in exact:
            result[cell] = exact[cell] @ elevation(exact[cell].shape[1] - 1, degree).T
        else:
            result[cell] = _closest(limits, cell, exact, degree)
    return result


def _closest(limits: Limits, cell: str, exact: Mapping[str, Row], degree: int) -> Row:
    row = limits.row(cell, LEVEL)
    basis = bernstein(degree, np.linspace(0, 1, row.shape[1]))
    poles = np.zeros((len(row), degree + 1))
    poles[:, 0], poles[:, -1] = row[:, 0], row[:, -1]
    free = np.ones(degree + 1, dtype=bool)
    free[[0, -1]] = False
    for end, pole, place in ((0, 0, 1), (1, degree, degree - 1)):
        slope = _slope(limits, cell, end, exact)
        if slope is not None:
            poles[:, place] = poles[:, pole] + slope / degree
            free[place] = False
    rest = row - poles @ basis.T
    poles[:, free] = np.linalg.lstsq(basis[:, free], rest.T, rcond=None)[0].T
    return poles


def _slope(
    limits: Limits, cell: str, end: int, exact: Mapping[str, Row]
) -> Float[np.ndarray, "_points"] | None:
    """The derivative from an end inwards, where the half at that end is polynomial."""
    state = limits.system.states[cell]
    label, forward = limits.segments[cell].halves[end]
    child = state.labels.index(label)
    if state.targets[child] not in exact:
        return None
    poles = state.operators[child] @ exact[state.targets[child]]
    starts_here = forward == (end == 0)
    step = poles[:, 1] - poles[:, 0] if starts_here else poles[:, -2] - poles[:, -1]
    return 2 * (poles.shape[1] - 1) * step
