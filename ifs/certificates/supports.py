"""How far an attractor reaches in any direction, bounded from outside, and a point that reaches there."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import product

import numpy as np
from jaxtyping import Float, Real

from ifs.certificates.bounds import bounds, extent, sample
from ifs.shape import Shape
from ifs.system import System

TOLERANCE = 1e-3
MOST_PIECES = 20_000
_DEEPEST = 200
_EPS = float(np.finfo(np.float64).eps)
_THICKENED = 1e-9  # of the size: what keeps a flat hull from being too thin to be computed

Control = Float[np.ndarray, "_pieces _points _dim"]
Places = Float[np.ndarray, "_pieces _dim"]
Values = Float[np.ndarray, "_pieces"]


@dataclass(frozen=True)
class Farthest:
    """The largest value on an attractor lies in `[inner, outer]`; `point` (mm) has the value `inner`."""

    outer: float
    inner: float
    point: Float[np.ndarray, "dim"]


@dataclass(frozen=True)
class Hull:
    """A polytope around an attractor: the x with `directions @ x <= outer`, in mm.

    `directions` are unit rows; `touching[k]` is a point of the attractor at height `inner[k]` in direction k,
    so that the true support lies in `[inner, outer]`.
    """

    directions: Float[np.ndarray, "faces dim"]
    outer: Float[np.ndarray, "faces"]
    inner: Float[np.ndarray, "faces"]
    touching: Float[np.ndarray, "faces dim"]

    @property
    def looseness(self) -> float:
        """How far, in mm, a face may be from touching the attractor, at most."""
        return float((self.outer - self.inner).max())

    def contains(self, points: Real[np.ndarray, "n dim"]) -> np.ndarray:
        """Which points (mm) lie in the polytope."""
        return np.asarray((np.asarray(points, dtype=float) @ self.directions.T <= self.outer).all(axis=1))

    def vertices(self) -> np.ndarray:
        """The corners of the polytope, in mm, `(n, dim)`, its faces moved out by 1e-9 of its size.

        Raises `ValueError` when the directions leave it unbounded.
        """
        from scipy.spatial import HalfspaceIntersection

        size = float(np.ptp(self.touching, axis=0).max()) + float(np.abs(self.touching).max()) * 1e-3 + 1e-300
        dim = self.directions.shape[1]
        if np.linalg.matrix_rank(self.directions) < dim or not _bounded(self.directions):
            raise ValueError(
                f"the {len(self.directions)} directions leave the polytope unbounded: add opposite ones"
            )
        centre = self.touching.mean(axis=0)
        distances = self.outer - self.directions @ centre + _THICKENED * size
        if dim == 1:
            return centre + np.array([[-distances[self.directions[:, 0] < 0].min()],
                                      [distances[self.directions[:, 0] > 0].min()]])  # fmt: skip
        faces = np.column_stack([self.directions, -distances / size])
        return centre + size * HalfspaceIntersection(faces, np.zeros(dim)).intersections


def hull(
    shape: Shape,
    directions: Real[np.ndarray, "faces dim"] | None = None,
    tolerance: float = TOLERANCE,
    cell: str | None = None,
    control: Real[np.ndarray, "points dim"] | None = None,
) -> Hull:
    """A polytope that contains the attractor, with one face for each direction.

    The support function `h_x(c) = max over the attractor of sum_j p_j c_j` of cell x satisfies `h_x(c) =
    max_i h_y(T_i^T c)`, c the heights of the control points. The equation is unrolled from outside: a piece
    is bounded by its box, and subdivided while that bound exceeds the farthest known point by more than
    `tolerance` times the extent of the control points. So each face is loose by that at most, unless 20000
    pieces are not enough; `Hull.looseness` says what was reached. By default the directions are those to the
    neighbours in a grid: 8 in the plane, 26 in space. With `cell` and `control` the attractor is that of
    another cell of the shape with control points of its own.

    The faces are moved outwards against rounding. Raises `NotContracting` or `Undecided`, `ValueError` for
    directions that are 0 or do not fit.

    >>> from ifs.shape import shape
    >>> found = hull(shape("koch-curve"), np.array([[0, 1], [0, -1], [1, 0], [-1, 0]]))
    >>> found.outer.round(6).tolist()
    [25.980762, 0.0, 90.0, 0.0]
    """
    cell, points = placed(shape, cell, control)
    dim = points.shape[1]
    rows = grid_directions(dim) if directions is None else np.asarray(directions, dtype=float)
    lengths = np.linalg.norm(rows, axis=1) if rows.ndim == 2 else np.zeros(0)
    if rows.ndim != 2 or rows.shape[1] != dim or not len(rows):
        raise ValueError(f"directions are rows of {dim} coordinates; got an array of shape {rows.shape}")
    if not (np.isfinite(lengths) & (lengths > 0)).all():
        wrong = int(np.flatnonzero(~(np.isfinite(lengths) & (lengths > 0)))[0])
        raise ValueError(f"direction {wrong} has no direction: {rows[wrong]}")
    rows = rows / lengths[:, None]
    table, columns = bounds(shape.system), sample(shape.system)
    found = []
    for row in rows:

        def bound(state: str, controls: Control, row: Float[np.ndarray, "dim"] = row) -> Values:
            return extent(table[state], (controls @ row)[:, :, None])[1][:, 0]

        found.append(
            farthest(
                shape.system, columns, cell, points, bound, lambda places, row=row: places @ row, tolerance
            )
        )
    return Hull(
        rows,
        np.array([f.outer for f in found]),
        np.array([f.inner for f in found]),
        np.array([f.point for f in found]),
    )


def grid_directions(dim: int) -> Float[np.ndarray, "faces dim"]:
    """The unit vectors to the neighbours in a grid of squares or cubes: 2, 8 or 26.

    >>> len(grid_directions(3))
    26
    """
    rows = np.array([row for row in product((-1.0, 0.0, 1.0), repeat=dim) if any(row)])
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


def farthest(
    system: System,
    columns: Mapping[str, Float[np.ndarray, "_points"]],
    cell: str,
    control: Float[np.ndarray, "points dim"],
    bound: Callable[[str, Control], Values],
    value: Callable[[Places], Values],
    tolerance: float,
) -> Farthest:
    """The largest value of a function on an attractor, by branch and bound.

    `bound(cell, control points of pieces)` bounds it on pieces from above, `value(points)` gives it;
    `columns` are points of the attractors (`ifs.sample`). The tolerance is a part of the extent of the
    control points.
    """
    size = float(np.ptp(control, axis=0).max())
    slack = tolerance * size
    noise = 16 * _EPS * (float(np.abs(control).max()) + size) * len(control)
    pieces: dict[str, Control] = {cell: control[None]}
    settled, known, point, depth = -np.inf, -np.inf, control[0], 0
    for depth in range(_DEEPEST):
        for state, controls in pieces.items():
            places = np.einsum("p,npd->nd", columns[state], controls)
            values = value(places)
            if values.max() > known:
                known, point = float(values.max()), places[values.argmax()]
        bounded = {state: bound(state, controls) for state, controls in pieces.items()}
        kept = {}
        for state, controls in pieces.items():
            low = bounded[state] <= known + slack
            settled = max(settled, float(bounded[state][low].max(initial=-np.inf)))
            if not low.all():
                kept[state] = controls[~low]
        if not kept:
            break
        if sum(len(controls) for controls in kept.values()) > MOST_PIECES or depth == _DEEPEST - 1:
            settled = max(settled, *(float(values.max()) for values in bounded.values()))
            break
        pieces = _children(system, kept)
    return Farthest(max(settled, known) + noise * (depth + 2), known, point)


def _children(system: System, pieces: Mapping[str, Control]) -> dict[str, Control]:
    found: dict[str, list[Control]] = {}
    for cell, controls in pieces.items():
        state = system.states[cell]
        for operator, target in zip(state.operators, state.targets, strict=True):
            found.setdefault(target, []).append(operator.T @ controls)
    return {cell: np.concatenate(parts) for cell, parts in found.items()}


def placed(
    shape: Shape, cell: str | None, control: Real[np.ndarray, "points dim"] | None
) -> tuple[str, Float[np.ndarray, "_points dim"]]:
    name = shape.system.shape if cell is None else cell
    if name not in shape.system.states:
        raise ValueError(f"there is no cell {name!r}; there are {', '.join(shape.system.states)}")
    if control is None and name != shape.system.shape:
        raise ValueError(
            f"give control points for the cell {name!r}: those of the shape are for its own cell"
        )
    points = shape.control if control is None else np.asarray(control, dtype=float)
    expected = shape.system.states[name].points
    if points.ndim != 2 or len(points) != expected or not np.isfinite(points).all():
        raise ValueError(
            f"cell {name!r} takes {expected} finite control points, one row each; got shape {points.shape}"
        )
    return name, points


def _bounded(directions: Float[np.ndarray, "faces dim"]) -> bool:
    """Whether no x other than 0 has `directions @ x <= 0`: then the polytope has no way to infinity."""
    from scipy.optimize import linprog

    dim = directions.shape[1]
    for axis, sign in product(range(dim), (-1.0, 1.0)):
        objective = np.zeros(dim)
        objective[axis] = sign
        found = linprog(objective, A_ub=directions, b_ub=np.zeros(len(directions)), bounds=[(-1, 1)] * dim)
        if found.fun < -1e-9:
            return False
    return True
