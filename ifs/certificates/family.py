"""Many members of a family at once: the operators of one cell as affine functions of two parameters."""

from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import product
from os import PathLike

import numpy as np
from jaxtyping import Float

import automata
import subdivision
from automata import Automaton
from automata.parameters import parameter_names
from ifs.shape import Shape, shape

Members = Float[np.ndarray, "members labels points points"]

_DIGITS = 1e-12


class NotAffine(ValueError):
    """The operators of a family are no affine functions of the two parameters that were asked for."""

    def __init__(self, names: tuple[str, str], off: float):
        self.names = names
        self.off = off
        super().__init__(
            f"the operators do not depend on {names[0]} and {names[1]} in an affine way (off by {off:.3g} at "
            f"{names[0]} = {names[1]} = 1). Ask for two free parameters that `bcifs solve` lists."
        )


@dataclass(frozen=True)
class Family:
    """The members of a family over the plane of two parameters, everything else held.

    `T_i(x, y) = origin[i] + x along[0, i] + y along[1, i]`, i counting the labels of the shape's cell, all of
    whose sub-cells are that cell again. `here` is the place of the member that the description itself sets,
    if it sets one; `shape` is the member at (0, 0), with its gluing and control points (mm).
    """

    names: tuple[str, str]
    shape: Shape
    origin: Float[np.ndarray, "labels points points"]
    along: Float[np.ndarray, "2 labels points points"]
    here: tuple[float, float] | None

    def members(self, places: Float[np.ndarray, "members 2"]) -> Members:
        """The operators at many places of the parameter plane.

        >>> family("corner-cutting", "a", "b").members(np.array([[0.25, 0.5]]))[0, 0, 0].tolist()
        [0.75, 0.5, 0.0]
        """
        moved = np.einsum("mp,plij->mlij", places, self.along)
        return self.origin + moved


def family(source: Automaton | str | PathLike[str], x: str, y: str) -> Family:
    """The members of an automaton's family in which two parameters, or entries, x and y vary.

    The other parameters keep the values of the description. Raises `subdivision.WrongValue` for x and y
    that are unknown or cannot be chosen independently, `subdivision.Undetermined` when others have no
    value, `NotAffine`, and `ValueError` for a shape whose sub-cells are other cells.

    >>> [round(value, 9) for value in family("corner-cutting", "a", "b").here]
    [0.25, 0.25]
    """
    automaton = source if isinstance(source, Automaton) else automata.read(source)
    automaton = with_control(automaton)
    _require_plane(automaton, x, y)
    state = shape(automaton, {x: Fraction(0), y: Fraction(0)})
    cell = state.system.states[state.system.shape]
    if any(target != cell.name for target in cell.targets):
        others = ", ".join(sorted(set(cell.targets) - {cell.name}))
        raise ValueError(
            f"cell {cell.name!r} has sub-cells that are other cells ({others}); a family over two "
            f"parameters needs a cell that is cut into copies of itself"
        )
    corners = ((0, 0), (1, 0), (0, 1), (1, 1))
    origin, first, second, both = (
        _operators(automaton, {x: Fraction(p), y: Fraction(q)}) for p, q in corners
    )
    off = float(np.abs(both - first - second + origin).max())
    if off > _DIGITS:
        raise NotAffine((x, y), off)
    along = np.stack([first - origin, second - origin])
    return Family((x, y), state, origin, along, _own(automaton, origin, along))


def with_control(automaton: Automaton) -> Automaton:
    """The automaton itself, or with control points on an arch (a row each, mm) where it has none."""
    if automaton.control is not None:
        return automaton
    count = automaton.cells[automaton.shape].points
    places = ((k / max(count - 1, 1)) for k in range(count))
    return replace(automaton, control=tuple((60 * t, 240 * t * (1 - t)) for t in places))


def _require_plane(automaton: Automaton, x: str, y: str) -> None:
    """Raises `subdivision.WrongValue` unless every value of x goes with every value of y."""
    if x == y:
        raise subdivision.WrongValue(f"{x} twice makes no plane; ask for two parameters that differ")
    if {x, y} & set(parameter_names(automaton)):
        return  # the family is solved again for each of their values, some of which divide by zero
    solution = subdivision.solve(automaton)
    for corner in product((Fraction(0), Fraction(1)), repeat=2):
        values = dict(zip((x, y), corner, strict=True))
        for key, value in values.items():
            solution.with_values({key: value})
        try:
            solution.with_values(values)
        except subdivision.WrongValue as error:
            raise subdivision.WrongValue(f"{x} and {y} cannot be chosen independently: {error}") from None


def _operators(
    automaton: Automaton, values: dict[str, Fraction]
) -> Float[np.ndarray, "labels points points"]:
    member = shape(automaton, values).system
    return np.stack(member.states[member.shape].operators)


def _own(automaton: Automaton, origin: np.ndarray, along: np.ndarray) -> tuple[float, float] | None:
    """Where the member that the description itself sets lies in the plane; None where it sets none."""
    try:
        own = _operators(automaton, {})
    except subdivision.Undetermined:
        return None
    rows = along.reshape(2, -1).T
    place = np.linalg.lstsq(rows, (own - origin).ravel(), rcond=None)[0]
    off = np.abs(rows @ place - (own - origin).ravel()).max()
    return (float(place[0]), float(place[1])) if off <= 1e-9 else None
