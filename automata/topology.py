"""Which boundaries of the sub-cells of a cell are the same cell: topology without coordinates.

After one subdivision of a cell x, the boundary cells of its sub-cells are named by paths such as `0 right`
(a boundary of a sub-cell) and `left s` (a sub-cell of a boundary). The stated incidences and adjacencies,
and boundaries whose embeddings coincide, say which paths name the same cell. Each class of such paths is
either *inherited*, a piece of a boundary of x that neighbours of x share, or *interior*, born inside x.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import islice

from automata.automaton import Automaton, Word
from automata.error import AutomatonError
from automata.expression import Number
from automata.merging import merged
from automata.parameters import settled
from automata.symmetry import Groups, Permutation, compose, inverse, symmetry_groups

Located = tuple[Word, Permutation]
"""A path and a symmetry after it."""

Relation = tuple[Word, Word, Permutation]
"""`left = right element`, both sides free of symmetries otherwise."""

MOST_PATHS = 2000
MOST_WORDS = 60_000


@dataclass(frozen=True)
class Subdivided:
    """One cell after one subdivision.

    `place[w] = (c, p)` says that the path w names the same cell as `c p`, c the path that stands for its
    class. `interior` lists the paths c of cells born inside, with the cell each of them is.
    `folded` lists paths found equal to themselves through a symmetry that is not the identity.
    """

    place: Mapping[Word, Located]
    interior: Mapping[Word, str]
    folded: tuple[Word, ...]


class Topology:
    """The gluing of all cells of an automaton, worked out cell by cell when first asked for.

    `automaton` is the given one with its parameters settled and the cells merged that must be one.
    """

    def __init__(self, automaton: Automaton):
        self.automaton = merged(settled(automaton)).automaton
        self._room = MOST_WORDS
        self._subdivided: dict[str, Subdivided] = {}
        self._boundaries: dict[str, tuple[Word, ...]] = {}
        self._coincident: dict[str, dict[Word, Located]] = {}
        self._equations: dict[str, dict[str, list[Relation]]] = {}
        self.groups: Groups = symmetry_groups(self.automaton)

    def boundaries(self, cell: str) -> tuple[Word, ...]:
        """All paths of one or more boundary labels, shortest first within each branch."""
        if cell not in self._boundaries:
            paths: list[Word] = []
            for label, boundary in self.automaton.cells[cell].boundary.items():
                paths.append((label,))
                paths.extend((label, *rest) for rest in self.boundaries(boundary.cell))
                if len(paths) > MOST_PATHS:
                    path = ("cells", cell, "boundary")
                    raise AutomatonError(f"over {MOST_PATHS} paths lead to boundaries", path=path)
            self._boundaries[cell] = tuple(paths)
        return self._boundaries[cell]

    def coincident(self, cell: str) -> Mapping[Word, Located]:
        """For each boundary path, the first one with the same embedding, up to a symmetry."""
        if cell not in self._coincident:
            first: dict[tuple[str, tuple], Located] = {}
            result: dict[Word, Located] = {}
            for path in self.boundaries(cell):
                end = self.automaton.end(cell, path)
                columns = embedding(self.automaton, cell, path)
                identity = self.groups.identity(end)
                result[path] = first.get((end, columns), (path, identity))
                if (end, columns) in first:
                    continue
                for element in self.groups.elements[end]:
                    seen = tuple(columns[i] for i in element)
                    first.setdefault((end, seen), (path, element))
            self._coincident[cell] = result
        return self._coincident[cell]

    def is_point(self, cell: str) -> bool:
        """Whether the attractor of a cell is a single point: it and all it becomes have one sub-cell."""
        seen: set[str] = set()
        while cell not in seen:
            seen.add(cell)
            targets = list(self.automaton.cells[cell].subdivision.values())
            if len(targets) != 1:
                return False
            cell = targets[0]
        return True

    def subdivided(self, cell: str) -> Subdivided:
        """The classes of boundary paths of a cell after one subdivision."""
        if cell not in self._subdivided:
            self._subdivided[cell] = self._glue(cell)
        return self._subdivided[cell]

    def _glue(self, cell: str) -> Subdivided:
        words = tuple(islice(self._words(cell), self._room + 1))
        if len(words) > self._room:
            message = f"the sub-cells of all cells have over {MOST_WORDS} boundaries"
            raise AutomatonError(message, path=("cells", cell))
        self._room -= len(words)
        union = _Union({word: self.groups.identity(self.automaton.end(cell, word)) for word in words})
        folded = [
            word
            for word in words
            for other, element in self._rewritings(cell, word)
            if other in union.parent and not union.join(word, other, element)
        ]
        own = self.automaton.cells[cell].boundary
        best: dict[Word, Word] = {}
        for word in words:
            root, _ = union.find(word)
            rank = (word[0] not in own, len(word))
            if root not in best or rank < (best[root][0] not in own, len(best[root])):
                best[root] = word
        place: dict[Word, Located] = {}
        for word in words:
            root, element = union.find(word)
            standing = best[root]
            place[word] = (standing, compose(inverse(union.find(standing)[1]), element))
        interior = {word: self.automaton.end(cell, word) for word in best.values() if word[0] not in own}
        pointless = tuple(w for w in folded if not self.is_point(self.automaton.end(cell, w)))
        return Subdivided(place, interior, pointless)

    def _words(self, cell: str) -> Iterator[Word]:
        """Boundaries of sub-cells, sub-cells of boundaries, and boundaries of these."""
        for label, target in self.automaton.cells[cell].subdivision.items():
            yield from ((label, *path) for path in self.boundaries(target))
        for path in self.boundaries(cell):
            for label, target in self.automaton.cells[self.automaton.end(cell, path)].subdivision.items():
                yield (*path, label)
                yield from ((*path, label, *rest) for rest in self.boundaries(target))

    def _rewritings(self, cell: str, word: Word) -> Iterator[Located]:
        """The paths that one stated equation, or one coincidence of boundaries, makes of a path."""
        here = cell
        for position, label in enumerate(word):
            before, after = word[:position], word[position:]
            for left, right, element in self._relations(here).get(label, ()):
                if after[: len(left)] == left:
                    yield self._continued(here, before, right, element, after[len(left) :])
            coincident = self.coincident(here)
            for length in range(1, len(after) + 1):
                path = after[:length]
                if path not in coincident:
                    break
                first, element = coincident[path]
                if path != first:
                    yield self._continued(here, before, first, element, after[length:])
            target = self.automaton.target(here, label)
            assert target is not None
            here = target

    def _continued(self, here: str, before: Word, middle: Word, element: Permutation, rest: Word) -> Located:
        end = self.automaton.end(here, middle)
        tail, last = self.groups.normal(end, rest, element)
        return before + middle + tail, last

    def _relations(self, cell: str) -> Mapping[str, list[Relation]]:
        """The equations of a cell and their images by its symmetries, as `left = right element`."""
        if cell not in self._equations:
            table: dict[str, list[Relation]] = {}
            for equation in self.automaton.cells[cell].equations:
                for element in self.groups.elements[cell]:
                    left, p = self.groups.normal(cell, equation.left, element)
                    right, q = self.groups.normal(cell, equation.right, element)
                    if left and right:
                        table.setdefault(left[0], []).append((left, right, compose(q, inverse(p))))
            self._equations[cell] = table
        return self._equations[cell]


def embedding(automaton: Automaton, cell: str, path: Word) -> tuple:
    """The columns of the embedding along a boundary path, as a key: equal keys are equal matrices.

    An embedding that is unknown, or has parameters without a value, is equal to no other one's.
    """
    start, points = cell, automaton.cells[cell].points
    columns = [{row: 1} for row in range(points)]
    for label in path:
        boundary = automaton.cells[cell].boundary[label]
        width = len(boundary.matrix[0])
        if not all(isinstance(entry, Number) for row in boundary.matrix for entry in row):
            width = automaton.cells[automaton.end(start, path)].points
            return tuple(((path, column),) for column in range(width))
        columns = [_column(columns, boundary.matrix, j) for j in range(width)]
        cell = boundary.cell
    return tuple(tuple(sorted(column.items())) for column in columns)


def _column(columns: list[dict], matrix, j: int) -> dict:
    result: dict = {}
    for row, line in enumerate(matrix):
        weight = line[j].value
        if weight:
            for place, value in columns[row].items():
                result[place] = result.get(place, 0) + weight * value
    return {place: value for place, value in result.items() if value}


class _Union:
    """Union-find whose links carry symmetries: `word = parent element`."""

    def __init__(self, identities: Mapping[Word, Permutation]):
        self.parent: dict[Word, Located] = {word: (word, one) for word, one in identities.items()}

    def find(self, word: Word) -> Located:
        chain = []
        while self.parent[word][0] != word:
            chain.append(word)
            word = self.parent[word][0]
        found = self.parent[word]
        for step in reversed(chain):
            found = word, compose(found[1], self.parent[step][1])
            self.parent[step] = found
        return found

    def join(self, word: Word, other: Word, element: Permutation) -> bool:
        """State `word = other element`; False when that makes a cell equal to itself turned."""
        root, p = self.find(word)
        target, q = self.find(other)
        if root == target:
            return p == compose(q, element)
        self.parent[root] = (target, compose(compose(q, element), inverse(p)))
        return True
