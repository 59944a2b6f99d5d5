"""Boxes that are certain to contain attractors, and the extents of shapes in space."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType

import numpy as np
from jaxtyping import Float

from ifs.certificates.convergence import RECENT, require_contraction
from ifs.error import EmptyAttractor, NotContracting
from ifs.system import State, System

_EPS = float(np.finfo(np.float64).eps)
_STILL = 1e-13  # relative change at which the boxes count as settled
_ROUNDS = 200
_ENTRIES = 100_000  # numbers in the operators of all words of one length, at most
_LETTERS = 12
_BLOCK = 2048  # pieces whose extents are computed together: what a cache holds
_PRODUCTS = 1e-14  # rounding of the products of that many operators, relative

_Column = Float[np.ndarray, "_points"]
_Operators = Float[np.ndarray, "_words _target_points _points"]
_Table = dict[str, dict[str, _Operators]]


@dataclass(frozen=True)
class Box:
    """Barycentric columns p with `lo <= p <= hi` and `sum p = 1`: a set around an attractor."""

    lo: Float[np.ndarray, "points"]
    hi: Float[np.ndarray, "points"]


def sample(system: System) -> Mapping[str, Float[np.ndarray, "_points"]]:
    """One point of each cell's attractor: that of the address that takes first labels for ever.

    The address ends in a cycle w, whose point is the solution of `T_w p = p`, `sum p = 1`; the
    letters before the cycle carry it to the other cells. `column @ control` is the point in space.
    Raises `EmptyAttractor` for a cell without subdivision and `NotContracting` where T_w leaves
    more than one point fixed.

    >>> import numpy as np
    >>> from ifs.system import State, System
    >>> halves = (np.array([[1, 0.5], [0, 0.5]]), np.array([[0.5, 0], [0.5, 1]]))
    >>> segment = State("segment", 2, ("0", "1"), ("segment", "segment"), halves)
    >>> sample(System("segment", {"segment": segment}))["segment"]
    array([1., 0.])
    """
    columns: dict[str, _Column] = {}
    for name in system.states:
        trail: list[str] = []
        cell = name
        while cell not in columns and cell not in trail:
            trail.append(cell)
            cell = _subdivided(system, cell).targets[0]
        if cell not in columns:
            cycle = trail[trail.index(cell) :]
            columns[cell] = _fixed_point([system.states[other] for other in cycle])
        for cell in reversed(trail):
            if cell not in columns:
                state = system.states[cell]
                columns[cell] = state.operators[0] @ columns[state.targets[0]]
    return {name: columns[name] for name in system.states}


@lru_cache(maxsize=RECENT)
def bounds(system: System) -> Mapping[str, Box]:
    """For each cell a box that contains its attractor, as tight as iterating boxes makes it.

    The start is [0, 1] when no operator has a negative entry (simplices then map into simplices),
    else the balls that the certificate of convergence gives. Each round replaces the box of x by
    the box around all `T_i (box of the i-th sub-cell)`, which is exact for each coordinate (see
    `extent`), until nothing changes; then the same with words of several letters, which
    rotations need. Attractors whose hull has its sides along coordinates get their exact box, to
    rounding.

    Raises `NotContracting` or `Undecided` when there is no certificate, `EmptyAttractor` for a
    cell without subdivision.

    >>> import numpy as np
    >>> from ifs.system import State, System
    >>> thirds = (np.array([[1, 2 / 3], [0, 1 / 3]]), np.array([[1 / 3, 0], [2 / 3, 1]]))
    >>> cantor = State("cantor", 2, ("0", "1"), ("cantor", "cantor"), thirds)
    >>> bounds(System("cantor", {"cantor": cantor}))["cantor"].hi
    array([1., 1.])
    """
    for name in system.states:
        _subdivided(system, name)
    operators = [operator for state in system.states.values() for operator in state.operators]
    if all((operator >= 0).all() for operator in operators):
        boxes = {
            name: Box(np.zeros(state.points), np.ones(state.points)) for name, state in system.states.items()
        }
    else:
        boxes = _balls(system)
    table = _letters(system)
    boxes = _tightened(boxes, table)
    return MappingProxyType(_tightened(boxes, _long_words(table), _PRODUCTS))


def extent(
    box: Box, control: Float[np.ndarray, "count points dim"]
) -> tuple[Float[np.ndarray, "count dim"], Float[np.ndarray, "count dim"]]:
    """The bounding boxes (lo, hi), in mm, of attractors with the given control points.

    `control` holds the control points of many pieces of one cell, `box` the cell's box. Each side
    is the exact extreme of `sum_j p_j c_j` over `lo <= p <= hi, sum p = 1`: from p = lo, the mass
    left goes to the smallest (largest) coordinates first. The result is moved outwards by some
    units in the last place (about `1e-15 * points * |p|` of the distances between the control
    points and of their size), so that it contains the attractor in spite of rounding.

    >>> import numpy as np
    >>> square = np.array([[[0.0, 0], [9, 0], [9, 6], [0, 6]]])
    >>> lo, hi = extent(Box(np.zeros(4), np.full(4, 0.5)), square)
    >>> bool(np.allclose(lo, 0) and np.allclose(hi, [9, 6]))
    True
    >>> lo, hi = extent(Box(np.full(4, 0.25), np.full(4, 0.25)), square)
    >>> bool(np.allclose(lo, [4.5, 3]) and np.allclose(hi, [4.5, 3]))
    True
    """
    if (box.lo == 0).all() and (box.hi == 1).all():
        return control.min(axis=1), control.max(axis=1)
    lo = np.empty((len(control), control.shape[2]))
    hi = np.empty_like(lo)
    for start in range(0, len(control), _BLOCK):
        block = slice(start, start + _BLOCK)
        lo[block], hi[block] = _extremes(box, np.ascontiguousarray(control[block].swapaxes(1, 2)))
    return lo, hi


def _extremes(
    box: Box, coordinates: Float[np.ndarray, "count dim points"]
) -> tuple[Float[np.ndarray, "count dim"], Float[np.ndarray, "count dim"]]:
    """The least and the largest `sum_j p_j c_j` over the box, moved outwards against rounding."""
    points = coordinates.shape[2]
    room = box.hi - box.lo
    mass = 1.0 - box.lo.sum()
    if np.ptp(box.lo) == 0 and np.ptp(box.hi) == 0:
        ordered = np.sort(coordinates, axis=2)
        origin = ordered[:, :, :1].copy()
        ordered -= origin
        fill = np.clip(mass - room[0] * np.arange(points), 0.0, room[0])
        lowest, highest = ordered @ (box.lo + fill), ordered @ (box.lo + fill[::-1])
    else:
        order = np.argsort(coordinates, axis=2, kind="stable")
        ordered = np.take_along_axis(coordinates, order, axis=2)
        origin = ordered[:, :, :1].copy()
        ordered -= origin
        rooms = room[order]
        base = np.einsum("cdj,cdj->cd", box.lo[order], ordered)
        upto = np.cumsum(rooms, axis=2)
        first = np.clip(mass - (upto - rooms), 0.0, rooms)
        final = np.clip(mass - (upto[:, :, -1:] - upto), 0.0, rooms)
        lowest = base + np.einsum("cdj,cdj->cd", first, ordered)
        highest = base + np.einsum("cdj,cdj->cd", final, ordered)
    reach = 1.0 + float(np.maximum(np.abs(box.lo), np.abs(box.hi)).sum())
    slack = 4 * (points + 2) * _EPS * reach * ordered[:, :, -1] + 4 * _EPS * np.abs(origin[:, :, 0])
    return origin[:, :, 0] + lowest - slack, origin[:, :, 0] + highest + slack


def _subdivided(system: System, name: str) -> State:
    state = system.states[name]
    if not state.labels:
        raise EmptyAttractor(name)
    return state


def _fixed_point(cycle: list[State]) -> _Column:
    product = np.eye(cycle[0].points)
    for state in cycle:
        product = product @ state.operators[0]
    linear = product[:-1, :-1] - product[:-1, -1:]
    try:
        first = np.linalg.solve(np.eye(len(linear)) - linear, product[:-1, -1])
    except np.linalg.LinAlgError:
        word = tuple(state.labels[0] for state in cycle)
        raise NotContracting(cycle[0].name, word, 1.0) from None
    return np.append(first, 1 - first.sum())


def _balls(system: System) -> dict[str, Box]:
    """Boxes around the balls, in each component's norm, that its rate and constant imply.

    A point of the attractor at x is `c_x + sum_k L_(s1..sk) d_k`, where c_x is the sample of x and
    `d = T_i c_y - c_x`; so inside a component it is no farther than `constant * max |d| /
    (1 - rate)`, and where the address leaves for an earlier component after k letters, the rest
    weighs at most `constant * rate^k` times its own distance.
    """
    centres = sample(system)
    boxes: dict[str, Box] = {}
    for part in require_contraction(system).components:
        inner = outer = 0.0
        for name in part.cells:
            state, factor = system.states[name], part.factors[name]
            for target, operator in zip(state.targets, state.operators, strict=True):
                if target in part.cells:
                    moved = operator @ centres[target] - centres[name]
                    inner = max(inner, float(np.linalg.norm(factor @ moved[:-1])))
                else:
                    lo, hi = extent(boxes[target], operator.T[None])
                    farthest = np.maximum(hi[0] - centres[name], centres[name] - lo[0])[:-1]
                    outer = max(outer, float(np.linalg.norm(np.abs(factor) @ farthest)))
        radius = part.constant * max(inner / (1 - part.rate), outer)
        for name in part.cells:
            inverse = np.linalg.inv(part.factors[name])
            rows = np.vstack([inverse, -inverse.sum(axis=0)])
            half = np.linalg.norm(rows, axis=1) * radius
            half = half * (1 + 1e-6) + 1e-9 * (1 + np.abs(centres[name]))
            boxes[name] = Box(centres[name] - half, centres[name] + half)
    return boxes


def _letters(system: System) -> _Table:
    """The transposed operators of each cell by target: the control points of its sub-cells."""
    table: _Table = {}
    for name, state in system.states.items():
        found: dict[str, list[np.ndarray]] = {}
        for target, operator in zip(state.targets, state.operators, strict=True):
            found.setdefault(target, []).append(np.asarray(operator, dtype=np.float64).T)
        table[name] = {target: np.stack(same) for target, same in found.items()}
    return table


def _long_words(table: _Table) -> _Table:
    """The same for the words of the greatest length at which they stay few."""
    powers = table
    for _ in range(_LETTERS):
        entries = sum(
            len(words) * len(last) * last.shape[1] * words.shape[2]
            for row in powers.values()
            for middle, words in row.items()
            for last in table[middle].values()
        )
        if entries > _ENTRIES:
            break
        powers = {name: _one_letter_more(row, table) for name, row in powers.items()}
    return powers


def _one_letter_more(row: dict[str, _Operators], table: _Table) -> dict[str, _Operators]:
    found: dict[str, list[np.ndarray]] = {}
    for middle, words in row.items():
        for target, last in table[middle].items():
            products = last[None] @ words[:, None]
            found.setdefault(target, []).append(products.reshape(-1, *products.shape[2:]))
    return {target: np.concatenate(same) for target, same in found.items()}


def _tightened(boxes: Mapping[str, Box], table: _Table, rounding: float = 0.0) -> dict[str, Box]:
    """Rounds of boxes around the images of boxes, each inside the one before."""
    current = dict(boxes)
    for _ in range(_ROUNDS):
        change = 0.0
        for name, row in table.items():
            extents = [extent(current[target], words) for target, words in row.items()]
            lo = np.min([low.min(axis=0) for low, _ in extents], axis=0)
            hi = np.max([high.max(axis=0) for _, high in extents], axis=0)
            old = current[name]
            size = float(max(np.abs(lo).max(), np.abs(hi).max()))
            lo = np.maximum(lo - rounding * size, old.lo)
            hi = np.minimum(hi + rounding * size, old.hi)
            change = max(change, float(max((lo - old.lo).max(), (old.hi - hi).max())) / size)
            current[name] = Box(lo, hi)
        if change <= _STILL:
            break
    return current
