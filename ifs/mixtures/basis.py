"""The matrix that takes control points to points of a shape at given parameters."""

from typing import Any

import numpy as np
from jaxtyping import Float, Real

from ifs.complex import initial
from ifs.shape import Shape
from ifs.tangency.points import at


def basis(shape: Shape, parameters: Real[np.ndarray, "n directions"]) -> Float[np.ndarray, "n points"]:
    """`B_ij`, the share of control point j in the point at parameter i: `points = B · control`.

    Rows sum to 1. For `bezier(d)` they are Bernstein's polynomials. `parameters` is `(n, 1)` for curves and
    `(n, 2)` for faces, as `points.at` places them; rows of parameters in holes are NaN. Raises what `at`
    raises.

    >>> import ifs
    >>> from subdivision.schemes import bezier
    >>> basis(ifs.shape(bezier(2)), np.array([[0.5], [1.0]])).tolist()
    [[0.25, 0.5, 0.25], [0.0, 0.0, 1.0]]
    """
    size = len(shape.control)
    whole: Any = initial(shape.topology, shape.system, np.eye(size))
    parameters = np.asarray(parameters, dtype=float)
    return at(whole, shape.system.shape, np.zeros(len(parameters), dtype=np.int64), parameters)
