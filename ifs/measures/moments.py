"""The moments of the invariant measure of a shape, exactly, by linear algebra."""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from math import comb

from ifs.certificates.convergence import require_contraction
from ifs.measures.operators import Number, Operators, operators
from ifs.measures.polynomials import Exponent, Polynomial, Powers, affine_form, exponents, solved
from ifs.shape import Shape

Probabilities = Mapping[str, Mapping[str, Number]]

MOST_UNKNOWNS = 2000
MOST_EXACT = 250
_ONE = 1e-12


class WrongProbabilities(ValueError):
    """Probabilities that do not fit a cell: a label missing or unknown, one below 0, a sum other than 1."""


@dataclass(frozen=True)
class Moments:
    """`table[a]` is the expectation of `x^a1 y^a2 …`, in mm to the power |a|, for all |a| up to `order`.

    The numbers are Fractions where operators and probabilities are rational (a control point counts as the
    binary fraction that it is), else floats.
    """

    dim: int
    order: int
    table: Mapping[Exponent, Number]

    @property
    def mean(self) -> tuple[Number, ...]:
        """The centroid, in mm."""
        return tuple(self.table[_unit(self.dim, i)] for i in range(self.dim))

    @property
    def covariance(self) -> tuple[tuple[Number, ...], ...]:
        """The central second moments `E (x_i - m_i)(x_j - m_j)`, in mm^2; for `order` 2 and more."""
        mean = self.mean
        return tuple(
            tuple(self.table[_sum(self.dim, i, j)] - mean[i] * mean[j] for j in range(self.dim))
            for i in range(self.dim)
        )


def moments(shape: Shape, order: int = 2, probabilities: Probabilities | None = None) -> Moments:
    """The moments of the measure that takes sub-piece i of a cell with probability p_i.

    The measures satisfy `mu_x = sum_i p_i (T_i)_* mu_y`, y the cell of sub-piece i, so in barycentric space
    `E_x[p] = sum p_i T_i E_y[p]`, `E_x[p p'] = sum p_i T_i E_y[p p'] T_i'`, and so on: each degree is a
    system of linear equations, with 1 as no eigenvalue once the coordinates' sum 1 is used. The points of
    space are `x = P^T p`. `probabilities[cell][label]`: by default all labels of a cell alike; cells that are
    not mentioned too. `dimension.natural_probabilities` gives those of the s-dimensional measure.

    Raises `NotContracting` or `Undecided`, `WrongProbabilities`, and `ValueError` for an order below 0 or too
    many moments (over 250 of one degree exactly, over 2000 in floats).

    >>> from ifs.shape import shape
    >>> found = moments(shape("menger-sponge"))
    >>> [str(x) for x in found.mean], str(found.covariance[0][0])
    (['27', '27', '27'], '1458/5')
    """
    require_contraction(shape.system)
    everything = operators(shape)
    weights = checked(everything, probabilities)
    used = [shape.automaton.shape]
    for cell in used:
        used.extend(t for t, _ in everything[cell].values() if t not in used)
    tables = barycentric_moments({c: everything[c] for c in used}, order, {c: weights[c] for c in used})
    control = [[Fraction(float(x)) for x in row] for row in shape.control]
    rows = list(zip(*control, strict=True))
    place = Powers([affine_form(row) for row in rows], len(control) - 1)
    own = tables[shape.automaton.shape]
    found = {
        exponent: _expectation(place(exponent), own)
        for degree in range(order + 1)
        for exponent in exponents(len(rows), degree)
    }
    return Moments(len(rows), order, found)


def barycentric_moments(
    operators: Operators, order: int, probabilities: Probabilities | None = None
) -> Mapping[str, Mapping[Exponent, Number]]:
    """For each cell the expectations of the monomials in all barycentric coordinates but the last.

    Operators and errors as in `moments`, but that the system contracts is taken for granted;
    `ZeroDivisionError` where a degree has no unique solution.

    >>> half = Fraction(1, 2)
    >>> halves = {"0": ("x", ((1, half), (0, half))), "1": ("x", ((half, 0), (half, 1)))}
    >>> [str(value) for value in barycentric_moments({"x": halves}, 3)["x"].values()]
    ['1', '1/2', '1/3', '1/4']
    """
    if order < 0:
        raise ValueError(f"the order of moments must be 0 or more; got {order}")
    weights = checked(operators, probabilities)
    widths = {cell: _width(operators, cell) for cell in operators}
    _check_work(operators, weights, widths, order)
    powers = {
        (cell, label): Powers([affine_form(row) for row in rows[:-1]], widths[target])
        for cell, table in operators.items()
        for label, (target, rows) in table.items()
    }
    tables: dict[str, dict[Exponent, Number]] = {
        cell: {(0,) * widths[cell]: Fraction(1)} for cell in operators
    }
    for degree in range(1, order + 1):
        unknowns = [(cell, exponent) for cell in operators for exponent in exponents(widths[cell], degree)]
        place = {unknown: k for k, unknown in enumerate(unknowns)}
        rows: list[dict[int, Number]] = []
        constants: list[Number] = []
        for cell, exponent in unknowns:
            row: dict[int, Number] = {}
            constant: Number = Fraction(0)
            for label, (target, _) in operators[cell].items():
                weight = weights[cell][label]
                for other, factor in powers[cell, label](exponent).items():
                    if sum(other) == degree:
                        key = place[target, other]
                        row[key] = row.get(key, Fraction(0)) + weight * factor
                    else:
                        constant += weight * factor * tables[target][other]
            rows.append(row)
            constants.append(constant)
        for (cell, exponent), value in zip(unknowns, solved(rows, constants), strict=True):
            tables[cell][exponent] = value
    return tables


def checked(operators: Operators, probabilities: Probabilities | None) -> dict[str, dict[str, Number]]:
    """The probabilities of all labels of all cells. Raises `WrongProbabilities`.

    >>> checked({"x": {"0": ("x", ((1,),)), "1": ("x", ((1,),))}}, {"x": {"0": 1, "1": 1}})
    Traceback (most recent call last):
    ...
    ifs.moments.WrongProbabilities: the probabilities of cell 'x' must sum to 1; they sum to 2
    """
    given = probabilities or {}
    for cell in given:
        if cell not in operators:
            raise WrongProbabilities(f"there is no cell {cell!r}; there are {', '.join(operators)}")
    result: dict[str, dict[str, Number]] = {}
    for cell, table in operators.items():
        if cell not in given:
            result[cell] = {label: Fraction(1, len(table)) for label in table}
            continue
        own = given[cell]
        if set(own) != set(table):
            odd = sorted(set(own) ^ set(table))
            raise WrongProbabilities(
                f"cell {cell!r} needs one probability for each of {', '.join(table)}; wrong: {', '.join(odd)}"
            )
        for label in table:
            if not 0 <= own[label] <= 1:
                raise WrongProbabilities(
                    f"the probability of {label!r} in cell {cell!r} must lie in [0, 1]; got {own[label]}"
                )
        total = sum(own.values())
        if abs(total - 1) > _ONE or (total != 1 and all(isinstance(p, int | Fraction) for p in own.values())):
            raise WrongProbabilities(f"the probabilities of cell {cell!r} must sum to 1; they sum to {total}")
        result[cell] = {label: own[label] for label in table}
    return result


def _width(operators: Operators, cell: str) -> int:
    if not operators[cell]:
        return 0
    return len(next(iter(operators[cell].values()))[1]) - 1


def _check_work(operators: Operators, weights: Probabilities, widths: Mapping[str, int], order: int) -> None:
    exact = all(
        isinstance(x, int | Fraction)
        for cell, table in operators.items()
        for label, (_, rows) in table.items()
        for x in (weights[cell][label], *(value for row in rows for value in row))
    )
    most = MOST_EXACT if exact else MOST_UNKNOWNS
    count = sum(comb(width + order - 1, order) for width in widths.values() if width)
    if count > most:
        raise ValueError(
            f"{count} moments of degree {order} are too many: at most {most} "
            f"{'as exact fractions (floats for the probabilities allow more)' if exact else 'in floats'}. "
            f"Ask for a lower order."
        )


def _expectation(polynomial: Polynomial, table: Mapping[Exponent, Number]) -> Number:
    total: Number = Fraction(0)
    for exponent, factor in polynomial.items():
        total += factor * table[exponent]
    return total


def _unit(dim: int, i: int) -> Exponent:
    return tuple(int(k == i) for k in range(dim))


def _sum(dim: int, i: int, j: int) -> Exponent:
    return tuple(int(k == i) + int(k == j) for k in range(dim))
