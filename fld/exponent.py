"""Local orders and pointwise Hölder exponents of a curve at an address, under any parametrisation."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from fld.address import parse_address
from fld.curve import curve
from fld.expansion import Expansion, Term, expansion
from fld.local import sides
from fld.parts import Chosen, chosen, parameter
from ifs import Shape

_SAME_ORDER = 1e-9
_SAME = 1e-8


@dataclass(frozen=True)
class Orders:
    """Local orders and the Hölder exponent at a point.

    `left` and `right` are `log|lambda(u)| / log r(u)` on either side: distances from the point shrink like
    `h^order`. None where the curve has no such side; infinite where it stays in the point. `holder` is
    the two-sided pointwise Hölder exponent: the largest s (as a supremum) for which some polynomial P of
    degree below s has `|H(t + h) - P(h)| <= C |h|^s`. It is the lesser of the two orders, unless the lowest
    terms are one polynomial on both sides, which P then takes away; infinite where the curve is a
    polynomial in its parameter there.
    """

    name: str
    address: str
    parameter: float
    left: float | None
    right: float | None
    holder: float

    def as_data(self) -> dict[str, Any]:
        """The same as plain numbers, ready for JSON; infinite ones as "infinite"."""
        numbers = {"left": self.left, "right": self.right, "holder": self.holder}
        written = {key: "infinite" if number == math.inf else number for key, number in numbers.items()}
        return {"name": self.name, "address": self.address, "parameter": self.parameter, **written}

    def as_text(self) -> str:
        """The same as a line to read."""
        ends = [
            f"{side} none" if order is None else f"{side} {order:.12g}"
            for side, order in (("left", self.left), ("right", self.right))
        ]
        return f"{self.name} at {self.address}: local orders {', '.join(ends)}; exponent {self.holder:.12g}"


def orders(shape: Shape, address: str, parametrisation: Chosen = "natural") -> Orders:
    """The local orders and the Hölder exponent at an address such as `"0 (1 2)*"`.

    The eigenvalue 1 of the operators in barycentric space belongs to the point itself and does not count:
    they are looked at on differences. Raises as `derivatives` does. Source: Gentil 2010, theorem 4.2.1 at any
    period; the exponent by `fld.expansion`.

    >>> import ifs
    >>> found = orders(ifs.shape("koch-curve"), "1 (0)*", {"0": 0.4, "1": 0.2, "2": 0.2, "3": 0.2})
    >>> round(found.left, 6), round(found.right, 6), round(found.holder, 6)
    (0.682606, 1.198978, 0.682606)
    """
    own = curve(shape)
    parts = chosen(own, parametrisation)
    where = parse_address(address, own)
    left, right = (found and expansion(found) for found in sides(own, parts, where))
    return Orders(
        shape.name,
        str(where),
        parameter(own, parts, where),
        _first(left),
        _first(right),
        holder(left, right),
    )


def holder(left: Expansion | None, right: Expansion | None) -> float:
    """The pointwise Hölder exponent from the terms of both sides; those of one side alone at an end."""
    if left is None or right is None:
        present = left or right
        assert present is not None
        return min((term.order for term in present.terms if not _is_polynomial(term)), default=math.inf)
    exponents = [term.order for term in (*left.terms, *right.terms) if not _is_polynomial(term)]
    for one, other in ((left, right), (right, left)):
        for term in one.terms:
            if _is_polynomial(term) and not _continued(term, other):
                exponents.append(term.order)
    return min(exponents, default=math.inf)


def _is_polynomial(term: Term) -> bool:
    return term.exact and abs(term.order - round(term.order)) < _SAME_ORDER


def _continued(term: Term, other: Expansion) -> bool:
    """Whether the polynomial term `v h^m` is `v (-h)^m` on the other side."""
    sign = (-1) ** round(term.order)
    return any(
        _is_polynomial(match)
        and abs(match.order - term.order) < _SAME_ORDER
        and bool(np.linalg.norm(match.vector - sign * term.vector) <= _SAME * np.linalg.norm(term.vector))
        for match in other.terms
    )


def _first(found: Expansion | None) -> float | None:
    if found is None:
        return None
    return min((term.order for term in found.terms), default=math.inf)
