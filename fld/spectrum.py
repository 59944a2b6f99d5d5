"""What the powers of a matrix tend to: the dominant eigenvalues, their Jordan blocks and directions."""

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


def dominant(matrix: Matrix) -> Dominant:
    """The dominant part of a square matrix; no values when it has no eigenvalue other than 0.

    Eigenvalues count as one when their condition numbers do not tell them apart (they then stand as their
    mean): a Jordan block comes out of the numerical eigenvalues as a small cloud.

    >>> dominant(np.array([[0.5, 1.0], [0.0, 0.5]])).block
    2
    """
    groups = _groups(matrix)
    ordered = sorted(
        (value for value, count in groups for _ in range(count)),
        key=lambda z: (-round(abs(z), 12), -z.real, -z.imag),
    )
    modulus = max((abs(value) for value, _ in groups), default=0.0)
    if modulus <= _SAME * max(1.0, float(np.linalg.norm(matrix))):
        return Dominant(tuple(ordered), (), 0, (), ())
    found = []
    for value, count in groups:
        if abs(value) >= modulus * (1 - _SAME):
            found.append((value, *_leading(matrix, value, count)))
    block = max(size for _, size, _, _ in found)
    found = sorted(
        (entry for entry in found if entry[1] == block), key=lambda entry: (-entry[0].real, -entry[0].imag)
    )
    return Dominant(
        tuple(ordered),
        tuple(value for value, *_ in found),
        block,
        tuple(leading for *_, leading, _ in found),
        tuple(rank for *_, rank in found),
    )


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


def _leading(matrix: Matrix, value: complex, count: int) -> tuple[int, Complex[np.ndarray, "n n"], int]:
    """The size of the largest Jordan block, `N^(size-1) Pi`, and its rank."""
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
    return block, columns @ power @ dual, int((values > _SAME * values[0]).sum())
