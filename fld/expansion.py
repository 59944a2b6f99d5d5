"""How a curve leaves a point, term by term: one for each eigenvalue of the operator that comes back there."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Inexact

from fld.address import parse_address
from fld.curve import curve
from fld.local import Local, Side, sides
from fld.monomials import is_power
from fld.parts import Chosen, chosen
from fld.spectrum import Part
from fld.wording import power, written
from ifs import Shape

_SAME_ORDER = 1e-9
_NOTHING = 1e-9


@dataclass(frozen=True)
class Term:
    """`vector h^order log(1/h)^power` of the difference `H(t ± h) - H(t)`, in mm per parameter^order.

    It is that along the ends `h = h_0 r_u^k` of the pieces `w u^k`. For a negative `eigenvalue` the sign
    changes with k; for a complex pair `vector` is complex, and the term is the real part of `vector e^(i k
    theta) h^order`, theta the angle of the eigenvalue. With a logarithm (`power` > 0, from a Jordan block) it
    is the leading one of its eigenvalue. `exact` says that the term is `vector h^order` for all h: then
    `Gamma(1 + order) vector` is the derivative of that order.
    """

    order: float
    eigenvalue: complex
    power: int
    vector: Inexact[np.ndarray, "dim"]
    exact: bool

    @property
    def derivative(self) -> Inexact[np.ndarray, "dim"]:
        """`Gamma(1 + order) vector`: on the right of a smooth curve, at whole orders, the ordinary one."""
        return math.gamma(1 + self.order) * self.vector

    @property
    def words(self) -> str:
        """The term in words."""
        if np.iscomplexobj(self.vector):
            degrees = math.degrees(math.atan2(self.eigenvalue.imag, self.eigenvalue.real))
            size = float(np.linalg.norm(self.vector))
            return (
                f"{size:.6g} mm {power(self.order, self.power)}, turning by {abs(degrees):.6g} degrees a step"
            )
        sign = "± " if self.eigenvalue.real < 0 else ""
        held = "" if self.exact else " along the ends of pieces"
        return f"{sign}{written(np.real(self.vector))} {power(self.order, self.power)}{held}"

    def as_data(self) -> dict[str, Any]:
        """The same as plain lists and numbers; complex ones as `[real, imaginary]`."""
        numbers = self.vector.tolist()
        if np.iscomplexobj(self.vector):
            numbers = [[number.real, number.imag] for number in numbers]
        return {
            "order": self.order,
            "eigenvalue": [self.eigenvalue.real, self.eigenvalue.imag],
            "power": self.power,
            "vector": numbers,
            "exact": self.exact,
        }


@dataclass(frozen=True)
class Bend:
    """Points of the curve at a distance d from the point are about `size d^exponent` mm off the tangent.

    With exponent 2 the curvature is `2 size`, in 1/mm. `exact` says that this holds for all h.
    """

    exponent: float
    size: float
    exact: bool


@dataclass(frozen=True)
class Expansion:
    """The difference from a point as the sum of its terms, lowest order first."""

    side: Side
    address: str
    terms: tuple[Term, ...]

    @property
    def bend(self) -> Bend | None:
        """How the curve bends away from its half-tangent; None without one, and where nothing bends.

        With `H - c = v_1 h^q_1 + v_2 h^q_2 + …` and w the part of v_2 across v_1 (or of the first v_j that
        has one): `size = |w| / |v_1|^(q_j / q_1)`, `exponent = q_j / q_1`.
        """
        first, *rest = self.terms or (None,)
        if first is None or first.power or first.eigenvalue.imag or first.eigenvalue.real < 0:
            return None
        length = float(np.linalg.norm(first.vector))
        if length == 0 or any(abs(term.order - first.order) < _SAME_ORDER for term in rest):
            return None
        along = first.vector / length
        for term in rest:
            across = term.vector - (term.vector @ along) * along
            if np.linalg.norm(across) > _NOTHING * np.linalg.norm(term.vector):
                if term.power or term.eigenvalue.imag or term.eigenvalue.real < 0:
                    return None
                exponent = term.order / first.order
                size = float(np.linalg.norm(across)) / length**exponent
                return Bend(exponent, size, first.exact and term.exact)
        return None

    @property
    def words(self) -> str:
        """The sum in words."""
        return " + ".join(term.words for term in self.terms) or "the curve stays in this point"

    def as_data(self) -> dict[str, Any]:
        """The same as plain lists and numbers."""
        return {
            "side": self.side,
            "address": self.address,
            "terms": [term.as_data() for term in self.terms],
            "bend": None if self.bend is None else dict(self.bend.__dict__),
        }


def expansions(
    shape: Shape, address: str, parametrisation: Chosen = "natural"
) -> tuple[Expansion | None, Expansion | None]:
    """The terms of the left and of the right difference `H(t ± h) - H(t)` at an address.

    Points on one side are `c + L_w L_u^k (p - c')` at the distances `r_w r_u^k s`. With the projectors Pi_j
    of the eigenvalues lambda_j of L_u, the part `L_w Pi_j (p - c') lambda_j^k` is of the order
    `q_j = log|lambda_j| / log r_u`. For a curve that is polynomial in its parameter all terms are exact:
    they are its Taylor expansion. Eigenvalues below 1e-9 of the largest are lost in rounding and left out, as
    happens with long periods. A side is None where the curve has none.

    Raises as `derivatives` does. Source: Gentil 2010, section 4.2.2, and the question of higher orders in the
    introduction (derivatives of higher order and the successive eigenvalues).

    >>> import ifs
    >>> _, right = expansions(ifs.shape("corner-cutting"), "0")
    >>> [(round(term.order, 9), (term.vector.round(6) + 0.0).tolist(), term.exact) for term in right.terms]
    [(1.0, [30.0, 60.0], True), (2.0, [0.0, -60.0], True)]
    """
    own = curve(shape)
    parts = chosen(own, parametrisation)
    left, right = sides(own, parts, parse_address(address, own))
    return left and expansion(left), right and expansion(right)


def expansion(found: Local) -> Expansion:
    """The terms of one side of a point."""
    terms = [_term(found, part) for part in found.modes if part.value.imag >= 0]
    return Expansion(
        found.side, str(found.address), tuple(sorted(terms, key=lambda term: (term.order, -term.power)))
    )


def _term(found: Local, part: Part) -> Term:
    order = found.order(part.value)
    factor = math.exp(found.fade - order * found.start)
    power = part.block - 1
    rows = found.drawn(part.leading)
    rows = np.real(rows) if part.value.imag == 0 else 2 * rows  # a complex one with its conjugate
    reached = found.ends(rows, order)
    vector = reached[0] * factor
    exact = False
    if power:
        value = part.value if part.value.imag else part.value.real
        vector = vector / (math.factorial(power) * (-found.rate * value) ** power)
    elif part.value.imag == 0 and part.value.real > 0 and abs(order - round(order)) < _SAME_ORDER:
        exact = is_power(found.pieces(np.real(rows), order), round(order), np.real(reached[0]))
    return Term(order, found.eigenvalue(part.value), power, vector, exact)
