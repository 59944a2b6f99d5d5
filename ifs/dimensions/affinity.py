"""An upper bound of dimensions for pieces that are no scaled copies: the affinity dimension of long words."""

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from ifs.certificates.convergence import require_contraction
from ifs.certificates.differences import components
from ifs.dimensions.spans import configurations, spanning_points
from ifs.shape import Shape
from ifs.system import System

_WORDS = 4000  # products of one length, at most
_RANK = 1e-9
_STEPS = 60
_LETTERS = 40

Stack = Float[np.ndarray, "_words _rows _columns"]
Products = dict[tuple[str, str], Stack]


def affinity_bound(shape: Shape) -> float:
    """An upper bound of the box dimension (so of the Hausdorff dimension) of a shape.

    The singular value function of a matrix with singular values a_1 >= … >= a_m is `phi^s = a_1 … a_k
    a_(k+1)^(s-k)`, k the integer part of s. It is submultiplicative, so that for every n the dimension is at
    most the s with `rho(sum over the words w of n letters of phi^s(A_w)) = 1`. The bound is the least over
    the lengths with up to 4000 words, at most the dimension of the span. The A_w act on the span of the
    attractor, measured in mm where the control points tell its directions apart, else in barycentric space,
    which the control points cannot make larger. Raises `NotContracting` or `Undecided`. Source: K. J.
    Falconer, The Hausdorff dimension of self-affine fractals, 1988.

    >>> from ifs.shape import shape
    >>> 1 <= affinity_bound(shape("corner-cutting")) < 1.3
    True
    """
    require_contraction(shape.system)
    steps, ranks = _linear_parts(shape)
    limit = float(
        min(max(ranks.values(), default=0), np.linalg.matrix_rank(shape.control - shape.control[0]))
    )
    powers, best = steps, limit
    parts = [tuple(c for c in part if c in ranks) for part in components(shape.system)]
    for _ in range(_LETTERS):
        values = {
            ends: np.linalg.svd(words, compute_uv=False)
            for ends, words in powers.items()
            if 0 not in words.shape
        }
        best = min(best, max((_least(values, part, best) for part in parts), default=0.0))
        longer = _longer(powers, steps)
        if longer is None or best == 0:
            break
        powers = longer
    return best


def _linear_parts(shape: Shape) -> tuple[Products, dict[str, int]]:
    """The linear parts of all labels between cells, in coordinates of the spans, and their dimensions."""
    system: System = shape.system
    control = configurations(system, shape.control)
    bases, rulers = {}, {}
    for cell, columns in spanning_points(system).items():
        if cell in control:
            bases[cell] = np.linalg.qr(columns[:, 1:] - columns[:, :1])[0]
            rulers[cell] = np.linalg.qr(control[cell].T @ bases[cell])[1]
    if not all(_regular(rulers[cell], control[cell]) for cell in rulers):
        rulers = {cell: np.eye(basis.shape[1]) for cell, basis in bases.items()}
    steps: dict[tuple[str, str], list[np.ndarray]] = {}
    for cell in bases:
        state = system.states[cell]
        for operator, target in zip(state.operators, state.targets, strict=True):
            linear = rulers[cell] @ bases[cell].T @ operator @ bases[target] @ np.linalg.inv(rulers[target])
            steps.setdefault((cell, target), []).append(linear)
    ranks = {cell: basis.shape[1] for cell, basis in bases.items()}
    return {ends: np.stack(found) for ends, found in steps.items()}, ranks


def _regular(ruler: Float[np.ndarray, "rows n"], control: Float[np.ndarray, "points dim"]) -> bool:
    if ruler.shape[0] < ruler.shape[1]:
        return False
    sizes = np.linalg.svd(ruler, compute_uv=False)
    return not len(sizes) or bool(sizes.min() > _RANK * max(sizes.max(), 1e-300))


def _longer(powers: Products, steps: Products) -> Products | None:
    found: dict[tuple[str, str], list[np.ndarray]] = {}
    count = sum(
        len(words) * len(more)
        for (_, middle), words in powers.items()
        for (start, _), more in steps.items()
        if start == middle
    )
    if count > _WORDS:
        return None
    for (start, middle), words in powers.items():
        for (other, end), more in steps.items():
            if other == middle:
                products = words[:, None] @ more[None]
                found.setdefault((start, end), []).append(products.reshape(-1, *products.shape[2:]))
    return {ends: np.concatenate(parts) for ends, parts in found.items()}


def _least(values: Mapping[tuple[str, str], np.ndarray], cells: tuple[str, ...], high: float) -> float:
    """The least s found, from `high` down, whose matrix has a spectral radius of at most 1."""
    if not any(ends[0] in cells and ends[1] in cells for ends in values):
        return 0.0
    if _radius(values, cells, high) > 1:
        return high
    low = 0.0
    for _ in range(_STEPS):
        middle = (low + high) / 2
        if _radius(values, cells, middle) > 1:
            low = middle
        else:
            high = middle
    return high


def _radius(values: Mapping[tuple[str, str], np.ndarray], cells: tuple[str, ...], s: float) -> float:
    place = {cell: k for k, cell in enumerate(cells)}
    matrix = np.zeros((len(cells), len(cells)))
    for (start, end), sizes in values.items():
        if start in place and end in place:
            matrix[place[start], place[end]] = _singular_value_function(sizes, s).sum()
    return float(np.abs(np.linalg.eigvals(matrix)).max(initial=0.0))


def _singular_value_function(sizes: Float[np.ndarray, "words m"], s: float) -> Float[np.ndarray, "words"]:
    whole = int(s)
    if whole >= sizes.shape[1]:
        return sizes.prod(axis=1) ** (s / sizes.shape[1])
    return sizes[:, :whole].prod(axis=1) * sizes[:, whole] ** (s - whole)
