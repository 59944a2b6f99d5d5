"""One step of subdivision for many pieces at once."""

import numpy as np
from jaxtyping import Float

from ifs.system import State

Control = Float[np.ndarray, "pieces points dim"]


def subdivide(state: State, control: Control) -> dict[str, list[np.ndarray]]:
    """The control points of every sub-piece: `Q = P T_i`, with points as rows `Q[k] = sum_j T_i[j,k] P[j]`.

    `control` is `(pieces, points, dim)` in millimetres. Returns for each target cell the pieces
    `(pieces, points of the target, dim)` of its labels, in the order of the labels. A label is one product of
    matrices for all pieces: nothing is compiled, so that the first shape is as quick as the next.
    """
    pieces, points, dimension = control.shape
    columns = np.ascontiguousarray(control.transpose(1, 0, 2)).reshape(points, pieces * dimension)
    result: dict[str, list[np.ndarray]] = {target: [] for target in state.targets}
    for operator, target in zip(state.operators, state.targets, strict=True):
        product = (operator.T @ columns).reshape(-1, pieces, dimension)
        result[target].append(np.ascontiguousarray(product.transpose(1, 0, 2)))
    return result
