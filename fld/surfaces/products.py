"""Tensor products of two curves at a point: what the surface does along either parameter, on either side.

With `S(u, v) = sum P_ij F_i(u) G_j(v)`, and differences of F and G over steps x and y,

    S(u + x, v + y) - S(u, v) = dF (x) G + F (x) dG + dF (x) dG.

The first two are differences of the curves through the point, whose control points are `sum_j P_ij G_j(v)`
and `sum_i P_ij F_i(u)`; the last one, the mixed term, is small against them unless both curves hide the
slowest direction of their factors.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Real

import ifs
from automata import Automaton
from fld.curve import Curve, curve, fixed_point
from fld.order import dominant_moduli
from fld.scale import require_scale, settled
from fld.surfaces.curve_rings import curve_ring, parameter
from fld.surfaces.leaving import Leaving, leaving, order_of
from fld.surfaces.modes import Mode, slowest
from fld.surfaces.rings import Ground, Ring
from ifs import Shape
from ifs.dimensions.order import ratios
from ifs.orbits.addresses import Address, UnknownLabel, address, parse_address

SIDES = ("left", "right")
_POINTS = 200


@dataclass(frozen=True)
class Product:
    """A tensor product of two curves: `control[i, j]` is P_ij in mm, `parts` the parameters of either curve.

    `parts[0]` says which part of [0, 1] each piece of the first curve takes, in the order along it.
    """

    curves: tuple[Curve, Curve]
    grounds: tuple[Ground, Ground]
    parts: tuple[Mapping[str, float], Mapping[str, float]]
    control: Float[np.ndarray, "first second dim"]


def product(
    first: Shape | Automaton | str,
    second: Shape | Automaton | str,
    control: Real[np.ndarray, "..."] | None = None,
    parts: tuple[Sequence[float] | None, Sequence[float] | None] = (None, None),
) -> Product:
    """The surface `S(u, v) = sum P_ij F_i(u) G_j(v)` of two curves `sum P_i F_i` and `sum P_j G_j`.

    `control` is `(m, n, dim)` or `(m n, dim)` in millimetres, in the order of `subdivision.schemes.tensor`;
    without it two plane curves with control points of their own are moved along each other, point (i, j) at
    `(x_i, x_j, y_i + y_j)`. `parts` are the parts of [0, 1] that the pieces of either curve take, in the
    order along it; without them those of the critical order of the curve with control points in general
    position.

    Raises `fld.NotACurve` and `fld.Collapsed` for what is no curve, `ValueError` for control points of the
    wrong number and for parts that are not positive or do not sum to 1.

    >>> surface = product("takagi-curve", "corner-cutting")
    >>> surface.control.shape
    (3, 3, 3)
    """
    shapes = [_shape(source) for source in (first, second)]
    curves = [curve(Shape(s.name, s.topology, s.system, np.eye(len(s.control)))) for s in shapes]
    m, n = (len(c.control) for c in curves)
    if control is None:
        points = _moved(shapes)
    else:
        points = np.array(control, dtype=float)
        if points.shape[:-1] not in ((m, n), (m * n,)):
            raise ValueError(f"expected {m} by {n} control points, found an array {points.shape}")
        points = points.reshape(m, n, -1)
    if not np.isfinite(points).all():
        place = np.argwhere(~np.isfinite(points))[0][:2].tolist()
        raise ValueError(f"control point {place} is not finite: {points[tuple(place)]}")
    grounds = [Ground(c.system) for c in curves]
    found = [_parts(c, given) for c, given in zip(curves, parts, strict=True)]
    require_scale(points.reshape(-1, points.shape[2]))
    return Product((curves[0], curves[1]), (grounds[0], grounds[1]), (found[0], found[1]), points)


def _shape(source: Shape | Automaton | str) -> Shape:
    if isinstance(source, Shape):
        return source
    automaton = source if isinstance(source, Automaton) else ifs.shape(source).automaton
    if automaton.control is None:
        count = automaton.cells[automaton.shape].points
        return ifs.shape(automaton, control=np.zeros((count, 1)))
    return ifs.shape(automaton)


def _moved(shapes: Sequence[Shape]) -> Float[np.ndarray, "first second 3"]:
    one, other = (shape.control for shape in shapes)
    if one.shape[1] != 2 or other.shape[1] != 2:
        raise ValueError(
            f"the control points of the curves lie in {one.shape[1]} and {other.shape[1]} dimensions: only "
            "plane curves are moved along each other; give the control points of the surface"
        )
    result = np.empty((len(one), len(other), 3))
    result[:, :, 0], result[:, :, 1] = one[:, None, 0], other[None, :, 0]
    result[:, :, 2] = one[:, None, 1] + other[None, :, 1]
    return result


def _parts(curve: Curve, given: Sequence[float] | None) -> Mapping[str, float]:
    if given is None:
        return ratios(dominant_moduli(curve))
    found = [float(part) for part in given]
    if len(found) != len(curve.labels) or not all(part > 0 for part in found) or abs(sum(found) - 1) > 1e-9:
        raise ValueError(
            f"expected {len(curve.labels)} parts of [0, 1], positive and of sum 1, one for each of "
            f"the pieces {', '.join(curve.labels)}; found {found}"
        )
    return dict(zip(curve.labels, found, strict=True))


@dataclass(frozen=True)
class Section:
    """One side of the curve through a point along one parameter.

    `drawn` is how the curve on the surface leaves the point, `own` how the factor does in its barycentric
    space, where nothing is hidden. `swing` are the least and the largest length that
    `difference / h^order` comes back to as h goes to 0, along the direction and relative to its limit along
    the ends of the pieces; (1, 1) where it converges for all h, to 9 digits at 200 points or more. None
    without a half-tangent. `own_swing` is the same of the factor.
    """

    drawn: Leaving
    own: Leaving
    swing: tuple[float, float] | None
    own_swing: tuple[float, float] | None


def is_steady(swing: tuple[float, float] | None) -> bool:
    """Whether a swing says that `difference / h^order` converges for all h."""
    return swing is not None and max(abs(end - 1) for end in swing) <= 1e-9


@dataclass(frozen=True)
class ProductPoint:
    """A point of a tensor product: where it is, in mm, and its sections `u["left"]` ... `v["right"]`.

    A section is None where the surface ends. `mixed(a, b)` is the mixed term of the sides a of u and b of v.
    """

    addresses: tuple[str, str]
    parameters: tuple[float, float]
    point: Float[np.ndarray, "dim"]
    u: Mapping[str, Section | None]
    v: Mapping[str, Section | None]
    control: Float[np.ndarray, "first second dim"]

    def mixed(self, u_side: str, v_side: str) -> tuple[float, Float[np.ndarray, "dim"] | None] | None:
        """The order of `dF (x) dG` and its limit in mm, None where that has none; None without an order.

        The order is the sum of those of the factors, h being the step in both parameters; where the limit
        draws nothing, the mixed term is of a higher order.
        """
        one, other = self.u[u_side], self.v[v_side]
        if one is None or other is None or one.own.order is None or other.own.order is None:
            return None
        order = one.own.order + other.own.order
        if one.own.vector is None or other.own.vector is None:
            return order, None
        return order, np.einsum("i,ijd,j->d", one.own.vector, self.control, other.own.vector)


def product_point(surface: Product, u: str, v: str) -> ProductPoint:
    """The point of a tensor product at an address of either curve, such as `"1 0"` or `"0 (1 0)*"`.

    An address is a word, then one or several labels repeated for ever; without `( )*` the last label repeats.
    A joint has two addresses, and each side is taken from its own.

    Raises `ValueError` for an address that cannot be read and `ifs` errors for one with unknown labels.
    Source: Gentil 2010, section 4.2.3.

    >>> found = product_point(product("takagi-curve", "corner-cutting"), "1 0", "1 0")
    >>> round(found.parameters[0], 9), found.u["right"].drawn.block
    (0.5, 2)
    """
    found = [_read(c, text) for c, text in zip(surface.curves, (u, v), strict=True)]
    columns = [_column(c, where) for c, where in zip(surface.curves, found, strict=True)]
    controls = (
        np.einsum("ijd,j->id", surface.control, columns[1]),
        np.einsum("ijd,i->jd", surface.control, columns[0]),
    )
    sections = [
        {side: _section(surface, axis, found[axis], side, controls[axis]) for side in SIDES}
        for axis in (0, 1)
    ]
    places = [
        parameter(parts, where.word, where.repeat) for parts, where in zip(surface.parts, found, strict=True)
    ]
    return ProductPoint(
        (str(found[0]), str(found[1])),
        (places[0], places[1]),
        settled(columns[0] @ controls[0], surface.control.reshape(-1, surface.control.shape[2])),
        sections[0],
        sections[1],
        surface.control,
    )


def _read(curve: Curve, text: str) -> Address:
    found = parse_address(text)
    for place, label in enumerate((*found.word, *found.repeat)):
        if label not in curve.labels:
            raise UnknownLabel(label, place, curve.cell, curve.labels)
    return found


def _column(curve: Curve, where: Address) -> Float[np.ndarray, "points"]:
    return curve.operator(where.word) @ fixed_point(curve.operator(where.repeat))


def _section(
    surface: Product, axis: int, where: Address, side: str, control: Float[np.ndarray, "points dim"]
) -> Section | None:
    curve = surface.curves[axis]
    ring = None
    for here in (where, twin(curve.labels, where)):
        if ring is None and here is not None:
            operators = dict(zip(curve.labels, curve.operators, strict=True))
            ring = curve_ring(
                surface.grounds[axis], operators, surface.parts[axis], here.word, here.repeat, side
            )
    if ring is None:
        return None
    whole = surface.control.reshape(-1, surface.control.shape[2])
    size = float(np.linalg.norm(whole - whole.mean(axis=0), 2))
    drawn, own = leaving(ring, control, size), leaving(ring, curve.control)
    parts = surface.parts[axis]
    return Section(
        drawn,
        own,
        None if drawn.vector is None else _swing(curve, parts, ring, slowest(ring, control, size)),
        None if own.vector is None else _swing(curve, parts, ring, slowest(ring, curve.control)),
    )


def twin(labels: Sequence[str], where: Address) -> Address | None:
    """The other address of a joint: the end of the piece before, or the start of the next; None without."""
    first, last = labels[0], labels[-1]
    if not where.word or where.repeat not in ((first,), (last,)):
        return None
    *before, label = where.word
    place = labels.index(label)
    if where.repeat == (first,):
        return address((*before, labels[place - 1]), (last,))
    return address((*before, labels[place + 1]), (first,))


def _swing(
    curve: Curve, parts: Mapping[str, float], ring: Ring, mode: Mode | None
) -> tuple[float, float] | None:
    order = None if mode is None else order_of(ring, mode)
    if mode is None or order is None:
        return None
    row = mode.rows[0]
    columns, parameters = _samples(curve, parts)
    values = []
    for (operator, _), (offset, slope) in zip(ring.pieces, ring.places, strict=True):
        steps = offset + slope * parameters
        values.append((row @ operator @ columns - row @ ring.point) / steps**order)
    found_values = np.concatenate(values) / float(row @ (ring.far - ring.point))
    return float(found_values.min()), float(found_values.max())


def _samples(
    curve: Curve, parts: Mapping[str, float]
) -> tuple[Float[np.ndarray, "points samples"], Float[np.ndarray, "samples"]]:
    """The joints of the pieces of some level, with their parameters."""
    columns = np.stack([fixed_point(curve.operators[0]), fixed_point(curve.operators[-1])], axis=1)
    parameters = np.array([0.0, 1.0])
    while len(parameters) < _POINTS:
        starts = np.cumsum([0.0, *parts.values()])[:-1]
        parameters = np.concatenate(
            [start + part * parameters for start, part in zip(starts, parts.values(), strict=True)]
        )
        columns = np.concatenate([operator @ columns for operator in curve.operators], axis=1)
    return columns, parameters
