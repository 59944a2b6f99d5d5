"""Which cells of an automaton are polynomial curves and surfaces, and their Bernstein control points.

A quadrangle x is polynomial of bidegree (d, d) when there are matrices M with

    T_i M_child(i) = M_x D_i    for all children i,

where column (i, j) of M_x holds the barycentric coordinates of the Bernstein control point (i, j), and D_i
restricts a polynomial to the quarter of the square that child i covers, seen in the frame of the child. The
limit is then the polynomial itself: both are fixed by the same contraction. Edges likewise, in one variable.
"""

from collections.abc import Mapping
from functools import cache
from math import comb, cos, pi
from typing import TypeVar

import numpy as np
from jaxtyping import Float

from automata.automaton import Word
from automata.topology import Topology, embedding
from export.step.frames import QuadFrame, SegmentFrame, halved_frames
from ifs.certificates.bounds import sample
from ifs.system import State, System

Grid = Float[np.ndarray, "_points _u _v"]
Row = Float[np.ndarray, "_points _u"]

Kept = TypeVar("Kept", QuadFrame, SegmentFrame)

ROUNDING = 1e-10


class Limits:
    """Frames of all cells that have one, and limit points on their dyadic parameter grids.

    `quads` and `segments` hold the frames by cell; `grid(x, L)` is `(points, 2^L + 1, 2^L + 1)`, first index
    u, and `row(x, L)` is `(points, 2^L + 1)`: barycentric columns of limit points, exact to rounding.
    """

    def __init__(self, topology: Topology, system: System):
        self.topology = topology
        self.system = system
        cells = [name for name in system.states if not topology.is_point(name)]
        quads, segments = halved_frames(topology, cells)
        self.quads = _closed_under(quads, system)
        self.segments = _closed_under(segments, system)
        self._sample = sample(system)
        self._known: dict[tuple[str, int], np.ndarray] = {}

    def corner(self, cell: str, path: Word) -> Float[np.ndarray, "_points"]:
        """The limit point at the end of a boundary path."""
        point = self._sample[self.topology.automaton.end(cell, path)]
        return embedding_matrix(self.topology, cell, path) @ point

    def grid(self, cell: str, level: int) -> Grid:
        if (cell, level) not in self._known:
            frame, state = self.quads[cell], self.system.states[cell]
            half = 2**level // 2
            result = np.full((state.points, 2**level + 1, 2**level + 1), np.nan)
            if level == 0:
                for (x, y), path in zip(((0, 0), (1, 0), (1, 1), (0, 1)), frame.corners, strict=True):
                    result[:, x, y] = self.corner(cell, path)
            else:
                index = np.arange(half + 1)
                for label, target, operator in zip(state.labels, state.targets, state.operators, strict=True):
                    x, y = _moved(frame.children[label], index, index, half)
                    result[:, x, y] = np.tensordot(operator, self.grid(target, level - 1), axes=1)
            self._known[cell, level] = result
        return self._known[cell, level]

    def row(self, cell: str, level: int) -> Row:
        if (cell, level) not in self._known:
            frame, state = self.segments[cell], self.system.states[cell]
            if level == 0:
                result = np.stack([self.corner(cell, path) for path in frame.ends], axis=1)
            else:
                parts = []
                for label, forward in frame.halves:
                    target, operator = _child(state, label)
                    part = operator @ self.row(target, level - 1)
                    parts.append(part if forward else part[:, ::-1])
                result = np.concatenate([parts[0], parts[1][:, 1:]], axis=1)
            self._known[cell, level] = result
        return self._known[cell, level]


def polynomial_faces(limits: Limits, highest: int = 3) -> Mapping[str, Grid]:
    """The quadrangles that are polynomial, with their Bernstein control points `(points, d + 1, d + 1)`.

    The degree d is the least, up to `highest`, for which the cell and all that it becomes satisfy the
    identity above, to 1e-10 of the size of the coefficients.

    >>> import ifs
    >>> patch = ifs.shape("doo-sabin-patch")
    >>> found = polynomial_faces(Limits(patch.topology, patch.system))
    >>> found["face"].shape
    (9, 3, 3)
    """
    found: dict[str, np.ndarray] = {}
    for degree in range(1, highest + 1):
        level, nodes = _nodes(degree)
        solve = _interpolation(degree)
        known = {
            cell: np.einsum("ia,jb,nab->nij", solve, solve, limits.grid(cell, level)[:, nodes][:, :, nodes])
            for cell in limits.quads
        }
        kept = _closed(known, limits.system, lambda cell, known: _face_defect(limits, cell, known))
        found.update({cell: known[cell] for cell in kept if cell not in found})
    return found


def polynomial_edges(limits: Limits, highest: int = 3) -> Mapping[str, Row]:
    """The edges that are polynomial, with their Bernstein control points `(points, d + 1)`.

    >>> import ifs
    >>> patch = ifs.shape("catmull-clark-patch")
    >>> found = polynomial_edges(Limits(patch.topology, patch.system))
    >>> (found["edge"] * 6).round(9)[[1, 5, 9], 0]
    array([0.66666667, 2.66666667, 0.66666667])
    """
    found: dict[str, np.ndarray] = {}
    for degree in range(1, highest + 1):
        level, nodes = _nodes(degree)
        solve = _interpolation(degree)
        known = {cell: limits.row(cell, level)[:, nodes] @ solve.T for cell in limits.segments}
        kept = _closed(known, limits.system, lambda cell, known: _edge_defect(limits, cell, known))
        found.update({cell: known[cell] for cell in kept if cell not in found})
    return found


def bernstein(degree: int, t: Float[np.ndarray, "samples"]) -> Float[np.ndarray, "samples coefficients"]:
    """The Bernstein polynomials `C(d, i) t^i (1 - t)^(d - i)` at the given parameters.

    >>> bernstein(2, np.array([0.5]))
    array([[0.25, 0.5 , 0.25]])
    """
    t = t[:, None]
    i = np.arange(degree + 1)
    weights = np.array([comb(degree, int(k)) for k in i], dtype=float)
    return weights * t**i * (1 - t) ** (degree - i)


def elevation(degree: int, higher: int) -> Float[np.ndarray, "_higher _lower"]:
    """The matrix that writes a polynomial of one degree in the Bernstein polynomials of a higher one.

    >>> elevation(1, 2)
    array([[1. , 0. ],
           [0.5, 0.5],
           [0. , 1. ]])
    """
    result = np.zeros((higher + 1, degree + 1))
    for i in range(higher + 1):
        for j in range(max(0, i - higher + degree), min(degree, i) + 1):
            result[i, j] = comb(degree, j) * comb(higher - degree, i - j) / comb(higher, i)
    return result


def embedding_matrix(
    topology: Topology, cell: str, path: Word
) -> Float[np.ndarray, "_points _boundary_points"]:
    """The embedding along a boundary path as numbers."""
    columns = embedding(topology.automaton, cell, path)
    result = np.zeros((topology.automaton.cells[cell].points, len(columns)))
    for place, column in enumerate(columns):
        for row, value in column:
            result[row, place] = float(value)
    return result


def _closed_under(frames: Mapping[str, Kept], system: System) -> dict[str, Kept]:
    """The cells whose descendants all have frames of the kind."""
    kept = dict(frames)
    while True:
        lost = [name for name in kept if not all(t in kept for t in system.states[name].targets)]
        if not lost:
            return kept
        for name in lost:
            del kept[name]


def _closed(known: Mapping[str, np.ndarray], system: System, defect) -> set[str]:
    """The largest set of cells without defect whose children are all in the set."""
    kept = {cell for cell in known if defect(cell, known) <= ROUNDING * max(1.0, np.abs(known[cell]).max())}
    while True:
        lost = {cell for cell in kept if not set(system.states[cell].targets) <= kept}
        if not lost:
            return kept
        kept -= lost


def _face_defect(limits: Limits, cell: str, known: Mapping[str, np.ndarray]) -> float:
    """The largest entry of `T_i M_child(i) - M_x D_i`."""
    frame: QuadFrame = limits.quads[cell]
    state, own = limits.system.states[cell], known[cell]
    degree = own.shape[1] - 1
    level, nodes = _nodes(degree)
    t, solve = nodes / 2**level, _interpolation(degree)
    worst = 0.0
    for label, target, operator in zip(state.labels, state.targets, state.operators, strict=True):
        x, y = _moved(frame.children[label], t, t, 1)
        u, v = bernstein(degree, x.ravel() / 2), bernstein(degree, y.ravel() / 2)
        values = np.einsum("ki,kj,nij->nk", u, v, own).reshape(-1, *x.shape)
        restricted = np.einsum("ia,jb,nab->nij", solve, solve, values)
        moved = np.tensordot(operator, known[target], axes=1)
        worst = max(worst, float(np.abs(moved - restricted).max()))
    return worst


def _edge_defect(limits: Limits, cell: str, known: Mapping[str, np.ndarray]) -> float:
    frame: SegmentFrame = limits.segments[cell]
    state, own = limits.system.states[cell], known[cell]
    degree = own.shape[1] - 1
    level, nodes = _nodes(degree)
    t, solve = nodes / 2**level, _interpolation(degree)
    worst = 0.0
    for side, (label, forward) in enumerate(frame.halves):
        target, operator = _child(state, label)
        values = own @ bernstein(degree, (side + (t if forward else 1 - t)) / 2).T
        worst = max(worst, float(np.abs(operator @ known[target] - values @ solve.T).max()))
    return worst


def _child(state: State, label: str) -> tuple[str, np.ndarray]:
    i = state.labels.index(label)
    return state.targets[i], state.operators[i]


def _moved(square, u: np.ndarray, v: np.ndarray, scale: int) -> tuple[np.ndarray, np.ndarray]:
    """The points (u, v) of a child in its parent, whose side is 2 `scale` where the child's is `scale`."""
    origin, along, _, across = (np.array(corner) for corner in square)
    place = [
        scale * origin[k] + (along - origin)[k] * u[:, None] + (across - origin)[k] * v[None, :]
        for k in (0, 1)
    ]
    return place[0], place[1]


@cache
def _nodes(degree: int) -> tuple[int, np.ndarray]:
    """A level, and degree + 1 points of its dyadic grid at which a polynomial is interpolated."""
    level = (degree - 1).bit_length() + 1
    nodes = [round(2**level * (1 - cos(pi * k / degree)) / 2) for k in range(degree + 1)]
    return level, np.array(nodes)


@cache
def _interpolation(degree: int) -> np.ndarray:
    """The matrix from the values at the nodes to Bernstein control points."""
    level, nodes = _nodes(degree)
    return np.linalg.inv(bernstein(degree, nodes / 2**level))
