"""How far what is drawn at a depth may be from the attractor: certified Hausdorff distances."""

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from ifs.asked import require_shape, require_whole
from ifs.certificates.bounds import Box, bounds, extent, sample
from ifs.certificates.convergence import require_contraction
from ifs.pieces import pieces
from ifs.shape import Shape
from ifs.system import System

MOST_PIECES = 100_000
_WORDS = 5000
_ROUNDING = 1 + 1e-9

Columns = Float[np.ndarray, "_points _count"]
Table = Mapping[tuple[str, str], float]


def hausdorff_error(shape: Shape, depth: int, drawn: Mapping[str, Columns] | None = None) -> float:
    """A bound, in mm, of the Hausdorff distance between the attractor and what is drawn at a depth.

    Every piece of `depth` letters draws the points `drawn[cell]` (barycentric columns), and may draw anything
    in their convex hull besides; by default one point of the attractor (`ifs.sample`), with `control_figures`
    the control points. The distance is at most the largest, over the pieces, of two numbers: the distance
    from the best drawn point to the farthest corner of the box of the piece; the largest distance of a drawn
    point from a point of the attractor.

    Up to 100000 pieces are looked at one by one. Beyond that depth the letters that are left multiply the
    largest distance between control points by at most the largest of `tau(T_w) = 1/2 max_jk sum_l |T_lj -
    T_lk|` over the words w. Raises `ValueError` for a depth below 0 or drawn points that do not fit,
    `NotContracting` or `Undecided`.

    >>> from ifs.shape import shape
    >>> koch = shape("koch-curve")
    >>> errors = [hausdorff_error(koch, depth) for depth in (2, 5, 40)]
    >>> round(errors[0] / errors[1], 6), errors[2] < 1e-12
    (27.0, True)
    """
    require_shape(shape)
    require_whole("depth", depth)
    require_contraction(shape.system)
    columns = sample(shape.system)
    figures = {cell: column[:, None] for cell, column in columns.items()} | dict(drawn or {})
    _check(shape.system, figures)
    first = _affordable(shape.system, depth)
    table = bounds(shape.system)
    spreads: dict[str, float] = {}
    largest = 0.0
    for group in pieces(shape.system, shape.control, depth=first):
        control = group.control
        if first == depth:
            errors = _errors(table[group.cell], control, figures[group.cell], columns[group.cell])
            largest = max(largest, float(errors.max()))
        else:
            spread = float(_spread(control).max())
            spreads[group.cell] = max(spreads.get(group.cell, 0.0), spread)
    if first == depth:
        return largest * _ROUNDING
    factors = _long_words(shape.system, depth - first)
    return _ROUNDING * max(
        spread * factors.get((cell, target), 0.0) * _share(table[target], figures[target], columns[target])
        for cell, spread in spreads.items()
        for target in shape.system.states
    )


def control_figures(system: System) -> Mapping[str, Columns]:
    """What draws the control points of every piece, or anything in their hull: the columns of the identity.

    >>> from ifs.shape import shape
    >>> control_figures(shape("koch-curve").system)["edge"].shape
    (3, 3)
    """
    return {name: np.eye(state.points) for name, state in system.states.items()}


def _check(system: System, figures: Mapping[str, Columns]) -> None:
    for cell, columns in figures.items():
        if cell not in system.states:
            raise ValueError(f"there is no cell {cell!r}; there are {', '.join(system.states)}")
        expected = system.states[cell].points
        if columns.ndim != 2 or len(columns) != expected or columns.shape[1] == 0:
            raise ValueError(
                f"cell {cell!r} draws columns of {expected} coordinates; got shape {columns.shape}"
            )
        sums = columns.sum(axis=0)
        if not (np.abs(sums - 1) <= 1e-9).all():
            wrong = int(np.argmax(np.abs(sums - 1)))
            raise ValueError(f"column {wrong} of cell {cell!r} must sum to 1; it sums to {sums[wrong]:.12g}")


def _errors(
    box: Box,
    control: Float[np.ndarray, "pieces points dim"],
    figure: Columns,
    column: Float[np.ndarray, "points"],
) -> Float[np.ndarray, "pieces"]:
    lo, hi = extent(box, control)
    places = np.einsum("pk,npd->nkd", figure, control)
    corner = np.maximum(np.abs(lo[:, None] - places), np.abs(hi[:, None] - places))
    reach = np.linalg.norm(corner, axis=2).min(axis=1)
    known = np.einsum("p,npd->nd", column, control)
    return np.maximum(reach, np.linalg.norm(places - known[:, None], axis=2).max(axis=1))


def _share(box: Box, figure: Columns, column: Float[np.ndarray, "points"]) -> float:
    """The same for control points at distances of at most 1: `|p C - v C| <= 1/2 sum |p - v|`."""
    wide = np.maximum(np.abs(box.lo[:, None] - figure), np.abs(box.hi[:, None] - figure))
    away = np.abs(figure - column[:, None])
    return max(float(wide.sum(axis=0).min()), float(away.sum(axis=0).max())) / 2


def _spread(control: Float[np.ndarray, "pieces points dim"]) -> Float[np.ndarray, "pieces"]:
    return np.linalg.norm(control[:, :, None] - control[:, None], axis=3).max(axis=(1, 2))


def _affordable(system: System, depth: int) -> int:
    """The greatest depth, up to the given one, with at most 100000 pieces."""
    counts = {system.shape: 1}
    for level in range(depth):
        following: dict[str, int] = {}
        for cell, count in counts.items():
            for target in system.states[cell].targets:
                following[target] = following.get(target, 0) + count
        if sum(following.values()) > MOST_PIECES:
            return level
        counts = following
    return depth


def _long_words(system: System, letters: int) -> dict[tuple[str, str], float]:
    """A bound of tau over the words of so many letters, from cell to cell: blocks, multiplied."""
    words = {(name, name): np.eye(state.points)[None] for name, state in system.states.items()}
    tables: list[dict[tuple[str, str], float]] = [dict.fromkeys(words, 1.0)]
    while len(tables) <= letters and sum(len(found) for found in words.values()) <= _WORDS:
        longer: dict[tuple[str, str], list[np.ndarray]] = {}
        for (start, middle), products in words.items():
            state = system.states[middle]
            for operator, target in zip(state.operators, state.targets, strict=True):
                longer.setdefault((start, target), []).append(products @ operator)
        words = {ends: np.concatenate(found) for ends, found in longer.items()}
        tables.append({ends: float(_tau(products).max()) for ends, products in words.items()})
        if len(tables) > 64:
            break
    block = len(tables) - 1
    result = tables[letters % block]
    for _ in range(letters // block):
        result = _composed(result, tables[block])
    return result


def _composed(one: Table, other: Table) -> dict[tuple[str, str], float]:
    result: dict[tuple[str, str], float] = {}
    for (start, middle), x in one.items():
        for (begin, end), y in other.items():
            if begin == middle:
                result[start, end] = max(result.get((start, end), 0.0), x * y)
    return result


def _tau(products: Float[np.ndarray, "words rows columns"]) -> Float[np.ndarray, "words"]:
    return np.abs(products[:, :, :, None] - products[:, :, None, :]).sum(axis=1).max(axis=(1, 2)) / 2
