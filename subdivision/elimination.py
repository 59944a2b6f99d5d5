"""Exact solution of sparse linear equations by identification first, elimination after.

Almost all constraints of an automaton say that two unknowns are equal, or that one is a constant. Those
are settled by union-find in near-linear time; the few equations that then remain different from each other
go through Gauss-Jordan elimination.
"""

from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction

from subdivision.coefficients import Scalar, is_number
from subdivision.error import TooMuchWork
from subdivision.form import CONSTANT, Form, add, scale

MOST_WORK = 6_000_000
"""Steps of arithmetic, a step for each word of 64 bits of each coefficient met."""


class Inconsistent(ArithmeticError):
    """The equations require `residual = 0` of a nonzero number."""

    def __init__(self, residual: Scalar):
        super().__init__(str(residual))
        self.residual = residual


class LinearSystem:
    """Unknowns and the affine equations `form = 0` they satisfy, always in solved form.

    `priority(i)` orders the unknowns: of a class of equal unknowns the lowest one stands for all, and
    when an equation determines one of several unknowns it is the one of highest priority, and one of
    `keep` only when there is no other.
    """

    def __init__(
        self, unknowns: int, priority: Callable[[int], tuple] | None = None, keep: Iterable[int] = ()
    ):
        self._parent = list(range(unknowns))
        self._priority = priority or (lambda i: (i,))
        self._solved: dict[int, Form] = {}
        self._uses: dict[int, set[int]] = defaultdict(set)
        self._keep = set(keep)
        self.work = 0

    def root(self, unknown: int) -> int:
        """The unknown that stands for all that equal this one."""
        path = []
        while self._parent[unknown] != unknown:
            path.append(unknown)
            unknown = self._parent[unknown]
        for step in path:
            self._parent[step] = unknown
        return unknown

    def value(self, unknown: int) -> Form:
        """The unknown in terms of the free ones."""
        root = self.root(unknown)
        return self._solved.get(root, {root: 1})

    def reduce(self, form: Form) -> Form:
        """The form in terms of the free unknowns."""
        result: dict[int, Scalar] = {}
        for key, coefficient in form.items():
            if key != CONSTANT:
                key = self.root(key)
            row = self._solved.get(key)
            if row is None:
                _accumulate(result, key, coefficient)
                continue
            self._count(row, coefficient)
            for place, value in row.items():
                _accumulate(result, place, coefficient * value)
        return result

    def _count(self, row: Form, factor: Scalar) -> None:
        """Note the work of a multiple of a row; raises `TooMuchWork` when it is too much in all."""
        self.work += len(row) * (1 + _words(factor) + _words(next(iter(row.values()), 0)))
        if self.work > MOST_WORK:
            raise TooMuchWork(MOST_WORK)

    def require(self, forms: Iterable[Form]) -> None:
        """Add the equations `form = 0`. Raises `Inconsistent`."""
        rest = [form for form in forms if not self._identify(form)]
        distinct = {}
        for form in rest:
            reduced = self.reduce(form)
            if reduced:
                distinct.setdefault(_normal(reduced), reduced)
        for form in sorted(distinct.values(), key=lambda form: (len(form), sorted(form))):
            self._eliminate(self.reduce(form))

    def _identify(self, form: Form) -> bool:
        """Settle `x = y` between free unknowns at once; anything else is left to elimination."""
        if len(form) != 2 or CONSTANT in form:
            return False
        (first, coefficient), (second, other) = form.items()
        first, second = self.root(first), self.root(second)
        if coefficient != -other or first in self._solved or second in self._solved:
            return first == second and coefficient == -other
        if first != second:
            low, high = sorted((first, second))
            if self._uses.get(high):
                return False
            self._parent[high] = low
            if high in self._keep:
                self._keep.add(low)
        return True

    def _eliminate(self, form: Form) -> None:
        if not form:
            return
        unknowns = [key for key in form if key != CONSTANT]
        if not unknowns:
            raise Inconsistent(form[CONSTANT])
        pivot = max(unknowns, key=lambda i: (i not in self._keep, self._priority(i)))
        rest = {key: coefficient for key, coefficient in form.items() if key != pivot}
        self._solve(pivot, scale(rest, ratio(-1, form[pivot])))

    def _solve(self, pivot: int, row: Form) -> None:
        for dependent in self._uses.pop(pivot, set()):
            old = self._solved[dependent]
            self._count(row, old[pivot])
            kept = {key: coefficient for key, coefficient in old.items() if key != pivot}
            self._set(dependent, add(kept, row, old[pivot]))
        self._set(pivot, row)

    def _set(self, unknown: int, row: Form) -> None:
        for key in self._solved.get(unknown, {}).keys() - row.keys() - {CONSTANT}:
            self._uses[key].discard(unknown)
        self._solved[unknown] = row
        for key in row:
            if key != CONSTANT:
                self._uses[key].add(unknown)

    def free(self, unknowns: Iterable[int]) -> list[int]:
        """The free unknowns on which the given ones depend, in increasing order."""
        return sorted({key for unknown in unknowns for key in self.value(unknown) if key != CONSTANT})


def minimal_conflict(groups: Sequence[Iterable[Form]], unknowns: int) -> tuple[list[int], Scalar]:
    """An inconsistent subset of groups of equations none of whose members can be left out.

    Returns the indices in increasing order, and the residual that they lead to.
    """
    groups = [list(group) for group in groups]

    def residual(chosen: Sequence[int]) -> Scalar | None:
        try:
            LinearSystem(unknowns).require(form for i in chosen for form in groups[i])
        except Inconsistent as error:
            return error.residual
        return None

    return minimal_subset(len(groups), residual)


def minimal_subset(
    count: int, residual: Callable[[Sequence[int]], Scalar | None]
) -> tuple[list[int], Scalar]:
    """A least subset of `range(count)` that has a residual, and its residual.

    QuickXplain: the number of trials grows with the size of the subset times the logarithm of the count.
    """

    def explain(background: list[int], changed: bool, candidates: list[int]) -> list[int]:
        if changed and residual(sorted(background)) is not None:
            return []
        if len(candidates) == 1:
            return candidates
        half = len(candidates) // 2
        first, second = candidates[:half], candidates[half:]
        from_second = explain(background + first, True, second)
        from_first = explain(background + from_second, bool(from_second), first)
        return from_first + from_second

    chosen = sorted(explain([], False, list(range(count))))
    found = residual(chosen)
    assert found is not None
    return chosen, found


def ratio(above: Scalar, below: Scalar) -> Scalar:
    """The exact quotient; an integer where it is one."""
    both = isinstance(above, int) and isinstance(below, int)
    quotient = Fraction(above, below) if both else above / below
    return quotient.numerator if isinstance(quotient, Fraction) and quotient.denominator == 1 else quotient


def _accumulate(result: dict[int, Scalar], key: int, value: Scalar) -> None:
    total = result.get(key, 0) + value
    if total:
        result[key] = total
    else:
        result.pop(key, None)


def _words(value: Scalar) -> int:
    """The length of a coefficient in words of 64 bits, or in terms."""
    if is_number(value):
        return (value.numerator.bit_length() + value.denominator.bit_length()) >> 6
    return len(value.numer) + len(value.denom)


def _normal(form: Form) -> tuple:
    """A key that is equal for forms that are multiples of each other."""
    entries = sorted(form.items())
    lead = entries[-1][1]
    return tuple((key, ratio(coefficient, lead)) for key, coefficient in entries)
