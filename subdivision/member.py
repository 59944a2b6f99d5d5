"""The members of an affine family as arrays: operators, and their products along paths, at any parameters."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import Any

from automata.automaton import Rows, Word
from automata.document import suggestion
from subdivision.error import WrongValue
from subdivision.form import CONSTANT, Form
from subdivision.solution import Forms, Solution

Array = Any
"""An array of NumPy, or of JAX while a function of the parameters is traced."""


@dataclass(frozen=True)
class Family:
    """All operators of a solution as affine functions of its free parameters x.

    `operators[cell, label]` is the pair (constant of shape (rows, columns), coefficients of shape
    (rows, columns, parameters)), so that `T(x) = constant + coefficients · x`, both rounded to doubles.
    """

    solution: Solution
    operators: Mapping[tuple[str, str], tuple[Array, Array]]
    places: Mapping[int, int]

    @property
    def size(self) -> int:
        """The number of free parameters."""
        return len(self.places)

    def at(self, x: Array, xp: Any) -> "Member":
        """The member with parameters x, of shape (parameters,), computed by `xp`: numpy or jax.numpy."""
        return Member(self, x, xp)

    @cached_property
    def table(self) -> tuple[Array, Array]:
        """All entries of all subdivision operators: constants (entries,), coefficients (entries, x)."""
        import numpy as np

        chosen = [self.operators[c, k] for c, table in self.solution.operators.items() for k in table]
        chosen = [pair for pair in chosen if pair[0].size]
        if not chosen:
            return np.zeros(0), np.zeros((0, self.size))
        return (
            np.concatenate([constant.ravel() for constant, _ in chosen]),
            np.concatenate([linear.reshape(constant.size, self.size) for constant, linear in chosen]),
        )

    def form(self, key: str) -> tuple[float, Array]:
        """A parameter or an entry as constant and coefficients (parameters,). Raises `WrongValue`."""
        import numpy as np

        constant, linear = _affine(self.solution.form(key), self.places, self.solution.fixed)
        row = np.zeros(self.size)
        for place, coefficient in linear.items():
            row[place] = coefficient
        return constant, row

    def points(self, cell: str) -> int:
        """The number of control points of a cell. Raises `WrongValue` for a cell that is not there."""
        cells = self.solution.automaton.cells
        if cell not in cells:
            raise WrongValue(f"there is no cell {cell!r}{suggestion(cell, cells)}")
        return cells[cell].points

    def end(self, cell: str, word: Word) -> str:
        """The cell that a word leads to. Raises `WrongValue` where the word does not compose."""
        self.points(cell)
        for place, label in enumerate(word):
            target = self.solution.automaton.target(cell, label)
            if target is None:
                here = self.solution.automaton.cells[cell]
                known = [*here.subdivision, *here.boundary, *here.symmetry]
                raise WrongValue(
                    f"the word {' '.join(word)!r} stops at its label {place + 1}: the cell {cell!r} has no "
                    f"{label!r}{suggestion(label, known)}"
                )
            cell = target
        return cell

    def require_loop(self, cell: str, word: Word) -> None:
        """Raises `WrongValue` unless the word composes and returns to its cell."""
        end = self.end(cell, word)
        if not word or end != cell:
            said = f"the word {' '.join(word)!r}" if word else "the empty word"
            raise WrongValue(
                f"{said} leads from {cell!r} to {end!r}: eigenvalues need a word that returns to its cell"
            )

    def loops(self, cell: str, longest: int) -> Iterator[Word]:
        """The words of sub-cells, up to a length, that return to a cell."""
        cells = self.solution.automaton.cells
        paths: list[tuple[Word, str]] = [((), cell)]
        for _ in range(longest):
            paths = [((*w, k), target) for w, at in paths for k, target in cells[at].subdivision.items()]
            yield from (word for word, at in paths if at == cell)


@dataclass(frozen=True)
class Member:
    """The operators of a family at one point x of its parameters."""

    family: Family
    x: Array
    xp: Any
    linears: dict[tuple[str, Word], Array] = field(default_factory=dict)
    """Linear parts that were asked for before."""

    def operator(self, cell: str, label: str) -> Array:
        """One operator, embedding or symmetry: (points of the cell, points of where it leads)."""
        constant, linear = self.family.operators[cell, label]
        return constant + linear @ self.x if linear.any() else constant

    def product(self, cell: str, word: Word) -> Array:
        """The product of the operators along a word that starts at a cell."""
        if not word:
            return self.xp.eye(self.family.points(cell))
        result = self.operator(cell, word[0])
        for place, label in enumerate(word[1:], start=1):
            result = result @ self.operator(self.family.end(cell, word[:place]), label)
        return result

    def linear(self, cell: str, word: Word) -> Array:
        """The linear part of a loop: its product on differences of points, where the fixed point's 1 is gone.

        In the orthonormal basis D of `differences`, `L = D^T T D` of shape (points - 1, points - 1).
        """
        if (cell, word) not in self.linears:
            basis = differences(self.family.points(cell))
            self.linears[cell, word] = basis.T @ self.product(cell, word) @ basis
        return self.linears[cell, word]

    def fixed_point(self, cell: str, word: Word) -> Array:
        """The point c with `T c = c` and coordinates that sum to 1; unique when the loop contracts."""
        xp, size = self.xp, self.family.points(cell)
        border = xp.ones((size, 1))
        left = self.product(cell, word) - xp.eye(size)
        system = xp.concatenate(
            [xp.concatenate([left, border], axis=1), xp.concatenate([border.T, xp.zeros((1, 1))], axis=1)]
        )
        return xp.linalg.solve(system, xp.concatenate([xp.zeros(size), xp.ones(1)]))[:size]


def family(solution: Solution) -> Family:
    """The operators of a solution as affine functions of its free parameters, in their order.

    >>> import automata, subdivision
    >>> import numpy as np
    >>> member = family(subdivision.solve(automata.read("corner-cutting"))).at(np.array([0.25, 0.25]), np)
    >>> member.operator("edge", "0")[0].tolist()
    [0.75, 0.25, 0.0]
    """
    places = {
        i: k for k, i in enumerate(i for i in range(len(solution.parameters)) if i not in solution.fixed)
    }
    operators = {}
    for name, cell in solution.automaton.cells.items():
        for label, rows in solution.operators.get(name, {}).items():
            operators[name, label] = _matrix(rows, places, solution)
        for label, boundary in cell.boundary.items():
            if (name, label) not in operators:
                operators[name, label] = _given(boundary.matrix, len(places))
        for label, symmetry in cell.symmetry.items():
            operators[name, label] = _permutation(symmetry.points, len(places))
    return Family(solution, operators, places)


def differences(points: int) -> Array:
    """An orthonormal basis of the vectors whose coordinates sum to 0: (points, points - 1), by columns.

    Column k is `(1, …, 1, -k, 0, …)` with k ones, scaled to length 1.

    >>> (differences(2) * 2**0.5).round(12).tolist()
    [[1.0], [-1.0]]
    """
    import numpy as np

    basis = np.zeros((points, points - 1))
    for k in range(1, points):
        basis[:k, k - 1] = 1
        basis[k, k - 1] = -k
        basis[:, k - 1] /= (k * (k + 1)) ** 0.5
    return basis


def _matrix(rows: Forms, places: Mapping[int, int], solution: Solution) -> tuple[Array, Array]:
    import numpy as np

    constant = np.zeros((len(rows), len(rows[0])))
    linear = np.zeros((*constant.shape, len(places)))
    for i, row in enumerate(rows):
        for j, form in enumerate(row):
            constant[i, j], coefficients = _affine(form, places, solution.fixed)
            for place, coefficient in coefficients.items():
                linear[i, j, place] = coefficient
    return constant, linear


def _given(rows: Rows, parameters: int) -> tuple[Array, Array]:
    import numpy as np

    values = [[_number(getattr(entry, "value", entry)) for entry in row] for row in rows]
    constant = np.array(values, dtype=float)
    return constant, np.zeros((*constant.shape, parameters))


def _permutation(points: tuple[int, ...], parameters: int) -> tuple[Array, Array]:
    import numpy as np

    constant = np.zeros((len(points), len(points)))
    constant[list(points), range(len(points))] = 1
    return constant, np.zeros((*constant.shape, parameters))


def _affine(
    form: Form, places: Mapping[int, int], fixed: Mapping[int, Form]
) -> tuple[float, dict[int, float]]:
    """A form as constant and coefficients by place, parameters that have a value replaced by it."""
    exact: dict[int, Fraction] = {}
    for key, coefficient in form.items():
        terms = {key: Fraction(1)} if key == CONSTANT or key in places else fixed[key]
        for inner, factor in terms.items():
            exact[inner] = exact.get(inner, Fraction(0)) + coefficient * factor
    constant = exact.pop(CONSTANT, Fraction(0))
    return _number(constant), {places[key]: _number(value) for key, value in exact.items() if value}


def _number(value: Any) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        raise WrongValue(
            f"{value} is no number: give the parameters of the description values before choosing"
        ) from None
