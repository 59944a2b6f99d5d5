"""Sets between two sets of points: the left, the right and the whole median set."""

import numpy as np
from jaxtyping import Float, Real

Points = Float[np.ndarray, "_points _dim"]
Given = Real[np.ndarray, "_given _dim"]


class EmptySet(ValueError):
    """A set without points: distances and medians are for compact sets that are not empty."""


def left_median(a: Given, b: Given, share: float = 0.5) -> Points:
    """`M_l(A, B)`: half-way from each point of A to the nearest point of B, in the order of A.

    Another `share` of the way, from 0 (A) to 1, gives the stages of a morph.

    So it is A, deformed by B. Each point of A has one of M_l within half its distance from B, and each point
    of M_l lies that near to both sets: `d(A, M_l) <= d(A, B) / 2` in the Hausdorff distance. To B it may be
    far: parts of B that are nearest to no point of A have no influence. Where several points of B are equally
    near, one is taken. Raises `EmptySet`, and `ValueError` for arrays that are not rows of finite
    coordinates, or a share out of [0, 1]. Source: Gentil, §5.2.2.

    >>> left_median(np.array([[0.0, 0]]), np.array([[4, 2], [9, 9]]))
    array([[2., 1.]])
    """
    ours, theirs = _checked("A", a), _checked("B", b)
    _same_width(ours, theirs)
    if not 0 <= share <= 1:
        raise ValueError(f"the share of the way lies in [0, 1]; found {share}")
    return (1 - share) * ours + share * theirs[_nearest(ours, theirs)[1]]


def right_median(a: Given, b: Given, share: float = 0.5) -> Points:
    """`M_r(A, B) = M_l(B, A)`: half-way from each point of B to the nearest point of A.

    `share` is counted from A to B, as in `left_median`.

    >>> right_median(np.array([[0.0, 0]]), np.array([[4, 2], [8, 8]]))
    array([[2., 1.],
           [4., 4.]])
    """
    return left_median(b, a, 1 - share)


def median(a: Given, b: Given, share: float = 0.5) -> Points:
    """`M(A, B) = M_l(A, B) + M_r(A, B)` (union), points sorted, each once.

    It lies exactly half-way: `d(A, M) = d(M, B) = d(A, B) / 2` in the Hausdorff distance d, and for a share q
    `d(A, M) = q d(A, B)`, `d(M, B) = (1 - q) d(A, B)`. (Each point of M lies that near to a point of A and to
    one of B, each point of A and B that near to M; the triangle inequality leaves no less.) `M(B, B) = B`, so
    B is a fixed point of `X -> M(X, B)`, and every X halves its distance to it.

    That this map contracts, as the source says, is not so in general: it is not even continuous where a
    point of B is as near to two points of X. (`X = {-1 - e, 1}` and `B = {-1.1, 0, 1.1}` on a line: the
    middle of 0 and its nearest point jumps from 1/2 to -1/2 as e falls below 0.) Raises as `left_median`.

    >>> median(np.array([[0.0, 0]]), np.array([[4, 2], [8, 8]]))
    array([[2., 1.],
           [4., 4.]])
    """
    return np.unique(np.concatenate([left_median(a, b, share), right_median(a, b, share)]), axis=0)


def turned_median(a: Given, b: Given, rate: float) -> Points:
    """The median set turned about the middle of its bounding box by `rate` degrees per mm of `d(A, B)`.

    In space the axis is that of z. `M(B, B) = B` still. With r the largest distance of M from the axis,
    `d(turned M, B) <= (1/2 + rate pi/180 r) d(A, B)`: the turned set is nearer to B than A was where
    `rate pi/180 r < 1/2`. The source superposes the bounding boxes, turns, and then takes the median set (in
    its text), or turns the median set (under its figures 5.23 and 5.24); this is the latter.

    >>> turned_median(np.array([[0, 0], [0, 2]]), np.array([[4, 0], [4, 2]]), 22.5).round(6)
    array([[3., 1.],
           [1., 1.]])
    """
    if not np.isfinite(rate):
        raise ValueError(f"the rate is a finite number of degrees per mm; found {rate}")
    found = median(a, b)
    if found.shape[1] not in (2, 3):
        raise ValueError(f"sets turn in the plane or in space; here are {found.shape[1]} coordinates")
    angle = np.deg2rad(rate * hausdorff_distance(a, b))
    middle = (found.min(axis=0) + found.max(axis=0)) / 2
    return middle + (found - middle) @ turn(angle, found.shape[1]).T


def turn(angle: float, dim: int) -> Float[np.ndarray, "dim dim"]:
    """The rotation by an angle in radians, of the plane or about the z axis."""
    result = np.eye(dim)
    result[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    return result


def hausdorff_distance(a: Given, b: Given) -> float:
    """The largest distance of a point of either set from the other set.

    >>> hausdorff_distance(np.array([[0.0, 0]]), np.array([[3, 4], [0, 1]]))
    5.0
    """
    ours, theirs = _checked("A", a), _checked("B", b)
    _same_width(ours, theirs)
    return float(max(_nearest(ours, theirs)[0].max(), _nearest(theirs, ours)[0].max()))


def _nearest(a: Points, b: Points):
    from scipy.spatial import KDTree

    return KDTree(b).query(a)


def _checked(name: str, points: Given) -> Points:
    rows = np.asarray(points, dtype=np.float64)
    if rows.ndim != 2 or rows.shape[1] == 0 or not np.isfinite(rows).all():
        raise ValueError(f"set {name} needs rows of finite coordinates; got an array of shape {rows.shape}")
    if not len(rows):
        raise EmptySet(f"set {name} has no points; give it one at least")
    return rows


def _same_width(a: Points, b: Points) -> None:
    if a.shape[1] != b.shape[1]:
        raise ValueError(f"set A has {a.shape[1]} coordinates, set B {b.shape[1]}; they must agree")
