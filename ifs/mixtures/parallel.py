"""Several systems that run along one address, as a system of one larger space.

Two spaces serve. In `together` points of the systems stand side by side: `x = (x_1, …, x_K)`, each summing
to 1, which is a space of `1 + sum (n_k - 1)` points. In `times` they are multiplied: `x ⊗ y`, `n m` points.
Operators, embeddings and symmetries act on each part, so that the equations of the parts hold for the whole.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from jaxtyping import Float

from automata import Automaton, AutomatonError, Boundary, Cell, Symmetry
from automata.automaton import Equation, Rows, Word
from automata.expression import Number
from automata.topology import Topology
from ifs.dimensions.alike import Cells, DifferentGluing, Factor, Matrix, alike, factor, same_partition
from ifs.mixtures.spaces import Grid, Numbers, Space, Staircase, moved
from ifs.shape import Shape, system

MOST_POINTS = 400

_NUMBER = {Fraction(k): Number(Fraction(k)) for k in (0, 1)}


@dataclass(frozen=True)
class Product:
    """An automaton that runs several along one address; `points` tells its shape's control points apart.

    Control point t of the shape stands for the control points `points[t][k]` of the parts k.
    """

    automaton: Automaton
    points: tuple[Numbers, ...]


def times(*automata: Automaton) -> Product:
    """The points `x_1(s) ⊗ … ⊗ x_K(s)` at every address s: operators `T_i^1 ⊗ … ⊗ T_i^K`.

    Columns sum to 1, and the joint spectral radius is the largest of those of the parts, since
    `(1 + a) ⊗ (1 + b) = 1 + a + b + a ⊗ b` on differences. Raises `DifferentGluing`, and `ValueError` for
    over 400 control points.

    >>> from subdivision.schemes import bezier
    >>> len(times(bezier(1), bezier(2)).points)
    6
    """
    return _product(automata, lambda sizes, turns: Grid(sizes), lambda sizes: _size(sizes, False), " times ")


def together(*automata: Automaton) -> Product:
    """The points `(x_1(s), …, x_K(s))` at every address s, in `1 + sum (n_k - 1)` control points.

    They are a staircase of tuples `(i_1, …, i_K)` from `(0, …, 0)` to `(n_1 - 1, …, n_K - 1)`, one number
    going up by one at each step: all others are affine combinations of these. Where the gluing needs a
    symmetry that does not keep the staircase, the images of the staircase are added. The joint spectral
    radius is the largest of those of the parts. Raises `DifferentGluing`, and `ValueError` for over 400
    control points.

    >>> from subdivision.schemes import bezier, takagi
    >>> together(bezier(2), takagi()).points
    ((0, 0), (1, 0), (1, 1), (1, 2), (2, 2))
    """
    return _product(automata, Staircase, lambda sizes: _size(sizes, True), " and ")


def given(automaton: Automaton, control: Float[np.ndarray, "points dim"]) -> Shape:
    """The shape of an automaton whose matrices are all given and known to meet its constraints."""
    numbers = {
        name: {
            label: tuple(tuple(e.value for e in row if isinstance(e, Number)) for row in rows)
            for label, rows in cell.matrices.items()
        }
        for name, cell in automaton.cells.items()
    }
    return Shape(automaton.name, Topology(automaton), system(automaton, numbers), control)


def _size(sizes: Sequence[int], side_by_side: bool) -> int:
    count = 1
    for size in sizes:
        count = count + size - 1 if side_by_side else count * size
    return count


def _product(automata: Sequence[Automaton], space, size, between: str) -> Product:
    if not automata:
        raise ValueError("a product needs one automaton or more, found none")
    factors = [factor(automaton) for automaton in automata]
    found = alike(factors)
    for cells in found:
        count = size([f.cell(c).points for f, c in zip(factors, cells, strict=True)])
        if count > MOST_POINTS:
            raise ValueError(
                f"cells {', '.join(cells)} together have {count} control points, over {MOST_POINTS}"
            )
    shared = _shared(factors, found)
    used = {
        label
        for one, cells in zip(factors, zip(*found, strict=True), strict=True)
        for cell in cells
        for equation in one.cell(cell).equations
        for label in (*equation.left, *equation.right)
    }
    if not any(name in used for names in shared.values() for name in names):
        spaces = {
            cells: space(_sizes(factors, cells), _turns(factors, cells, shared[cells])) for cells in found
        }
        if any(not getattr(one, "minimal", True) for one in spaces.values()):
            shared = dict.fromkeys(found, ())
    built = _Building(factors, found, shared, space, between)
    automaton = built.automaton()
    _require_same(factors[0], automaton, built.names)
    return Product(automaton, tuple(built.spaces[found[0]].points))


def _sizes(factors: Sequence[Factor], cells: Cells) -> list[int]:
    return [one.cell(cell).points for one, cell in zip(factors, cells, strict=True)]


def _turns(factors: Sequence[Factor], cells: Cells, names: Iterable[str]) -> list[tuple[Numbers, ...]]:
    return [
        tuple(one.cell(cell).symmetry[name].points for one, cell in zip(factors, cells, strict=True))
        for name in names
    ]


def _shared(factors: Sequence[Factor], found: Sequence[Cells]) -> dict[Cells, tuple[str, ...]]:
    """The symmetries that all parts have, with the same images of labels."""
    shared: dict[Cells, tuple[str, ...]] = {}
    for cells in found:
        parts = [one.cell(cell) for one, cell in zip(factors, cells, strict=True)]
        shared[cells] = tuple(
            name
            for name, own in parts[0].symmetry.items()
            if all(
                name in part.symmetry
                and part.symmetry[name].subdivision == own.subdivision
                and part.symmetry[name].boundary == own.boundary
                for part in parts
            )
        )
    changed = True
    while changed:
        kept = {
            cells: tuple(n for n in names if _images_shared(factors, cells, n, shared))
            for cells, names in shared.items()
        }
        changed, shared = kept != shared, kept
    return shared


def _images_shared(factors: Sequence[Factor], cells: Cells, name: str, shared: Mapping[Cells, tuple]) -> bool:
    symmetry = factors[0].cell(cells[0]).symmetry[name]
    for image in (*symmetry.subdivision.values(), *symmetry.boundary.values()):
        after = _after(factors, cells, image[:1])
        if not all(label in shared[after] for label in image[1:]):
            return False
    return True


def _after(factors: Sequence[Factor], cells: Cells, word: Word) -> Cells:
    return tuple(one.automaton.end(cell, word) for one, cell in zip(factors, cells, strict=True))


@dataclass
class _Building:
    factors: Sequence[Factor]
    found: Sequence[Cells]
    shared: Mapping[Cells, tuple[str, ...]]
    space: object
    between: str

    def __post_init__(self):
        self.spaces: dict[Cells, Space] = {
            cells: self.space(_sizes(self.factors, cells), _turns(self.factors, cells, self.shared[cells]))  # type: ignore
            for cells in self.found
        }
        self.names = {cells: _name(cells) for cells in self.found}

    def automaton(self) -> Automaton:
        cells = {self.names[cells]: self.cell(cells) for cells in self.found}
        name = self.between.join(one.name for one in self.factors)
        return Automaton(name, self.names[self.found[0]], cells)

    def cell(self, cells: Cells) -> Cell:
        first = self.factors[0].cell(cells[0])
        after = {
            label: _after(self.factors, cells, (label,)) for label in (*first.subdivision, *first.boundary)
        }
        matrices = {label: self.matrix(cells, label, target) for label, target in after.items()}
        incidence, adjacency = (
            self.equations(cells, getattr(first, kind), kind) for kind in ("incidence", "adjacency")
        )
        return Cell(
            self.names[cells],
            len(self.spaces[cells].points),
            {label: self.names[after[label]] for label in first.subdivision},
            {label: Boundary(self.names[after[label]], matrices[label]) for label in first.boundary},
            {name: self.symmetry(cells, name) for name in self.shared[cells]},
            incidence,
            adjacency,
            {label: matrices[label] for label in first.subdivision},
            first.figure if first.figure and not first.figure.points else None,
        )

    def matrix(self, cells: Cells, label: str, target: Cells) -> Rows:
        parts: list[Matrix] = [
            one.matrices[cell][label] for one, cell in zip(self.factors, cells, strict=True)
        ]
        columns = [
            self.spaces[cells].weights(
                [[row[n] for row in part] for part, n in zip(parts, point, strict=True)]
            )
            for point in self.spaces[target].points
        ]
        return tuple(
            tuple(_NUMBER.get(value) or Number(value) for value in row) for row in zip(*columns, strict=True)
        )

    def symmetry(self, cells: Cells, name: str) -> Symmetry:
        (turn,) = _turns(self.factors, cells, [name])
        points = self.spaces[cells].points
        number = {point: i for i, point in enumerate(points)}
        own = self.factors[0].cell(cells[0]).symmetry[name]
        return Symmetry(tuple(number[moved(turn, point)] for point in points), own.subdivision, own.boundary)

    def equations(self, cells: Cells, stated: Sequence[Equation], kind: str) -> tuple[Equation, ...]:
        """The stated equations; where a symmetry is not shared, their images that are free of symmetries."""
        one, cell = self.factors[0], cells[0]
        groups = one.topology.groups
        pairs: dict[tuple[Word, Word], None] = {}
        for equation in stated:
            if self._composes(cells, equation.left) and self._composes(cells, equation.right):
                pairs[equation.left, equation.right] = None
            if set(self.shared[cells]) == set(one.cell(cell).symmetry):
                continue
            for element in groups.elements[cell]:
                (left, p), (right, q) = (
                    groups.normal(cell, side, element) for side in (equation.left, equation.right)
                )
                if p == q:
                    pairs[left, right] = None
        path = ("cells", self.names[cells], kind)
        return tuple(
            Equation(left, right, f"{' '.join(left)} = {' '.join(right)}", (*path, i))
            for i, (left, right) in enumerate(pairs)
        )

    def _composes(self, cells: Cells, word: Word) -> bool:
        for place, label in enumerate(word):
            here = _after(self.factors, cells, tuple(word[:place]))
            if label in self.factors[0].cell(here[0]).symmetry and label not in self.shared[here]:
                return False
        return True


def _name(cells: Cells) -> str:
    return cells[0] if len(set(cells)) == 1 else "|".join(cells)


def _require_same(one: Factor, automaton: Automaton, names: Mapping[Cells, str]) -> None:
    """The product is glued as its parts are."""
    try:
        topology = Topology(automaton)
    except AutomatonError as error:  # pragma: no cover - the parts have the same symmetries
        raise AssertionError from error
    for cells, name in names.items():
        places = one.topology.subdivided(cells[0]).place, topology.subdivided(name).place
        if not same_partition(*places):
            cell = one.cell(cells[0])
            missing = sorted(set(cell.symmetry) - set(automaton.cells[name].symmetry))
            raise DifferentGluing(
                (one.name, automaton.name),
                (cell.name, name),
                " ".join(missing),
                f"the gluing needs symmetries that not all have: {', '.join(missing) or 'of other cells'}",
            )
