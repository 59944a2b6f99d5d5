"""A shape: an automaton with its operators as numbers and its control points."""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from os import PathLike

import numpy as np
from jaxtyping import Float, Real

import automata
import subdivision
from automata import Automaton
from automata.topology import Topology
from ifs.system import State, System


@dataclass(frozen=True)
class Shape:
    """What the engine evaluates: the gluing, the operators, and where it lies in modelling space.

    `control` is `(points, dim)` in millimetres.
    """

    name: str
    topology: Topology
    system: System
    control: Float[np.ndarray, "points dim"]

    @property
    def automaton(self) -> Automaton:
        return self.topology.automaton

    def scaled(self, factor: float) -> "Shape":
        """The same shape, its control points multiplied by a factor."""
        return Shape(self.name, self.topology, self.system, self.control * factor)


def shape(
    source: Automaton | str | PathLike[str],
    values: Mapping[str, Fraction | int | float | str] | None = None,
    control: Real[np.ndarray, "points dim"] | None = None,
) -> Shape:
    """The shape of an automaton, a file or a built-in name, ready to be evaluated.

    `values` set parameters or entries over those of the description, which hold where they still
    are a choice; `control` replaces its control points. Raises `automata.AutomatonError` for a wrong
    description, `subdivision.Contradiction`, `subdivision.Undetermined` when parameters are left without
    a value, `ValueError` for control points of the wrong number or not finite, and
    `TypeError` for another source.

    >>> shape("corner-cutting").control.shape
    (3, 2)
    """
    if not isinstance(source, Automaton | str | PathLike):
        raise TypeError(
            f"a shape is made from an automaton, a file or a built-in name such as 'koch-curve'; "
            f"found {source!r} ({type(source).__name__})"
        )
    automaton = source if isinstance(source, Automaton) else automata.read(source)
    automaton = subdivision.overridden(automaton, values or {})
    solution = subdivision.solve(automaton)
    points = _control(automaton, control)
    return Shape(automaton.name, Topology(automaton), system(automaton, solution.numbers()), points)


def system(automaton: Automaton, numbers: Mapping[str, Mapping[str, subdivision.Exact]]) -> System:
    """The operators of all cells, in double precision."""
    states = {}
    for name, cell in automaton.cells.items():
        operators = tuple(np.array(numbers[name][label], dtype=float) for label in cell.subdivision)
        states[name] = State(
            name, cell.points, tuple(cell.subdivision), tuple(cell.subdivision.values()), operators
        )
    return System(automaton.shape, states)


def _control(automaton: Automaton, given: np.ndarray | None) -> np.ndarray:
    count = automaton.cells[automaton.shape].points
    if given is None:
        if automaton.control is None:
            raise automata.AutomatonError(
                f"{automaton.name!r} has no control points: add [control] points = [[x, y], …], {count} rows"
            )
        given = np.array(automaton.control)
    given = np.array(given, dtype=float)
    if given.ndim != 2 or len(given) != count:
        raise ValueError(f"expected {count} control points as rows, found an array {given.shape}")
    if not np.isfinite(given).all():
        row = int(np.argwhere(~np.isfinite(given))[0][0])
        raise ValueError(f"control point {row} is not finite: {given[row]}")
    given.setflags(write=False)
    return given
