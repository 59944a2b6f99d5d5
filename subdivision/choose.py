"""The choice of a member of a family by what it is to be like: eigenvalues, joints, signs, nearness."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import accumulate, pairwise
from typing import TYPE_CHECKING, Any

from subdivision.error import WrongValue
from subdivision.member import Family, family
from subdivision.requests import Nearest, Request
from subdivision.solution import Solution

if TYPE_CHECKING:
    from subdivision.descent import Jacobians, Problem

TOLERANCE = 1e-12
_SMALL = 1024
_SPREADS = (0.5, 0.2, 0.08, 0.03)
_GUESSES = 4


@dataclass(frozen=True)
class Outcome:
    """How one request fared: `residual` is its largest equation or missed margin at the answer."""

    request: Request
    met: bool
    residual: float


@dataclass(frozen=True)
class Choice:
    """A member of a family, and how far it is what was asked for.

    `exact` holds the value of every free parameter: a fraction of denominator up to 1024 where one lies
    within 1e-12, otherwise the shortest decimal of the double. `solution` is the family with these values
    set, in which all linear constraints hold exactly. `degrees_of_freedom` counts the parameters that can
    still vary, to first order, while the equations of the requests that are met stay so; `distance` is that
    to the `Nearest` wish, None without one.
    """

    exact: Mapping[str, Fraction]
    solution: Solution
    outcomes: tuple[Outcome, ...]
    degrees_of_freedom: int
    distance: float | None

    @property
    def values(self) -> Mapping[str, float]:
        """The values of the parameters as doubles."""
        return {name: float(value) for name, value in self.exact.items()}

    @property
    def met(self) -> tuple[Outcome, ...]:
        return tuple(outcome for outcome in self.outcomes if outcome.met)

    @property
    def unmet(self) -> tuple[Outcome, ...]:
        return tuple(outcome for outcome in self.outcomes if not outcome.met)

    @property
    def ok(self) -> bool:
        """Whether every request is met, to 1e-12."""
        return not self.unmet


class NotMet(ValueError):
    """No member was found that meets all requests; `choice` is the best one, with every residual."""

    def __init__(self, choice: Choice):
        self.choice = choice
        listed = "".join(f"\n  - {o.request.text}: off by {o.residual:.3g}" for o in choice.unmet)
        super().__init__(
            f"{len(choice.unmet)} of {len(choice.outcomes)} requests could not be met together with those "
            f"before them; leave some out, or try more starts:{listed}"
        )


def choose(
    solution: Solution,
    requests: Sequence[Request | Nearest],
    *,
    seed: int = 0,
    starts: int = 16,
    throw: bool = False,
    report: Callable[[float], None] = lambda done: None,
) -> Choice:
    """The member of an affine family that meets all requests, and among those the nearest.

    The unknowns are the free parameters x and what the requests bring along (eigenvectors). From several
    start points, drawn with `seed`, Newton's method (Gauss-Newton with the shortest step) leads to the
    conditions, scipy's Levenberg-Marquardt where it fails, until residuals are below 1e-12. Steps along
    the conditions then make the distance of the `Nearest` wishes least, after that the sum of squares of all
    entries of all operators (the flattest masks). The best point found is kept: a search, no proof.
    Values are then made exact, the operators computed anew from them by fractions, and every request
    evaluated on those by NumPy. When not all can be met together, requests are taken in their order,
    each kept that can be met with those kept before it; each costs a search of its own. `report` is told
    which share of the work is done at most, from 0 to 1; what it raises ends the search.

    Raises `WrongValue` for requests that do not fit the automaton, and with `throw` `NotMet`.
    Source: Gentil 2010, section 4.3.1 (the conditions), chosen here numerically.

    >>> import automata, subdivision
    >>> from subdivision.requests import Eigenvalue
    >>> family = subdivision.solve(automata.read("corner-cutting"))
    >>> half, quarter = (Eigenvalue("edge", ("0",), Fraction(1, k)) for k in (2, 4))
    >>> other = Eigenvalue("edge", ("1",), Fraction(1, 2))
    >>> {name: str(value) for name, value in choose(family, [half, quarter, other]).exact.items()}
    {'a': '1/4', 'b': '1/4'}
    """
    if starts < 1 or seed < 0:
        raise WrongValue(f"starts = {starts}, seed = {seed}: expected at least 1 start, and no negative seed")
    own = family(solution)
    for request in requests:
        request.check(own)
    wishes = tuple(request for request in requests if isinstance(request, Nearest))
    conditions = tuple(request for request in requests if not isinstance(request, Nearest))
    search = _Search(own, wishes, seed, starts, conditions)
    share = 1 / (len(conditions) + 1)
    found = search.best(conditions, lambda done: report(share * done))
    if not search.meets(conditions, found):
        found = _in_order(search, conditions, found, lambda done: report(share + (1 - share) * done))
    report(1.0)
    choice = search.choice(conditions, found)
    if throw and not choice.ok:
        raise NotMet(choice)
    return choice


def _in_order(
    search: "_Search", conditions: Sequence[Request], found: Any, report: Callable[[float], None]
) -> Any:
    """The best member for the requests kept in their order, when not all can be met."""
    if len(conditions) == 1:
        return found
    kept: tuple[Request, ...] = ()
    best = search.centre()
    for number, request in enumerate(conditions):
        if len(kept) == len(conditions) - 1:
            break  # all of them together have failed already
        tried = search.best(
            (*kept, request), lambda done, number=number: report((number + done) / len(conditions))
        )
        if search.meets((*kept, request), tried):
            kept, best = (*kept, request), tried
    return best


@dataclass(frozen=True)
class _Search:
    """Searches in one family with the same wishes, seed and number of starts, for some of the requests.

    The Jacobian of the `whole` is compiled once; those of its parts are parts of it.
    """

    family: Family
    wishes: tuple[Nearest, ...]
    seed: int
    starts: int
    whole: tuple[Request, ...]
    problems: dict[tuple[Request, ...], "Problem"] = field(default_factory=dict)

    def best(self, conditions: tuple[Request, ...], report: Callable[[float], None]) -> Any:
        """The parameters x of the best member for some conditions."""
        from subdivision.descent import searched

        if not self.family.size:
            return self.centre()
        found = searched(self.problem(conditions), self.first(conditions), report)
        return found[0][: self.family.size] if found else self.centre()

    def centre(self) -> Any:
        """The parameters that are best without any condition."""
        from subdivision.descent import in_turn

        return in_turn(list(self.levels(self.family.size)), self.family.size)

    def levels(self, size: int) -> Iterator[tuple[Any, Any]]:
        """The wishes as linear least squares in all unknowns, of which the parameters come first."""
        import numpy as np

        pairs = [wish.rows(self.family) for wish in self.wishes]
        if pairs:
            yield _padded(np.concatenate([a for a, _ in pairs]), size), np.concatenate([b for _, b in pairs])
        constant, linear = self.family.table
        if linear.size:
            left, right = np.linalg.qr(linear)
            scale = max(abs(right).max(), 1e-300)
            yield _padded(right / scale, size), -left.T @ constant / scale

    def first(self, conditions: Sequence[Request]) -> Any:
        """The start points: the centre, and others about it; each with the guesses of the requests."""
        import numpy as np

        random = np.random.default_rng(self.seed)
        rows = []
        for start in range(self.starts):
            x = self.centre()
            if start:
                x = x + _SPREADS[start % len(_SPREADS)] * random.standard_normal(self.family.size)
            member = self.family.at(x, np)
            rows.append(np.concatenate([x, *(request.guess(member, start) for request in conditions)]))
        return np.array(rows)

    def problem(self, conditions: tuple[Request, ...]) -> "Problem":
        """The requests together; their own unknowns follow the parameters, in order."""
        if conditions not in self.problems:
            self.problems[conditions] = self._problem(conditions)
        return self.problems[conditions]

    def _problem(self, conditions: tuple[Request, ...]) -> "Problem":
        import numpy as np

        from subdivision.descent import Problem

        size = self.family.size
        member = self.family.at(self.centre(), np)
        counts = [len(request.guess(member, 0)) for request in conditions]
        places = _slices(counts, size)
        end = size + sum(counts)

        def collected(name: str):
            def function(y, xp):
                at = self.family.at(y[:size], xp)
                parts = [
                    getattr(request, name)(at, y[place])
                    for request, place in zip(conditions, places, strict=True)
                ]
                return xp.concatenate([xp.zeros(0), *parts])

            return function

        within = None if conditions == self.whole else self._within(conditions)
        return Problem(collected("equations"), collected("margins"), list(self.levels(end)), within)

    def _within(self, conditions: tuple[Request, ...]) -> "Jacobians":
        """The rows and columns of some requests in what is compiled for all, whose other unknowns stay."""
        import numpy as np

        size, member = self.family.size, self.family.at(self.centre(), np)
        guesses = [request.guess(member, 0) for request in self.whole]
        base = np.concatenate([np.zeros(size), *guesses])
        chosen, waiting = [], list(conditions)
        for number, request in enumerate(self.whole):
            if waiting and request == waiting[0]:
                chosen.append(number)
                del waiting[0]
        rows = [
            _gathered([len(f(member, z)) for f, z in zip(kind, guesses, strict=True)], chosen)
            for kind in ([r.equations for r in self.whole], [r.margins for r in self.whole])
        ]
        columns = np.concatenate([np.arange(size), size + _gathered([len(z) for z in guesses], chosen)])
        at = self.problem(self.whole).at

        def part(y):
            full = base.copy()
            full[columns] = y
            equations, jacobian, margins, slopes = at(full)
            one, other = rows
            return equations[one], jacobian[one][:, columns], margins[other], slopes[other][:, columns]

        return part

    def meets(self, conditions: tuple[Request, ...], x: Any) -> bool:
        return all(outcome(self.family, request, x).met for request in conditions)

    def choice(self, conditions: tuple[Request, ...], x: Any) -> Choice:
        exact = self.exact(conditions, x)
        solution = self.family.solution.with_values(exact)
        own = family(solution)
        outcomes = tuple(outcome(own, request) for request in conditions)
        met = tuple(o.request for o in outcomes if o.met)
        distance = None
        if self.wishes:
            distance = float(sum(sum(wish.rows(own)[1] ** 2) for wish in self.wishes) ** 0.5)
        return Choice(exact, solution, outcomes, self.freedom(met, x), distance)

    def exact(self, conditions: tuple[Request, ...], x: Any) -> Mapping[str, Fraction]:
        """Small fractions where they meet what the doubles meet, otherwise decimals."""
        names = [parameter.name for parameter in self.family.solution.free]
        decimals = {name: Fraction(repr(float(value))) for name, value in zip(names, x, strict=True)}
        small = {name: _small(value) for name, value in decimals.items()}
        own = family(self.family.solution.with_values(small))
        for request in conditions:
            if outcome(self.family, request, x).met and not outcome(own, request).met:
                return decimals
        return small

    def freedom(self, met: tuple[Request, ...], x: Any) -> int:
        import numpy as np

        from subdivision.descent import freedom

        if not len(x):
            return 0
        member = self.family.at(x, np)
        guesses = (min(_guesses(request, member), key=lambda pair: pair[0])[1] for request in met)
        y = np.concatenate([x, *guesses])
        return freedom(self.problem(met).at(y)[1], len(x))


def outcome(own: Family, request: Request, x: Any = None) -> Outcome:
    """How far a member meets a request, evaluated by NumPy alone, the request's own unknowns guessed anew."""
    import numpy as np

    member = own.at(np.zeros(own.size) if x is None else x, np)
    residual = min(worst for worst, _ in _guesses(request, member))
    return Outcome(request, residual <= TOLERANCE, residual)


def _guesses(request: Request, member: Any) -> Iterator[tuple[float, Any]]:
    """What a request misses with each guess of its own unknowns: its largest residual or missed margin."""
    import numpy as np

    for start in range(_GUESSES):
        z = request.guess(member, start)
        worst = [0.0, *abs(request.equations(member, z)), *(-request.margins(member, z))]
        yield float(max(worst)) if np.isfinite(worst).all() else float("inf"), z


def _slices(counts: Sequence[int], start: int) -> list[slice]:
    ends = list(accumulate(counts, initial=start))
    return [slice(a, b) for a, b in pairwise(ends)]


def _gathered(counts: Sequence[int], chosen: Sequence[int]) -> Any:
    """The places that the chosen of consecutive parts take."""
    import numpy as np

    parts = _slices(counts, 0)
    return np.concatenate([np.arange(0), *(np.arange(parts[k].start, parts[k].stop) for k in chosen)])


def _padded(matrix: Any, size: int) -> Any:
    import numpy as np

    return np.pad(matrix, ((0, 0), (0, size - matrix.shape[1])))


def _small(value: Fraction) -> Fraction:
    near = value.limit_denominator(_SMALL)
    return near if abs(near - value) <= TOLERANCE else value
