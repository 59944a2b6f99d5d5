"""Attributes: numbers of a set that similarities leave as they are."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from trees.errors import TreeError
from trees.measures.counts import box_dimension
from trees.measures.directions import value
from trees.measures.frame import principal_frame
from trees.measures.moments import moments
from trees.tree import Tree

KINDS = ("inertia", "skewness", "kurtosis", "fill", "dimension")
DEFAULT = ("inertia", "skewness", "kurtosis", "fill")


def attributes(
    tree: Tree, kinds: Sequence[str] = DEFAULT, tolerance: float = 0.02
) -> Float[np.ndarray, " n"]:
    """The attribute vector of a set: numbers without unit, in the frame that `principal_frame` finds.

    With `s_i^2` the variance along axis i of k, and u the coordinates in the frame:

    - "inertia": `s_i / s_1` for i from 2 (k - 1 numbers);
    - "skewness": the cube root of the mean of `u_i^3`, over `s_1` (k numbers);
    - "kurtosis": the fourth root of the mean of `u_i^4`, over `s_1` (k numbers);
    - "fill": `(s_1 ... s_k / volume)^(1/k)` (one number);
    - "dimension": `box_dimension(tree)` (one number, which the position in the grid changes).

    The first two are the vector of Guye 1988, VI.2, of 2k - 1 numbers; there the variance itself is taken as
    unit of both, with which the vector changes with scale. A set and its mirror image have equal attributes.

    Raises `TreeError` for the empty set, or an unknown kind.

    >>> from trees import from_array
    >>> bar = from_array(np.indices((16, 16))[0] < 4)
    >>> attributes(bar).round(3).tolist()
    [0.25, 0.0, 0.0, 1.158, 0.29, 0.289]
    """
    _check(kinds)
    found = moments(tree, 4).central()
    frame = principal_frame(found, tolerance)
    deviations = np.sqrt(frame.variances)
    largest, parts = deviations[0], []
    for kind in kinds:
        if kind == "inertia":
            parts.append(deviations[1:] / largest)
        elif kind == "skewness":
            parts.append(np.cbrt(frame.skewness) / largest)
        elif kind == "kurtosis":
            fourth = found.means(4)
            parts.append(np.array([value(fourth, axis) for axis in frame.axes]) ** 0.25 / largest)
        elif kind == "fill":
            parts.append(np.array([np.exp(np.log(deviations).mean()) / tree.measure ** (1 / tree.dimension)]))
        else:
            parts.append(np.array([box_dimension(tree).value]))
    return np.concatenate(parts)


def attribute_names(dimension: int, kinds: Sequence[str] = DEFAULT) -> list[str]:
    """The names of the numbers of `attributes`, axes counted from 1.

    >>> attribute_names(2, ("inertia", "fill"))
    ['inertia 2', 'fill']
    """
    _check(kinds)
    axes = {"inertia": range(2, dimension + 1), "skewness": range(1, dimension + 1)}
    axes["kurtosis"] = axes["skewness"]
    return [
        name for kind in kinds for name in ([f"{kind} {i}" for i in axes[kind]] if kind in axes else [kind])
    ]


def _check(kinds: Sequence[str]) -> None:
    wrong = [kind for kind in kinds if kind not in KINDS]
    if wrong or not kinds:
        raise TreeError(f"kinds {list(kinds)}: one or more of {', '.join(KINDS)} are needed")
