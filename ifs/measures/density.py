"""The invariant measure of a shape on a grid: pushed down through the maps, or sampled."""

from collections.abc import Callable, Iterator
from itertools import product

import numpy as np
from jaxtyping import Float, Int

from ifs.certificates.bounds import bounds, extent
from ifs.certificates.box import bounding_box
from ifs.certificates.convergence import require_contraction
from ifs.measures.grid import Density, Grid, WrongGrid, grid_around
from ifs.orbits.chaos import Given, Weights, given_weights, points, weights
from ifs.shape import Shape
from ifs.system import System

Progress = Callable[[str, float], None]

_SLACK = 1e-7  # pitches: a piece that reaches over the side of a cell by no more than this lies in the cell
_CHUNK = 1 << 14
_BATCHES = 32  # of samples, whose spread gives the error

_Batch = list[tuple[str, Float[np.ndarray, "_count _points _dim"], Float[np.ndarray, "_count"]]]


def density(
    shape: Shape,
    resolution: int = 128,
    *,
    grid: Grid | None = None,
    probabilities: Given | None = None,
    part: float = 1 / 8,
    progress: Progress | None = None,
) -> Density:
    """How much of the invariant measure of a shape lies in each cell of a grid; all mass is 1.

    The measure satisfies `mu_x = sum_i p_i (T_i)_* mu_y`, y the cell of sub-piece i, so a piece whose word is
    w has the mass `p_w`. A piece whose certified box lies in one cell of the grid gives its mass to it;
    the others are subdivided until all sides of their boxes are at most `part` of a cell. The mass of those
    that still straddle is split among the cells as the box is; their mass together is `error`.

    The grid is by default that of the shape's bounding box, with `resolution` cells along the longest side.
    `probabilities` as in `chaos.points`. Memory stays in proportion to the grid; time to the number of
    pieces along the sides of cells, which a smaller `part` multiplies. `progress(message, share)` is told.

    Raises `WrongGrid` for a grid that does not hold the shape, a part out of (0, 1] or a shape not in the
    plane or in space, `TooManyCells`, `WrongProbabilities`, `NotContracting` or `Undecided`.
    Source: Gentil, §5.2.1 (with M. F. Barnsley's sum of measures, where the source prints a union).

    >>> from ifs.shape import shape
    >>> carpet = density(shape("sierpinski-triangle"), 4)
    >>> carpet.amounts.shape, round(carpet.total, 12)
    ((4, 4), 1.0)
    """
    if not 0 < part <= 1:
        raise WrongGrid(f"the part of a cell lies in (0, 1]; found {part}")
    require_contraction(shape.system)
    chances = weights(shape) if probabilities is None else given_weights(shape, probabilities)
    place = _fitting(shape, resolution, grid)
    amounts = np.zeros(place.size)
    undecided = 0.0
    settled = 0.0
    for low, high, mass, whole in _pushed(shape, chances, place, part):
        if whole:
            _add(amounts, _cell(low, high, place.size), mass)
        else:
            _split(amounts, low, high, mass)
            undecided += float(mass.sum())
        settled += float(mass.sum())
        if progress:
            progress("measure", min(settled, 1.0))
    return Density(place, amounts, undecided)


def sampled(
    shape: Shape,
    count: int,
    seed: int,
    resolution: int = 128,
    *,
    grid: Grid | None = None,
    probabilities: Given | None = None,
    progress: Progress | None = None,
) -> Density:
    """The same measure from `count` points of the chaos game (`ifs.orbits.chaos.points`).

    `error` estimates the total variation distance to expect, `1/2 sum_cells E|error|`: the means of 32
    stretches of the game spread with a standard deviation s in a cell, which leaves an error of
    `sqrt(2 / pi) s / sqrt(32)` in their mean. Neighbouring points depend on each other, and stretches hardly
    do. Raises as `density` does, and `ValueError` for fewer than 32 points or a seed out of range.

    >>> from ifs.shape import shape
    >>> found = sampled(shape("sierpinski-triangle"), 10000, seed=1, resolution=4)
    >>> round(found.total, 12), found.error < 0.02
    (1.0, True)
    """
    if count < _BATCHES:
        raise ValueError(f"the error needs {_BATCHES} points or more; found {count}")
    place = _fitting(shape, resolution, grid)
    length = count // _BATCHES
    mean, square = np.zeros(place.size), np.zeros(place.size)
    rest = np.zeros(place.size)
    done = 0
    ours = np.zeros(place.size)
    for drawn in points(shape, count, seed, min(length, 1 << 20), probabilities):
        start = 0
        while start < len(drawn):
            stop = min(len(drawn), start + length - done % length)
            into = ours if done < length * _BATCHES else rest
            scaled = (drawn[start:stop] - place.origin) / place.pitch
            _add(into, np.clip(np.floor(scaled).astype(np.int64), 0, np.array(place.size) - 1), None)
            done += stop - start
            start = stop
            if into is ours and done % length == 0:
                mean += ours
                square += ours * ours
                ours[:] = 0
        if progress:
            progress("sample", done / count)
    variance = (square - mean * mean / _BATCHES) / (_BATCHES - 1) / length**2
    spread = np.sqrt(np.maximum(variance, 0) / _BATCHES)
    error = 0.5 * float(np.sqrt(2 / np.pi) * spread.sum())
    return Density(place, (mean + rest) / count, error)


def _fitting(shape: Shape, resolution: int, grid: Grid | None) -> Grid:
    dim = shape.control.shape[1]
    if dim not in (2, 3):
        raise WrongGrid(f"densities are for shapes in the plane and in space; here are {dim} coordinates")
    low, high = bounding_box(shape)
    if grid is None:
        return grid_around(low, high, resolution)
    if len(grid.size) != dim:
        raise WrongGrid(f"the shape has {dim} coordinates, the grid {len(grid.size)} axes")
    room = 2e-3 * float((high - low).max()) + _SLACK * grid.pitch  # how loose the box may be
    if (low < grid.origin - room).any() or (high > grid.high + room).any():
        raise WrongGrid(
            f"the shape reaches from {low.tolist()} to {high.tolist()} mm, "
            f"the grid from {grid.origin.tolist()} to {grid.high.tolist()} mm only"
        )
    return grid


def _pushed(
    shape: Shape, chances: Weights, place: Grid, part: float
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray, bool]]:
    """Boxes of pieces in units of the grid, with their mass, and whether they lie in one cell."""
    boxes = bounds(shape.system)
    steps = {name: _steps(shape.system, name, chances) for name in shape.system.states if name in chances}
    # In units of the grid; the affine change commutes with the operators, whose columns sum to 1.
    control = (shape.control - place.origin) / place.pitch
    waiting: list[_Batch] = [[(shape.system.shape, control[None], np.ones(1))]]
    while waiting:
        children: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {}
        for name, controls, mass in waiting.pop():
            low, high = extent(boxes[name], controls)
            cell = _cell(low, high, place.size)
            whole = ((low >= cell - _SLACK) & (high <= cell + 1 + _SLACK)).all(axis=1)
            small = ~whole & (high - low <= part).all(axis=1)
            for these, decided in ((whole, True), (small, False)):
                if these.any():
                    yield low[these], high[these], mass[these], decided
            left = ~(whole | small)
            if not left.any():
                continue
            for target, stack, share in steps[name]:
                moved = (stack @ controls[left][:, None]).reshape(-1, *stack.shape[1:2], controls.shape[2])
                children.setdefault(target, []).append((moved, (mass[left][:, None] * share).ravel()))
        waiting.extend(reversed(_batches(children)))


def _steps(system: System, name: str, chances: Weights) -> list[tuple[str, np.ndarray, np.ndarray]]:
    """The transposed operators of a cell by target, with their probabilities; those of 0 left out."""
    state = system.states[name]
    found: dict[str, list[tuple[np.ndarray, float]]] = {}
    for label, target, operator in zip(state.labels, state.targets, state.operators, strict=True):
        if chances[name][label] > 0:
            found.setdefault(target, []).append((np.asarray(operator).T, chances[name][label]))
    return [(t, np.stack([o for o, _ in ours]), np.array([p for _, p in ours])) for t, ours in found.items()]


def _batches(children: dict[str, list[tuple[np.ndarray, np.ndarray]]]) -> list[_Batch]:
    result: list[_Batch] = []
    for name, parts in children.items():
        controls = np.concatenate([moved for moved, _ in parts])
        mass = np.concatenate([share for _, share in parts])
        for start in range(0, len(controls), _CHUNK):
            result.append([(name, controls[start : start + _CHUNK], mass[start : start + _CHUNK])])
    return result


def _cell(
    low: Float[np.ndarray, "n dim"], high: Float[np.ndarray, "n dim"], size: tuple[int, ...]
) -> Int[np.ndarray, "n dim"]:
    return np.clip(np.floor((low + high) / 2), 0, np.array(size) - 1).astype(np.int64)


def _add(amounts: np.ndarray, cells: Int[np.ndarray, "n dim"], mass: np.ndarray | None) -> None:
    flat = np.atleast_1d(np.ravel_multi_index(tuple(cells.T), amounts.shape))
    if len(flat) * 8 < amounts.size and mass is not None:
        np.add.at(amounts.reshape(-1), flat, mass)
    else:
        amounts += np.bincount(flat, mass, amounts.size).reshape(amounts.shape)


def _split(
    amounts: np.ndarray,
    low: Float[np.ndarray, "n dim"],
    high: Float[np.ndarray, "n dim"],
    mass: Float[np.ndarray, "n"],
) -> None:
    """Boxes no larger than a cell, each shared among the cells that it meets as its content is."""
    first = np.floor(low)
    side = np.maximum(high - low, 1e-300)
    lower = np.clip((first + 1 - low) / side, 0, 1)
    most = np.array(amounts.shape) - 1
    for step in product((0, 1), repeat=low.shape[1]):
        share = np.where(np.array(step) == 1, 1 - lower, lower).prod(axis=1)
        some = share > 0
        cells = np.clip(first[some] + step, 0, most).astype(np.int64)
        _add(amounts, cells, (mass * share)[some])
