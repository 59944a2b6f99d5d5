"""The correlating way: the exclusive or with labelled normalised trees."""

from collections.abc import Hashable, Sequence
from typing import Any

import numpy as np
from jaxtyping import UInt64

from trees.cells import from_array, to_array
from trees.errors import TreeError
from trees.measures.distances import jaccard_distance
from trees.measures.frame import principal_frame
from trees.measures.normal import normalised
from trees.recognition.parameters import checked, fitted, parameters_of, set_parameters, share_right, tags
from trees.tree import Tree

BASES = ("each", "union")


class CorrelatingClassifier:
    """Labels sets by the overlap of normalised trees (Guye 1988, VI.2), as scikit-learn's classifiers do.

    `fit(X, y)` keeps the `normalised` trees of the examples, `2^bits` cells an axis; `base_` maps each label
    to its trees: all of them with `base="each"`, their union alone with "union" (the source's base, small,
    but right only where the examples of a label hardly differ). `predict` takes the label of the tree
    that differs least: the measure of the exclusive or, divided by that of the union (the source does not
    divide; small sets would then be near to all). Where axes have no sign of their own, all signs are tried.

    Errors of `fit` and `predict` are `TreeError`; they name the example.

    >>> from trees import from_array
    >>> side = np.indices((16, 16))
    >>> square = from_array((side[0] < 9) & (side[1] < 9))
    >>> wedge = from_array(side[0] + side[1] < 12)
    >>> learned = CorrelatingClassifier(bits=5).fit([square, wedge], ["square", "wedge"])
    >>> learned.predict([from_array(side[0] + 15 - side[1] < 9), from_array(side.max(0) < 13)]).tolist()
    ['wedge', 'square']
    """

    def __init__(
        self,
        bits: int = 5,
        base: str = "each",
        unit: str = "inertia",
        reach: float = 4.0,
        tolerance: float = 0.02,
    ):
        self.bits, self.base, self.unit, self.reach, self.tolerance = bits, base, unit, reach, tolerance

    def fit(self, X: Sequence, y: Sequence[Hashable] | np.ndarray) -> "CorrelatingClassifier":
        """Learn the normalised trees and labels of trees."""
        trees = checked(X, y)
        if self.base not in BASES:
            raise TreeError(f"base {self.base!r}: one of {', '.join(BASES)} is needed")
        labels = np.asarray(y)
        self.classes_, self.dimension_ = np.unique(labels), trees[0].dimension
        self.base_: dict[Hashable, list[Tree]] = {label: [] for label in self.classes_.tolist()}
        for tree, label in zip(trees, labels.tolist(), strict=True):
            known = self.base_[label]
            if self.base == "union" and known:
                positions = self._positions(tree)
                known[0] = known[0] | min(positions, key=lambda other: jaccard_distance(known[0], other))
            else:
                known.append(self._positions(tree)[0])
        return self

    def predict(self, X: Sequence) -> np.ndarray:
        """The labels of trees."""
        trees = fitted(self, X)
        return self.classes_[[int(np.argmin(row)) for row in self._distances(trees)]]

    def score(self, X: Sequence, y: Sequence[Hashable] | np.ndarray) -> float:
        """The share of trees whose label is found."""
        return share_right(self.predict(X).tolist(), list(y))

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """The parameters by name."""
        return parameters_of(self)

    def set_params(self, **values: Any) -> "CorrelatingClassifier":
        """Set parameters by name."""
        set_parameters(self, values)
        return self

    def __sklearn_tags__(self) -> Any:
        return tags()

    def _distances(self, trees: list[Tree]) -> list[list[float]]:
        """The least distance of each tree from each class."""
        base = {
            label: np.array([_bits(one) for one in self.base_[label]]) for label in self.classes_.tolist()
        }
        rows = []
        for tree in trees:
            positions = [_bits(one) for one in self._positions(tree)]
            rows.append([min(_least(known, one) for one in positions) for known in base.values()])
        return rows

    def _positions(self, tree: Tree) -> list[Tree]:
        """The normalised tree, and its mirror images in the axes without a sign."""
        frame = principal_frame(tree, self.tolerance)
        normal = normalised(tree, self.bits, self.unit, self.reach, frame, clip=True)
        arrays = [to_array(normal)]
        for axis in np.flatnonzero(~frame.signed).tolist():
            arrays += [np.flip(array, axis) for array in arrays]
        return [from_array(array, normal.cube) for array in arrays]


def _bits(tree: Tree) -> UInt64[np.ndarray, " bricks"]:
    """The words of all bricks, one each."""
    return np.repeat(tree.words, tree.lengths.astype(np.int64))


def _least(known: UInt64[np.ndarray, "trees bricks"], one: UInt64[np.ndarray, " bricks"]) -> float:
    """The least `jaccard_distance` from `one` to a row of `known`."""
    apart = np.bitwise_count(known ^ one).sum(axis=1, dtype=np.int64)
    either = np.bitwise_count(known | one).sum(axis=1, dtype=np.int64)
    return float((apart / np.maximum(either, 1)).min())
