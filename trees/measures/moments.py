"""Moments of a set of cells, exactly: volume, centroid, covariance, inertia."""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from math import comb

import numpy as np
from jaxtyping import Float

from trees.doors import whole
from trees.errors import TreeError
from trees.measures.sums import Exponent, cell_integrals
from trees.tree import Tree


@dataclass(frozen=True)
class Moments:
    """`table[a]` is the integral of `x_1^a_1 ... x_k^a_k` over the cells, |a| up to `order`, in mm^(k + |a|).

    The numbers are exact: origin and size of a cube are floats, so fractions with a power of two below.
    The other fields are these numbers, or quotients of them, rounded once.
    """

    dimension: int
    order: int
    table: Mapping[Exponent, Fraction]

    @property
    def volume(self) -> float:
        """The measure of the set, in mm^k."""
        return float(self.table[(0,) * self.dimension])

    @property
    def centroid(self) -> Float[np.ndarray, " dim"]:
        """The centre of gravity, in mm. Raises `TreeError` for the empty set."""
        return np.array([float(x) for x in _centroid(self)])

    @property
    def covariance(self) -> Float[np.ndarray, "dim dim"]:
        """The mean of `(x_i - c_i)(x_j - c_j)`, c the centroid, in mm^2; for orders from 2.

        Raises `TreeError` for the empty set.
        """
        return self.means(2)

    @property
    def inertia(self) -> Float[np.ndarray, "3 3"]:
        """The inertia tensor of the solid about its centroid at density 1, in mm^5; k = 3, orders from 2.

        `J = V (tr(C) 1 - C)`, C the covariance and V the volume. (Guye 1988, VI.1, calls V C the matrix of
        inertia: both have the same axes.)

        Raises `TreeError` where k is not 3, or for the empty set.
        """
        if self.dimension != 3:
            raise TreeError(
                f"the inertia tensor is for dimension 3, not {self.dimension}: take the covariance"
            )
        covariance = self.covariance
        return self.volume * (np.trace(covariance) * np.eye(3) - covariance)

    def central(self) -> "Moments":
        """The moments of the set moved to have its centroid at 0, exactly.

        Raises `TreeError` for the empty set.

        >>> from trees import from_points
        >>> central = moments(from_points([[0], [1], [3]], bits=2), order=3).central()
        >>> [str(central.table[(n,)]) for n in range(4)]
        ['3/4', '0', '59/768', '5/576']
        """
        return _moved(self, [-x for x in _centroid(self)])

    def means(self, degree: int) -> Float[np.ndarray, "..."]:
        """The tensor of the mean of `y_i y_j ...`, y = x - centroid, `degree` factors, in mm^degree.

        Raises `TreeError` for the empty set, or a degree above the order.
        """
        if not 0 <= whole(degree, "degree") <= self.order:
            raise TreeError(f"means of degree {degree} from moments of order {self.order}")
        central = self.central().table
        volume = central[(0,) * self.dimension]
        rounded = {a: float(value / volume) for a, value in central.items() if sum(a) == degree}
        tensor = np.empty((self.dimension,) * degree)
        for place in np.ndindex(tensor.shape):
            tensor[place] = rounded[tuple(place.count(axis) for axis in range(self.dimension))]
        return tensor


def moments(tree: Tree, order: int = 3) -> Moments:
    """The moments of a set of cells as a solid, to any total order, exactly (Guye 1988, VI.1).

    `M(x^a) = integral over the cells of x_1^a_1 ... x_k^a_k`, in mm, computed over words and over
    blocks of equal words (see `trees.measures.sums`).

    Raises `TreeError` for an order below 0, or above 4096 moments.

    >>> from trees import from_points
    >>> found = moments(from_points([[0, 0], [1, 0]], bits=1), order=2)
    >>> found.volume, found.centroid.tolist(), str(found.table[(1, 1)])
    (0.5, [0.5, 0.25], '1/16')
    """
    order = whole(order, "order")
    if order < 0:
        raise TreeError(f"moments of order {order}: at least 0 is needed")
    k, cell = tree.dimension, Fraction(tree.size) / 2**tree.bits
    scaled = {a: value * cell ** (k + sum(a)) for a, value in cell_integrals(tree, order).items()}
    return _moved(Moments(k, order, scaled), [Fraction(x) for x in tree.origin])


def _centroid(found: Moments) -> list[Fraction]:
    k = found.dimension
    volume = found.table[(0,) * k]
    if volume == 0:
        raise TreeError("the empty set has no centroid: give a tree with black cells")
    if found.order < 1:
        raise TreeError("a centroid needs moments of order 1 at least")
    return [found.table[tuple(int(i == axis) for i in range(k))] / volume for axis in range(k)]


def _moved(found: Moments, by: list[Fraction]) -> Moments:
    """The moments of the set moved by a vector."""
    if not any(by):
        return found
    table = dict(found.table)
    for axis, step in enumerate(by):
        powers = [step**e for e in range(found.order + 1)]
        table = {
            a: sum(
                (
                    comb(a[axis], d) * powers[a[axis] - d] * table[(*a[:axis], d, *a[axis + 1 :])]
                    for d in range(a[axis] + 1)
                ),
                Fraction(0),
            )
            for a in table
        }
    return Moments(found.dimension, found.order, table)
