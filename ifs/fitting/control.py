"""Control points from samples: linear least squares, and parameters found by projection.

At known parameters a shape is linear in its control points, `Y = B P + noise`, B of `basis`; what the
data leave open shows in the singular values of B. Without parameters, each sample takes that of the nearest
point, and both are improved in turn: no step makes the sum of squares larger.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Real

from ifs.mixtures.basis import basis
from ifs.shape import Shape

_RANK = 1e-10
_ROUNDS = 50
_STILL = 1e-6
_EXACT = 1e-9
_ZOOMS = 4
_GRID = {1: 2048, 2: 64}
_NEAR = {1: 8, 2: 4}


@dataclass(frozen=True)
class Fit:
    """A fitted shape and how good it is.

    `residuals` are `(n, dim)` in mm at `parameters`, `rms` the root of their mean square length. `rank`
    counts the free control points that the data determine; `singular_values` are those of B, whose largest
    over smallest is `condition`. `noise` estimates the standard deviation of a coordinate of a sample (NaN
    where no data are left over), and `deviation[j]` that of a coordinate of control point j (0 for those
    held, infinite where the data do not determine all). `rounds` counts projections. `ok` is False where the
    rank is short or projections did not settle; `why` says it.
    """

    shape: Shape
    parameters: Float[np.ndarray, "n directions"]
    residuals: Float[np.ndarray, "n dim"]
    rank: int
    singular_values: Float[np.ndarray, "unknowns"]
    noise: float
    deviation: Float[np.ndarray, "points"]
    rounds: int
    ok: bool
    why: str

    @property
    def rms(self) -> float:
        return float(np.sqrt((self.residuals**2).sum(axis=1).mean()))

    @property
    def condition(self) -> float:
        smallest = self.singular_values.min(initial=np.inf)
        return float(self.singular_values.max(initial=0.0) / smallest) if smallest > 0 else np.inf


def fit_control(
    shape: Shape,
    samples: Real[np.ndarray, "n dim"],
    parameters: Real[np.ndarray, "n directions"],
    held: Sequence[int] = (),
) -> Fit:
    """The control points that make the sum of squares `|Y - B P|^2` least, at known parameters.

    `samples` are in mm. Control points in `held` stay as they are. Where the data do not determine all, the
    result is the one nearest to `shape.control`, and `ok` is False. Raises `ValueError` for samples that do
    not fit or are not finite, parameters in a hole, and numbers in `held` out of range.

    >>> import ifs
    >>> from subdivision.schemes import bezier
    >>> t = np.linspace(0, 1, 5)[:, None]
    >>> found = fit_control(ifs.shape(bezier(2)), np.column_stack([t, t**2]), t)
    >>> found.rank, found.rms < 1e-12
    (3, True)
    """
    samples, parameters = np.asarray(samples, dtype=float), np.asarray(parameters, dtype=float)
    _validate(shape, samples, held)
    if len(parameters) != len(samples):
        raise ValueError(f"expected a parameter for each of {len(samples)} samples, found {len(parameters)}")
    matrix = basis(shape, parameters)
    holes = np.isnan(matrix).any(axis=1)
    if holes.any():
        row = int(np.flatnonzero(holes)[0])
        raise ValueError(f"sample {row} has its parameter {parameters[row].tolist()} in a hole of the shape")
    free = np.setdiff1d(np.arange(len(shape.control)), np.array(held, dtype=np.int64))
    start = np.tile(shape.control, (1, 1))
    left, sizes, right = np.linalg.svd(matrix[:, free], full_matrices=False)
    rank = int((sizes > _RANK * sizes.max(initial=0.0)).sum())
    gap = left[:, :rank].T @ (samples - matrix @ start)
    control = start.copy()
    control[free] += right[:rank].T @ (gap / sizes[:rank, None])
    residuals = samples - matrix @ control
    over = len(samples) - rank
    noise = float(np.sqrt((residuals**2).sum() / (over * samples.shape[1]))) if over else float("nan")
    deviation = np.zeros(len(control))
    deviation[free] = np.inf
    if rank == len(free):
        deviation[free] = noise * np.sqrt(((right.T / sizes) ** 2).sum(axis=1))
    why = (
        ""
        if rank == len(free)
        else (
            f"{len(samples)} samples determine {rank} of {len(free)} control points: give samples where the "
            "others have influence, or hold some"
        )
    )
    values = np.concatenate([sizes, np.zeros(len(free) - len(sizes))])
    fitted = replace(shape, control=control)
    return Fit(fitted, parameters, residuals, rank, values, noise, deviation, 0, not why, why)


def fit_curve(
    shape: Shape, samples: Real[np.ndarray, "n dim"], held: Sequence[int] = (), rounds: int = _ROUNDS
) -> Fit:
    """The control points that bring a curve or a face near to samples (mm) whose parameters are not known.

    Starting from `shape.control`, samples are projected and control points fitted in turn, until the sum of
    squares changes by less than 1e-6 of itself, at most `rounds` times. A start near the data is needed: the
    result is a local minimum, and `ok` is False where it is not reached or the rank is short. Raises what
    `fit_control` raises.

    >>> import ifs
    >>> from subdivision.schemes import bezier
    >>> line = ifs.shape(bezier(1), control=np.array([[0, 1], [9, 1]]))
    >>> fit_curve(line, np.array([[0, 0], [4, 0], [9, 0]])).rms < 1e-3
    True
    """
    samples = np.asarray(samples, dtype=float)
    _validate(shape, samples, held)
    grid = _grid(shape)
    found = fit_control(shape, samples, _projected(shape, samples, None, grid), held)
    before, enough = np.inf, samples.size * (_EXACT * float(np.ptp(samples, axis=0).max())) ** 2
    for number in range(1, rounds + 1):
        now = float((found.residuals**2).sum())
        if now <= enough or before - now <= _STILL * before < np.inf:
            return replace(found, rounds=number)
        before = now
        parameters = _projected(found.shape, samples, found.parameters, grid)
        found = fit_control(found.shape, samples, parameters, held)
    why = found.why or f"the projections had not settled after {rounds} rounds: allow more"
    return replace(found, rounds=rounds, ok=False, why=why)


def project(
    shape: Shape,
    samples: Real[np.ndarray, "n dim"],
    parameters: Real[np.ndarray, "n directions"] | None = None,
) -> Float[np.ndarray, "n directions"]:
    """Parameters of the nearest points of a curve or a quadrangle, and never farther than those given.

    The nearest of a grid of parameters (2049 on a curve, 65 by 65 on a face), then of finer grids around it.
    On a fractal shape, with many near points, a nearer one may be missed.

    >>> import ifs
    >>> from subdivision.schemes import bezier
    >>> line = ifs.shape(bezier(1), control=np.array([[0, 0], [9, 0]]))
    >>> project(line, np.array([[3, 2], [20, 0]])).round(6).tolist()
    [[0.333333], [1.0]]
    """
    return _projected(shape, np.asarray(samples, dtype=float), parameters, _grid(shape))


Grid = tuple[Float[np.ndarray, "count directions"], Float[np.ndarray, "count points"]]
"""Parameters, and the basis at them."""


def _grid(shape: Shape) -> Grid:
    directions = 1 if len(shape.automaton.cells[shape.automaton.shape].boundary) == 2 else 2
    axis = np.linspace(0, 1, _GRID[directions] + 1)
    grid = np.stack(np.meshgrid(*[axis] * directions, indexing="ij"), axis=-1).reshape(-1, directions)
    matrix = basis(shape, grid)
    seen = ~np.isnan(matrix).any(axis=1)
    return grid[seen], matrix[seen]


def _projected(
    shape: Shape,
    samples: Float[np.ndarray, "n dim"],
    parameters: Real[np.ndarray, "n directions"] | None,
    grid: Grid,
) -> Float[np.ndarray, "n directions"]:
    from scipy.spatial import KDTree

    best = grid[0][KDTree(grid[1] @ shape.control).query(samples)[1]]
    directions = best.shape[1]
    given = best[:, None] if parameters is None else np.stack([best, parameters], axis=1)
    best = _nearer(shape, samples, given)
    width, count = 1 / _GRID[directions], _NEAR[directions]
    around = np.linspace(-1, 1, 2 * count + 1)
    offsets = np.stack(np.meshgrid(*[around] * directions, indexing="ij"), axis=-1).reshape(-1, directions)
    for _ in range(_ZOOMS):
        best = _nearer(shape, samples, np.clip(best[:, None] + width * offsets, 0, 1))
        width /= count
    return best


def _nearer(
    shape: Shape, samples: Float[np.ndarray, "n dim"], candidates: Float[np.ndarray, "n choices directions"]
) -> Float[np.ndarray, "n directions"]:
    flat = candidates.reshape(-1, candidates.shape[2])
    points = (basis(shape, flat) @ shape.control).reshape(*candidates.shape[:2], -1)
    distance = np.linalg.norm(points - samples[:, None], axis=2)
    chosen = np.argmin(np.where(np.isnan(distance), np.inf, distance), axis=1)
    return candidates[np.arange(len(samples)), chosen]


def _validate(shape: Shape, samples: np.ndarray, held: Sequence[int]) -> None:
    dimension = shape.control.shape[1]
    if samples.ndim != 2 or samples.shape[1] != dimension or not len(samples):
        raise ValueError(
            f"expected samples as rows of {dimension} coordinates, found an array {samples.shape}"
        )
    if not np.isfinite(samples).all():
        row = int(np.flatnonzero(~np.isfinite(samples).all(axis=1))[0])
        raise ValueError(f"sample {row} is not finite: {samples[row].tolist()}")
    for number in held:
        if not 0 <= number < len(shape.control):
            raise ValueError(
                f"there is no control point {number} to hold; there are {len(shape.control)}, from 0"
            )
