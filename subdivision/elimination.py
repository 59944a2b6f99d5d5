"""Exact solution of sparse linear equations by identification first, elimination after.

Almost all constraints of an automaton say that two unknowns are equal, or that one is a constant. Those
are settled by union-find in near-linear time; the few equations that then remain different from each other
go through Gauss-Jordan elimination.
"""

from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction

from subdivision.form import CONSTANT, Form, add, constant, scale


class Inconsistent(ArithmeticError):
    """The equations require `residual = 0` of a nonzero number."""

    def __init__(self, residual: Fraction):
        super().__init__(str(residual))
        self.residual = residual


class LinearSystem:
    """Unknowns and the affine equations `form = 0` they satisfy, always in solved form.

    `priority(i)` orders the unknowns: of a class of equal unknowns the lowest one stands for all, and
    when an equation determines one of several unknowns it is the one of highest priority.
    """

    def __init__(self, unknowns: int, priority: Callable[[int], tuple] | None = None):
        self._parent = list(range(unknowns))
        self._priority = priority or (lambda i: (i,))
        self._solved: dict[int, Form] = {}
        self._uses: dict[int, set[int]] = defaultdict(set)

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
        return self._solved.get(root, {root: Fraction(1)})

    def reduce(self, form: Form) -> Form:
        """The form in terms of the free unknowns."""
        result: Form = {}
        for key, coefficient in form.items():
            term = constant(Fraction(1)) if key == CONSTANT else self.value(key)
            result = add(result, term, coefficient)
        return result

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
        return True

    def _eliminate(self, form: Form) -> None:
        if not form:
            return
        unknowns = [key for key in form if key != CONSTANT]
        if not unknowns:
            raise Inconsistent(form[CONSTANT])
        pivot = max(unknowns, key=self._priority)
        rest = {key: coefficient for key, coefficient in form.items() if key != pivot}
        self._solve(pivot, scale(rest, -1 / form[pivot]))

    def _solve(self, pivot: int, row: Form) -> None:
        for dependent in self._uses.pop(pivot, set()):
            old = self._solved[dependent]
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


def minimal_conflict(groups: Sequence[Iterable[Form]], unknowns: int) -> tuple[list[int], Fraction]:
    """An inconsistent subset of groups of equations none of whose members can be left out.

    QuickXplain: the number of trials grows with the size of the conflict times the logarithm of the
    number of groups. Returns the indices in increasing order, and the residual that they lead to.
    """
    groups = [list(group) for group in groups]

    def residual(chosen: Iterable[int]) -> Fraction | None:
        system = LinearSystem(unknowns)
        try:
            system.require(form for i in sorted(chosen) for form in groups[i])
        except Inconsistent as error:
            return error.residual
        return None

    def explain(background: list[int], changed: bool, candidates: list[int]) -> list[int]:
        if changed and residual(background) is not None:
            return []
        if len(candidates) == 1:
            return candidates
        half = len(candidates) // 2
        first, second = candidates[:half], candidates[half:]
        from_second = explain(background + first, True, second)
        from_first = explain(background + from_second, bool(from_second), first)
        return from_first + from_second

    chosen = sorted(explain([], False, list(range(len(groups)))))
    found = residual(chosen)
    assert found is not None
    return chosen, found


def _normal(form: Form) -> tuple:
    """A key that is equal for forms that are multiples of each other."""
    entries = sorted(form.items())
    lead = entries[-1][1]
    return tuple((key, coefficient / lead) for key, coefficient in entries)
