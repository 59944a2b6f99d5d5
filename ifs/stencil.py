"""Where the points of a template lie: combinations of a cell's control points, and all of them at once.

The points born inside a cell x in k subdivisions are the rows of

    M(x, k) = [M(y_w, k-1) T_w^T],  M(x, 0) = p^T for a point x whose attractor is p,

one block for each word w of `Templates.parts(x, k)`, with T_w the product of operators along w; points that
figures draw for themselves have rows of the same kind.
"""

import numpy as np
from jaxtyping import Float

from automata.automaton import Word
from automata.topology import embedding
from ifs.certificates.bounds import sample
from ifs.system import System
from ifs.template import Templates

Operator = Float[np.ndarray, "_points _end_points"]

LARGEST = 1 << 20
"""A table of rows with more entries is not made: its cells are subdivided once instead."""


class Stencils:
    """The rows of all cells, worked out when first asked for and kept."""

    def __init__(self, templates: Templates, system: System):
        self.templates = templates
        self.system = system
        self._sample = sample(system)
        self._operators: dict[tuple[str, Word], Operator] = {}
        self._rows: dict[tuple[str, int, bool], Float[np.ndarray, "_born _points"]] = {}

    def operator(self, cell: str, word: Word) -> Operator:
        """The product of operators along a word: a label or none, then a path of boundaries."""
        if (cell, word) not in self._operators:
            state = self.system.states[cell]
            if word and word[0] in state.labels:
                number = state.labels.index(word[0])
                found = state.operators[number] @ self.operator(state.targets[number], word[1:])
            else:
                found = self._embedding(cell, word)
            self._operators[cell, word] = found
        return self._operators[cell, word]

    def _embedding(self, cell: str, path: Word) -> Operator:
        columns = embedding(self.templates.automaton, cell, path)
        result = np.zeros((self.templates.automaton.cells[cell].points, len(columns)))
        for number, column in enumerate(columns):
            for row, value in column:
                result[row, number] = float(value)
        return result

    def rows(self, cell: str, depth: int, own: bool = False) -> Float[np.ndarray, "_born _points"]:
        """M(cell, depth); with `own`, the rows of the points that figures draw for themselves."""
        key = cell, depth, own
        if key not in self._rows:
            parts = [
                self.rows(end, depth - 1, own) @ self.operator(cell, word).T
                for word, end, _, _ in self._parts(cell, depth, own)
            ]
            self._rows[key] = np.concatenate(parts) if parts else self._leaf(cell, own and depth == 0)
        return self._rows[key]

    def _leaf(self, cell: str, own: bool) -> Float[np.ndarray, "_born _points"]:
        points = self.templates.automaton.cells[cell].points
        if own and self.templates.own(cell, 0):
            figure = self.templates.automaton.cells[cell].figure
            return np.array(figure.points, dtype=float) if figure and figure.points else np.eye(points)
        if not own and self.templates.born(cell, 0):
            return self._sample[cell][None]
        return np.zeros((0, points))

    def _parts(self, cell: str, depth: int, own: bool) -> list[tuple[Word, str, int, int]]:
        """The words, where they lead, and where the points of each begin and end; those with points."""
        if depth == 0:
            return []
        start, total = self.templates.parts(cell, depth)
        automaton = self.templates.automaton
        if own:
            total = 0
            start = {}
            for label, target in automaton.cells[cell].subdivision.items():
                start[label,] = total
                total += self.templates.own(target, depth - 1)
        ends = [*list(start.values())[1:], total]
        return [
            (word, automaton.end(cell, word), first, last)
            for (word, first), last in zip(start.items(), ends, strict=True)
            if last > first
        ]

    def positions(
        self,
        cell: str,
        depth: int,
        control: Float[np.ndarray, "cells _points dim"],
        out: Float[np.ndarray, "cells _born dim"],
        own: bool = False,
    ) -> None:
        """Writes the points of many cells of one state, `(cells, born, dim)`, into `out`."""
        if not out.size:
            return
        if depth and out.shape[1] * control.shape[1] > LARGEST:
            for word, end, first, last in self._parts(cell, depth, own):
                inner = np.matmul(self.operator(cell, word).T, control)
                self.positions(end, depth - 1, inner, out[:, first:last], own)
        else:
            np.matmul(self.rows(cell, depth, own), control, out=out)
