"""The corner of a cell seen through ever smaller sub-pieces: where its pieces go, and how fast."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from automata.topology import Topology
from ifs.drawing import vertex_column
from ifs.system import System
from ifs.tangency.frames import Frame
from ifs.tangency.modes import Mode, modes

_SAMPLES = 20  # at least so many points of a piece speak for it
_NEAR = 1e-9

Columns = Float[np.ndarray, "_points _samples"]


@dataclass(frozen=True)
class Corner:
    """Points around one corner of a cell, as differences from it in the cell's barycentric space.

    The sub-pieces that keep the corner become, after some steps, the same cells over and over. The samples
    are points of such a sub-piece; `modes` are their parts by how fast they shrink from one round to the
    next. `along[j]` marks the samples on side j: from the corner to the next one, and to the one before.
    A curve has one side.
    """

    modes: tuple[Mode, ...]
    along: Bool[np.ndarray, "sides samples"]
    size: float


def corner(
    topology: Topology,
    system: System,
    found: Mapping[str, Frame],
    points: Mapping[str, Float[np.ndarray, "_points"]],
    cell: str,
    number: int,
) -> Corner:
    """What a corner of a cell looks like from near; `points` are the limits that `ifs.sample` gives."""
    lead, cycle, (state, last) = _rounds(system, found, cell, number)
    reference = found[state].reference
    columns, parameters = _samples(topology, system, found, points, state)
    centre = vertex_column(topology, points, state, found[state].corners[last])
    other = np.abs(parameters - reference[last]).max(axis=1) > _NEAR
    differences = columns[:, other] - centre[:, None]
    parts = [
        Mode(mode.modulus, lead @ mode.parts, mode.straight)
        for mode in modes(cycle, differences)
        if mode.modulus < 1
    ]
    near = [(last + 1) % len(reference), (last - 1) % len(reference)]
    along = [
        _on_segment(reference[last], reference[end], parameters[other]) for end in near[: reference.shape[1]]
    ]
    size = float(np.abs(lead @ differences).max(initial=0.0))
    return Corner(tuple(parts), np.stack(along), size)


def _rounds(
    system: System, found: Mapping[str, Frame], cell: str, number: int
) -> tuple[np.ndarray, np.ndarray, tuple[str, int]]:
    """The operators to the first corner that comes back and from there around, and that corner."""
    trail: list[tuple[str, int]] = []
    operators: list[np.ndarray] = []
    here = (cell, number)
    while here not in trail:
        trail.append(here)
        part, corner_there = found[here[0]].kept[here[1]]
        operators.append(system.states[here[0]].operators[part])
        here = (found[here[0]].parts[part].cell, corner_there)
    start = trail.index(here)
    lead = _product(operators[:start], system.states[cell].points)
    return lead, _product(operators[start:], system.states[here[0]].points), here


def _product(operators: list[np.ndarray], points: int) -> Float[np.ndarray, "_rows _columns"]:
    result = np.eye(points)
    for operator in operators:
        result = result @ operator
    return result


def _samples(
    topology: Topology,
    system: System,
    found: Mapping[str, Frame],
    points: Mapping[str, Float[np.ndarray, "_points"]],
    cell: str,
) -> tuple[Columns, Float[np.ndarray, "_samples directions"]]:
    """Limit points of a cell, barycentric, and their parameters: the corners of its sub-pieces."""
    directions = found[cell].reference.shape[1]
    pieces = [(cell, np.eye(system.states[cell].points), np.zeros(directions), np.eye(directions))]
    levels = 0
    while len(pieces) < _SAMPLES or levels < 2:
        levels += 1
        pieces = [
            (part.cell, product @ operator, origin + axes @ part.origin, axes @ part.axes)
            for state, product, origin, axes in pieces
            for part, operator in zip(found[state].parts, system.states[state].operators, strict=True)
        ]
    columns, parameters, seen = [], [], set()
    for state, product, origin, axes in pieces:
        for path, local in zip(found[state].corners, found[state].reference, strict=True):
            place = origin + axes @ local
            key = tuple(np.round(place, 9))
            if key not in seen:
                seen.add(key)
                columns.append(product @ vertex_column(topology, points, state, path))
                parameters.append(place)
    return np.stack(columns, axis=1), np.stack(parameters)


def _on_segment(
    start: Float[np.ndarray, "directions"],
    end: Float[np.ndarray, "directions"],
    parameters: Float[np.ndarray, "samples directions"],
) -> Bool[np.ndarray, "samples"]:
    along = end - start
    share = (parameters - start) @ along / (along @ along)
    return np.abs(start + share[:, None] * along - parameters).max(axis=1) < _NEAR
