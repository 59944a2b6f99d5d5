"""The automaton: cells, what each is subdivided into, and which boundaries are shared."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction

from automata.expression import Expression, Name, Number

Word = tuple[str, ...]
"""A path through the automaton, as labels: `("left", "s")` is the operator product `left s`."""

Entry = Number | Name | Expression
Rows = tuple[tuple[Entry | None, ...], ...]
"""A matrix by rows; an entry that is left open is None."""


@dataclass(frozen=True)
class Equation:
    """`left = right`: two paths that must give the same operator.

    `text` is what the user wrote, `path` the keys that lead to it in the description.
    """

    left: Word
    right: Word
    text: str
    path: tuple[str | int, ...] = ()


@dataclass(frozen=True)
class Boundary:
    """The embedding of a boundary cell: which cell, and the matrix of its embedding operator.

    `matrix` is `(points of the cell, points of the boundary cell)`, each column summing to 1; most
    embeddings select points, and then each column holds a single 1. An entry that is None is unknown.
    """

    cell: str
    matrix: Rows


@dataclass(frozen=True)
class Symmetry:
    """A permutation of a cell's control points under which its operators correspond.

    Its matrix S has a 1 in row `points[j]` of column j. `subdivision[i] = (j, g…)` states
    `S T_i = T_j g…` and `boundary[b] = (c, g…)` states `S B_b = B_c g…`, with g symmetries.
    """

    points: tuple[int, ...]
    subdivision: Mapping[str, Word]
    boundary: Mapping[str, Word]


@dataclass(frozen=True)
class Figure:
    """What a cell draws at the last level: points of its barycentric space, and faces on them.

    Without `points` the faces count the limit vertices of the cell's boundary.
    """

    kind: str
    points: tuple[tuple[Fraction, ...], ...] = ()
    faces: tuple[tuple[int, ...], ...] = ()


@dataclass(frozen=True)
class Cell:
    """A state of the automaton: face, edge, vertex, or any fractal piece.

    `points` is the number n of control points it depends on, so that it lives in R^n with coordinates
    summing to 1. `subdivision` names the cell of each sub-cell, `boundary` the embeddings,
    `matrices` the operators that are given wholly or in part, `coherence` equations between embeddings
    that the description vouches for, `share` the boundaries that pieces have in common where the equations
    are to be worked out from that.
    """

    name: str
    points: int
    subdivision: Mapping[str, str]
    boundary: Mapping[str, Boundary] = field(default_factory=dict)
    symmetry: Mapping[str, Symmetry] = field(default_factory=dict)
    incidence: tuple[Equation, ...] = ()
    adjacency: tuple[Equation, ...] = ()
    matrices: Mapping[str, Rows] = field(default_factory=dict)
    figure: Figure | None = None
    coherence: tuple[Equation, ...] = ()
    share: tuple[Equation, ...] = ()

    @property
    def equations(self) -> tuple[Equation, ...]:
        """The stated constraints: incidence first, then adjacency."""
        return self.incidence + self.adjacency

    def symmetry_equations(self) -> Iterator[Equation]:
        """The constraints that the declared symmetries bring: `S T_i = T_j g` and `S B_b = B_c g`."""
        for name, symmetry in self.symmetry.items():
            for kind in ("subdivision", "boundary"):
                for label, image in getattr(symmetry, kind).items():
                    text = f"{name} {label} = {' '.join(image)}"
                    path = ("cells", self.name, "symmetry", name, kind, label)
                    yield Equation((name, label), image, text, path)


@dataclass(frozen=True)
class Automaton:
    """A shape described by iteration, before any number is chosen.

    `values` holds what the user set (`"edge.0[1,0]"` or a parameter's name, to an exact number or an
    expression in parameters), `names` the names given to entries, `control` the control points in
    millimetres, a row each. `parameters` holds the values of names that expressions use.
    """

    name: str
    shape: str
    cells: Mapping[str, Cell]
    values: Mapping[str, Fraction | Expression] = field(default_factory=dict)
    names: Mapping[str, str] = field(default_factory=dict)
    control: tuple[tuple[float, ...], ...] | None = None
    parameters: Mapping[str, Fraction] = field(default_factory=dict)
    placing: frozenset[str] = frozenset()
    """The parameters that control points are expressions in."""

    def target(self, cell: str, label: str) -> str | None:
        """The cell that a label leads to from `cell`, or None when the cell has no such label."""
        here = self.cells[cell]
        if label in here.subdivision:
            return here.subdivision[label]
        if label in here.boundary:
            return here.boundary[label].cell
        return cell if label in here.symmetry else None

    def end(self, cell: str, word: Word) -> str:
        """The cell that a word leads to; the word must compose."""
        for label in word:
            target = self.target(cell, label)
            assert target is not None, (cell, word)
            cell = target
        return cell

    def reachable(self) -> tuple[str, ...]:
        """The cells that the shape needs, in the order in which they are met."""
        found = [self.shape]
        for name in found:
            cell = self.cells[name]
            targets = [*cell.subdivision.values(), *(b.cell for b in cell.boundary.values())]
            found.extend(t for t in dict.fromkeys(targets) if t not in found)
        return tuple(found)
