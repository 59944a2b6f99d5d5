"""What the powers of a matrix tend to: eigenvalues, their Jordan blocks and directions."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float

from ifs.certificates.differences import eigenvalues

_SAME = 1e-9  # relative: moduli of eigenvalues nearer than this are equal, parts smaller than this are 0

Matrix = Float[np.ndarray, "n n"]


@dataclass(frozen=True)
class Dominant:
    """`L^k = C(k, m-1) sum_j values_j^(k-m+1) leading_j + smaller terms`, C the binomial coefficient.

    `values` are the distinct eigenvalues of largest modulus that have a Jordan block of the largest size
    m = `block`; `leading` their matrices `N^(m-1) Pi`, Pi the spectral projector and N = L - lambda;
    `ranks` the number of such blocks of each. `eigenvalues` holds all eigenvalues, largest modulus first.
    """

    eigenvalues: tuple[complex, ...]
    values: tuple[complex, ...]
    block: int
    leading: tuple[Complex[np.ndarray, "n n"], ...]
    ranks: tuple[int, ...]

    @property
    def modulus(self) -> float:
        return abs(self.values[0]) if self.values else 0.0


@dataclass(frozen=True)
class Part:
    """What a matrix does along one eigenvalue: `L^k = sum over the parts of L^k projector`.

    `block` is the size m of its largest Jordan block and `leading = (L - value)^(m-1) projector`, so that
    `L^k projector = C(k, m-1) value^(k-m+1) leading` up to terms with lower powers of k (none when m = 1).
    `multiplicity` counts the eigenvalue, `rank` the blocks of size m.
    """

    value: complex
    multiplicity: int
    block: int
    rank: int
    projector: Complex[np.ndarray, "n n"]
    leading: Complex[np.ndarray, "n n"]


def spectral_parts(matrix: Matrix) -> tuple[Part, ...]:
    """The parts of a square matrix, largest modulus first; without those below 1e-9 of the largest.

    Eigenvalues count as one when their condition numbers do not tell them apart (they then stand as their
    mean): a Jordan block comes out of the numerical eigenvalues as a small cloud. Empty when the matrix has
    no eigenvalue other than 0.

    >>> [part.value.real for part in spectral_parts(np.diag([0.25, 0.5]))]
    [0.5, 0.25]
    """
    groups = _groups(matrix)
    modulus = max((abs(value) for value, _ in groups), default=0.0)
    if modulus <= _SAME * max(1.0, float(np.linalg.norm(matrix))):
        return ()
    found = [
        Part(value, count, *_leading(matrix, value, count))
        for value, count in groups
        if abs(value) > _SAME * modulus
    ]
    return tuple(sorted(found, key=lambda part: _largest_first(part.value)))


def dominant(matrix: Matrix) -> Dominant:
    """The dominant part of a square matrix; no values when it has no eigenvalue other than 0.

    >>> dominant(np.array([[0.5, 1.0], [0.0, 0.5]])).block
    2
    """
    ordered = tuple(
        sorted((value for value, count in _groups(matrix) for _ in range(count)), key=_largest_first)
    )
    parts = spectral_parts(matrix)
    if not parts:
        return Dominant(ordered, (), 0, (), ())
    modulus = max(abs(part.value) for part in parts)
    top = [part for part in parts if abs(part.value) >= modulus * (1 - _SAME)]
    block = max(part.block for part in top)
    top = sorted(
        (part for part in top if part.block == block), key=lambda part: (-part.value.real, -part.value.imag)
    )
    return Dominant(
        ordered,
        tuple(part.value for part in top),
        block,
        tuple(part.leading for part in top),
        tuple(part.rank for part in top),
    )


def _largest_first(value: complex) -> tuple[float, float, float]:
    return (-round(abs(value), 12), -value.real, -value.imag)


def _groups(matrix: Matrix) -> list[tuple[complex, int]]:
    """The eigenvalues that can be told apart, with their multiplicities."""
    if len(matrix) == 0:
        return []
    values, reach = eigenvalues(matrix)
    near = np.abs(values[:, None] - values[None, :]) <= np.maximum(reach[:, None], reach[None, :])
    groups: list[tuple[complex, int]] = []
    rest = list(range(len(values)))
    while rest:
        members = [rest.pop(0)]
        for member in members:
            joined = [k for k in rest if near[member, k]]
            members.extend(joined)
            rest = [k for k in rest if k not in joined]
        mean = complex(values[members].mean())
        real = abs(mean.imag) <= 1e-12 * max(abs(mean), 1e-300)
        groups.append((complex(mean.real, 0.0) if real else mean, len(members)))
    return groups


def _leading(
    matrix: Matrix, value: complex, count: int
) -> tuple[int, int, Complex[np.ndarray, "n n"], Complex[np.ndarray, "n n"]]:
    """The size of the largest Jordan block, the number of such blocks, Pi and `N^(size-1) Pi`."""
    shifted = matrix - value * np.eye(len(matrix))
    left, _, right = np.linalg.svd(np.linalg.matrix_power(shifted, count))
    columns, rows = right[-count:].conj().T, left[:, -count:].conj().T
    dual = np.linalg.solve(rows @ columns, rows)
    nilpotent = dual @ shifted @ columns
    tolerance = _SAME * np.linalg.norm(matrix)
    power, block = np.eye(count, dtype=complex), 1
    while block < count and np.linalg.norm(power @ nilpotent, 2) > tolerance:
        power, block = power @ nilpotent, block + 1
    values = np.linalg.svd(power, compute_uv=False)
    rank = int((values > _SAME * values[0]).sum())
    return block, rank, (columns @ dual).astype(complex), columns @ power @ dual
