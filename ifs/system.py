"""A controlled iterated function system: the numbers that the engine iterates."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

Operator = Float[np.ndarray, "_points _target_points"]


@dataclass(frozen=True)
class State:
    """One cell of the automaton with its subdivision operators as numbers.

    `operators[i]` is `(points, points of targets[i])`; it maps the barycentric space of the sub-cell
    into that of this cell, acts on columns from the left, and each of its columns sums to 1.
    """

    name: str
    points: int
    labels: tuple[str, ...]
    targets: tuple[str, ...]
    operators: tuple[Operator, ...]


@dataclass(frozen=True, eq=False)
class System:
    """The states by name, and the one whose attractor is the shape. Two systems are never equal."""

    shape: str
    states: Mapping[str, State]
