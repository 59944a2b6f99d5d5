"""Directional local fractional derivatives of tensor products."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from fld.surfaces.products import ProductPoint, Section, is_steady
from fld.wording import written

_SAME = 1e-9


@dataclass(frozen=True)
class Directional:
    """The local fractional derivative of a surface at a point, in one direction of its parameters.

    `order` is the order q asked for, `critical` the order at which the difference in this direction vanishes.
    `status` is one of

    - "value": the limit exists for all h; `value` is it, in mm per parameter^q;
    - "log-periodic": the quotient swings for ever; `value` is its limit along the ends of the pieces;
    - "zero", "infinite": of what order the difference is, says `critical`; `direction` is where it goes;
    - a status of a section that has no half-tangent ("oscillates", "spiral", "unoriented", "undecided",
      "several directions"), when q is the critical order;
    - "undecided" also where the mixed term may decide and its limit is not known.

    `value` is None but for the first two, and 0 for "zero".
    """

    status: str
    order: float
    critical: float | None
    value: Float[np.ndarray, "dim"] | None
    direction: Float[np.ndarray, "dim"] | None
    words: str

    def as_data(self) -> dict[str, Any]:
        """The same as plain lists and numbers, ready for JSON."""
        return {
            "status": self.status,
            "order": self.order,
            "critical": self.critical,
            "value": None if self.value is None else [float(x) for x in self.value],
            "direction": None if self.direction is None else [float(x) for x in self.direction],
            "words": self.words,
        }


@dataclass(frozen=True)
class _Term:
    """A part of the difference: like `h^order log(1/h)^(block-1)`, with its limit where it has one."""

    name: str
    order: float
    block: int
    status: str
    vector: Float[np.ndarray, "_dim"] | None
    direction: Float[np.ndarray, "_dim"] | None
    is_steady: bool


def directional(at: ProductPoint, direction: tuple[float, float], order: float | None = None) -> Directional:
    """`Gamma(1 + q) lim (S(u + h v_u, v + h v_v) - S(u, v)) / h^q` for h -> 0, h > 0.

    With a and b the orders of the two curves through the point, on the sides that the signs of the direction
    say, and A and B their limits `difference / h^order`, the difference is

        h^a |v_u|^a A + h^b |v_v|^b B + terms of higher order,

    so that the critical order is the smaller one of a and b (with the other component 0, that of the curve).
    Two corrections to equation (4.9): it takes a = b, whereas the curve of smaller order alone counts
    otherwise; and with D_- as in (4.1), which has a minus sign of its own, a negative component needs
    the factor -1 (for S(u, v) = (u, v) and the direction (-1, 0) the derivative is (-1, 0), D_- is (1, 0)).
    Here A and B point into the surface. The mixed term counts where both curves hide the slowest direction
    of their factors, as at a pole. The order is q = the critical order unless given.

    Raises `ValueError` for the direction (0, 0), numbers that are not finite, an order that is not positive,
    and a direction that leaves the surface.

    >>> from fld.surfaces.products import product, product_point
    >>> patch = product("corner-cutting", "corner-cutting")
    >>> directional(product_point(patch, "1 0", "1 0"), (1.0, -1.0)).status
    'value'
    """
    steps = (float(direction[0]), float(direction[1]))
    if not all(map(math.isfinite, steps)) or not any(steps):
        raise ValueError(f"a direction has two finite components, not both 0; found {steps}")
    if order is not None and not (math.isfinite(order) and order > 0):
        raise ValueError(f"an order is finite and more than 0, found {order}")
    terms = _terms(at, steps)
    if not terms:
        q = 1.0 if order is None else order
        zero = np.zeros(len(at.point))
        return Directional(
            "zero", q, None, zero, None, "nothing moves in this direction: zero at every order"
        )
    critical = min(term.order for term in terms)
    q = critical if order is None else float(order)
    near = [term for term in terms if term.order <= critical + _SAME]
    block = max(term.block for term in near)
    leading = [term for term in near if term.block == block]
    return _result(leading, q, critical, np.zeros(len(at.point)))


def _terms(at: ProductPoint, steps: tuple[float, float]) -> list[_Term]:
    found, sides = [], []
    for name, step, sections in zip("uv", steps, (at.u, at.v), strict=True):
        side = "right" if step > 0 else "left"
        sides.append(side)
        if step == 0:
            continue
        section = sections[side]
        if section is None:
            raise ValueError(f"the surface ends here: it has nothing on the {side} side of {name}")
        term = _of_section(name, abs(step), section)
        found += [term] if term else []
    if all(steps):
        found += _mixed(at, steps, sides, found)
    return found


def _of_section(name: str, step: float, section: Section) -> _Term | None:
    drawn = section.drawn
    if drawn.order is None:
        return None
    vector = None if drawn.vector is None else step**drawn.order * drawn.vector
    oriented = drawn.direction if drawn.status == "half-tangent" else None
    return _Term(
        f"the {name} term", drawn.order, drawn.block, drawn.status, vector, oriented, is_steady(section.swing)
    )


def _mixed(
    at: ProductPoint, steps: tuple[float, float], sides: list[str], others: list[_Term]
) -> list[_Term]:
    """The mixed term, where it is not of higher order than the others."""
    mixed = at.mixed(sides[0], sides[1])
    if mixed is None or any(term.order < mixed[0] - _SAME for term in others):
        return []
    order, limit = mixed
    u, v = at.u[sides[0]], at.v[sides[1]]
    assert u is not None
    assert v is not None
    if limit is None:
        return [_Term("the mixed term", order, 1, "undecided", None, None, False)]
    size = float(np.linalg.norm(limit))
    if size <= _SAME * float(np.abs(at.control - at.point).max()):
        # Drawn by faster directions only: of some order above, not above those of the others for sure.
        return [] if others else [_Term("the mixed term", order, 1, "undecided", None, None, False)]
    orders = [section.own.order or 0.0 for section in (u, v)]
    vector = abs(steps[0]) ** orders[0] * abs(steps[1]) ** orders[1] * limit
    block = u.own.block + v.own.block - 1
    steady = is_steady(u.own_swing) and is_steady(v.own_swing)
    return [_Term("the mixed term", order, block, "half-tangent", vector, limit / size, steady)]


def _result(leading: list[_Term], q: float, critical: float, zero: Float[np.ndarray, "dim"]) -> Directional:
    block = leading[0].block
    names = " and ".join(term.name for term in leading)
    rate = f"the difference is like h^{critical:.6g}" + (f" log(1/h)^{block - 1}" if block > 1 else "")
    rough = [term for term in leading if term.status != "half-tangent"]
    direction = _direction(leading) if not rough else None
    going = "" if direction is None else f", in the direction {written(direction)}"
    if q < critical - _SAME:
        return Directional("zero", q, critical, zero, direction, f"zero at the order {q:.6g}: {rate}{going}")
    if q > critical + _SAME or (block > 1 and not rough):
        said = f"infinite at the order {q:.6g}: {rate}{going}"
        return Directional("infinite", q, critical, None, direction, said)
    if rough:
        said = f"no limit at the order {q:.6g}: {rough[0].name} {rough[0].status}; {rate}"
        return Directional(rough[0].status, q, critical, None, None, said)
    vectors = [term.vector for term in leading if term.vector is not None]
    total = math.gamma(1 + q) * np.sum(vectors, axis=0)
    if np.linalg.norm(total) <= _SAME * max(float(np.linalg.norm(vector)) for vector in vectors):
        said = f"zero at the order {q:.6g}, where {names} cancel: the difference is of a higher order"
        return Directional("zero", q, critical, np.zeros_like(total), None, said)
    if all(term.is_steady for term in leading):
        said = f"{written(total)} mm at the order {q:.6g}, from {names}"
        return Directional("value", q, critical, total, direction, said)
    said = (
        f"no limit for all h at the order {q:.6g}: {names} swing for ever; {written(total)} mm along the "
        f"ends of the pieces"
    )
    return Directional("log-periodic", q, critical, total, direction, said)


def _direction(leading: list[_Term]) -> Float[np.ndarray, "dim"] | None:
    """Where the difference goes; None where several terms count and their proportions have no limit."""
    if len(leading) == 1:
        return leading[0].direction
    if not all(term.is_steady and term.vector is not None for term in leading):
        return None
    total = np.sum([term.vector for term in leading if term.vector is not None], axis=0)
    size = float(np.linalg.norm(total))
    return None if size == 0 else total / size
