"""Iterated function systems on sets: each map takes a set half-way to a fixed one, its condensation set."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int32

from ifs.measures.moments import WrongProbabilities
from ifs.medians.median_sets import EmptySet, turn

Progress = Callable[[str, float], None]
Cells = Bool[np.ndarray, "..."]

MOST_SETS = 1 << 14


@dataclass(frozen=True, eq=False)
class Coverage:
    """`chance` is the probability that a cell belongs to the random set, in the shape of the grid.

    `change` is how much the last map applied mattered: the sum of `|chance - chance before|` over that of
    `chance`. `sets` is how many words there were.
    """

    chance: Float[np.ndarray, "..."]
    change: float
    sets: int


def coverage(
    models: Sequence[Cells],
    probabilities: Sequence[float],
    depth: int = 5,
    turning: float = 0.0,
    progress: Progress | None = None,
) -> Coverage:
    """How likely each cell of a grid is covered by a set drawn from the measure attractor of `{f_1, …, f_n}`.

    `f_i(X)` is the median set of X and model i on the grid (`median_cells`). The attractor is a set of sets,
    its measure a law on sets: start from model j with probability p_j, then apply `depth` maps, map i with
    probability p_i. What is seen of it is the covering function of the random set. All `n^(depth + 1)` words
    are taken, shared beginnings once, so there is nothing random in it; memory is that of `depth` sets and a
    few numbers a cell for each model, time grows as the number of words. A cell of all models has chance 1.

    As the median set need not contract (see `median_sets.median`), a limit for growing depth is not
    promised; `change` tells how far it is. `turning` turns each median set by that many degrees per cell of
    the distance between X and the model; what turns out of the grid is cut off.

    Raises `EmptySet`, `WrongProbabilities` and `ValueError` for models of different sizes, not booleans in 2
    or 3 dimensions, and more than 16384 words. Source: Gentil, §5.2.2-5.2.3.

    >>> a, b = np.zeros((2, 9, 1), dtype=bool)
    >>> a[0], b[8] = True, True
    >>> coverage([a, b], [0.75, 0.25], depth=1).chance[:, 0].tolist()
    [0.5625, 0.0, 0.0, 0.0, 0.375, 0.0, 0.0, 0.0, 0.0625]
    """
    chances = _checked(models, probabilities, depth)
    if not np.isfinite(turning):
        raise ValueError(f"the turning is a finite number of degrees per cell; found {turning}")
    box = _box(models) if turning == 0 else tuple(slice(None) for _ in models[0].shape)
    walk = _Walk(
        [_Model(np.ascontiguousarray(model[box])) for model in models], chances, depth, turning, progress
    )
    for model, chance in zip(walk.models, chances, strict=True):
        walk.visit(model.cells, chance, 0)
    total = float(walk.last.sum())
    change = float(np.abs(walk.last - walk.before).sum()) / total if total else 0.0
    chance = np.zeros(models[0].shape)
    chance[box] = walk.last
    return Coverage(np.minimum(chance, 1.0), change, len(models) ** (depth + 1))


def median_cells(cells: Cells, model: Cells) -> Cells:
    """The median set of cells X and a model B on their grid.

    The cells of both sets stay. From each other cell x of X and the nearest cell b of B, and from each other
    cell b of B and the nearest x of X, the middle is taken, coordinates rounded towards b: then
    `d(M, B) <= d(X, B) / 2` without rounding error, `d(X, M) <= d(X, B) / 2 + sqrt(dim) / 2` cells, and X
    becomes B after finitely many steps. Where two cells are equally near, one is taken by a fixed rule.

    >>> a, b = np.zeros((2, 9, 1), dtype=bool)
    >>> a[0], b[7:] = True, True
    >>> np.flatnonzero(median_cells(a, b)).tolist()
    [4]
    """
    _checked([cells, model], [0.5, 0.5], 0)
    return _Model(model).median(cells)[0]


class _Model:
    """A condensation set, with the nearest of its cells for every cell of the grid."""

    def __init__(self, cells: Cells):
        self.cells = cells
        self.table = _table(cells)

    def median(self, cells: Cells) -> tuple[Cells, float]:
        """The median set, and the Hausdorff distance in cells."""
        from ifs.medians.nearest_cells import half_way

        result = cells & self.cells
        found = half_way(_deep(result), _deep(cells & ~self.cells), self.table, True)
        missing = self.cells & ~cells
        if missing.any():
            found = max(found, half_way(_deep(result), _deep(missing), _table(cells), False))
        return result, float(np.sqrt(found))


@dataclass
class _Walk:
    """All words, depth first; `last` and `before` add up the sets of `depth` and of one map less."""

    models: Sequence[_Model]
    chances: Sequence[float]
    depth: int
    turning: float
    progress: Progress | None
    done: float = 0.0

    def __post_init__(self) -> None:
        self.last = np.zeros(self.models[0].cells.shape)
        self.before = np.zeros(self.models[0].cells.shape)

    def visit(self, cells: Cells, chance: float, level: int) -> None:
        if level >= self.depth - 1:
            into = self.last if level == self.depth else self.before
            into[cells] += chance
        if level == self.depth:
            self.done += len(self.models) ** -(self.depth + 1)
            if self.progress:
                self.progress("sets", min(self.done, 1.0))
            return
        for model, own in zip(self.models, self.chances, strict=True):
            if own > 0:
                self.visit(self.image(cells, model), chance * own, level + 1)

    def image(self, cells: Cells, model: _Model) -> Cells:
        if not cells.any():
            return cells
        found, distance = model.median(cells)
        return _turned(found, np.deg2rad(self.turning * distance)) if self.turning and distance else found


def _table(cells: Cells) -> Int32[np.ndarray, "_x _y _z"]:
    from ifs.medians.nearest_cells import nearest_cells

    return nearest_cells(_deep(cells))


def _deep(cells: Cells) -> Bool[np.ndarray, "_x _y _z"]:
    """The same cells with three axes."""
    return cells if cells.ndim == 3 else cells[None]


def _turned(cells: Cells, angle: float) -> Cells:
    """Cells turned about the middle of their box: each cell asks the nearest one that it comes from."""
    from scipy.ndimage import affine_transform

    middle = np.array([(part.start + part.stop - 1) / 2 for part in _box([cells])])
    back = turn(-angle, cells.ndim)
    start = middle - back @ middle
    moved = affine_transform(cells.astype(np.uint8), back, start, order=0, prefilter=False)  # pyright: ignore
    return np.asarray(moved) > 0


def _box(models: Sequence[Cells]) -> tuple[slice, ...]:
    """The box around all models: medians do not leave it."""
    result = []
    for axis in range(models[0].ndim):
        there = np.flatnonzero(np.any([_flat(model, axis) for model in models], axis=0))
        result.append(slice(int(there[0]), int(there[-1]) + 1))
    return tuple(result)


def _flat(cells: Cells, axis: int) -> Bool[np.ndarray, "n"]:
    return np.asarray(cells.any(axis=tuple(other for other in range(cells.ndim) if other != axis)))


def _checked(models: Sequence[Cells], probabilities: Sequence[float], depth: int) -> list[float]:
    if not models:
        raise EmptySet("there is no model; give one at least")
    for k, model in enumerate(models):
        if model.dtype != np.bool_ or model.ndim not in (2, 3):
            raise ValueError(
                f"model {k} must be booleans in 2 or 3 dimensions, not {model.dtype} {model.shape}"
            )
        if model.shape != models[0].shape:
            raise ValueError(
                f"model {k} has the grid {model.shape}, model 0 {models[0].shape}; they must agree"
            )
        if not model.any():
            raise EmptySet(f"model {k} fills no cell of the grid")
    if depth < 0 or len(models) ** (depth + 1) > MOST_SETS:
        raise ValueError(
            f"{len(models)} models and a depth of {depth} make {len(models)}^{depth + 1} words; "
            f"the depth is 0 or more, and there are {MOST_SETS} words at most"
        )
    if len(probabilities) != len(models):
        raise WrongProbabilities(f"{len(models)} models need as many probabilities; got {len(probabilities)}")
    for k, chance in enumerate(probabilities):
        if not 0 <= chance <= 1:
            raise WrongProbabilities(f"the probability of model {k} must lie in [0, 1]; got {chance}")
    if abs(sum(probabilities) - 1) > 1e-12:
        raise WrongProbabilities(
            f"the probabilities of the models must sum to 1; they sum to {sum(probabilities)}"
        )
    return [float(chance) for chance in probabilities]
