"""Mixed shapes: at every address a weighted mean of the points of several shapes; the weights are a shape.

At address s the shapes have the points `p_k(s) = P_k x_k(s)` and the blend has `b(s)`, coordinates that sum
to 1. With M_kj the share of shape k at control point j of the blend, the mixed point is

    `p(s) = sum_k beta_k(s) p_k(s)`,    `beta_k(s) = sum_j M_kj b_j(s)`.

It is linear in `b ⊗ (x_1, …, x_K)`, which has operators of its own, `B_i ⊗ diag(T_i^1, …, T_i^K)`. So a mixed
shape is an ordinary one with more control points, `sum_k M_kj P_k[i_k]` for `(j, i_1, …, i_K)`: bounds,
certificates, meshes, voxels and files need nothing new. Source: Gentil 2010, §5.1.3, which says that a mixed
attractor is not one of an IFS: in modelling space it is none, in this space it is.

The source blends operators, `T_i^mu = sum_k mu_k(s) T_i^k` with the weights of the point sought; that is
`ifs.mixtures.modulation`. Both agree where a weight is 1, and wherever all shapes are the same.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, Real

from automata import Automaton
from ifs.mesh import Mesh
from ifs.mixtures.parallel import given, times, together
from ifs.shape import Shape

_SUM = 1e-9


def mixed(
    shapes: Sequence[Shape],
    blend: Automaton,
    weights: Real[np.ndarray, "_shapes _blend"] | None = None,
) -> Shape:
    """The shape `sum_k beta_k(s) p_k(s)`, s running over all addresses, with beta given by a blend.

    `weights` is M, `(shapes, control points of the blend)`, its columns summing to 1; by default the
    identity, one control point of the blend for each shape. `bezier(K - 1)` blends by Bernstein's
    polynomials, `b_spline`, `takagi` and `sierpinski_triangle` by their own basis functions. Control points
    of the result are in mm, `m (1 + sum (n_k - 1))` of them for m of the blend and n_k of shape k.

    Raises `DifferentGluing` for shapes or a blend that are not glued alike, and `ValueError` for weights or
    control points that do not fit, or over 400 control points.

    >>> import ifs
    >>> from subdivision.schemes import bezier, takagi
    >>> curve = mixed([ifs.shape(bezier(2)), ifs.shape(takagi())], bezier(1))
    >>> len(curve.control)
    10
    >>> ifs.convergence(curve.system).verdict
    'contracts'
    """
    shares = _shares(shapes, blend, weights)
    return _mixed([one.control for one in shapes], shapes, blend, shares)


def rational(
    shapes: Sequence[Shape],
    blend: Automaton,
    importance: Sequence[float],
    weights: Real[np.ndarray, "_shapes _blend"] | None = None,
) -> Shape:
    """The same with rational weights, in homogeneous coordinates: the last one is the denominator.

    `beta_k(s) = sum_j w_j M_kj b_j(s) / sum_j w_j b_j(s)`, w the positive `importance` of the control
    points of the blend. The result has one more dimension; `projected(ifs.mesh(result, depth))` lies in
    space. The source (§5.1.4) gives K shapes the degree `m - 1` where they are counted from 0 to m; the
    degree is m.

    >>> import ifs
    >>> from subdivision.schemes import bezier, takagi
    >>> curve = rational([ifs.shape(bezier(2)), ifs.shape(takagi())], bezier(1), [4, 1])
    >>> projected(ifs.mesh(curve, 3)).vertices.shape
    (9, 2)
    """
    factors = np.asarray(importance, dtype=float)
    shares = _shares(shapes, blend, weights)
    if factors.shape != (shares.shape[1],) or not (np.isfinite(factors) & (factors > 0)).all():
        raise ValueError(f"expected {shares.shape[1]} positive weights, found {list(importance)}")
    controls = [np.column_stack([one.control, np.ones(len(one.control))]) for one in shapes]
    return _mixed(controls, shapes, blend, shares * factors)


def projected(mesh: Mesh) -> Mesh:
    """A mesh in homogeneous coordinates in space: all coordinates divided by the last one.

    Raises `ValueError` where that is not positive.
    """
    below = mesh.vertices[:, -1]
    if not (below > 0).all():
        worst = int(np.argmin(below))
        raise ValueError(
            f"the weights of the blend cancel: vertex {worst} has the denominator {below[worst]:g}"
        )
    return Mesh(mesh.vertices[:, :-1] / below[:, None], mesh.faces)


def _mixed(
    controls: Sequence[Float[np.ndarray, "_points dim"]],
    shapes: Sequence[Shape],
    blend: Automaton,
    shares: Float[np.ndarray, "shapes blend"],
) -> Shape:
    joined = together(*(one.automaton for one in shapes))
    whole = times(blend, joined.automaton)
    numbers = np.array(joined.points)
    parts = np.stack([points[numbers[:, k]] for k, points in enumerate(controls)])
    tuples = np.array(whole.points)
    control = np.einsum("kj,ksd->jsd", shares, parts)[tuples[:, 0], tuples[:, 1]]
    return given(whole.automaton, control)


def _shares(shapes: Sequence[Shape], blend: Automaton, weights: np.ndarray | None) -> np.ndarray:
    if not shapes:
        raise ValueError("expected one shape or more, found none")
    dimensions = [one.control.shape[1] for one in shapes]
    if len(set(dimensions)) > 1:
        raise ValueError(f"the control points have different dimensions: {dimensions}")
    points = blend.cells[blend.shape].points
    if weights is None:
        if points != len(shapes):
            raise ValueError(
                f"{blend.name!r} has {points} control points for {len(shapes)} shapes: give weights, "
                f"a matrix of {len(shapes)} rows and {points} columns that sum to 1"
            )
        return np.eye(points)
    shares = np.array(weights, dtype=float)
    if shares.shape != (len(shapes), points):
        raise ValueError(f"expected weights {(len(shapes), points)}, found {shares.shape}")
    off = abs(shares.sum(axis=0) - 1)
    if not (off <= _SUM).all():
        column = int(np.argmax(~(off <= _SUM)))
        raise ValueError(f"column {column} of the weights sums to {shares[:, column].sum():g}, expected 1")
    return shares
