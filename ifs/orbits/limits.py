"""The point of an attractor at an address, exact where the operators are."""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from jaxtyping import Float

from ifs.certificates.differences import linear_part, spectral_radius
from ifs.error import NotContracting
from ifs.maps.exact import Matrix, product, reduced
from ifs.measures.operators import Operators, operators
from ifs.orbits.addresses import Address, Path, Word, parse_address, path_of
from ifs.shape import Shape

MOST_EXACT = 64  # points of a cell up to which fractions are used
_ONE = 1 - 1e-12
_RANK = 1e-10


class ManyFixedPoints(ValueError):
    """A repeated word with more than one fixed point: its product has the eigenvalue 1 several times."""

    def __init__(self, cell: str, word: Word, multiplicity: int):
        self.cell = cell
        self.word = word
        self.multiplicity = multiplicity
        super().__init__(
            f"repeating {' '.join(word)!r} from cell {cell!r} has no single limit: its product has the "
            f"eigenvalue 1 with multiplicity {multiplicity}, and a limit needs 1. Change the "
            f"operators along this word."
        )


@dataclass(frozen=True)
class LimitPoint:
    """The point at an address: `column` in the barycentric space of the shape's cell, `point` in mm.

    `exact` and `exact_column` are the same as fractions, of the control points as the binary fractions that
    they are; None where the operators are not known as fractions.
    """

    address: Address
    column: Float[np.ndarray, "points"]
    point: Float[np.ndarray, "dim"]
    exact: tuple[Fraction, ...] | None
    exact_column: tuple[Fraction, ...] | None


def point_at(shape: Shape, where: Address | str) -> LimitPoint:
    """The point `phi(s) = lim T_s1 T_s2 … p` at an address s; see `points_at`.

    >>> from ifs.shape import shape
    >>> [str(x) for x in point_at(shape("corner-cutting"), "0 (1)*").exact]
    ['30', '45']
    """
    return points_at(shape, [where])[0]


def points_at(shape: Shape, addresses: Sequence[Address | str]) -> list[LimitPoint]:
    """The points at several addresses, finite ones being continued by their last label.

    For the word u and the repeated word w from cell c it is `T_u p` with `T_w p = p` and coordinates of p
    that sum to 1: solved in fractions where operators are rational and cells have up to 64 points, else in
    floats.

    Raises `UnknownLabel` with the label, the cell and its labels, `ValueError` for a text that is no address,
    `ManyFixedPoints` where `T_w` has the eigenvalue 1 more than once, and `NotContracting` where another
    eigenvalue of it has a modulus of 1 or more. Source: Gentil 2010, §3.3.2.
    """
    table = operators(shape)
    return [_point(shape, table, parse_address(a) if isinstance(a, str) else a) for a in addresses]


def _point(shape: Shape, table: Operators, where: Address) -> LimitPoint:
    path = path_of(shape.system, where)
    _require_contraction(shape, path)
    exact = _exact_column(shape, table, path)
    if exact is None:
        column = _float_column(shape, path)
        return LimitPoint(where, column, column @ shape.control, None, None)
    point = tuple(
        sum((weight * Fraction(float(x)) for weight, x in zip(exact, axis, strict=True)), Fraction(0))
        for axis in shape.control.T
    )
    return LimitPoint(where, np.array(exact, dtype=float), np.array(point, dtype=float), point, exact)


def _require_contraction(shape: Shape, path: Path) -> None:
    linear = linear_part(_product(shape, path.cell, path.cycle))
    radius = spectral_radius(linear)
    if radius < _ONE:
        return
    ones = int((np.abs(np.linalg.eigvals(linear) - 1) < 1e-6).sum())
    if ones:
        raise ManyFixedPoints(path.cell, path.cycle, ones + 1)
    raise NotContracting(path.cell, path.cycle, radius)


def _product(shape: Shape, cell: str, word: Word) -> Float[np.ndarray, "_points _target_points"]:
    result = np.eye(shape.system.states[cell].points)
    for label in word:
        state = shape.system.states[cell]
        number = state.labels.index(label)
        result, cell = result @ state.operators[number], state.targets[number]
    return result


def _float_column(shape: Shape, path: Path) -> Float[np.ndarray, "_points"]:
    cycle = _product(shape, path.cell, path.cycle)
    size = len(cycle)
    rows = np.vstack([np.eye(size) - cycle, np.ones(size)])
    fixed = np.linalg.lstsq(rows, np.eye(size + 1)[-1], rcond=None)[0]
    return _product(shape, shape.system.shape, path.word) @ fixed


def _exact_column(shape: Shape, table: Operators, path: Path) -> tuple[Fraction, ...] | None:
    cells = [path.cell, *_cells(shape, path.cell, path.cycle), *_cells(shape, shape.system.shape, path.word)]
    if max(shape.system.states[cell].points for cell in cells) > MOST_EXACT:
        return None
    cycle = _exact_product(shape, table, path.cell, path.cycle)
    if cycle is None:
        return None
    size = len(cycle)
    rows = [[cycle[i][j] - (i == j) for j in range(size)] + [Fraction(0)] for i in range(size)]
    solved, pivots = reduced([*rows, [Fraction(1)] * (size + 1)], size)
    if len(pivots) < size:
        raise ManyFixedPoints(path.cell, path.cycle, size - len(pivots) + 1)
    column = [[solved[i][-1]] for i in range(size)]
    cell = shape.system.shape
    steps: list[Matrix] = []
    for label in path.word:
        rows_of = _fractions(table, cell, label)
        if rows_of is None:
            return None
        steps.append(rows_of)
        cell = table[cell][label][0]
    for step in reversed(steps):
        column = product(step, column)
    return tuple(row[0] for row in column)


def _exact_product(shape: Shape, table: Operators, cell: str, word: Word) -> Matrix | None:
    size = shape.system.states[cell].points
    result: Matrix = [[Fraction(int(i == j)) for j in range(size)] for i in range(size)]
    for label in word:
        rows = _fractions(table, cell, label)
        if rows is None:
            return None
        result, cell = product(result, rows), table[cell][label][0]
    return result


def _fractions(table: Operators, cell: str, label: str) -> Matrix | None:
    rows = table[cell][label][1]
    if not all(isinstance(x, int | Fraction) for row in rows for x in row):
        return None
    return [[Fraction(x) for x in row] for row in rows]


def _cells(shape: Shape, cell: str, word: Word) -> list[str]:
    found = [cell]
    for label in word:
        state = shape.system.states[cell]
        cell = state.targets[state.labels.index(label)]
        found.append(cell)
    return found
