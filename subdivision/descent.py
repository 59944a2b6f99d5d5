"""Solving equations and inequalities while keeping close to wishes: many starts, then a polish to 1e-12."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float

from subdivision.member import Array

Vector = Float[np.ndarray, "_"]
Matrix = Float[np.ndarray, "_ _"]
Wish = tuple[Matrix, Vector]
"""A and b of a distance `|A y - b|` that is to be small."""

Jacobians = Callable[[Vector], tuple[Vector, Matrix, Vector, Matrix]]
"""Equations and margins at a point, each with its Jacobian."""

TOLERANCE = 1e-12
_PULLS = (1e-2, 1e-5)
_RANK = 1e-7
_STEPS = 60
_PATIENCE = 8
_QUICKLY = {"xla_backend_optimization_level": 0, "xla_llvm_disable_expensive_passes": True}
"""Every problem is compiled anew, and solved in milliseconds: what counts is the time to compile."""


@dataclass(frozen=True)
class Problem:
    """`equations(y, xp) = 0`, `margins(y, xp) >= 0`, and wishes: of all such y the first wish decides, then
    the second. `xp` is numpy or jax.numpy. `within` does what `at` does, where more is compiled already.
    """

    equations: Callable[[Array, Any], Array]
    margins: Callable[[Array, Any], Array]
    wishes: Sequence[Wish]
    within: Jacobians | None = None

    @cached_property
    def at(self) -> Jacobians:
        """Equations and margins at y, each with its Jacobian."""
        if self.within is not None:
            return self.within
        import jax
        import jax.numpy as jnp

        def both(y):
            return self.equations(y, jnp), self.margins(y, jnp)

        def out(y):
            values = both(y)
            return values, jax.jacfwd(both)(y)

        compiled = jax.jit(out, compiler_options=_QUICKLY)

        def at(y: Vector) -> tuple[Vector, Matrix, Vector, Matrix]:
            with jax.enable_x64(True), jax.default_device(jax.devices("cpu")[0]):
                (equations, margins), (first, second) = compiled(y)
            return tuple(np.asarray(part) for part in (equations, first, margins, second))  # type: ignore

        return at

    def distances(self, y: Vector) -> tuple[float, ...]:
        return tuple(float(np.linalg.norm(matrix @ y - right)) for matrix, right in self.wishes)


def violation(problem: Problem, y: Vector) -> float:
    """The largest absolute residual of an equation, or amount by which a margin is missed; by NumPy."""
    equations, margins = problem.equations(y, np), problem.margins(y, np)
    worst = [0.0, *abs(equations), *(-margins)]
    return float(max(worst)) if np.isfinite(worst).all() else float("inf")


def searched(
    problem: Problem,
    starts: Float[np.ndarray, "starts unknowns"],
    report: Callable[[float], None] = lambda done: None,
) -> list[Vector]:
    """Points that meet the conditions, or come near, best first: by misses, then by the wishes in turn.

    Gauss-Newton leads there from most starts, where a solution exists. Where it does from none, scipy's
    trust-region method (a Levenberg-Marquardt) makes the sum of squares of residuals, missed margins and
    weakly weighted wishes least from every start. All points that meet the conditions are then `settled`.
    `report` is told which share of both is done.
    """
    if starts.shape[1] == 0:
        return [starts[0]]
    found = []
    for done, y in enumerate(starts):
        report(done / len(starts) / 2)
        found.append(_onto(problem, y))
    if all(violation(problem, y) > TOLERANCE for y in found):
        for done, y in enumerate(_descended(problem, list(starts)), 1):
            report((1 + done / len(starts)) / 2)
            found.append(_onto(problem, y))
    found.sort(key=lambda y: _rating(problem, y))
    return sorted((settled(problem, y) for y in found), key=lambda y: _rating(problem, y))


def _rating(problem: Problem, y: Vector) -> list[float]:
    """What is compared, coarse enough not to depend on rounding; the point itself decides ties."""
    missed = max(violation(problem, y) - TOLERANCE, 0.0)
    return [round(missed, 12), *(round(d, 9) for d in problem.distances(y)), *y.round(9)]


def _descended(problem: Problem, starts: Sequence[Vector]) -> Iterator[Vector]:
    """The least sum of squares from each start, first with a stronger and then with a weaker pull."""
    from scipy.optimize import least_squares

    weights = [10.0**-k for k in range(len(problem.wishes))]

    def parts(y: Vector, pull: float) -> tuple[Vector, Matrix]:
        equations, jacobian, margins, slopes = problem.at(y)
        rows = [(equations, jacobian), (np.maximum(-margins, 0), -slopes * (margins < 0)[:, None])]
        rows += [
            (pull * w * (matrix @ y - right), pull * w * matrix)
            for w, (matrix, right) in zip(weights, problem.wishes, strict=True)
        ]
        values, tables = zip(*rows, strict=True)
        return np.concatenate([*values, np.zeros(1)]), np.vstack([*tables, np.zeros((1, len(y)))])

    for y in starts:
        for pull in _PULLS:
            if np.isfinite(np.concatenate([part.ravel() for part in parts(y, pull)])).all():
                y = least_squares(
                    lambda at, pull: parts(at, pull)[0],
                    y,
                    jac=lambda at, pull: np.nan_to_num(parts(at, pull)[1]),  # type: ignore
                    ftol=1e-10,
                    xtol=1e-12,
                    gtol=1e-14,
                    max_nfev=_STEPS,
                    args=(pull,),
                ).x
        yield y


def settled(problem: Problem, y: Vector) -> Vector:
    """Steps along the conditions towards the wishes, as long as these come nearer."""
    if violation(problem, y) > TOLERANCE:
        return y
    for _ in range(_STEPS):
        step = next((found for found in _along(problem, y) if _better(problem, found, y)), None)
        if step is None:
            break
        y = step
    return _closed(problem, y)


def _closed(problem: Problem, y: Vector) -> Vector:
    """Whole last steps, against an error too small to be seen in the distances."""
    for _ in range(8):
        found = _onto(problem, y + _step(problem, y, 1e-8))
        worse = any(
            new > old + 1e-12 for new, old in zip(problem.distances(found), problem.distances(y), strict=True)
        )
        if worse or violation(problem, found) > TOLERANCE or abs(found - y).max() > 1e-4:
            break
        y = found
    return y


def _onto(problem: Problem, y: Vector) -> Vector:
    """Gauss-Newton with the shortest step; missed margins count as equations. Keeps the best y met.

    It may grow worse a few times before it grows better.
    """
    best, least, patience = y, np.inf, _PATIENCE
    for _ in range(_STEPS // 2):
        equations, jacobian, margins, slopes = problem.at(y)
        missed = margins < 0
        residual = np.concatenate([equations, margins[missed]])
        size = abs(residual).max(initial=0.0)
        if size < least:
            best, least = y, size
        else:
            patience = patience - 1 if least > TOLERANCE else 0
        if size <= 1e-15 or not patience or not size < 1e6:
            break
        y = y - np.linalg.lstsq(np.concatenate([jacobian, slopes[missed]]), residual, _RANK)[0]
        if not np.isfinite(y).all():
            break
    return best


def _along(problem: Problem, y: Vector) -> Iterator[Vector]:
    """Points nearer to the wishes that meet the conditions to first order, then brought back onto them.

    First as if no margin were in the way, then with the margins that are used up kept as equations.
    """
    for bound in (-np.inf, 1e-8):
        step = _step(problem, y, bound)
        for halving in range(4):
            yield _onto(problem, y + step * 0.25**halving)


def _step(problem: Problem, y: Vector, bound: float) -> Vector:
    """The step towards the wishes that keeps the equations, and the margins below a bound, to first order."""
    _, jacobian, margins, slopes = problem.at(y)
    first = np.concatenate([jacobian, slopes[margins < bound]])
    rows = [(first, np.zeros(len(first)))]
    rows += [(matrix, right - matrix @ y) for matrix, right in problem.wishes]
    return in_turn(rows, len(y))


def _better(problem: Problem, found: Vector, y: Vector) -> bool:
    if violation(problem, found) > TOLERANCE:
        return False
    for new, old in zip(problem.distances(found), problem.distances(y), strict=True):
        if new < old - 1e-10:
            return True
        if new > old + 1e-12:
            return False
    return False


def in_turn(levels: Sequence[Wish], size: int) -> Vector:
    """The vector that minimises `|A s - b|` of the first level, of all such that of the second, and so on.

    >>> in_turn([(np.array([[1.0, 1.0]]), np.array([1.0])), (np.eye(2), np.array([1.0, 0.0]))], 2).tolist()
    [1.0, 0.0]
    """
    step, free = np.zeros(size), np.eye(size)
    for matrix, right in levels:
        if not free.shape[1] or not len(matrix):
            continue
        inner = matrix @ free
        left, sizes, rows = np.linalg.svd(inner)
        rank = int((sizes > _RANK * max(1.0, sizes.max(initial=0.0))).sum())
        gap = right - matrix @ step
        step = step + free @ (rows[:rank].T @ ((left[:, :rank].T @ gap) / sizes[:rank]))
        free = free @ rows[rank:].T
    return step


def freedom(jacobian: Matrix, parameters: int) -> int:
    """How many of the first `parameters` unknowns can still be chosen while the equations hold.

    That is the dimension of the kernel's image in them: `parameters - rank(J) + rank(J_others)`.
    """
    return parameters - _rank(jacobian) + _rank(jacobian[:, parameters:])


def _rank(matrix: Matrix) -> int:
    if not matrix.size:
        return 0
    sizes = np.linalg.svd(matrix, compute_uv=False)
    return int((sizes > _RANK * max(1.0, sizes[0])).sum())
