"""One step of subdivision for many pieces at once, on JAX in double precision."""

from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from ifs.system import State

if TYPE_CHECKING:
    from jax import Array


@cache
def _jax():
    import jax

    jax.config.update("jax_enable_x64", True)
    return jax


@cache
def _step():
    jax = _jax()

    @jax.jit
    def step(operators, control):
        return jax.numpy.einsum("ljk,cjd->lckd", operators, control)

    return step


def subdivide(state: State, control: Float[np.ndarray, "pieces points dim"]) -> dict[str, list["Array"]]:
    """The control points of every sub-piece: `Q = P T_i`, with points as rows `Q[k] = sum_j T_i[j,k] P[j]`.

    `control` is `(pieces, points, dim)` in millimetres. Returns for each target cell the pieces
    `(pieces, points of the target, dim)` of its labels, in the order of the labels.
    """
    _jax()
    result: dict[str, list] = {target: [] for target in state.targets}
    for target, parts in result.items():
        chosen = [op for op, name in zip(state.operators, state.targets, strict=True) if name == target]
        parts.extend(_step()(np.stack(chosen), control))
    return result
