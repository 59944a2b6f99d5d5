"""The kernel of the chaos game; it imports numba, and is itself imported where a game is played."""

from typing import no_type_check

import numba
import numpy as np


@no_type_check
@numba.njit(cache=True, inline="always")
def _next(state):
    """The next number of a splitmix64 sequence, and its state."""
    state = state + np.uint64(0x9E3779B97F4A7C15)
    z = state
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return state, z ^ (z >> np.uint64(31))


@no_type_check
@numba.njit(cache=True, inline="always")
def _drawn(number, count, accept, other):
    """A label by Walker's alias method, from the 53 high bits of a number."""
    place = np.float64(number >> np.uint64(11)) * (1.0 / 9007199254740992.0) * count
    label = int(place)
    return label if place - label < accept[label] else other[label]


@no_type_check
@numba.njit(cache=True)
def played(state, places, first, sizes, targets, accept, other, linear, shift, view, origin, out):
    """Steps of the chaos game, one a row of `out`; `places` are changed in place, the new state is returned.

    `places[c]` is a point of cell c, in the coordinates whose number is `sizes[c]`. Labels of c are
    `first[c]` to `first[c + 1]`. In a step every cell draws a label, and its point becomes
    `linear[label] places[target] + shift[label]`. `out[k] = view places[0] + origin`.
    """
    cells, width = places.shape
    dim = out.shape[1]
    moved = np.empty_like(places)
    for k in range(len(out)):
        for c in range(cells):
            state, number = _next(state)
            begin = first[c]
            label = begin + _drawn(number, first[c + 1] - begin, accept[begin:], other[begin:])
            target = targets[label]
            for i in range(sizes[c]):
                total = shift[label, i]
                for j in range(sizes[target]):
                    total += linear[label, i, j] * places[target, j]
                moved[c, i] = total
        for c in range(cells):
            for i in range(width):
                places[c, i] = moved[c, i]
        for i in range(dim):
            total = origin[i]
            for j in range(sizes[0]):
                total += view[i, j] * places[0, j]
            out[k, i] = total
    return state


@no_type_check
@numba.njit(cache=True)
def played_alone(state, place, accept, other, maps, out):
    """The game of a plain IFS: `maps[label]` is `[A, b]`, `(dim, dim + 1)`, and `place` a point of space."""
    dim = out.shape[1]
    count = len(maps)
    now = place.copy()
    for k in range(len(out)):
        state, number = _next(state)
        label = _drawn(number, count, accept, other)
        for i in range(dim):
            total = maps[label, i, dim]
            for j in range(dim):
                total += maps[label, i, j] * now[j]
            out[k, i] = total
        for i in range(dim):
            now[i] = out[k, i]
    for i in range(dim):
        place[i] = now[i]
    return state
