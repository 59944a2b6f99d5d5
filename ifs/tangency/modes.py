"""How differences of points shrink under the powers of an operator: their parts by modulus of eigenvalue."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from ifs.certificates.differences import eigenvalues

_SAME = 1e-8  # relative: moduli of eigenvalues nearer than this are equal
_STILL = 1e-9  # relative: parts smaller than this are 0
_ZERO = 1e-10  # moduli below this are 0
_RANK = 1e-11  # relative: singular values below this are 0

Differences = Float[np.ndarray, "points differences"]


@dataclass(frozen=True)
class Mode:
    """A part of some differences that shrinks by the factor `modulus`, times a power of k after k rounds.

    `straight[i]` says whether the part of difference i keeps its direction, and does not turn over or around.
    """

    modulus: float
    parts: Differences
    straight: Bool[np.ndarray, "differences"]


def modes(operator: Float[np.ndarray, "points points"], differences: Differences) -> list[Mode]:
    """Differences (columns of sum 0) under the powers of an operator, mode by mode, the slowest first.

    With L the operator, r the modulus of some eigenvalues, d their part of a difference and N = L / r - 1:
    where N^m d = 0, `(L / r)^k d = sum_j C(k, j) N^j d`, and the modes are N^(m-1) d, ..., N d, d. Elsewhere
    (eigenvalues that are not real and positive) the mode is d, and not straight. Eigenvalues count on the
    space that the differences and their images span: a symmetry of the differences rules out the rest.

    >>> halves = np.array([[1, 0.5, 0.25], [0, 0.5, 0.5], [0, 0, 0.25]])
    >>> [round(mode.modulus, 9) for mode in modes(halves, np.array([[-1.0, -1], [1, 0], [0, 1]]))]
    [0.5, 0.25]
    """
    basis = _invariant(operator, differences)
    matrix, coordinates = basis.T @ operator @ basis, basis.T @ differences
    least = _STILL * max(1.0, float(np.abs(coordinates).max(initial=0.0)))
    result = []
    for values, projector in _levels(matrix):
        modulus = float(np.abs(values).mean())
        shifted = matrix / modulus - np.eye(len(matrix))
        powers = [projector @ coordinates]
        while len(powers) <= len(values) and np.abs(powers[-1]).max(initial=0.0) > least:
            powers.append(shifted @ powers[-1])
        straight = np.abs(powers[-1]).max(axis=0) <= least
        for power in powers[-2:0:-1] if straight.any() else []:
            result.append(Mode(modulus, basis @ np.where(straight, power, 0.0), straight))
        result.append(Mode(modulus, basis @ powers[0], straight))
    return result


def _invariant(
    operator: Float[np.ndarray, "points points"], differences: Differences
) -> Float[np.ndarray, "points dimensions"]:
    """An orthonormal basis of the space that the differences and their images span."""
    basis = np.zeros((len(operator), 0))
    fresh = differences
    while fresh.shape[1]:
        fresh = fresh - basis @ (basis.T @ fresh)
        left, sizes, _ = np.linalg.svd(fresh - basis @ (basis.T @ fresh), full_matrices=False)
        new = left[:, sizes > _RANK * max(1.0, float(np.abs(differences).max(initial=0.0)))]
        basis, _ = np.linalg.qr(np.concatenate([basis, new], axis=1))
        fresh = operator @ basis[:, basis.shape[1] - new.shape[1] :]
    return basis


def _levels(
    matrix: Float[np.ndarray, "n n"],
) -> list[tuple[np.ndarray, Float[np.ndarray, "n n"]]]:
    """The eigenvalues by modulus, largest first, with the projector on the space of each modulus."""
    if not len(matrix):
        return []
    values, reach = eigenvalues(matrix)
    order = np.argsort(-np.abs(values), kind="stable")
    groups: list[list[int]] = []
    for i in order:
        modulus = abs(values[i])
        if modulus <= _ZERO:
            break
        if groups:
            last = groups[-1][-1]
            gap = abs(values[last]) - modulus
            if gap <= max(_SAME * abs(values[last]), float(reach[i]), float(reach[last])):
                groups[-1].append(i)
                continue
        groups.append([i])
    return [(values[group], _projector(matrix, values[group])) for group in groups]


def _projector(matrix: Float[np.ndarray, "n n"], values: np.ndarray) -> Float[np.ndarray, "n n"]:
    """The spectral projector of some eigenvalues, from the product of the shifted matrices."""
    count = len(values)
    shifted = np.eye(len(matrix), dtype=complex)
    for value in values:
        shifted = (matrix - value * np.eye(len(matrix))) @ shifted
    left, _, right = np.linalg.svd(shifted)
    columns, rows = right[-count:].conj().T, left[:, -count:].conj().T
    return np.real(columns @ np.linalg.solve(rows @ columns, rows))
