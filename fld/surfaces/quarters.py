"""The quarter tangent planes of a tensor product at a point, and how they meet."""

import itertools
import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from fld.surfaces.products import ProductPoint, Section
from fld.wording import written

_SAME = 1e-6  # radians
_FLAT = 1e-9

AROUND = (("right", "right"), ("left", "right"), ("left", "left"), ("right", "left"))
"""The sides of u and of v of the quarters, counterclockwise in the parameters."""


@dataclass(frozen=True)
class Quarter:
    """One quarter of the surface around a point: the side of u, the side of v, and its tangent plane.

    `status` is "plane" where both half-tangents exist and are not parallel: the tangents of the quarter are
    the directions between `tangents[0]`, along u, and `tangents[1]`, along v, and `normal` is the unit vector
    along `d_u x d_v` of increasing u and v. Otherwise it is "line" (both along one line), "undecided" (the
    mixed term may count as much) or "none", as `words` say, and there is no normal.
    """

    sides: tuple[str, str]
    status: str
    tangents: tuple[Float[np.ndarray, "3"] | None, Float[np.ndarray, "3"] | None]
    normal: Float[np.ndarray, "3"] | None
    orders: tuple[float | None, float | None]
    words: str

    def as_data(self) -> dict[str, Any]:
        """The same as plain lists and numbers, ready for JSON."""
        tangents = [None if t is None else [float(x) for x in t] for t in self.tangents]
        return {
            "sides": list(self.sides),
            "status": self.status,
            "tangents": tangents,
            "normal": None if self.normal is None else [float(x) for x in self.normal],
            "orders": list(self.orders),
            "words": self.words,
        }


@dataclass(frozen=True)
class Quarters:
    """The quarters of the surface that there are around a point, and how they meet.

    `joint` is "smooth" (one plane, and both curves pass through), "one plane" (the same plane, while a curve
    turns in it), "crease along u" or "crease along v" (two half-planes, the curve along the crease passes
    through), "fold along u" or "fold along v" (the same with the one plane turned over: a cusp in every
    section across), "corner" (other planes), or None where some quarter has no plane or there is only one.
    `angles` are the angles in degrees between the normals of quarters that follow each other around the
    point.
    """

    quarters: tuple[Quarter, ...]
    joint: str | None
    angles: tuple[float, ...]

    @property
    def words(self) -> str:
        """All of this in lines to read."""
        said = [f"u {q.sides[0]}, v {q.sides[1]}: {q.words}" for q in self.quarters]
        if self.joint is not None:
            angles = ", ".join(f"{angle:.6g}" for angle in self.angles)
            said.append(f"together: {self.joint}; degrees between neighbouring normals: {angles}")
        return "\n".join(said)


def quarters(at: ProductPoint) -> Quarters:
    """The quarter tangent planes at a point of a tensor product in space: four at joints of both curves.

    A quarter is spanned by the half-tangent of the curve along u on its side and that of the curve along v.
    Any point of it near (u, v), by steps x and y, is off by `x^a A + y^b B` and smaller terms, with a, b >
    0: so all directions between A and B are tangents, and only these, whatever the orders a and b. The mixed
    term is small against these as long as `a'/a + b'/b > 1`, with a' and b' the orders of the factors where
    nothing is hidden, as it is unless both curves hide the slowest direction of their factors.

    Raises `ValueError` for a surface that is not in space. Source: Gentil 2010, section 4.2.3, figure 4.7.

    >>> from fld.surfaces.products import product, product_point
    >>> patch = product("corner-cutting", "corner-cutting")
    >>> quarters(product_point(patch, "1 0", "1 0")).joint
    'smooth'
    """
    if len(at.point) != 3:
        raise ValueError(
            f"tangent planes are those of surfaces in space; this one is in {len(at.point)} dimensions"
        )
    found = []
    for u_side, v_side in AROUND:
        u, v = at.u[u_side], at.v[v_side]
        if u is not None and v is not None:
            found.append(_quarter((u_side, v_side), u, v))
    normals = [quarter.normal for quarter in found]
    missing = any(normal is None for normal in normals)
    if missing or len(found) < 2:
        return Quarters(tuple(found), None, ())
    pairs = list(itertools.pairwise(found)) + ([(found[-1], found[0])] if len(found) == 4 else [])
    angles = tuple(_angle(one.normal, other.normal) for one, other in pairs)
    return Quarters(tuple(found), _joint(at, found, angles), tuple(math.degrees(angle) for angle in angles))


def _quarter(sides: tuple[str, str], u: Section, v: Section) -> Quarter:
    one, other = u.drawn, v.drawn
    orders = one.order, other.order
    if one.status != "half-tangent" or other.status != "half-tangent":
        said = [f"the curve along {name} {found.words}" for name, found in (("u", one), ("v", other))]
        return Quarter(sides, "none", (None, None), None, orders, "no quarter plane: " + "; ".join(said))
    assert one.direction is not None
    assert other.direction is not None
    tangents = one.direction, other.direction
    normal = np.cross(*tangents) * (1 if sides[0] == sides[1] else -1)
    size = float(np.linalg.norm(normal))
    if size <= _FLAT:
        said = f"no quarter plane: both half-tangents lie along {written(tangents[0])}"
        return Quarter(sides, "line", tangents, None, orders, said)
    if not _mixed_is_small(u, v):
        said = (
            "undecided: both curves hide the slowest direction of their factors, so the mixed term may count"
        )
        return Quarter(sides, "undecided", tangents, None, orders, said)
    said = f"the plane from {written(tangents[0])} to {written(tangents[1])}, normal {written(normal / size)}"
    if one.order is not None and other.order is not None and abs(one.order - other.order) > 1e-9:
        nearer = "u" if one.order < other.order else "v"
        said += (
            f"; distances are like h^{one.order:.6g} along u and h^{other.order:.6g} along v, so straight "
            f"ways in the parameters leave along {nearer}"
        )
    return Quarter(sides, "plane", tangents, normal / size, orders, said)


def _mixed_is_small(u: Section, v: Section) -> bool:
    shares = 0.0
    for section in (u, v):
        if section.own.order is None or section.drawn.order is None:
            return False
        shares += section.own.order / section.drawn.order
    return shares > 1 + 1e-9


def _angle(one: Float[np.ndarray, "3"] | None, other: Float[np.ndarray, "3"] | None) -> float:
    assert one is not None
    assert other is not None
    return 2 * math.atan2(float(np.linalg.norm(one - other)), float(np.linalg.norm(one + other)))


def _joint(at: ProductPoint, found: list[Quarter], angles: tuple[float, ...]) -> str:
    same = [angle <= _SAME for angle in angles]
    through_u, through_v = (_passes(sections) for sections in (at.u.values(), at.v.values()))
    if all(same):
        return "smooth" if through_u is not False and through_v is not False else "one plane"
    most = "fold" if max(angles) >= math.pi - _SAME else "crease"
    if len(found) == 2:
        return f"{most} along {'v' if found[0].sides[1] == found[1].sides[1] else 'u'}"
    if same == [True, False, True, False] and through_u:
        return f"{most} along u"
    if same == [False, True, False, True] and through_v:
        return f"{most} along v"
    return "corner"


def _passes(sections: Iterable[Section | None]) -> bool | None:
    """Whether the two half-tangents along a parameter are opposite; None where one is missing."""
    ways = [section.drawn.direction for section in sections if section is not None]
    if len(ways) < 2 or ways[0] is None or ways[1] is None:
        return None
    return _angle(ways[0], -ways[1]) <= _SAME
