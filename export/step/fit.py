"""Bicubic fits of the patches around extraordinary points, and how to tell these from fractal ones."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np
from jaxtyping import Float

from export.step.edges import LEVEL, edge_curves
from export.step.error import NotPolynomial
from export.step.frames import CORNERS
from export.step.polynomial import (
    Grid,
    Limits,
    bernstein,
    embedding_matrix,
    polynomial_edges,
    polynomial_faces,
)

Edges = Mapping[str, Float[np.ndarray, "_points _poles"]]


@dataclass(frozen=True)
class Surfaces:
    """For each quadrangle its Bernstein control points `(points, d + 1, d + 1)`, exact or fitted.

    `differences[x]`, `(points, samples)`, is there for the fitted ones alone: the limit points less the fit's
    points at the same parameters, as combinations of the control points of x.
    """

    limits: Limits
    exact: Mapping[str, Grid]
    fitted: Mapping[str, Grid]
    differences: Mapping[str, Float[np.ndarray, "_points _samples"]]


def surfaces(limits: Limits, pieces: Iterable[str], highest: int = 3) -> Surfaces:
    """The surfaces of the given cells and of all that they become.

    The sides of a fit are those of `edge_curves`, which neighbours share. At sides where the limit surface is
    polynomial on the inside, the fit has its derivatives across the side too; what is left is the closest
    in the mean.

    Raises `NotPolynomial` for a cell that is no quadrangle, and for one that is neither polynomial nor
    becomes so away from finitely many points.
    """
    pieces = list(dict.fromkeys(pieces))
    for cell in pieces:
        if cell not in limits.quads:
            raise NotPolynomial(cell, "it is no quadrangle that becomes four quadrangles")
    exact = polynomial_faces(limits, highest)
    require_isolated(limits, exact, pieces)
    needed = _descendants(limits, pieces)
    degree = max(3, highest)
    edges = edge_curves(limits, polynomial_edges(limits, highest), degree)
    fitted, differences = {}, {}
    for cell in needed:
        if cell not in exact:
            fitted[cell], differences[cell] = _fit(limits, cell, edges, exact)
    return Surfaces(limits, {c: exact[c] for c in needed if c in exact}, fitted, differences)


def require_isolated(limits: Limits, exact: Mapping[str, Grid], pieces: Iterable[str]) -> None:
    """`NotPolynomial` unless what is not polynomial shrinks to finitely many points.

    That is so when the number of such pieces stays bounded: a cell that becomes itself again does so once,
    and becomes no other cell that becomes itself.
    """
    from scipy.sparse.csgraph import connected_components

    cells = [cell for cell in _descendants(limits, pieces) if cell not in exact]
    number = {cell: i for i, cell in enumerate(cells)}
    count = np.zeros((len(cells), len(cells)), dtype=np.int64)
    for cell in cells:
        for target in limits.system.states[cell].targets:
            if target in number:
                count[number[cell], number[target]] += 1
    if not cells:
        return
    _, part = connected_components(count, directed=True, connection="strong")
    cyclic = np.zeros(len(cells), dtype=bool)
    for cell in cells:
        inside = part == part[number[cell]]
        arrows = int(count[np.ix_(inside, inside)].sum())
        cyclic[number[cell]] = arrows > 0
        if arrows > inside.sum():
            children = int(count[number[cell]].sum())
            raise NotPolynomial(
                cell,
                f"it is no polynomial surface and is not smooth, {children} of its 4 children are like it",
            )
    reached = (count > 0).astype(np.int64)
    for _ in cells:
        reached = ((reached + reached @ reached) > 0).astype(np.int64)
    for a, b in zip(*np.nonzero(reached), strict=True):
        if cyclic[a] and cyclic[b] and part[a] != part[b]:
            raise NotPolynomial(
                cells[a],
                f"it is no polynomial surface and is not smooth, each level brings one more {cells[b]!r}",
            )


def _descendants(limits: Limits, pieces: Iterable[str]) -> list[str]:
    found = list(pieces)
    for cell in found:
        found.extend(t for t in dict.fromkeys(limits.system.states[cell].targets) if t not in found)
    return found


def _fit(limits: Limits, cell: str, edges: Edges, exact: Mapping[str, Grid]) -> tuple[np.ndarray, np.ndarray]:
    """The control points of the fit, and the limit points less those of the fit."""
    target = limits.grid(cell, LEVEL)
    degree = next(iter(edges.values())).shape[1] - 1
    basis = bernstein(degree, np.linspace(0, 1, target.shape[1]))
    control = np.zeros((len(target), degree + 1, degree + 1))
    known = np.zeros((degree + 1, degree + 1), dtype=bool)
    for i, side in enumerate(limits.quads[cell].sides):
        curve = embedding_matrix(limits.topology, cell, (side.label,)) @ edges[side.cell]
        _along(control, i, 0)[:] = curve if side.forward else curve[:, ::-1]
        _along(known, i, 0)[:] = True
    for i in range(4):
        slope = _slope(limits, cell, i, exact, degree)
        if slope is not None:
            second = _along(control, i, 0)[:, 1:-1] + slope[:, 1:-1] / degree
            _along(control, i, 1)[:, 1:-1] = second
            _along(known, i, 1)[1:-1] = True
    rest = target - np.einsum("ui,vj,nij->nuv", basis, basis, control)
    inner = np.einsum("ui,vj->uvij", basis, basis)[:, :, ~known].reshape(basis.shape[0] ** 2, -1)
    control[:, ~known] = np.linalg.lstsq(inner, rest.reshape(len(rest), -1).T, rcond=None)[0].T
    difference = target - np.einsum("ui,vj,nij->nuv", basis, basis, control)
    return control, difference.reshape(len(rest), -1)


def _along(table: np.ndarray, side: int, inwards: int) -> np.ndarray:
    """A view of the row of control points along a side, as it is walked; row 0 lies on the side."""
    last = table.shape[-1] - 1
    return (
        table[..., :, inwards],
        table[..., last - inwards, :],
        table[..., ::-1, last - inwards],
        table[..., inwards, ::-1],
    )[side]


def _slope(limits: Limits, cell: str, side: int, exact: Mapping[str, Grid], degree: int) -> np.ndarray | None:
    """The derivative into the cell along a side, as Bernstein coefficients; nothing unless it is polynomial.

    It is read from the two children at the side, which must be polynomial.
    """
    frame, state = limits.quads[cell], limits.system.states[cell]
    begin, end = np.array(CORNERS[side]), np.array(CORNERS[(side + 1) % 4])
    inward = np.array([-(end - begin)[1], (end - begin)[0]]) / 2
    t, values = [], []
    for corner in (begin, end):
        label = next(label for label, square in frame.children.items() if tuple(corner) in square)
        target = state.targets[state.labels.index(label)]
        if target not in exact:
            return None
        origin, along, _, across = (np.array(p) for p in frame.children[label])
        inside = np.linspace(0, 1, degree + 2) / 2
        inside = inside if corner is begin else inside + 0.5
        place = begin + inside[:, None] * (end - begin) - origin
        grid = np.tensordot(state.operators[state.labels.index(label)], exact[target], axes=1)
        along, across = along - origin, across - origin
        by_u, by_v = _gradient(grid, place @ along, place @ across)
        values.append(2 * ((inward @ along) * by_u + (inward @ across) * by_v))
        t.append(inside)
    basis, wanted = bernstein(degree, np.concatenate(t)), np.concatenate(values, axis=1)
    slope = np.linalg.lstsq(basis, wanted.T, rcond=None)[0].T
    if np.abs(slope @ basis.T - wanted).max() > 1e-9:
        return None
    return slope


def _gradient(grid: np.ndarray, u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    degree = grid.shape[1] - 1
    lower, full = partial(bernstein, degree - 1), partial(bernstein, degree)
    by_u = degree * np.einsum("si,sj,nij->ns", lower(u), full(v), np.diff(grid, axis=1))
    by_v = degree * np.einsum("si,sj,nij->ns", full(u), lower(v), np.diff(grid, axis=2))
    return by_u, by_v
