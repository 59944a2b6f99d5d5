"""Roughness maps: the local order of every piece of a curve or a surface."""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from fld.curve import Curve, curve, fixed_point
from fld.directions import projected, spanned, visible
from fld.error import Collapsed, NotACurve
from fld.parts import Chosen, chosen
from fld.surfaces.corners import patch_corner
from fld.surfaces.vertices import Patches, patches
from ifs import Complex, Mesh, Shape, draw, require_contraction
from ifs.asked import require_whole
from ifs.complex import refine_traced

_MOST = 300_000
_NOTHING = 1e-12

Matrices = Float[np.ndarray, "_pieces _n _n"]


class TooManyPieces(ValueError):
    """A depth at which there would be more pieces than a map is made of."""


@dataclass(frozen=True)
class Roughness:
    """The pieces of a shape as segments or faces of `mesh` (mm), and the local order of each of them.

    An order of 1 stands for what is as smooth as its parameter, smaller ones for rougher pieces. `of` says
    what the orders are: "fixed points" of the pieces, or "corners", the least of those at a face's corners.
    """

    mesh: Mesh
    orders: Float[np.ndarray, "pieces"]
    of: str

    @property
    def range(self) -> tuple[float, float]:
        """The least and the largest order."""
        return float(self.orders.min()), float(self.orders.max())


def roughness(
    source: Shape | Complex, depth: int = 4, parametrisation: Chosen = "natural", detail: int = 0
) -> Roughness:
    """The local order of every piece of a curve or a surface after `depth` subdivisions.

    The mesh is subdivided `detail` times more; what that adds has the order of the piece that it is in.

    A piece T_w of a curve, or of a face cut into copies of itself, has the point w^omega; there, distances
    shrink like `h^order` with `order = log rho(L_w) / log r_w`, rho the largest modulus of an eigenvalue of
    L_w on visible directions. The parts r_i of a curve are those of `fld.parametrisation`, or as given; those
    of a face with N sub-faces are `N^(-1/2)`, and `parametrisation` must stay "natural".

    In a surface of several kinds of faces no point need come back, and each face drawn has the least order of
    its own corners, for control points in general position: `fld.surfaces.PatchCorner.orders`. A corner whose
    parameter shrinks unequally has none, and a face without any is NaN. Where an eigenvalue is defective (the
    Takagi curve), orders are right to about 1e-8.

    Raises `fld.NotACurve` for a shape that is neither, `TooManyPieces`, `fld.Collapsed`, and what
    `ifs.require_contraction` raises. Source: Gentil 2010, theorem 4.2.1, taken at the fixed point of T_w.

    >>> import ifs
    >>> koch = roughness(ifs.shape("koch-curve"), 3)
    >>> [round(order, 9) for order in koch.range], len(koch.orders)
    ([0.79248125, 0.79248125], 64)
    """
    require_whole("depth", depth, 1)
    require_whole("detail", detail)
    if isinstance(source, Shape):
        require_contraction(source.system)
        try:
            own = curve(source)
        except NotACurve as error:
            try:
                surface = patches(source)
            except ValueError:
                raise error from None
        else:
            return _of_curve(own, depth, detail, chosen(own, parametrisation))
    else:
        surface = patches(source)
    if parametrisation != "natural":
        raise ValueError("a parametrisation is for curves; faces are cut into equal parts")
    return _of_surface(surface, depth, detail)


def _of_curve(own: Curve, depth: int, detail: int, parts: dict[str, float]) -> Roughness:
    count = len(own.labels)
    _limit(count ** (depth + detail))
    linear = _linear(own)
    rates = np.log([parts[label] for label in own.labels])
    products, logs = np.eye(linear.shape[1])[None], np.zeros(1)
    controls = own.control[None]
    steps = np.stack([operator.T for operator in own.operators])
    for _ in range(depth):
        products = np.einsum("pij,ljk->plik", products, linear).reshape(-1, *linear.shape[1:])
        logs = (logs[:, None] + rates).ravel()
    for _ in range(depth + detail):
        controls = np.einsum("lij,pjd->plid", steps, controls).reshape(-1, *own.control.shape)
    first, last = (fixed_point(own.operators[k]) for k in (0, -1))
    points = np.vstack([first @ controls, (last @ controls[-1])[None]])
    pieces = np.arange(len(controls))
    mesh = Mesh(points, np.stack([pieces, pieces + 1], axis=1))
    return Roughness(mesh, _orders(own, products, logs).repeat(count**detail), "fixed points")


def _of_surface(surface: Patches, depth: int, detail: int) -> Roughness:
    complex_ = surface.complex
    cells = complex_.topology.automaton.cells
    faces = list(complex_.control)
    if len(faces) == 1 and set(cells[faces[0]].subdivision.values()) == {faces[0]}:
        return _of_copies(complex_, faces[0], depth, detail)
    total = sum(len(control) for control in complex_.control.values())
    widest = max(len(cell.subdivision) for name, cell in cells.items() if name in complex_.control)
    _limit(total * widest ** (depth + detail))
    for _ in range(depth + detail):
        complex_, _ = refine_traced(complex_)
    known = {cell: _least_order(surface, cell) for cell in complex_.control}
    orders = [np.full(len(control), known[cell]) for cell, control in complex_.control.items()]
    return Roughness(draw(complex_), np.concatenate(orders), "corners")


def _of_copies(complex_: Complex, cell: str, depth: int, detail: int) -> Roughness:
    state = complex_.system.states[cell]
    count = len(complex_.control[cell])
    _limit(count * len(state.labels) ** (depth + detail))
    control = np.asarray(complex_.control[cell][0]) if count == 1 else np.eye(state.points)
    own = Curve(cell, state.labels, state.operators, control, complex_.system)
    linear = _linear(own)
    products = np.tile(np.eye(linear.shape[1]), (count, 1, 1))
    for _ in range(depth):
        complex_, numbers = refine_traced(complex_)
        following = np.empty((len(products) * len(linear), *linear.shape[1:]))
        for label, matrix in zip(state.labels, linear, strict=True):
            following[numbers(cell, label, np.arange(len(products)))] = products @ matrix
        products = following
    logs = np.full(len(products), -depth * math.log(len(state.labels)) / 2)
    orders = _orders(own, products, logs)
    for _ in range(detail):
        complex_, numbers = refine_traced(complex_)
        following = np.empty(len(orders) * len(linear))
        for label in state.labels:
            following[numbers(cell, label, np.arange(len(orders)))] = orders
        orders = following
    return Roughness(draw(complex_), orders, "fixed points")


def _linear(own: Curve) -> Matrices:
    """The linear parts on the directions that are spanned and seen."""
    basis = spanned(own)
    found = visible(basis, own.operators, projected(own, basis))
    if len(found.basis) == 0:
        raise Collapsed(own.cell, None, 0.0)
    return np.stack(found.linear)


def _orders(own: Curve, products: Matrices, logs: Float[np.ndarray, "pieces"]) -> Float[np.ndarray, "pieces"]:
    moduli = np.abs(np.linalg.eigvals(products)).max(axis=1)
    if moduli.min() <= _NOTHING * math.exp(logs.min()):
        raise Collapsed(own.cell, None, float(moduli.min()))
    return np.log(moduli) / logs


def _least_order(surface: Patches, cell: str) -> float:
    topology = surface.complex.topology
    control = np.eye(topology.automaton.cells[cell].points)
    found = [
        patch_corner(topology, surface.ground, surface.frames, cell, number, control).orders
        for number in range(len(surface.frames[cell].corners))
    ]
    return min((orders[0] for orders in found if orders and orders[0] is not None), default=math.nan)


def _limit(count: int) -> None:
    if count > _MOST:
        raise TooManyPieces(
            f"{count} pieces are more than a map is made of ({_MOST}): choose a smaller depth"
        )
