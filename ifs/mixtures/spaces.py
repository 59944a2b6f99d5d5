"""Control points of a space in which several systems run side by side, or are multiplied."""

from collections.abc import Sequence
from fractions import Fraction
from itertools import product
from typing import Protocol

from automata.symmetry import compose

Numbers = tuple[int, ...]
"""The numbers of one control point of each part."""


class Space(Protocol):
    """The control points of a product cell, as tuples of those of its parts."""

    @property
    def points(self) -> Sequence[Numbers]: ...

    def weights(self, columns: Sequence[Sequence[Fraction]]) -> list[Fraction]:
        """The point given by a column for each part, in terms of the control points."""
        ...


class Grid:
    """All tuples; the weights of a tuple are products."""

    def __init__(self, sizes: Sequence[int]):
        self.points: list[Numbers] = list(product(*map(range, sizes)))

    def weights(self, columns: Sequence[Sequence[Fraction]]) -> list[Fraction]:
        found = [Fraction(1)]
        for column in columns:
            found = [a * b if a and b else Fraction(0) for a in found for b in column]
        return found


class Staircase:
    """A staircase of tuples and its images; the weights are the mean of those on each image."""

    def __init__(self, sizes: Sequence[int], turns: Sequence[tuple[Numbers, ...]]):
        self.steps = _steps(sizes)
        stairs = [(0,) * len(sizes)]
        for part in self.steps:
            stairs.append(tuple(n + (k == part) for k, n in enumerate(stairs[-1])))
        self.group = _closed(turns, tuple(tuple(range(size)) for size in sizes))
        images = [[moved(turn, stair) for stair in stairs] for turn in self.group]
        self.points: list[Numbers] = list(dict.fromkeys(point for image in images for point in image))
        self.minimal = len(self.points) == len(stairs)
        number = {point: i for i, point in enumerate(self.points)}
        self.images = [[number[point] for point in image] for image in images]

    def weights(self, columns: Sequence[Sequence[Fraction]]) -> list[Fraction]:
        if self.minimal:
            return self._on_stairs(columns, 0)
        found = [self._on_stairs(columns, turn) for turn in range(len(self.group))]
        return [sum(row, Fraction(0)) / len(found) for row in zip(*found, strict=True)]

    def _on_stairs(self, columns: Sequence[Sequence[Fraction]], turn: int) -> list[Fraction]:
        """The weight of a stair is that of reaching its step less that of reaching the next."""
        seen = [[column[i] for i in move] for column, move in zip(columns, self.group[turn], strict=True)]
        beyond = [[sum(column[n + 1 :], Fraction(0)) for n in range(len(column) - 1)] for column in seen]
        passed = [0] * len(columns)
        reached = [Fraction(1)]
        for part in self.steps:
            reached.append(beyond[part][passed[part]])
            passed[part] += 1
        result = [Fraction(0)] * len(self.points)
        for place, here, after in zip(self.images[turn], reached, [*reached[1:], Fraction(0)], strict=True):
            result[place] = here - after
        return result


def _steps(sizes: Sequence[int]) -> list[int]:
    """Which number goes up at each step: all in proportion, the same from both ends where possible."""
    places = []
    for part, size in enumerate(sizes):
        for step in range(size - 1):
            place = Fraction(2 * step + 1, size - 1) - 1
            places.append((place, part if place < 0 else -part, part))
    return [part for _, _, part in sorted(places)]


def _closed(turns: Sequence[tuple[Numbers, ...]], identity: tuple[Numbers, ...]) -> list[tuple[Numbers, ...]]:
    found = [identity]
    for element in found:
        for turn in turns:
            image = tuple(compose(a, b) for a, b in zip(turn, element, strict=True))
            if image not in found:
                found.append(image)
    return found


def moved(turn: tuple[Numbers, ...], point: Numbers) -> Numbers:
    return tuple(move[n] for move, n in zip(turn, point, strict=True))
