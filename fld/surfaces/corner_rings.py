"""The ring of a corner of a cell."""

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from automata.topology import Topology
from fld.surfaces.rings import Ground, Ring
from ifs.drawing import vertex_column
from ifs.tangency.frames import Frame


def corner_ring(
    topology: Topology, ground: Ground, frames: Mapping[str, Frame], cell: str, number: int
) -> Ring:
    """The ring of a corner of a cell: one end of a curve, or the corner of a triangle or quadrangle.

    The sub-pieces that keep the corner become the same cells over and over; `ratio` and `reach` are those of
    the uniform parameters that `ifs.at` has.
    """
    trail: list[tuple[str, int]] = []
    here = (cell, number)
    while here not in trail:
        trail.append(here)
        part, corner = frames[here[0]].kept[here[1]]
        here = (frames[here[0]].parts[part].cell, corner)
    start = trail.index(here)
    system = ground.system
    lead = tuple(system.states[x].operators[frames[x].kept[k][0]] for x, k in trail[:start])
    state, last = here
    cycle, pieces, axes = np.eye(system.states[state].points), [], np.eye(frames[state].reference.shape[1])
    for x, k in trail[start:]:
        kept = frames[x].kept[k][0]
        for i, (operator, target) in enumerate(
            zip(system.states[x].operators, system.states[x].targets, strict=True)
        ):
            if i != kept:
                pieces.append((cycle @ operator, target))
        cycle, axes = cycle @ system.states[x].operators[kept], axes @ frames[x].parts[kept].axes
    before = [frames[x].parts[frames[x].kept[k][0]].axes for x, k in trail[:start]]
    reach = float(np.prod([abs(np.linalg.det(a)) ** (1 / len(a)) for a in before]))
    corners = frames[state].corners
    columns = [
        vertex_column(topology, ground.points, state, corners[(last + k) % len(corners)])
        for k in range(len(corners))
    ]
    return Ring(
        ground,
        state,
        lead,
        cycle,
        tuple(pieces),
        columns[0],
        columns[1],
        reach,
        _ratio(axes),
        tuple(columns[1:]),
    )


def _ratio(axes: Float[np.ndarray, "n n"]) -> float:
    """By how much the powers of a linear map shrink lengths; NaN where they shrink them unequally."""
    values = np.abs(np.linalg.eigvals(axes))
    return float(values.mean()) if np.ptp(values) <= 1e-9 * values[0] else float("nan")
