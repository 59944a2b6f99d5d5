"""The chaos game: as many points of an attractor as one likes, drawn from its invariant measure."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from ifs.asked import require_shape, require_whole
from ifs.certificates.bounds import sample
from ifs.certificates.convergence import require_contraction
from ifs.certificates.differences import linear_part
from ifs.dimensions.dimension import natural_probabilities, similarity
from ifs.measures.moments import WrongProbabilities, checked
from ifs.measures.operators import Number, operators
from ifs.shape import Shape
from ifs.system import State, System

Weights = Mapping[str, Mapping[str, float]]
Given = Mapping[str, Number] | Mapping[str, Mapping[str, Number]]

CHUNK = 1 << 16
_BEFORE = 256  # steps played before the first point, in which the law settles
_LEAST = 0.04  # least share of a label, against an equal one


def points(
    shape: Shape, count: int, seed: int, chunk: int = CHUNK, probabilities: Given | None = None
) -> Iterator[Float[np.ndarray, "_points dim"]]:
    """Points of an attractor by the chaos game, in mm, up to `chunk` at a time and `count` in all.

    Every cell c keeps a point X_c of its attractor. In each step all cells draw a label i of their own with
    its probability and take `X_c = T_i X_y`, y the cell of sub-piece i; the point of the shape's cell is the
    next result. So it has the law of the random address that walks the automaton with these probabilities,
    for any automaton. The first points are points of the attractor (`ifs.sample`), hence so are all, to
    rounding; 256 steps go before the first result. Neighbouring results depend on each other.

    `probabilities[label]`, or `[cell][label]` for several cells, sum to 1 in each cell, exactly where they
    are fractions, else to 1e-12; cells that are not mentioned take their labels alike. By default those of
    `weights`. The result depends on the seed (0 to 2^64 - 1), not on `chunk`; memory stays in proportion to
    `chunk`. Raises at the call `NotContracting` or `Undecided` (so also for systems that only contract on
    average), `WrongProbabilities`, and `ValueError` for a count, chunk or seed out of range.

    >>> from ifs.shape import shape
    >>> drawn = list(points(shape("sierpinski-triangle"), 1000, seed=7, chunk=600))
    >>> [len(part) for part in drawn], bool((drawn[0] >= 0).all())
    ([600, 400], True)
    """
    require_shape(shape)
    require_whole("count of points", count)
    require_whole("chunk", chunk, 1)
    require_whole("seed", seed, 0, (1 << 64) - 1)
    require_contraction(shape.system)
    chances = weights(shape) if probabilities is None else given_weights(shape, probabilities)
    return _streamed(shape, chances, count, seed, chunk)


def weights(shape: Shape) -> Weights:
    """The probabilities by which the chaos game draws where none are given, by cell and label.

    Where all pieces are similar to their cells those of the s-dimensional measure, s the similarity
    dimension: `p_i = r_i^s h_y / h_x` (`dimension.natural_probabilities`; `r_i^s` for one cell). Else, in
    each cell whose pieces depend on as many points as it does, p_i in proportion to `|det L_i|`, L_i the
    linear part of T_i, raised to at least 1/25 of an equal share, so that flat maps are drawn too (M. F.
    Barnsley, Fractals Everywhere, 1988, §3.8, takes 1/100 for one of four). In other cells all alike.

    >>> from ifs.shape import shape
    >>> {label: round(p, 9) for label, p in weights(shape("koch-curve"))["edge"].items()}
    {'0': 0.25, '1': 0.25, '2': 0.25, '3': 0.25}
    """
    system = shape.system
    found = similarity(shape)
    natural: Weights = {}
    if found is not None and found.dimension > 0:
        try:
            natural = natural_probabilities(system, found)
        except ValueError:  # some cell has no share of the measure
            natural = {}
    return {name: natural.get(name) or _by_volume(system, system.states[name]) for name in _cells(system)}


def given_weights(shape: Shape, probabilities: Given) -> Weights:
    """The probabilities that a user gave, checked, for all cells. Raises `WrongProbabilities`.

    >>> from ifs.shape import shape
    >>> given_weights(shape("sierpinski-triangle"), {"0": 0.5, "1": 0.5, "2": 0.25})
    Traceback (most recent call last):
    ...
    ifs.moments.WrongProbabilities: the probabilities of cell 'triangle' must sum to 1; they sum to 1.25
    """
    tables = {name: p for name, p in probabilities.items() if isinstance(p, Mapping)}
    plain = {label: p for label, p in probabilities.items() if not isinstance(p, Mapping)}
    if plain and tables:
        raise WrongProbabilities("give probabilities either by label or by cell and label, not both")
    chosen = checked(operators(shape), {shape.system.shape: plain} if plain else tables)
    return {name: {i: float(p) for i, p in chosen[name].items()} for name in _cells(shape.system)}


def _cells(system: System) -> list[str]:
    """The cells that the shape is subdivided into, itself first."""
    found = [system.shape]
    for name in found:
        found += [t for t in dict.fromkeys(system.states[name].targets) if t not in found]
    return found


def _by_volume(system: System, state: State) -> dict[str, float]:
    count = len(state.labels)
    shares = np.full(count, 1 / count)
    if all(system.states[target].points == state.points for target in state.targets) and state.points > 1:
        sizes = np.abs([np.linalg.det(linear_part(operator)) for operator in state.operators])
        if sizes.sum() > 0:
            shares = np.maximum(sizes / sizes.sum(), _LEAST / count)
            shares = shares / shares.sum()
    return {label: float(share) for label, share in zip(state.labels, shares, strict=True)}


@dataclass(frozen=True)
class _Tables:
    """What the kernel reads: the labels of all cells in one row; points less their last coordinate."""

    first: Int[np.ndarray, "cells_and_one"]
    sizes: Int[np.ndarray, "cells"]
    targets: Int[np.ndarray, "labels"]
    accept: Float[np.ndarray, "labels"]
    other: Int[np.ndarray, "labels"]
    linear: Float[np.ndarray, "labels width width"]
    shift: Float[np.ndarray, "labels width"]
    view: Float[np.ndarray, "dim width"]
    origin: Float[np.ndarray, "dim"]
    places: Float[np.ndarray, "cells width"]


def _tables(shape: Shape, chances: Weights) -> _Tables:
    system, names = shape.system, _cells(shape.system)
    number = {name: k for k, name in enumerate(names)}
    sizes = np.array([system.states[name].points - 1 for name in names])
    width = max(int(sizes.max()), 1)
    centres = sample(system)
    places = np.zeros((len(names), width))
    first, targets, accept, other, linear, shift = [0], [], [], [], [], []
    for name in names:
        state = system.states[name]
        places[number[name], : state.points - 1] = centres[name][:-1]
        for target, operator in zip(state.targets, state.operators, strict=True):
            matrix, moved = np.zeros((width, width)), np.zeros(width)
            matrix[: state.points - 1, : operator.shape[1] - 1] = linear_part(operator)
            moved[: state.points - 1] = operator[:-1, -1]
            targets.append(number[target])
            linear.append(matrix)
            shift.append(moved)
        ours = _alias([chances[name][label] for label in state.labels])
        accept.append(ours[0])
        other.append(ours[1])
        first.append(first[-1] + len(state.labels))
    view = np.zeros((shape.control.shape[1], width))
    view[:, : sizes[0]] = (shape.control[:-1] - shape.control[-1]).T
    return _Tables(
        np.array(first),
        sizes,
        np.array(targets),
        np.concatenate(accept),
        np.concatenate(other),
        np.array(linear),
        np.array(shift),
        view,
        np.array(shape.control[-1]),
        places,
    )


def _alias(chances: list[float]) -> tuple[Float[np.ndarray, "labels"], Int[np.ndarray, "labels"]]:
    """Walker's tables: column k holds label k with chance `accept[k]`, else `other[k]`."""
    count = len(chances)
    left = np.array(chances) * count / sum(chances)
    other = np.arange(count)
    accept = np.ones(count)
    small, large = [k for k in range(count) if left[k] < 1], [k for k in range(count) if left[k] >= 1]
    while small and large:
        k, giver = small.pop(), large[-1]
        accept[k], other[k] = left[k], giver
        left[giver] -= 1 - left[k]
        if left[giver] < 1:
            small.append(large.pop())
    return accept, other


def _streamed(
    shape: Shape, chances: Weights, count: int, seed: int, chunk: int
) -> Iterator[Float[np.ndarray, "_points dim"]]:
    from ifs.orbits.walk import played, played_alone

    tables = _tables(shape, chances)
    state = np.uint64(seed)
    alone = _in_space(shape, tables)
    place = tables.view @ tables.places[0] + tables.origin
    done = -_BEFORE
    while done < count:
        rows = np.empty(
            (min(_BEFORE if done < 0 else chunk, count - done if done >= 0 else _BEFORE), len(place))
        )
        if alone is not None:
            state = played_alone(state, place, tables.accept, tables.other, alone, rows)
        else:
            state = played(
                state,
                tables.places,
                tables.first,
                tables.sizes,
                tables.targets,
                tables.accept,
                tables.other,
                tables.linear,
                tables.shift,
                tables.view,
                tables.origin,
                rows,
            )
        state = np.uint64(state)
        if done >= 0:
            yield rows
        done += len(rows)


def _in_space(shape: Shape, tables: _Tables) -> Float[np.ndarray, "labels dim width"] | None:
    """The maps of a plain IFS as `[A, b]` in space, where its control points are a good frame; else None."""
    dim = shape.control.shape[1]
    if len(tables.sizes) > 1 or tables.sizes[0] != dim or np.linalg.cond(tables.view) > 1e3:
        return None
    linear = tables.view @ tables.linear @ np.linalg.inv(tables.view)
    shift = (tables.view @ tables.shift[:, :, None])[:, :, 0] + tables.origin - linear @ tables.origin
    return np.ascontiguousarray(np.concatenate([linear, shift[:, :, None]], axis=2))
