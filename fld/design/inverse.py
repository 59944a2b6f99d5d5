"""Inverse use: coefficients of a family for which a curve behaves as asked."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from numbers import Real
from os import PathLike
from typing import Any

import numpy as np
from jaxtyping import Float
from jaxtyping import Real as Real_

import automata
import ifs
import subdivision
from automata import Automaton
from fld.address import Address, parse_address, twin
from fld.behaviour import behaviour
from fld.curve import Curve, curve
from fld.design.wishes import CriticalOrder, Leaves
from fld.error import Collapsed
from fld.order import critical_order
from ifs import NotContracting, Shape
from ifs.asked import require_whole, shown
from ifs.certificates.convergence import convergence
from subdivision import Solution
from subdivision.choose import Choice, choose
from subdivision.requests import Contracts, Nearest, Request

_TIGHT = 1e-9

Source = Solution | Automaton | str | PathLike[str]
Direction = Sequence[Real | float] | Real_[np.ndarray, "_dim"]
Values = Mapping[str, Fraction | int | float | str]


@dataclass(frozen=True)
class Asked:
    """One wish: what was wanted, what the member found has, and how far that is off.

    Orders are numbers, directions unit vectors; `found` is None where the member has none. The residual is
    the absolute difference, the length of that of directions, infinite without one.
    """

    text: str
    wanted: float | Float[np.ndarray, "dim"]
    found: float | Float[np.ndarray, "dim"] | None
    residual: float

    @property
    def met(self) -> bool:
        return self.residual <= _TIGHT


@dataclass(frozen=True)
class Fit:
    """A member of a family, its shape, and how far it behaves as asked.

    `choice.exact` holds the values of the parameters; `asked` is worked out anew from the shape, by
    `fld.critical_order` and `fld.behaviour`. `convergence` is the verdict of `ifs.convergence`.
    """

    choice: Choice
    shape: Shape
    asked: tuple[Asked, ...]
    convergence: str

    @property
    def values(self) -> Mapping[str, Fraction]:
        """The exact value of every parameter that was free."""
        return self.choice.exact

    @property
    def ok(self) -> bool:
        """Whether all is met to 1e-9, for a system that contracts."""
        return self.convergence == "contracts" and all(asked.met for asked in self.asked)


class OutOfReach(ValueError):
    """No member was found that behaves as asked; `nearest` is the best one found, with its residuals."""

    def __init__(self, nearest: Fit):
        self.nearest = nearest
        missed = [f"{a.text}: {_found(a)}" for a in nearest.asked if not a.met]
        if nearest.convergence != "contracts":
            missed.append(f"convergence: {nearest.convergence}")
        values = ", ".join(f"{name} = {float(value):.6g}" for name, value in nearest.values.items())
        super().__init__(
            f"no member of the family was found that behaves as asked. The nearest one, {values or 'alone'}, "
            f"misses: {'; '.join(missed)}. Ask for less, leave more coefficients free, or try more starts"
        )


def fit_behaviour(
    source: Source,
    *,
    order: float | None = None,
    left: Direction | None = None,
    right: Direction | None = None,
    at: str | None = None,
    fixed: Values | None = None,
    seed: int = 0,
    starts: int = 16,
    report: Callable[[float], None] = lambda done: None,
) -> Fit:
    """The member of a family whose curve has a critical order, and half-tangents in given directions.

    `source` is a family (`subdivision.solve`), or an automaton, file or built-in name, whose whole family is
    then searched but for the values in `fixed`; the member nearest to the description's own values
    is taken. `left` and `right` are directions into the curve (of any length) at the address `at`: they are
    opposite where it is to pass smoothly. The control points are those of the description, in mm.

    The search is that of `subdivision.choose` (Gauss-Newton, then scipy's Levenberg-Marquardt, from
    `starts` points drawn with `seed`) for the requests `CriticalOrder` and `Leaves`. `report` is told which
    share of it is done at most; what it raises ends it. What is found is judged anew from the shape. A search
    proves nothing by failing; it is poor where two eigenvalues have one modulus, where the order has a kink.

    Raises `OutOfReach` with the nearest member, `ValueError` for wishes that make no sense (named), and
    `fld.NotACurve`. Source: Gentil 2010, theorem 4.2.1, equations 4.4 to 4.8; the inverse use is our own.

    >>> found = fit_behaviour("corner-cutting", order=1.0, at="0", right=(30, 60))
    >>> {name: str(value) for name, value in found.values.items()}
    {'a': '1/4', 'b': '1/4'}
    """
    require_whole("number of starts", starts, 1)
    require_whole("seed", seed)
    solution, own, nearest = _opened(source, fixed or {})
    wishes = _wishes(own, order, left, right, at)
    requests: list[Request | Nearest] = [*wishes, Contracts(longest=1)]
    if nearest:
        requests.append(Nearest(nearest))
    choice = choose(solution, requests, seed=seed, starts=starts, report=report)
    found = _judged(solution, choice, wishes, at)
    if not found.ok:
        raise OutOfReach(found)
    return found


def _opened(source: Source, fixed: Values) -> tuple[Solution, Curve, dict[str, Fraction]]:
    """The family, a curve of it that tells labels and control points, and the values to keep near to."""
    if isinstance(source, Solution):
        solution, automaton = source, source.automaton
    else:
        if not isinstance(source, Automaton | str | PathLike):
            raise TypeError(
                f"a family is that of `subdivision.solve`, an automaton, a file or a built-in name; "
                f"found {shown(source)}"
            )
        automaton = source if isinstance(source, Automaton) else automata.read(source)
        solution = subdivision.solve(automaton)
    solution = solution.with_values(fixed)
    near = {key: value for key, value in automaton.values.items() if isinstance(value, Fraction)}
    some = _shape(solution, dict.fromkeys((p.name for p in solution.free), Fraction(0)))
    return solution, curve(some), near


def _shape(solution: Solution, values: Mapping[str, Fraction]) -> Shape:
    return ifs.shape(replace(solution.automaton, values={**solution.chosen, **values}))


def _wishes(
    own: Curve,
    order: float | None,
    left: Direction | None,
    right: Direction | None,
    at: str | None,
) -> list[CriticalOrder | Leaves]:
    found: list[CriticalOrder | Leaves] = []
    if order is not None:
        if not (isinstance(order, Real) and math.isfinite(order) and order > 0):
            raise ValueError(f"the critical order must be above 0 and finite; found {order}")
        found.append(CriticalOrder(own.cell, own.labels, float(order)))
    directions = {"left": left, "right": right}
    if at is None and any(direction is not None for direction in directions.values()):
        raise ValueError("half-tangents need a point: give its address, as in at='1 0'")
    for side, direction in directions.items():
        if direction is not None:
            assert at is not None
            found.append(_leaves(own, parse_address(at, own), side, direction))
    if not found:
        raise ValueError("nothing is asked: give an order, or left or right directions at an address")
    return found


def _leaves(own: Curve, where: Address, side: str, direction: Direction) -> Leaves:
    vector = np.array([float(x) for x in direction])
    if vector.shape != own.control.shape[1:] or not np.isfinite(vector).all() or not vector.any():
        raise ValueError(
            f"the {side} direction {tuple(direction)}: expected {own.control.shape[1]} finite coordinates, "
            f"not all of them 0"
        )
    last = own.labels[-1] if side == "right" else own.labels[0]
    here = next(
        (a for a in (where, twin(where, own)) if a is not None and any(k != last for k in a.repeat)), None
    )
    if here is None:
        ends = "ends" if side == "right" else "starts"
        raise ValueError(f"the curve has no {side} side at {where}: it {ends} there")
    unit = vector / np.linalg.norm(vector)
    control = tuple(tuple(row) for row in own.control.tolist())
    return Leaves(own.cell, here.word, here.repeat, last, tuple(unit.tolist()), control, side)


def _judged(solution: Solution, choice: Choice, wishes: list[CriticalOrder | Leaves], at: str | None) -> Fit:
    shape = _shape(solution, choice.exact)
    verdict = convergence(shape.system).verdict
    asked = []
    for wish in wishes:
        if isinstance(wish, CriticalOrder):
            asked.append(_asked_order(shape, wish))
        else:
            asked.append(_asked_direction(shape, wish, at or ""))
    return Fit(choice, shape, tuple(asked), verdict)


def _asked_order(shape: Shape, wish: CriticalOrder) -> Asked:
    try:
        found = critical_order(shape)
    except (Collapsed, NotContracting):
        return Asked(wish.text, wish.order, None, math.inf)
    return Asked(wish.text, wish.order, found, abs(found - wish.order))


def _asked_direction(shape: Shape, wish: Leaves, at: str) -> Asked:
    wanted = np.array(wish.direction)
    found: Any = None
    try:
        seen = behaviour(shape, at)
    except (Collapsed, NotContracting):
        seen = None
    side = None if seen is None else seen.left if wish.side == "left" else seen.right
    if side is not None and side.status == "half-tangent":
        found = side.direction
    residual = math.inf if found is None else float(np.linalg.norm(found - wanted))
    return Asked(wish.text, wanted, found, residual)


def _found(asked: Asked) -> str:
    if asked.found is None:
        return "the nearest member has none"
    if not isinstance(asked.found, np.ndarray):
        return f"found {asked.found:.9g}, off by {asked.residual:.3g}"
    vector = ", ".join(f"{x:.6g}" for x in asked.found)
    return f"found ({vector}), off by {asked.residual:.3g}"
