"""What `bcifs fld` tells about a point of a curve."""

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from automata.expression import ExpressionError, number
from fld import WrongParts
from fld.address import Address, parse_address, twin
from fld.behaviour import Behaviour, behaviour
from fld.curve import Curve, curve
from fld.derivative import Derivative, Derivatives, derivatives
from fld.expansion import Expansion, expansions
from fld.exponent import Orders, orders
from fld.parts import Chosen, parameter
from fld.tangent import HalfTangent
from fld.wording import number as eigenvalue
from fld.wording import written
from ifs import Shape

_SIDES = ("left", "right")
_WIDTH = 16


@dataclass(frozen=True)
class Report:
    """A point of a curve: half-tangents, local orders, derivatives and terms on either side.

    `twin` is the other address of a joint, None for a point that has one address.
    """

    curve: Curve
    behaviour: Behaviour
    twin: str | None
    orders: Orders
    derivatives: Derivatives
    expansions: tuple[Expansion | None, Expansion | None]

    def sides(
        self,
    ) -> list[tuple[str, HalfTangent | None, Derivative | None, Expansion | None]]:
        """Name, half-tangent, derivative and terms of the left and of the right side."""
        found, slopes = self.behaviour, self.derivatives
        return [
            ("left", found.left, slopes.left, self.expansions[0]),
            ("right", found.right, slopes.right, self.expansions[1]),
        ]

    def reach(self, side: Expansion) -> float:
        """The distance in parameter to the end of the piece that the word of a side's address leads to."""
        parts = dict(self.behaviour.ratios)
        where = parse_address(side.address, self.curve)
        place = parameter(self.curve, parts, Address((), where.repeat))
        return math.prod(parts[k] for k in where.word) * (1 - place if side.side == "right" else place)

    def as_data(self) -> dict[str, Any]:
        """The same as plain dictionaries, lists and numbers, ready for JSON."""
        found = self.orders.as_data()
        slopes = self.derivatives.as_data()
        terms = [None if e is None else e.as_data() for e in self.expansions]
        return {
            "kind": "curve",
            **self.behaviour.as_data(),
            "twin": self.twin,
            "local_orders": {side: found[side] for side in _SIDES},
            "holder": found["holder"],
            "derivatives": {key: slopes[key] for key in (*_SIDES, "passage")},
            "terms": dict(zip(_SIDES, terms, strict=True)),
        }

    def as_text(self) -> str:
        """The same as lines to read."""
        found = self.behaviour
        parts = ", ".join(f"{label}: {ratio:.6g}" for label, ratio in found.ratios.items())
        rows = [
            ("point", f"{written(found.point)} mm, parameter {found.parameter:.9g}"),
            ("twin", f"{self.twin}, the same point" if self.twin else ""),
            ("critical order", f"{found.critical_order:.12g}"),
            ("parametrisation", parts),
            ("Hölder exponent", f"{exponent(self.orders.holder)}"),
        ]
        for side, tangent, slope, terms in self.sides():
            if tangent is None or slope is None or terms is None:
                ends = "starts" if side == "left" else "ends"
                rows.append((side, f"none: the curve {ends} here"))
                continue
            values = ", ".join(map(eigenvalue, tangent.eigenvalues)) or "none"
            rows += [
                (side, f"{tangent.status}: {tangent.words}"),
                ("  derivative", slope.words.removesuffix(f": {tangent.words}")),
                ("  terms", terms.words),
                ("  eigenvalues", f"{values} at {tangent.address}"),
            ]
        rows += [("joint", found.joint or ""), ("derivatives", self.derivatives.passage or "")]
        return "\n".join(
            [f"{found.name} at {found.address}"]
            + [f"  {title:<{_WIDTH}}{text}" for title, text in rows if text]
        )


def report(
    shape: Shape, address: str, order: float | None = None, parametrisation: str = "natural"
) -> Report:
    """All that is known of a curve at an address; the derivative of order `order`, else of the local order.

    `parametrisation` is "natural", "uniform" or the parts of the pieces, "1/2, 1/4, 1/4", along the curve.
    Raises what `fld.behaviour` and `fld.derivatives` raise.

    >>> import ifs
    >>> report(ifs.shape("corner-cutting"), "1 0").twin
    '0 (1)*'
    """
    own = curve(shape)
    where = parse_address(address, own)
    parts = parse_parts(parametrisation, own)
    other = twin(where, own)
    return Report(
        own,
        behaviour(shape, address, parts),
        None if other is None else str(other),
        orders(shape, address, parts),
        derivatives(shape, address, order, parts),
        expansions(shape, address, parts),
    )


def parse_parts(text: str, own: Curve) -> Chosen:
    """The parametrisation that a text states. Raises `fld.WrongParts`."""
    if text.strip() in ("natural", "uniform"):
        return text.strip()
    found = [part.strip() for part in text.split(",")]
    if len(found) != len(own.labels):
        raise WrongParts(
            f"--parametrisation {text}: expected natural, uniform, or {len(own.labels)} parts of sum 1, one "
            f"for each of the pieces {', '.join(own.labels)}"
        )
    return {label: _part(text, label, part) for label, part in zip(own.labels, found, strict=True)}


def _part(text: str, label: str, part: str) -> Fraction:
    try:
        found = number(part)
    except ExpressionError as error:
        said = str(error)
    else:
        if 0 < found < 1:
            return found
        said = "it is not between 0 and 1"
    raise WrongParts(
        f"--parametrisation {text}: {part!r}, the part of piece {label!r}: {said}; give numbers between 0 "
        f"and 1, such as 1/4, whose sum is 1"
    )


def exponent(value: float) -> str:
    """An order to read."""
    return "infinite: a polynomial here" if value == float("inf") else f"{value:.12g}"
