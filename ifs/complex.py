"""A complex of cells that share their boundaries, and its refinement, which is purely combinatorial."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from automata.automaton import Word
from automata.symmetry import Permutation
from automata.topology import Topology
from ifs.asked import require_whole
from ifs.evaluate import subdivide
from ifs.system import System

Ids = Int[np.ndarray, "cells"]


class Seen(NamedTuple):
    """Cells, and the symmetry through which each is seen, as its number in the group."""

    ids: Ids
    turn: Ids

    def take(self, chosen: np.ndarray) -> "Seen":
        return Seen(self.ids[chosen], self.turn[chosen])


@dataclass(frozen=True)
class Complex:
    """Pieces of a shape at one level, and the boundary cells that they share.

    The cells of each state are numbered from 0; the first `len(control[state])` of them are pieces of the
    shape, whose control points are `control[state]`, `(pieces, points, dim)` in millimetres; the others are
    only boundaries. `boundary[state][label]` says which cell each boundary is.
    """

    topology: Topology
    system: System
    counts: Mapping[str, int]
    boundary: Mapping[str, Mapping[str, Seen]]
    control: Mapping[str, Float[np.ndarray, "pieces points dim"]]

    def boundary_at(self, state: str, path: Word, ids: Ids) -> Seen:
        """The cells that a path of boundary labels leads to from the given cells of a state."""
        groups = self.topology.groups
        seen = Seen(ids, np.zeros(len(ids), dtype=np.int64))
        return self._follow(state, path, seen, groups)

    def _follow(self, state: str, path: Word, seen: Seen, groups) -> Seen:
        if not path:
            return seen
        elements = _elements(self.topology, state)
        target = self.topology.automaton.end(state, path)
        result = Seen(np.empty(len(seen.ids), dtype=np.int64), np.zeros(len(seen.ids), dtype=np.int64))
        for number in np.unique(seen.turn):
            chosen = np.flatnonzero(seen.turn == number)
            (label, *rest), last = groups.normal(state, path, elements[number])
            cell = self.topology.automaton.cells[state].boundary[label].cell
            step = self.boundary[state][label].take(seen.ids[chosen])
            end = _turned(self.topology, target, self._follow(cell, tuple(rest), step, groups), last)
            result.ids[chosen], result.turn[chosen] = end
        return result


def initial(topology: Topology, system: System, control: Float[np.ndarray, "points dim"]) -> Complex:
    """The complex of a single piece: the shape itself with its boundary cells of every dimension.

    Boundaries whose embeddings coincide are one cell.
    """
    shape = topology.automaton.shape
    coincident = topology.coincident(shape)
    counts: dict[str, int] = {shape: 1}
    number: dict[Word, int] = {(): 0}
    for path, (first, _) in coincident.items():
        if path == first:
            end = topology.automaton.end(shape, path)
            number[path] = counts.get(end, 0)
            counts[end] = number[path] + 1
    boundary: dict[str, dict[str, Seen]] = {}
    for path in number:
        state = topology.automaton.end(shape, path)
        for label, border in topology.automaton.cells[state].boundary.items():
            first, element = coincident[(*path, label)]
            seen = boundary.setdefault(state, {}).setdefault(label, _nobody(counts[state]))
            seen.ids[number[path]] = number[first]
            seen.turn[number[path]] = _elements(topology, border.cell).index(element)
    return Complex(topology, system, counts, boundary, {shape: np.asarray(control, dtype=float)[None]})


def refine(complex_: Complex) -> Complex:
    """One subdivision of every cell; pieces that shared a boundary share its pieces.

    Which boundaries coincide is read from the automaton's gluing alone; coordinates play no part.
    """
    return refine_traced(complex_)[0]


def refine_traced(complex_: Complex) -> tuple[Complex, Callable[[str, str, Ids], Ids]]:
    """One subdivision, and `numbers(cell, label, ids)`: which cells the sub-cells of a label have become."""
    refinement = _Refinement(complex_)
    return refinement.result(), lambda cell, label, ids: refinement.subcells(cell, (label,), ids).ids


def refined(complex_: Complex, depth: int) -> Complex:
    """`depth` subdivisions. Raises `ValueError` for what is no whole number of them."""
    require_whole("depth", depth)
    for _ in range(depth):
        complex_ = refine(complex_)
    return complex_


class _Refinement:
    """The numbering of the cells after one subdivision, and the boundaries looked up in it."""

    def __init__(self, old: Complex):
        self.old = old
        self.topology = old.topology
        self.automaton = old.topology.automaton
        self.pieces = {state: len(old.control[state]) for state in old.counts if state in old.control}
        self.counts: dict[str, int] = {}
        self.start: dict[tuple[str, Word, bool], int] = {}
        for of_shape in (True, False):
            for state in old.counts:
                self._numbersubcells(state, of_shape)
        for state, count in old.counts.items():
            for word, cell in self.topology.subdivided(state).interior.items():
                self._reserve((state, word, False), cell, count)

    def _numbersubcells(self, state: str, of_shape: bool) -> None:
        pieces = self.pieces.get(state, 0)
        count = pieces if of_shape else self.old.counts[state] - pieces
        for label, target in self.automaton.cells[state].subdivision.items():
            self._reserve((state, (label,), of_shape), target, count)

    def _reserve(self, key: tuple[str, Word, bool], cell: str, count: int) -> None:
        if count:
            self.start[key] = self.counts.get(cell, 0)
            self.counts[cell] = self.start[key] + count

    def result(self) -> Complex:
        boundary: dict[str, dict[str, Seen]] = {}
        for (state, word, of_shape), start in self.start.items():
            ids = self._members(state, word, of_shape)
            cell = self.automaton.end(state, word)
            for label in self.automaton.cells[cell].boundary:
                seen = boundary.setdefault(cell, {}).setdefault(label, _nobody(self.counts[cell]))
                found = self._locate(state, (*word, label), ids)
                seen.ids[start : start + len(ids)], seen.turn[start : start + len(ids)] = found
        return Complex(self.topology, self.old.system, self.counts, boundary, self._control())

    def _members(self, state: str, word: Word, of_shape: bool) -> Ids:
        pieces = self.pieces.get(state, 0)
        if len(word) > 1:
            return np.arange(self.old.counts[state])
        return np.arange(pieces) if of_shape else np.arange(pieces, self.old.counts[state])

    def _control(self) -> dict[str, np.ndarray]:
        parts: dict[str, list] = {}
        for state in self.pieces:
            control = self.old.control[state]
            for target, children in subdivide(self.old.system.states[state], control).items():
                parts.setdefault(target, []).extend(children)
        return {target: np.concatenate(children) for target, children in parts.items()}

    def _locate(self, state: str, word: Word, ids: Ids) -> Seen:
        """The new cells that a path after one subdivision names, seen from the given old cells."""
        if len(word) == 1:
            return self.subcells(state, word, ids)
        standing, element = self.topology.subdivided(state).place[word]
        end = self.automaton.end(state, word)
        if standing[0] not in self.automaton.cells[state].boundary:
            found = Seen(self.start[state, standing, False] + ids, np.zeros(len(ids), dtype=np.int64))
        else:
            found = self._inherited(state, standing, ids)
        return _turned(self.topology, end, found, element)

    def subcells(self, state: str, word: Word, ids: Ids) -> Seen:
        pieces = self.pieces.get(state, 0)
        shape_start = self.start.get((state, word, True), 0)
        other_start = self.start.get((state, word, False), 0)
        new = np.where(ids < pieces, shape_start + ids, other_start + ids - pieces)
        return Seen(new, np.zeros(len(ids), dtype=np.int64))

    def _inherited(self, state: str, word: Word, ids: Ids) -> Seen:
        """The rest of the path, seen from the old boundary cell that its first label names."""
        border = self.automaton.cells[state].boundary[word[0]].cell
        old = self.old.boundary[state][word[0]].take(ids)
        end = self.automaton.end(border, word[1:])
        elements = _elements(self.topology, border)
        result = _nobody(len(ids))
        for number in np.unique(old.turn):
            chosen = np.flatnonzero(old.turn == number)
            rest, last = self.topology.groups.normal(border, word[1:], elements[number])
            found = self._locate(border, rest, old.ids[chosen])
            result.ids[chosen], result.turn[chosen] = _turned(self.topology, end, found, last)
        return result


def _nobody(count: int) -> Seen:
    return Seen(np.zeros(count, dtype=np.int64), np.zeros(count, dtype=np.int64))


def _elements(topology: Topology, state: str) -> list[Permutation]:
    return list(topology.groups.elements[state])


def _turned(topology: Topology, state: str, seen: Seen, element: Permutation) -> Seen:
    """The same cells seen through one more symmetry."""
    elements = _elements(topology, state)
    if element == elements[0]:
        return seen
    number = {candidate: i for i, candidate in enumerate(elements)}
    table = np.array([number[tuple(first[i] for i in element)] for first in elements])
    return Seen(seen.ids, table[seen.turn])
