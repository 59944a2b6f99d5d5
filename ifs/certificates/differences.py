"""The linear parts of a system: what its operators do to differences of points.

Differences of barycentric points sum to 0, so their first n - 1 coordinates say everything: the
space of differences of a cell with n points is R^(n-1), and that of a cell with 1 point is 0.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Shaped

from ifs.system import Operator, System

Linear = Float[np.ndarray, "_size _target_size"]


@dataclass(frozen=True)
class Step:
    """One linear part from `cell` to `target`: that of `label`, and of every label equal to it.

    `matrix` maps the differences of the target into those of the cell. The maps that the step
    stands for are within `spread` of it (Frobenius norm).
    """

    cell: str
    target: str
    label: str
    matrix: Linear
    spread: float


def linear_part(operator: Operator) -> Linear:
    """An operator on differences, in their first coordinates: `T[:-1, :-1] - T[:-1, -1:]`.

    >>> import numpy as np
    >>> linear_part(np.array([[1.0, 0.5], [0.0, 0.5]]))
    array([[0.5]])
    """
    return operator[:-1, :-1] - operator[:-1, -1:]


def components(system: System) -> tuple[tuple[str, ...], ...]:
    """The strongly connected components of the automaton: whatever one leads to stands before it.

    Cells keep the system's order inside a component.
    """
    names = list(system.states)
    place = {name: k for k, name in enumerate(names)}
    reach = np.eye(len(names))
    for name in names:
        for target in system.states[name].targets:
            reach[place[name], place[target]] = 1
    for _ in range(len(names).bit_length()):
        reach = np.minimum(reach @ reach, 1)
    mutual = reach * reach.T
    first = [int(row.argmax()) for row in mutual]
    # A component that leads to another one reaches strictly more cells than the other.
    heads = sorted(set(first), key=lambda k: (reach[k].sum(), k))
    return tuple(tuple(names[k] for k in np.flatnonzero(mutual[head])) for head in heads)


def steps(system: System, cells: tuple[str, ...]) -> tuple[Step, ...]:
    """The linear parts between the given cells; equal ones (to 13 digits) are one step."""
    inside = set(cells)
    found: dict[tuple[str, str, bytes], list] = {}
    for cell in cells:
        state = system.states[cell]
        for label, target, operator in zip(state.labels, state.targets, state.operators, strict=True):
            if target in inside:
                matrix = linear_part(np.asarray(operator, dtype=np.float64))
                scale = 2.0 ** np.ceil(np.log2(max(np.abs(matrix).max(initial=0.0), 1e-300)))
                key = (np.round(matrix / scale, 13) + 0.0).tobytes() + np.float64(scale).tobytes()
                found.setdefault((cell, target, key), []).append((label, matrix))
    return tuple(
        Step(
            cell,
            target,
            same[0][0],
            same[0][1],
            max(float(np.linalg.norm(matrix - same[0][1])) for _, matrix in same),
        )
        for (cell, target, _), same in found.items()
    )


def spectral_norm(matrices: Float[np.ndarray, "count m n"]) -> Float[np.ndarray, "count"]:
    """The largest singular value of each matrix, to a few units in the last place; 0 if empty."""
    if matrices.shape[1] > matrices.shape[2]:
        matrices = matrices.swapaxes(1, 2)
    if 0 in matrices.shape:
        return np.zeros(len(matrices))
    if matrices.shape[1] == 1:
        return np.linalg.norm(matrices[:, 0], axis=1)
    largest = np.abs(matrices).max(axis=(1, 2))
    scale = np.where(largest > 0, largest, 1.0)
    matrices = matrices / scale[:, None, None]
    squares = np.linalg.eigvalsh(matrices @ matrices.swapaxes(1, 2))[:, -1]
    return np.sqrt(np.maximum(squares, 0.0)) * scale


def spectral_radius(matrix: Float[np.ndarray, "n n"]) -> float:
    """The largest modulus of an eigenvalue, careful with defective matrices.

    The eigenvalues of a Jordan block of size m are computed with errors of the order of
    `eps^(1/m)`, but their mean is accurate; so each eigenvalue stands for the mean of those which
    its own condition number does not tell apart from it. The mean never exceeds the largest
    modulus: the result errs on the small side.

    >>> import numpy as np
    >>> abs(spectral_radius(np.array([[0.5, 1e3], [0.0, 0.5]])) - 0.5) < 1e-15
    True
    """
    if matrix.shape[0] == 0:
        return 0.0
    values, reach = eigenvalues(matrix)
    near = np.abs(values[:, None] - values[None, :]) <= reach[:, None]
    means = (near * values[None, :]).sum(axis=1) / near.sum(axis=1)
    return float(np.abs(means).max())


def eigenvalues(
    matrix: Float[np.ndarray, "n n"],
) -> tuple[Shaped[np.ndarray, "n"], Float[np.ndarray, "n"]]:
    """The eigenvalues as computed, and how far each may be from the true one by its condition number."""
    values, vectors = np.linalg.eig(matrix)
    try:
        condition = len(values) * np.abs(np.linalg.inv(vectors)).max(axis=1)
    except np.linalg.LinAlgError:
        condition = np.full(len(values), np.inf)
    reach = np.minimum(10 * len(values) * np.finfo(float).eps * condition, 1e-4) * np.linalg.norm(matrix)
    return values, reach
