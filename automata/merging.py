"""Cells that gluing forces to be one.

When an equation's two sides lead to different cells of the same size, as in a curve whose left and right
ends are cells of their own, the two cells must have the same operators for the gluing to hold at the levels
below: they are one cell under two names, and so are the cells that they are subdivided into.
Source: Gentil 2010, §4.3.1 ("les états s_g et s_d doivent être identiques").
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace

from automata.automaton import Automaton, Boundary, Cell, Equation, Rows, Symmetry, Word
from automata.error import AutomatonError

_ENTRY = re.compile(r"(.+)\.([^.\[\]]+)(\[.*\])")


@dataclass(frozen=True)
class Merged:
    """An automaton in which cells that must be one are one.

    `standing[x]` is the cell that stands for x, `renamed[x, i]` the label that stands for the sub-cell i of
    x where the two differ. `notes` says in words which cells were found to be one, and why.
    """

    automaton: Automaton
    standing: Mapping[str, str]
    renamed: Mapping[tuple[str, str], str]
    notes: tuple[str, ...]

    def label(self, cell: str, label: str) -> str:
        """The label in the standing cell that stands for a label of `cell`."""
        return self.renamed.get((cell, label), label)

    def entry(self, text: str) -> str:
        """An entry such as `right.s[0,1]` as an entry of the standing cell."""
        match = _ENTRY.fullmatch(text)
        if match is None or match[1] not in self.standing:
            return text
        return f"{self.standing[match[1]]}.{self.label(match[1], match[2])}{match[3]}"


def merged(automaton: Automaton) -> Merged:
    """The automaton with all cells merged that its equations force to be one.

    Raises `AutomatonError`, with the path of the equation, when two such cells differ in size, in the
    labels of their sub-cells or boundaries, or in an embedding.

    >>> import automata
    >>> merged(automata.read("corner-cutting")).notes
    ()
    """
    merging = _Merging(automaton)
    for cell in automaton.cells.values():
        for equation in (*cell.equations, *cell.symmetry_equations()):
            first, second = (automaton.end(cell.name, side) for side in (equation.left, equation.right))
            merging.join(first, second, equation)
    standing = {name: merging.root(name) for name in automaton.cells}
    if not merging.notes:
        return Merged(automaton, standing, {}, ())
    return Merged(merging.automaton(standing), standing, merging.renamed, tuple(merging.notes))


class _Merging:
    """Union-find over the cells; the cell that the shape meets first stands for its class."""

    def __init__(self, automaton: Automaton):
        self.given = automaton
        reachable = automaton.reachable()
        order = [*reachable, *(name for name in automaton.cells if name not in reachable)]
        self.rank = {name: place for place, name in enumerate(order)}
        self.parent = {name: name for name in automaton.cells}
        self.cells: dict[str, Cell] = dict(automaton.cells)
        self.renamed: dict[tuple[str, str], str] = {}
        self.notes: list[str] = []

    def root(self, cell: str) -> str:
        while self.parent[cell] != cell:
            cell = self.parent[cell]
        return cell

    def join(self, first: str, second: str, equation: Equation) -> None:
        queue = [(first, second)]
        for one, other in queue:
            kept, gone = sorted((self.root(one), self.root(other)), key=self.rank.__getitem__)
            if kept == gone:
                continue
            x, y = self.cells[kept], self.cells[gone]
            queue.extend(self._subcells(x, y, equation))
            queue.extend(self._borders(x, y, equation))
            self.cells[kept] = replace(x, boundary={**x.boundary, **y.boundary})
            self.parent[gone] = kept
            self.notes.append(f"cells {kept} and {gone} are one: {equation.text!r} glues them")

    def _subcells(self, x: Cell, y: Cell, equation: Equation) -> list[tuple[str, str]]:
        """The pairs of sub-cells that are one as well; notes the labels that change."""
        if x.points != y.points:
            raise _different(
                x, y, equation, f"they depend on {x.points} and {y.points} points, and cannot be one cell"
            )
        if set(x.subdivision) == set(y.subdivision):
            return [(target, y.subdivision[label]) for label, target in x.subdivision.items()]
        if len(x.subdivision) != 1 or len(y.subdivision) != 1:
            labels = " and ".join(", ".join(cell.subdivision) for cell in (x, y))
            raise _different(x, y, equation, f"their sub-cells need the same labels, found {labels}")
        (new,), (old,) = x.subdivision, y.subdivision
        for name in self.parent:
            if self.root(name) == y.name:
                (own,) = self.given.cells[name].subdivision
                self.renamed[name, own] = new
        return [(x.subdivision[new], y.subdivision[old])]

    def _borders(self, x: Cell, y: Cell, equation: Equation) -> list[tuple[str, str]]:
        if not x.boundary or not y.boundary:
            return []
        if set(x.boundary) != set(y.boundary):
            raise _different(x, y, equation, "their boundaries need the same labels")
        for label, border in x.boundary.items():
            if border.matrix != y.boundary[label].matrix:
                raise _different(x, y, equation, f"their embeddings {label!r} differ")
        return [(border.cell, y.boundary[label].cell) for label, border in x.boundary.items()]

    def automaton(self, standing: Mapping[str, str]) -> Automaton:
        cells = {}
        for name in self.given.cells:
            if standing[name] == name:
                members = [self.given.cells[m] for m in self.given.cells if standing[m] == name]
                cells[name] = self._cell(self.cells[name], members, standing)
        return replace(self.given, shape=standing[self.given.shape], cells=cells)

    def _cell(self, cell: Cell, members: list[Cell], standing: Mapping[str, str]) -> Cell:
        matrices: dict[str, Rows] = {}
        symmetry: dict[str, Symmetry] = {}
        for member in members:
            for label, rows in member.matrices.items():
                new = self.renamed.get((member.name, label), label)
                matrices[new] = _both(matrices[new], rows, member.name, label) if new in matrices else rows
            for label, one in member.symmetry.items():
                if label in symmetry and symmetry[label].points != one.points:
                    path = ("cells", member.name, "symmetry", label)
                    raise AutomatonError(
                        f"cell {cell.name!r}, glued to this, has another {label!r}", path=path
                    )
                symmetry[label] = self._symmetry(member.name, one)
        labels = [*cell.subdivision, *cell.boundary, *symmetry]
        twice = {label for label in labels if labels.count(label) > 1}
        if twice:
            message = f"the label {min(twice)!r} means two things in the cells {cell.name!r} stands for"
            raise AutomatonError(message, path=("cells", cell.name))
        figures = [member.figure for member in members if member.figure is not None]
        return Cell(
            cell.name,
            cell.points,
            {label: standing[target] for label, target in cell.subdivision.items()},
            {label: Boundary(standing[b.cell], b.matrix) for label, b in cell.boundary.items()},
            symmetry,
            tuple(self._equation(m.name, e) for m in members for e in m.incidence),
            tuple(self._equation(m.name, e) for m in members for e in m.adjacency),
            matrices,
            figures[0] if figures else None,
            tuple(self._equation(m.name, e) for m in members for e in m.coherence),
        )

    def _symmetry(self, cell: str, one: Symmetry) -> Symmetry:
        moved = {
            self.renamed.get((cell, i), i): self._word(cell, image) for i, image in one.subdivision.items()
        }
        return Symmetry(one.points, moved, {b: self._word(cell, image) for b, image in one.boundary.items()})

    def _equation(self, cell: str, equation: Equation) -> Equation:
        left, right = (self._word(cell, side) for side in (equation.left, equation.right))
        return replace(equation, left=left, right=right)

    def _word(self, cell: str, word: Word) -> Word:
        result = []
        for label in word:
            result.append(self.renamed.get((cell, label), label))
            target = self.given.target(cell, label)
            assert target is not None
            cell = target
        return tuple(result)


def _different(x: Cell, y: Cell, equation: Equation, why: str) -> AutomatonError:
    message = f"the sides of {equation.text!r} lead to different cells: {x.name!r} and {y.name!r}; {why}"
    return AutomatonError(message, path=equation.path)


def _both(first: Rows, second: Rows, cell: str, label: str) -> Rows:
    """One matrix of which two descriptions each give a part."""
    rows = []
    for one, other in zip(first, second, strict=True):
        for a, b in zip(one, other, strict=True):
            if a is not None and b is not None and a != b:
                path = ("cells", cell, "matrices", label)
                raise AutomatonError("a cell glued to this one gives other entries", path=path)
        rows.append(tuple(b if a is None else a for a, b in zip(one, other, strict=True)))
    return tuple(rows)
