"""The differential behaviour of a curve at one point: what `bcifs fld` reports."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from fld.address import parse_address
from fld.curve import curve, fixed_point
from fld.local import sides
from fld.order import dominant_moduli, solved_order
from fld.parts import Chosen, chosen, parameter
from fld.scale import settled
from fld.tangent import HalfTangent, seen
from fld.wording import number, written
from ifs import Shape

_SAME_ANGLE = 1e-6  # degrees


@dataclass(frozen=True)
class Behaviour:
    """A point of a curve, and how the curve leaves it to the left and to the right.

    `point` is in mm, `parameter` the point's place in [0, 1] under the parametrisation `ratios` (r_i by
    label), `critical_order` the curve's alpha. `left` and `right` are None where the curve has no such
    side; both point into the curve, so that they are opposite where it passes smoothly.
    `joint` says which it is, or is None when one of the two has no half-tangent.
    """

    name: str
    address: str
    point: Float[np.ndarray, "dim"]
    parameter: float
    critical_order: float
    ratios: Mapping[str, float]
    left: HalfTangent | None
    right: HalfTangent | None
    joint: str | None

    def as_data(self) -> dict[str, Any]:
        """The same as plain dictionaries, lists and numbers, ready for JSON."""
        return {
            "name": self.name,
            "address": self.address,
            "point": [float(x) for x in self.point],
            "parameter": self.parameter,
            "critical_order": self.critical_order,
            "ratios": dict(self.ratios),
            "left": self.left.as_data() if self.left else None,
            "right": self.right.as_data() if self.right else None,
            "joint": self.joint,
        }

    def as_text(self) -> str:
        """The same as lines to read."""
        parts = ", ".join(f"{label}: {ratio:.6g}" for label, ratio in self.ratios.items())
        lines = [
            f"{self.name} at {self.address}",
            f"  point           {written(self.point)} mm, parameter {self.parameter:.9g}",
            f"  critical order  {self.critical_order:.12g}",
            f"  parametrisation {parts}",
        ]
        for which, found in (("left", self.left), ("right", self.right)):
            if found is None:
                lines.append(f"  {which:<15} none: the curve {'starts' if which == 'left' else 'ends'} here")
                continue
            values = ", ".join(number(value) for value in found.eigenvalues)
            lines.append(f"  {which:<15} {found.status}: {found.words}")
            lines.append(f"{'':18}eigenvalues {values or 'none'} at {found.address}")
        if self.joint:
            lines.append(f"  joint           {self.joint}")
        return "\n".join(lines)


def behaviour(shape: Shape, address: str, parametrisation: Chosen = "natural") -> Behaviour:
    """The differential behaviour at an address: a finite word, then another repeated for ever.

    `"0"` and `"(0)*"` are the start of a curve whose labels are 0 and 1, `"1"` its end, `"1 0"` the
    joint of its two pieces. A joint has two addresses; each side is taken from its own (equations
    4.7 and 4.8: the linear part of T_w carries what happens at the fixed point). A fixed
    point inside the curve has both sides at its one address (equation 4.5).

    `parametrisation` is "natural", "uniform" or the part of each label: orders and sizes depend on it,
    directions do not. Raises `ValueError` for an address that cannot be read, has an unknown label, or wrong
    parts, and what `critical_order` raises. Source: Gentil 2010, section 4.2.2.

    >>> import ifs
    >>> behaviour(ifs.shape("corner-cutting"), "1 0").joint
    'smooth passage'
    """
    own = curve(shape)
    where = parse_address(address, own)
    moduli = dominant_moduli(own)
    parts = chosen(own, parametrisation)
    left, right = (found and seen(found) for found in sides(own, parts, where))
    point = own.operator(where.word) @ fixed_point(own.operator(where.repeat))
    return Behaviour(
        shape.name,
        str(where),
        settled(point @ own.control, own.control),
        parameter(own, parts, where),
        solved_order(list(moduli.values())),
        parts,
        left,
        right,
        joint(left, right),
    )


def joint(left: HalfTangent | None, right: HalfTangent | None) -> str | None:
    """How two half-tangents meet: "smooth passage", "cusp", or a corner with its angle."""
    if left is None or right is None or left.status != "half-tangent" or right.status != "half-tangent":
        return None
    assert left.direction is not None
    assert right.direction is not None
    # The angle between unit vectors a and b, exact for small ones too: 2 atan2(|a - b|, |a + b|).
    before, after = -left.direction, right.direction
    turn = math.degrees(2 * math.atan2(np.linalg.norm(after - before), np.linalg.norm(after + before)))
    if turn <= _SAME_ANGLE:
        return "smooth passage"
    if turn >= 180 - _SAME_ANGLE:
        return "cusp"
    return f"corner, turning by {turn:.6g} degrees"
