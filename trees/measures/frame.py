"""The principal frame of a set: centroid, axes of inertia, and their signs."""

from dataclasses import dataclass
from itertools import product

import numpy as np
from jaxtyping import Bool, Float, Int

from trees.doors import real
from trees.errors import TreeError
from trees.measures.directions import extreme_directions, value
from trees.measures.moments import Moments, moments
from trees.tree import Tree


@dataclass(frozen=True)
class Frame:
    """The axes of inertia of a set, the unit vectors `axes[i]`: coordinates are `axes @ (x - centroid)`.

    `variances`, in mm^2, fall; `skewness` is the mean of `u_i^3` along each axis, in mm^3. What the set
    leaves open is said: `signed[i]` is false where the skewness is 0 within the tolerance, so that
    `-axes[i]` is as good, and axes with the same number in `groups` have equal variances within the
    tolerance, so that they are chosen by other means (see `principal_frame`) or, on a ball, by none.
    """

    centroid: Float[np.ndarray, " dim"]
    axes: Float[np.ndarray, "dim dim"]
    variances: Float[np.ndarray, " dim"]
    skewness: Float[np.ndarray, " dim"]
    signed: Bool[np.ndarray, " dim"]
    groups: Int[np.ndarray, " dim"]

    @property
    def unique(self) -> bool:
        """Whether variances and skewness alone determine the frame."""
        return bool(self.signed.all()) and len(set(self.groups.tolist())) == len(self.groups)

    @property
    def mirrored(self) -> bool:
        """Whether the axes form a left-handed frame (their determinant is -1)."""
        return bool(np.linalg.det(self.axes) < 0)

    def alternatives(self) -> "list[Frame]":
        """The frames with all signs of the axes that have no sign of their own; this one comes first."""
        choices = [(1.0,) if fixed else (1.0, -1.0) for fixed in self.signed]
        return [_turned(self, np.array(signs)) for signs in product(*choices)]


def principal_frame(tree: Tree | Moments, tolerance: float = 0.02, proper: bool = False) -> Frame:
    """The frame of a set in which its covariance is diagonal, variances falling (Guye 1988, VI.1).

    Axis i is turned so that the mean of `u_i^3` is not negative. Where this is below `tolerance` times
    `variance_i^(3/2)`, the sign stays open. Variances that differ by less than `tolerance` times the largest
    form a group (the source does not speak of these): its axes are turned to the direction of
    the greatest third moment, then to the greatest orthogonal to it, and so on; where third moments
    vanish, fourth moments decide (`trees.measures.directions`). That fixes cubes and regular tetrahedra up
    to their own symmetries, and leaves balls open.

    With all signs fixed the frame may be left-handed: a set and its mirror image then have the same
    coordinates, which is what the source wants. With `proper` the axis of least skewness, relative to its
    variance, is turned about where needed, and mirror images differ.

    Moments of order 4 do in place of the tree.

    Raises `TreeError` for the empty set, a tolerance outside 0 to 1, or moments of too low an order.

    >>> from trees import from_points
    >>> frame = principal_frame(from_points([[0, 0], [1, 0], [2, 0], [0, 1]], bits=2))
    >>> frame.centroid.tolist(), bool((frame.skewness >= 0).all())
    ([0.3125, 0.1875], True)
    """
    tolerance = real(tolerance, "tolerance")
    if not 0 <= tolerance < 1:
        raise TreeError(f"a tolerance of {tolerance}: a share from 0 to below 1 is needed")
    if isinstance(tree, Moments) and tree.order < 4:
        raise TreeError(f"a frame from moments of order {tree.order}: order 4 is needed")
    found = tree if isinstance(tree, Moments) else moments(tree, 3)
    central = found.central()
    covariance, third = central.means(2), central.means(3)
    variances, columns = np.linalg.eigh(covariance)
    variances, axes = variances[::-1].copy(), np.ascontiguousarray(columns[:, ::-1].T)
    groups = np.cumsum(np.append(False, variances[:-1] - variances[1:] > tolerance * variances[0]))
    if groups[-1] + 1 < len(groups):
        fourth = (central if isinstance(tree, Moments) else moments(tree, 4)).means(4)
        for group in range(groups[-1] + 1):
            rows = np.flatnonzero(groups == group)
            axes[rows] = extreme_directions(axes[rows], third, fourth, tolerance)
        variances = np.einsum("ia,ab,ib->i", axes, covariance, axes)
    skewness = np.array([value(third, axis) for axis in axes])
    signed = np.abs(skewness) > tolerance * variances**1.5
    frame = Frame(found.centroid, axes, variances, skewness, signed, groups)
    frame = _turned(frame, np.where(skewness < 0, -1.0, 1.0))
    if proper and frame.mirrored:
        signs = np.ones(len(axes))
        signs[np.argmin(frame.skewness / variances**1.5)] = -1.0
        frame = _turned(frame, signs)
    return frame


def _turned(frame: Frame, signs: Float[np.ndarray, " dim"]) -> Frame:
    axes = frame.axes * signs[:, None]
    return Frame(frame.centroid, axes, frame.variances, frame.skewness * signs, frame.signed, frame.groups)
