"""The patches that leave as faces: exact ones as large as they come, rings of smaller ones, fitted ones."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from export.step.error import TooManyFaces
from export.step.fit import Surfaces
from ifs.complex import Complex, refine_traced
from ifs.subcomplex import subcomplex

MOST_FACES = 20_000
DIAGONAL = 4  # the "side" of a plane triangle from (1, 0) to (0, 1)
Ids = Int[np.ndarray, "_cells"]


class Use(NamedTuple):
    """An edge on a side of a face: walked forward or not, and the part of the side, from t0 to t1."""

    edge: int
    forward: bool
    side: int
    t0: float
    t1: float


@dataclass(frozen=True)
class Leaf:
    """A face: its Bernstein control points in mm, whether it is exact, and its edges around it in order.

    A `plane` face is the triangle of the control points (0, 0), (1, 0) and (0, 1).
    """

    control: Float[np.ndarray, "_u _v 3"]
    exact: bool
    uses: tuple[Use, ...]
    plane: bool = False


class _Side(NamedTuple):
    edge: int
    forward: bool


class _Edges:
    """All edges of all levels, numbered; `halves[e]` are the two edges that e became, in its direction."""

    def __init__(self) -> None:
        self.total = 0
        self.halves: dict[int, tuple[_Side, _Side]] = {}

    def numbered(self, complex_: Complex, segments: Mapping) -> dict[str, Ids]:
        result = {}
        for cell, count in complex_.counts.items():
            if cell in segments:
                result[cell] = np.arange(self.total, self.total + count)
                self.total += count
        return result


def leaves(
    complex_: Complex, found: Surfaces, tolerance: float, most: int = MOST_FACES
) -> tuple[list[Leaf], float, int]:
    """The faces, the largest distance in mm between limit points and fits, and the number of levels.

    A fitted patch is subdivided, with all those around the same extraordinary points, until its fit lies
    within `tolerance` at equal parameters. A side next to smaller faces is cut into their edges, so that each
    edge is shared by two faces. Raises `TooManyFaces` for over `most`.
    """
    edges, flat, worst, level = _Edges(), [], 0.0, 0
    numbers = edges.numbered(complex_, found.limits.segments)
    while True:
        keep, parts, error = _sorted(complex_, found, numbers, tolerance)
        flat.extend(parts)
        worst = max(worst, error)
        waiting = sum(len(ids) for ids in keep.values())
        if len(flat) + 4 * waiting > most:
            raise TooManyFaces(len(flat) + 4 * waiting, most, "ask for a larger tolerance")
        if not waiting:
            break
        part, kept = subcomplex(complex_, keep)
        numbers = {cell: numbers[cell][kept[cell]] for cell in part.counts if cell in numbers}
        complex_, numbers = _halved(part, found, numbers, edges)
        level += 1
    return _cut(flat, edges), worst, level


def _sorted(
    complex_: Complex, found: Surfaces, numbers: Mapping[str, Ids], tolerance: float
) -> tuple[dict[str, Ids], list[tuple[np.ndarray, bool, list[_Side]]], float]:
    """The pieces to be subdivided further, and the faces among the others with their sides."""
    sides = {cell: _sides(complex_, found, cell, numbers) for cell in complex_.control}
    split = {cell: _has_seam(number) for cell, (number, _) in sides.items()}
    rough, errors = [], {}
    for cell in sides:
        if cell in found.fitted:
            errors[cell] = _errors(found.differences[cell], complex_.control[cell])
            split[cell] = split[cell] | (errors[cell] > tolerance)
            rough.append(cell)
    _spread(rough, sides, split)
    parts, worst = [], 0.0
    for cell, (number, forward) in sides.items():
        exact = cell in found.exact
        weights = found.exact[cell] if exact else found.fitted[cell]
        done = np.flatnonzero(~split[cell])
        control = np.einsum("nij,cnd->cijd", weights, complex_.control[cell][done])
        control = np.pad(control, ((0, 0), (0, 0), (0, 0), (0, 3 - control.shape[3])))
        for piece, points in zip(done, control, strict=True):
            around = [_Side(int(e), bool(f)) for e, f in zip(number[piece], forward[piece], strict=True)]
            parts.append((points, exact, around))
        if not exact and len(done):
            worst = max(worst, float(errors[cell][done].max()))
    return {cell: np.flatnonzero(rest) for cell, rest in split.items() if rest.any()}, parts, worst


def _sides(complex_: Complex, found: Surfaces, cell: str, numbers: Mapping[str, Ids]):
    """The edges of all pieces of a cell, `(pieces, 4)`, and whether each is walked forward."""
    topology = complex_.topology
    columns, directions = [], []
    for side in found.limits.quads[cell].sides:
        ends = found.limits.segments[side.cell].ends
        coincident = topology.coincident(side.cell)
        first = coincident[ends[0]][0]
        same = np.array(
            [
                coincident[topology.groups.normal(side.cell, ends[0], element)[0]][0] == first
                for element in topology.groups.elements[side.cell]
            ]
        )
        seen = complex_.boundary[cell][side.label].take(np.arange(len(complex_.control[cell])))
        columns.append(numbers[side.cell][seen.ids])
        directions.append(same[seen.turn] == side.forward)
    return np.stack(columns, axis=1), np.stack(directions, axis=1)


def _has_seam(number: np.ndarray) -> np.ndarray:
    """The pieces that have one edge twice: a face cannot border itself."""
    ordered = np.sort(number, axis=1)
    return (ordered[:, 1:] == ordered[:, :-1]).any(axis=1)


def _errors(difference: np.ndarray, control: np.ndarray) -> np.ndarray:
    """The largest distance of each piece's limit points from its fit, in mm."""
    if not len(control):
        return np.zeros(0)
    return np.linalg.norm(np.einsum("ns,cnd->csd", difference, control), axis=2).max(axis=1)


def _spread(rough: list[str], sides: Mapping, split: dict[str, np.ndarray]) -> None:
    """Fitted patches that share an edge are subdivided together."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    if not rough:
        return
    number = np.concatenate([sides[cell][0] for cell in rough])
    wanted = np.concatenate([split[cell] for cell in rough])
    pieces = len(number)
    _, edge = np.unique(number, return_inverse=True)
    edge = edge.reshape(-1) + pieces
    size = int(edge.max()) + 1
    links = coo_array((np.ones(len(edge)), (np.repeat(np.arange(pieces), 4), edge)), shape=(size, size))
    _, group = connected_components(links, directed=False)
    group = group[:pieces]
    wanted = np.isin(group, np.unique(group[wanted]))
    start = 0
    for cell in rough:
        split[cell] = wanted[start : start + len(split[cell])]
        start += len(split[cell])


def _halved(
    part: Complex, found: Surfaces, numbers: Mapping[str, Ids], edges: _Edges
) -> tuple[Complex, dict[str, Ids]]:
    """One subdivision, and the two edges that each edge became."""
    finer, numbered = refine_traced(part)
    new = edges.numbered(finer, found.limits.segments)
    for cell, old in numbers.items():
        halves = []
        for label, forward in found.limits.segments[cell].halves:
            ids = numbered(cell, label, np.arange(len(old)))
            target = part.topology.automaton.cells[cell].subdivision[label]
            halves.append([_Side(int(e), forward) for e in new[target][ids]])
        edges.halves.update(zip(old.tolist(), zip(*halves, strict=True), strict=True))
    return finer, new


def _cut(flat: list[tuple[np.ndarray, bool, list[_Side]]], edges: _Edges) -> list[Leaf]:
    """The faces with their sides cut wherever a smaller face lies on the other side."""
    cut = np.zeros(edges.total, dtype=bool)
    below = np.zeros(edges.total, dtype=bool)
    for _, _, around in flat:
        below[[side.edge for side in around]] = True
    for edge in sorted(edges.halves, reverse=True):
        cut[edge] = any(below[half.edge] for half in edges.halves[edge])
        below[edge] |= cut[edge]
    return [
        Leaf(
            control, exact, tuple(use for i, side in enumerate(around) for use in _parts(side, i, cut, edges))
        )
        for control, exact, around in flat
    ]


def _parts(side: _Side, number: int, cut: np.ndarray, edges: _Edges, t0: float = 0.0, t1: float = 1.0):
    """The edges along a side, in the order in which the face is walked."""
    if not cut[side.edge]:
        yield Use(side.edge, side.forward, number, t0, t1)
        return
    middle = (t0 + t1) / 2
    first, second = edges.halves[side.edge]
    halves = (first, second) if side.forward else (second, first)
    for half, (a, b) in zip(halves, ((t0, middle), (middle, t1)), strict=True):
        yield from _parts(_Side(half.edge, half.forward == side.forward), number, cut, edges, a, b)
