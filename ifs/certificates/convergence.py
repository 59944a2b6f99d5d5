"""Does a system contract, and how fast: bounds of its joint spectral radius, with their proof.

The joint spectral radius of the linear parts is the limit, for k to infinity, of the largest
`|L_w|^(1/k)` over the words w of length k that are paths of the automaton. Below 1 the system has
an attractor, whatever norm one looks with. A cycle gives a lower bound, the k-th root of the
spectral radius of its product; norms of words give upper bounds (G. Gripenberg, Computing the joint
spectral radius, Linear Algebra and its Applications 234, 1996).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
from jaxtyping import Float, Int

from ifs.certificates.differences import Step, components, spectral_norm, spectral_radius, steps
from ifs.certificates.ellipsoids import ellipsoids, scaled
from ifs.error import NotContracting, Undecided
from ifs.system import System

Verdict = Literal["contracts", "does not contract", "undecided"]

BUDGET = 2e7
TOLERANCE = 1e-3

_EPS = float(np.finfo(np.float64).eps)
_ONE = 1 - 1e-12
_CYCLES = 32  # words of each length and cell whose eigenvalues are looked at
_LENGTH = 200
RECENT = 64  # systems whose certificates are kept
_OVERHEAD = 500  # what one word costs beside its multiplications


@dataclass(frozen=True)
class Component:
    """The bounds for one strongly connected component of the automaton, and what proves them.

    Every path w of length k inside the component, from x to y, satisfies
    `|R_x L_w R_y^-1| <= constant * rate^k` in the spectral norm, where `R = factors[cell]` acts on
    the first n - 1 coordinates of a difference and L_w is the product of the linear parts along w.
    The proof took words of up to `depth` letters. `rate` is `upper`, or 1e-3 where upper is less.
    """

    cells: tuple[str, ...]
    lower: float
    upper: float
    cell: str | None
    word: tuple[str, ...]
    depth: int
    rate: float
    constant: float
    factors: Mapping[str, Float[np.ndarray, "_size _size"]]


@dataclass(frozen=True)
class Convergence:
    """Where the joint spectral radius of a system lies: in `[lower, upper]`.

    `upper` is a bound with rounding accounted for, so that differences shrink like `upper^k`;
    `lower` is attained by repeating `word` from `cell` (both empty when there is no cycle) and is
    accurate to about 1e-12. The components tell what leads to what: a later one leads to earlier
    ones, never the reverse.
    """

    verdict: Verdict
    lower: float
    upper: float
    cell: str | None
    word: tuple[str, ...]
    components: tuple[Component, ...]


@dataclass(frozen=True)
class _Words:
    """Words from one cell to another: products in the norms, their rounding, the steps taken.

    `least` is the smallest `norm^(1/length)` of the prefixes of each word.
    """

    products: Float[np.ndarray, "count size target_size"]
    error: Float[np.ndarray, "count"]
    least: Float[np.ndarray, "count"]
    path: Int[np.ndarray, "count length"]


_Alive = dict[tuple[str, str], _Words]


@lru_cache(maxsize=RECENT)
def convergence(system: System, budget: float = BUDGET, tolerance: float = TOLERANCE) -> Convergence:
    """Bound the joint spectral radius of the linear parts of a system, component by component.

    Words grow until their norms bound the radius to within `tolerance` of the best cycle found, or
    until `budget` multiplications are spent (2e7 are some tenths of a second), or words have 200
    letters. The verdict is "does not contract" when some cycle's product has spectral radius
    1 - 1e-12 or more (the search ends there, so that `lower` need not be the largest),
    "contracts" when `upper < 1`, else "undecided". What was found of the last systems is remembered.

    >>> import numpy as np
    >>> from ifs.system import State, System
    >>> halves = (np.array([[1, 0.5], [0, 0.5]]), np.array([[0.5, 0], [0.5, 1]]))
    >>> segment = State("segment", 2, ("0", "1"), ("segment", "segment"), halves)
    >>> found = convergence(System("segment", {"segment": segment}))
    >>> found.verdict, found.lower, round(found.upper, 9), found.word
    ('contracts', 0.5, 0.5, ('0',))
    """
    parts: list[Component] = []
    for cells in components(system):
        part, spent = _component(system, cells, budget, tolerance)
        parts.append(part)
        budget -= spent
    found = tuple(parts)
    worst = max(found, key=lambda part: part.lower)
    upper = max(part.upper for part in found)
    verdict: Verdict = "contracts" if upper < 1 else "undecided"
    if worst.lower > 0 and worst.lower ** len(worst.word) >= _ONE:
        verdict = "does not contract"
    return Convergence(verdict, worst.lower, upper, worst.cell, worst.word, found)


def require_contraction(system: System, budget: float = BUDGET, tolerance: float = TOLERANCE) -> Convergence:
    """The convergence of a system that contracts.

    Raises `NotContracting` with the cell, the word and its spectral radius, or `Undecided` with
    the interval that the budget left.
    """
    found = convergence(system, budget, tolerance)
    if found.verdict == "contracts":
        return found
    if found.verdict == "does not contract" and found.cell is not None:
        raise NotContracting(found.cell, found.word, found.lower ** len(found.word))
    raise Undecided(found.cell, found.word, found.lower, found.upper, budget)


def require_no_growth(system: System) -> None:
    """Raise `NotContracting` for a system that is proved not to contract; say nothing of undecided ones."""
    found = convergence(system)
    if found.verdict == "does not contract" and found.cell is not None:
        raise NotContracting(found.cell, found.word, found.lower ** len(found.word))


def _component(
    system: System, cells: tuple[str, ...], budget: float, tolerance: float
) -> tuple[Component, float]:
    """Gripenberg's search: a word is closed once some prefix of it shrinks fast enough.

    Any path then is a sequence of closed words and a rest, which is where the rate comes from, and
    the constant from the largest norm met on the way. Also returns the work spent.
    """
    taken = steps(system, cells)
    sizes = {cell: system.states[cell].points - 1 for cell in cells}
    factors = ellipsoids(sizes, taken)
    matrices = [scaled(step, factors) for step in taken]
    alive: _Alive = {
        (cell, cell): _Words(
            np.eye(sizes[cell])[None], np.zeros(1), np.full(1, np.inf), np.zeros((1, 0), int)
        )
        for cell in cells
    }
    lower, word, closed, spent, length = 0.0, (), 0.0, 0.0, 0
    peaks = [1.0]
    while taken and length < _LENGTH:
        cost = _cost(alive, taken, sizes)
        if length and spent + cost > budget:
            break
        spent += cost
        length += 1
        alive, peak = _grown(alive, taken, matrices, length)
        peaks.append(peak)
        lower, word = _best_cycle(alive, taken, length, lower, word)
        if word and lower ** len(word) >= _ONE:
            break
        # Half the way to 1 where that is nearer, so that a slow contraction is told from none.
        alive, reached = _open(alive, min(lower + tolerance, (lower + 1) / 2))
        closed = max(closed, reached)
        if not alive:
            break
    remaining = max((float(words.least.max()) for words in alive.values() if taken), default=0.0)
    upper = max(lower, closed, remaining)
    rate = max(upper, 1e-3)
    constant = max(peak / rate**k for k, peak in enumerate(peaks))
    cell = taken[word[0]].cell if word else None
    labels = tuple(taken[k].label for k in word)
    return (
        Component(cells, lower, upper, cell, labels, length, rate, constant, factors),
        spent,
    )


def _cost(alive: _Alive, taken: tuple[Step, ...], sizes: Mapping[str, int]) -> float:
    return float(
        sum(
            len(words.error) * (sizes[start] * sizes[end] * sizes[step.target] + _OVERHEAD)
            for (start, end), words in alive.items()
            for step in taken
            if step.cell == end
        )
    )


def _grown(
    alive: _Alive,
    taken: tuple[Step, ...],
    matrices: list[tuple[Float[np.ndarray, "_size _target_size"], float]],
    length: int,
) -> tuple[_Alive, float]:
    """Every word one step longer, and the largest norm among them."""
    grown: dict[tuple[str, str], list[_Words]] = {}
    peak = 0.0
    for (start, end), words in alive.items():
        norms = spectral_norm(words.products) + words.error
        for k, step in enumerate(taken):
            if step.cell != end:
                continue
            matrix, margin = matrices[k]
            products = words.products @ matrix
            size = max(1, *products.shape[1:], matrix.shape[0])
            own = float(spectral_norm(matrix[None])[0])
            error = words.error * own + norms * (margin + 2 * size**1.5 * _EPS * own)
            reached = spectral_norm(products) * (1 + 8 * size * _EPS) + error
            least = np.minimum(words.least, reached ** (1 / length))
            path = np.column_stack([words.path, np.full(len(error), k)])
            grown.setdefault((start, step.target), []).append(_Words(products, error, least, path))
            peak = max(peak, float(reached.max(initial=0.0)))
    return {ends: _joined(found) for ends, found in grown.items()}, peak


def _joined(words: list[_Words]) -> _Words:
    return _Words(
        np.concatenate([found.products for found in words]),
        np.concatenate([found.error for found in words]),
        np.concatenate([found.least for found in words]),
        np.concatenate([found.path for found in words]),
    )


def _open(alive: _Alive, threshold: float) -> tuple[_Alive, float]:
    """The words that no prefix closes yet, and the largest value among those closed now."""
    still: _Alive = {}
    reached = 0.0
    for ends, words in alive.items():
        keep = words.least > threshold
        reached = max(reached, float(words.least[~keep].max(initial=0.0)))
        if keep.any():
            still[ends] = _Words(words.products[keep], words.error[keep], words.least[keep], words.path[keep])
    return still, reached


def _best_cycle(
    alive: _Alive, taken: tuple[Step, ...], length: int, lower: float, word: tuple[int, ...]
) -> tuple[float, tuple[int, ...]]:
    """The better of the best cycle so far and those of this length with the largest norms."""
    for (start, end), words in alive.items():
        if start != end or words.products.shape[1] == 0:
            continue
        promising = np.flatnonzero(words.least > lower)
        largest = np.argsort(-words.least[promising], kind="stable")[:_CYCLES]
        promising = promising[largest]
        if len(promising) == 0:
            continue
        radii = np.abs(np.linalg.eigvals(words.products[promising])).max(axis=1)
        path = words.path[promising[int(radii.argmax())]]
        product = taken[path[0]].matrix
        for k in path[1:]:
            product = product @ taken[k].matrix
        value = spectral_radius(product) ** (1 / length)
        if value > lower * (1 + 1e-13):
            lower, word = value, tuple(int(k) for k in path)
    return lower, word
