"""What can be asked of the members of a family, one small class each.

A condition writes equations `= 0` and margins `>= 0` in the operators of a member and in unknowns z of its
own, such as eigenvectors. `guess` starts z at a member; the same code runs on NumPy and on JAX.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from numbers import Complex, Rational, Real
from typing import Any, Protocol, runtime_checkable

from automata.automaton import Word
from subdivision.eigen import rest, schur_vectors, spectral_radius, triangle
from subdivision.error import WrongValue
from subdivision.member import Array, Family, Member

Number = Rational | float | complex


@runtime_checkable
class Request(Protocol):
    """A condition on a member. `z` has the shape of `guess`; `start` numbers the start points."""

    @property
    def text(self) -> str:
        """The request in words."""
        ...

    def check(self, family: Family) -> None:
        """Raises `WrongValue` where the request does not fit the automaton."""
        ...

    def guess(self, member: Member, start: int) -> Array:
        """A first value of the unknowns z, by NumPy."""
        ...

    def equations(self, member: Member, z: Array) -> Array:
        """The residuals that are to be 0, a flat array."""
        ...

    def margins(self, member: Member, z: Array) -> Array:
        """The numbers that are to be at least 0, a flat array."""
        ...


@dataclass(frozen=True)
class Eigenvalue:
    """An eigenvalue of the product along a word that returns to its cell, on differences of points.

    On differences the eigenvalue 1 of the fixed point is gone. With L the linear part, V^T V = 1 and N
    strictly upper triangular, the unknowns V and N satisfy

        L V = V (value + N),

    V of as many columns as the `multiplicity`: a Schur form, which holds for one eigenvector as for a Jordan
    block, and stays regular at both. (The determinant `det(L - value)` has a vanishing derivative where an
    eigenvalue is double, and finds it to eight digits only.) A complex value asks for the pair with its
    conjugate. `dominant` asks, besides, that no other eigenvalue on differences has a larger modulus. The
    residual bounds the smallest singular value of `L - value`: so small a change of L makes it exact.

    Source: Gentil 2010, section 4.3.1 (eigenvalues 1, a, 1 - a - b of T_0).
    """

    cell: str
    word: Word
    value: Number
    multiplicity: int = 1
    dominant: bool = False

    @property
    def text(self) -> str:
        times = f" ({self.multiplicity} times)" if self.multiplicity > 1 else ""
        kind = "dominant eigenvalue" if self.dominant else "eigenvalue"
        return f"{kind} {self.value}{times} of {self.cell}.{' '.join(self.word)}"

    @property
    def pair(self) -> bool:
        return isinstance(self.value, Complex) and not isinstance(self.value, Real) and self.value.imag != 0

    def check(self, family: Family) -> None:
        family.require_loop(self.cell, self.word)
        size = family.points(self.cell) - 1
        asked = self.multiplicity * (2 if self.pair else 1)
        if self.multiplicity < 1 or asked > size or (self.pair and self.multiplicity > 1):
            raise WrongValue(
                f"{self.text}: on differences of points the cell {self.cell!r} has {size} eigenvalues; "
                "ask for a multiplicity from 1 to that, and for a complex pair only once"
            )

    def guess(self, member: Member, start: int) -> Array:
        import numpy as np

        linear = member.linear(self.cell, self.word)
        if self.pair:
            vector = np.linalg.svd(linear - complex(self.value) * np.eye(len(linear)))[2][-1].conj()
            return np.concatenate([vector.real, vector.imag])
        shifted = linear - complex(self.value).real * np.eye(len(linear))
        vectors = schur_vectors(shifted, self.multiplicity, start // 4 % len(linear))
        upper = (vectors.T @ shifted @ vectors)[np.triu_indices(self.multiplicity, 1)]
        return np.concatenate([vectors.ravel(), upper])

    def equations(self, member: Member, z: Array) -> Array:
        xp = member.xp
        linear = member.linear(self.cell, self.word)
        vectors, block = self._split(z, len(linear), xp)
        gram = vectors.T @ vectors
        unit = [xp.trace(gram).reshape(1) - 1] if self.pair else [_upper(gram - xp.eye(self.multiplicity))]
        return xp.concatenate([(linear @ vectors - vectors @ block).ravel(), *unit])

    def margins(self, member: Member, z: Array) -> Array:
        xp = member.xp
        if not self.dominant:
            return xp.zeros(0)
        linear = member.linear(self.cell, self.word)
        vectors, _ = self._split(z, len(linear), xp)
        if self.pair:
            vectors = xp.linalg.qr(vectors)[0]
        return (abs(complex(self.value)) - spectral_radius(rest(linear, vectors, xp), xp)).reshape(1)

    def _split(self, z: Array, size: int, xp: Any) -> tuple[Array, Array]:
        value = complex(self.value)
        if self.pair:
            block = xp.array([[value.real, value.imag], [-value.imag, value.real]])
            return z.reshape(2, size).T, block
        count = self.multiplicity
        vectors = z[: size * count].reshape(size, count)
        return vectors, value.real * xp.eye(count) + triangle(z[size * count :], count, xp)


@dataclass(frozen=True)
class Eigenvector:
    """A given vector of control points' coordinates as eigenvector: `T v = value v`; any value where None.

    A point of coordinates that sum to 1 has the value 1: it is the fixed point. Coordinates of a direction
    sum to 0. Source: Gentil 2010, section 4.3.1 ((1, -1, 0) for 1 - a - b of T_0).
    """

    cell: str
    word: Word
    vector: tuple[Rational | float, ...]
    value: Rational | float | None = None

    @property
    def text(self) -> str:
        value = "" if self.value is None else f" of eigenvalue {self.value}"
        return f"eigenvector ({', '.join(map(str, self.vector))}){value} of {self.cell}.{' '.join(self.word)}"

    def check(self, family: Family) -> None:
        family.require_loop(self.cell, self.word)
        points = family.points(self.cell)
        if len(self.vector) != points or not any(self.vector):
            raise WrongValue(f"{self.text}: expected {points} coordinates, not all of them 0")

    def guess(self, member: Member, start: int) -> Array:
        import numpy as np

        if self.value is not None:
            return np.zeros(0)
        vector = self._unit()
        return np.array([vector @ member.product(self.cell, self.word) @ vector])

    def equations(self, member: Member, z: Array) -> Array:
        vector = self._unit()
        value = z[0] if self.value is None else float(self.value)
        return member.product(self.cell, self.word) @ vector - value * vector

    def margins(self, member: Member, z: Array) -> Array:
        return member.xp.zeros(0)

    def _unit(self) -> Array:
        import numpy as np

        vector = np.array([float(x) for x in self.vector])
        return vector / np.linalg.norm(vector)


@dataclass(frozen=True)
class SymmetricMask:
    """A permutation of control points under which an operator does not change: `S T_label = T_image R`.

    S has a 1 in row `permutation[j]` of column j, as in a description's `symmetry`. R is S again where
    `inner` is None; `image` is `label` where None.
    """

    cell: str
    label: str
    permutation: tuple[int, ...]
    image: str | None = None
    inner: tuple[int, ...] | None = None

    @property
    def text(self) -> str:
        image = f" onto {self.image}" if self.image not in (None, self.label) else ""
        return f"{self.cell}.{self.label}{image} symmetric under {self.permutation}"

    def check(self, family: Family) -> None:
        ends = {family.end(self.cell, (label,)) for label in (self.label, self.image or self.label)}
        sizes = [family.points(self.cell), *map(family.points, ends)]
        for points, size in zip((self.permutation, *[self._inner()] * len(ends)), sizes, strict=True):
            if sorted(points) != list(range(size)):
                raise WrongValue(f"{self.text}: {points} is no permutation of 0 to {size - 1}")

    def guess(self, member: Member, start: int) -> Array:
        import numpy as np

        return np.zeros(0)

    def equations(self, member: Member, z: Array) -> Array:
        label = member.operator(self.cell, self.label)
        image = member.operator(self.cell, self.image or self.label)
        # (S T)[p[i], j] = T[i, j] and (T' R)[p[i], j] = T'[p[i], r[j]].
        rows, columns = list(self.permutation), list(self._inner())
        return (label - image[rows, :][:, columns]).ravel()

    def margins(self, member: Member, z: Array) -> Array:
        return member.xp.zeros(0)

    def _inner(self) -> tuple[int, ...]:
        return self.permutation if self.inner is None else self.inner


@dataclass(frozen=True)
class Positive:
    """No entry of a cell's operators below `margin`; of all cells where `cell` is None.

    Entries that the constraints make constant need only not be negative: a structural 0 is no offence.
    """

    cell: str | None = None
    margin: Rational | float = 0.0

    @property
    def text(self) -> str:
        return f"entries of {self.cell or 'all cells'} at least {self.margin}"

    def check(self, family: Family) -> None:
        if self.cell is not None:
            family.points(self.cell)

    def guess(self, member: Member, start: int) -> Array:
        import numpy as np

        return np.zeros(0)

    def equations(self, member: Member, z: Array) -> Array:
        return member.xp.zeros(0)

    def margins(self, member: Member, z: Array) -> Array:
        import numpy as np

        xp, parts = member.xp, []
        for cell, table in member.family.solution.operators.items():
            if self.cell not in (None, cell):
                continue
            for label in table:
                constant, linear = member.family.operators[cell, label]
                varies = linear.any(axis=2)
                rows, columns = np.nonzero(varies)
                parts.append(member.operator(cell, label)[rows, columns] - float(self.margin))
                # Constant entries that are negative remain as one number each.
                parts.append(constant[~varies & (constant < 0)])
        return xp.concatenate([xp.zeros(0), *parts])


@dataclass(frozen=True)
class Contracts:
    """Spectral radii of short words at most `1 - margin` on differences: necessary for convergence.

    The words are all those of at most `longest` sub-cells that return to their cell, of the cells that the
    shape needs. That the system contracts is for `ifs.convergence` to prove.
    """

    margin: Rational | float = 1e-3
    longest: int = 2

    @property
    def text(self) -> str:
        return f"spectral radii of words of up to {self.longest} at most 1 - {self.margin}"

    def check(self, family: Family) -> None:
        if self.longest < 1:
            raise WrongValue(f"{self.text}: ask for words of at least one sub-cell")

    def guess(self, member: Member, start: int) -> Array:
        import numpy as np

        return np.zeros(0)

    def equations(self, member: Member, z: Array) -> Array:
        return member.xp.zeros(0)

    def margins(self, member: Member, z: Array) -> Array:
        xp = member.xp
        radii = [
            spectral_radius(member.linear(cell, word), xp) ** (1 / len(word))
            for cell in member.family.solution.automaton.reachable()
            if member.family.points(cell) > 1
            for word in member.family.loops(cell, self.longest)
        ]
        return 1 - float(self.margin) - xp.stack(radii) if radii else xp.zeros(0)


@dataclass(frozen=True)
class Nearest:
    """A wish, not a condition: of the members that meet all conditions, the nearest to given coefficients.

    `values` maps parameters (`a`) or entries (`edge.0[1,0]`) to numbers; the distance is the square root of
    `sum weight (entry - value)^2`, each weight 1 unless given.
    """

    values: Mapping[str, Rational | float]
    weights: Mapping[str, Rational | float] | None = None

    def check(self, family: Family) -> None:
        """Raises `WrongValue` for a key that names nothing or a weight that is not positive."""
        for key in self.values:
            family.form(key)
        for key, weight in (self.weights or {}).items():
            if key not in self.values or not float(weight) > 0:
                raise WrongValue(
                    f"the weight {weight} of {key!r}: give positive weights, to keys with a value"
                )

    def rows(self, family: Family) -> tuple[Array, Array]:
        """A and b whose `|A x - b|` is the distance: (values, parameters) and (values,)."""
        import numpy as np

        rows, right = np.zeros((len(self.values), family.size)), np.zeros(len(self.values))
        for i, (key, value) in enumerate(self.values.items()):
            constant, row = family.form(key)
            weight = float((self.weights or {}).get(key, 1)) ** 0.5
            rows[i], right[i] = weight * row, weight * (float(value) - constant)
        return rows, right


def _upper(matrix: Array) -> Array:
    """The entries on and above the diagonal."""
    import numpy as np

    rows, columns = np.triu_indices(matrix.shape[0])
    return matrix[rows, columns]
