"""Projective IFS: maps that are not affine, iterated in homogeneous coordinates inside a box.

The certificates of `ifs.convergence` and the boxes of `ifs.bounds` are for affine operators and say nothing
here; `contraction` gives what stands for them: a box that all maps keep, with a Lipschitz constant below 1.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from ifs.maps.maps import Corner, Map

MOST_POINTS = 20_000_000

Points = Float[np.ndarray, "_points _dim"]


class NoContraction(ValueError):
    """A box on which maps are not shown to contract. `map` is the number of the map at fault."""

    def __init__(self, number: int, why: str):
        self.map = number
        super().__init__(f"map {number} {why}")


def contraction(maps: Sequence[Map], lo: Corner, hi: Corner) -> float:
    """A common Lipschitz constant below 1 of maps on a box that they map into itself.

    Then the maps have one attractor in the box, and their n-th images of the box are within `L^n` times its
    diagonal of it (Hausdorff distance). A box that fails may only be too large or too small, and maps that
    contract in another metric than the Euclidean are not recognised. Raises `NoContraction`, naming the map.

    >>> from ifs.maps.maps import projective
    >>> maps = [projective([[1, 0], [1, 3]]), projective([[1, 1], [0, 3]])]
    >>> round(contraction(maps, [0], [1]), 9)
    0.333333333
    """
    if not maps:
        raise ValueError("a projective IFS has at least one map")
    worst = 0.0
    low, high = np.array(lo, dtype=float), np.array(hi, dtype=float)
    room = 1e-12 * np.abs(high - low).max()
    for number, each in enumerate(maps):
        try:
            least, most = each.image_box(lo, hi)
            constant = each.lipschitz(lo, hi)
        except ValueError as error:
            raise NoContraction(number, f"cannot be bounded: {error}") from None
        if (least < low - room).any() or (most > high + room).any():
            reached = f"{least.round(9).tolist()} to {most.round(9).tolist()}"
            box = f"{low.tolist()} to {high.tolist()}"
            raise NoContraction(number, f"leaves the box {box}: it reaches {reached}")
        if constant >= 1:
            raise NoContraction(number, f"has the Lipschitz bound {constant:.6g} on the box, not below 1")
        worst = max(worst, constant)
    return worst


def projective_points(maps: Sequence[Map], lo: Corner, hi: Corner, depth: int) -> Points:
    """A point of the attractor in each of its pieces after `depth` generations, `(maps^depth, dim)`.

    Row `sum_k s_k m^(depth-k)` has the address s_1 … s_depth followed by zeros for ever: the fixed point of
    map 0, exact to rounding, moved by the word. Raises what `contraction` raises, and `ValueError` for a
    negative depth and for over 20 million points.

    >>> from ifs.maps.maps import affine
    >>> thirds = [affine([[1 / 3]], [0]), affine([[1 / 3]], [2 / 3])]
    >>> projective_points(thirds, [0], [1], 2)[:, 0].round(6).tolist()
    [0.0, 0.222222, 0.666667, 0.888889]
    """
    rate = contraction(maps, lo, hi)
    if depth < 0 or len(maps) ** depth > MOST_POINTS:
        raise ValueError(
            f"the depth is 0 or more, for at most {MOST_POINTS} points; found {depth} for {len(maps)} maps"
        )
    point = (np.array(lo, dtype=float) + np.array(hi, dtype=float))[None] / 2
    for _ in range(int(np.ceil(40 / max(-np.log(max(rate, 1e-6)), 1e-3)))):
        moved = maps[0].apply(point)
        if np.array_equal(moved, point):
            break
        point = moved
    for _ in range(depth):
        point = np.concatenate([each.apply(point) for each in maps])
    return point
