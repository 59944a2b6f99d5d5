"""What a cell looks like after k subdivisions, worked out once for each state: points, faces, addresses.

After k subdivisions the points of a cell x are those born inside it and those born inside its boundary
cells. With I(x, k) the points born inside,

    I(x, k) = I(y, k-1) of every sub-cell, then I(z, k-1) of every cell born inside x,

the latter being the classes of `Topology.subdivided(x).interior`, and I(x, 0) is the point itself for a
point, nothing for all other cells. The points of x are I(x, k), I(z, k) for each boundary cell z, and those
that the figures of its pieces draw for themselves. All tables follow from the automaton alone: coordinates
play no part.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int

from automata.automaton import Word
from automata.symmetry import Permutation, compose
from automata.topology import Topology
from ifs.drawing import check_figure, corner_paths, padded, uses_corners

Numbers = Int[np.ndarray, "_numbers"]
Faces = Int[np.ndarray, "_faces _corners"]


class NotStamped(ValueError):
    """A cell whose figure is the box that bounds it, which is no combination of its control points."""

    def __init__(self, cell: str):
        self.cell = cell
        super().__init__(
            f"cell {cell!r} draws the box that bounds it: draw(refined(...)) makes its mesh, or state "
            "a figure with points of its own"
        )


@dataclass(frozen=True)
class Template:
    """The points and faces of one cell after some subdivisions.

    The points stand in blocks: `start[()]` is where those born inside begin, `start[path]` those born inside
    the boundary cell at a path, in that cell's order, `own` those that figures draw for themselves; `size`
    is their number. `faces` is `(faces, corners)`, shorter faces ending in -1.
    """

    start: dict[Word, int]
    own: int
    size: int
    faces: Faces


class Templates:
    """The templates of all cells of an automaton, worked out when first asked for and kept."""

    def __init__(self, topology: Topology):
        self.topology = topology
        self.automaton = topology.automaton
        self._born: dict[tuple[str, int], tuple[dict[Word, int], int]] = {}
        self._own: dict[tuple[str, int], int] = {}
        self._turned: dict[tuple[str, Permutation, int], Numbers] = {}
        self._places: dict[tuple[str, Word], tuple[Word, Word, Permutation]] = {}
        self._templates: dict[tuple[str, int], Template] = {}

    # ---- points ----------------------------------------------------------------------------------------

    def born(self, cell: str, depth: int) -> int:
        """How many points are born inside a cell in some subdivisions: |I(cell, depth)|."""
        return self.parts(cell, depth)[1]

    def parts(self, cell: str, depth: int) -> tuple[dict[Word, int], int]:
        """Where the points of each sub-cell, and of each cell born inside, begin in I; and |I|.

        Empty at depth 0.
        """
        if depth == 0:
            return {}, int(self.topology.is_point(cell))
        if (cell, depth) not in self._born:
            start: dict[Word, int] = {}
            total = 0
            words = [(label,) for label in self.automaton.cells[cell].subdivision]
            for word in (*words, *self.topology.subdivided(cell).interior):
                start[word] = total
                total += self.born(self.automaton.end(cell, word), depth - 1)
            self._born[cell, depth] = start, total
        return self._born[cell, depth]

    def own(self, cell: str, depth: int) -> int:
        """How many points the figures of the pieces draw for themselves, after some subdivisions."""
        if (cell, depth) not in self._own:
            targets = self.automaton.cells[cell].subdivision.values() if depth else ()
            inner = sum(self.own(target, depth - 1) for target in targets)
            self._own[cell, depth] = inner if depth else self._own_points(cell)
        return self._own[cell, depth]

    def turned(self, cell: str, element: Permutation, depth: int) -> Numbers:
        """For each point born inside a cell seen through a symmetry, its number in the cell itself."""
        key = cell, element, depth
        if key not in self._turned:
            self._turned[key] = self._turn(cell, element, depth)
        return self._turned[key]

    def _turn(self, cell: str, element: Permutation, depth: int) -> Numbers:
        start, total = self.parts(cell, depth)
        result = np.arange(total)
        if depth == 0 or element == self.topology.groups.identity(cell):
            return result
        for word, first in start.items():
            image, last = self.topology.groups.normal(cell, word, element)
            _, standing, before = self.place(cell, image)
            inside = self.turned(self.automaton.end(cell, standing), compose(before, last), depth - 1)
            result[first : first + len(inside)] = start[standing] + inside
        return result

    def place(self, cell: str, word: Word) -> tuple[Word, Word, Permutation]:
        """Where a path after one subdivision leads: a boundary path q of the cell, empty for the cell itself,
        what is born there at w, and a symmetry g, so that `word = q w g`.
        """
        if (cell, word) not in self._places:
            self._places[cell, word] = self._found(cell, word)
        return self._places[cell, word]

    def _found(self, cell: str, word: Word) -> tuple[Word, Word, Permutation]:
        end = self.automaton.end(cell, word)
        if len(word) == 1:
            return (), word, self.topology.groups.identity(end)
        standing, element = self.topology.subdivided(cell).place[word]
        border = self.automaton.cells[cell].boundary.get(standing[0])
        if border is None:
            return (), standing, element
        rest, born, last = self.place(border.cell, standing[1:])
        path, last = (standing[0], *rest), compose(last, element)
        first, turn = self.topology.coincident(cell)[path]
        if path == first:
            return path, born, last
        carrier = self.automaton.end(cell, first)
        image, after = self.topology.groups.normal(carrier, born, turn)
        _, born, before = self.place(carrier, image)
        return first, born, compose(compose(before, after), last)

    # ---- faces -----------------------------------------------------------------------------------------

    def template(self, cell: str, depth: int) -> Template:
        """The points and faces of a cell after some subdivisions, the faces in the order of addresses."""
        if (cell, depth) not in self._templates:
            start: dict[Word, int] = {(): 0}
            total = self.born(cell, depth)
            for path, (first, _) in self.topology.coincident(cell).items():
                if path == first:
                    start[path] = total
                    total += self.born(self.automaton.end(cell, path), depth)
            faces = self._joined(cell, depth, start, total) if depth else self._figure(cell, start, total)
            self._templates[cell, depth] = Template(start, total, total + self.own(cell, depth), faces)
        return self._templates[cell, depth]

    def _joined(self, cell: str, depth: int, start: dict[Word, int], own: int) -> Faces:
        parts = []
        for label, target in self.automaton.cells[cell].subdivision.items():
            inner = self.template(target, depth - 1)
            number = np.empty(inner.size + 1, dtype=np.int64)
            number[-1] = -1  # what the -1 of a shorter face becomes
            for path, first in inner.start.items():
                found = self._lifted(cell, (label, *path), depth, start)
                number[first : first + len(found)] = found
            count = inner.size - inner.own
            number[inner.own : -1] = own + np.arange(count)
            own += count
            parts.append(number[inner.faces])
        return padded(parts)

    def _lifted(self, cell: str, word: Word, depth: int, start: dict[Word, int]) -> Numbers:
        """The numbers, among the points of a cell, of those born in the cell that a word leads to."""
        path, born, element = self.place(cell, word)
        carrier = self.automaton.end(cell, path)
        first = start[path] + self.parts(carrier, depth)[0][born]
        return first + self.turned(self.automaton.end(carrier, born), element, depth - 1)

    def _own_points(self, cell: str) -> int:
        description = self.automaton.cells[cell]
        figure = description.figure
        if uses_corners(description, corner_paths(self.topology, cell)):
            return 0
        if figure is None or not (figure.points or figure.kind in ("segment", "polygon")):
            raise NotStamped(cell)
        return len(figure.points) or description.points

    def _figure(self, cell: str, start: dict[Word, int], first: int) -> Faces:
        description = self.automaton.cells[cell]
        figure = description.figure
        corners = corner_paths(self.topology, cell)
        own = self._own_points(cell)
        numbers = first + np.arange(own) if own else np.array([start[path] for path in corners])
        stated = figure.faces if figure and figure.faces else (tuple(range(len(numbers))),)
        if figure and figure.kind == "segment":
            stated = ((0, len(numbers) - 1),)
        check_figure(description, len(numbers))
        return padded([numbers[None, list(face)] for face in stated])

    # ---- addresses -------------------------------------------------------------------------------------

    def address(self, cell: str, depth: int, face: int) -> Word:
        """The address of the piece that draws a face of a template."""
        labels = []
        while depth:
            depth -= 1
            for label, target in self.automaton.cells[cell].subdivision.items():
                count = len(self.template(target, depth).faces)
                if face < count:
                    labels.append(label)
                    cell = target
                    break
                face -= count
        return tuple(labels)

    def addresses(self, cell: str, depth: int) -> Int[np.ndarray, "_faces depth"]:
        """The address of the piece that draws each face: the numbers of its labels, first label first."""
        if depth == 0:
            return np.zeros((len(self.template(cell, 0).faces), 0), dtype=np.int64)
        parts = []
        for number, target in enumerate(self.automaton.cells[cell].subdivision.values()):
            inner = self.addresses(target, depth - 1)
            parts.append(np.pad(inner, ((0, 0), (1, 0)), constant_values=number))
        return np.concatenate(parts)
