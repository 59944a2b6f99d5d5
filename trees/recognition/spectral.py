"""The spectral way: attribute vectors in a labelled tree of the space of attributes."""

from collections.abc import Hashable, Sequence
from typing import Any

import numpy as np
from jaxtyping import Float

from trees.cube import Cube
from trees.errors import TreeError
from trees.recognition.attributes import DEFAULT, attributes
from trees.recognition.labelled import labelled_tree
from trees.recognition.parameters import checked, fitted, parameters_of, set_parameters, share_right, tags
from trees.tree import Tree

RULES = ("tree", "nearest")
WIDTH = 4.0


class SpectralClassifier:
    """Labels sets by their attributes (Guye 1988, VI.2), with the conventions of scikit-learn.

    `fit(X, y)` takes a list of trees and a label for each. Attributes are moved and scaled to mean 0 and
    deviation 1, so that `[-4, 4)` holds nearly all; the learned base is the `labelled_tree` of the vectors
    there, `2^bits` cells an axis (`tree_`). `predict` asks, with `rule="tree"`, the smallest node of the
    base around the new vector: the nearest for the ultrametric, which does not see across the middle of a
    node; ties go to the first of `classes_`. With "nearest" it is the nearest learned vector for the
    Euclidean distance.

    Errors of `fit` and `predict` are `TreeError`; they name the example.

    >>> from trees import from_array
    >>> side = np.indices((16, 16))
    >>> bars = [from_array((side[0] < n) & (side[1] < 12)) for n in (2, 3, 4)]
    >>> discs = [from_array(((side - 8) ** 2).sum(0) < n) for n in (20, 25, 40)]
    >>> learned = SpectralClassifier().fit(bars + discs, ["bar"] * 3 + ["disc"] * 3)
    >>> new = [from_array((side[1] < 3) & (side[0] > 3)), from_array(((side - 7) ** 2).sum(0) < 30)]
    >>> learned.predict(new).tolist()
    ['bar', 'disc']
    """

    def __init__(
        self,
        kinds: Sequence[str] = DEFAULT,
        rule: str = "nearest",
        bits: int | None = None,
        tolerance: float = 0.02,
    ):
        self.kinds, self.rule, self.bits, self.tolerance = kinds, rule, bits, tolerance

    def fit(self, X: Sequence, y: Sequence[Hashable] | np.ndarray) -> "SpectralClassifier":
        """Learn the attributes and labels of trees."""
        trees = checked(X, y)
        if self.rule not in RULES:
            raise TreeError(f"rule {self.rule!r}: one of {', '.join(RULES)} is needed")
        vectors = self._attributes(trees)
        self.mean_, deviations = vectors.mean(0), vectors.std(0)
        # An attribute that is the same in all examples, up to rounding, says nothing.
        self.scale_ = np.where(deviations > 1e-9, deviations, np.inf)
        self.vectors_ = (vectors - self.mean_) / self.scale_
        self.labels_ = np.asarray(y)
        self.classes_, self.dimension_ = np.unique(self.labels_), trees[0].dimension
        size = self.vectors_.shape[1]
        bits = min(64 // size, 12) if self.bits is None else self.bits
        cube = Cube((-WIDTH,) * size, 2 * WIDTH)
        self.tree_ = labelled_tree(self.vectors_, self.labels_.tolist(), cube, bits)
        return self

    def predict(self, X: Sequence) -> np.ndarray:
        """The labels of trees."""
        vectors = (self._attributes(fitted(self, X)) - self.mean_) / self.scale_
        if self.rule == "nearest":
            apart = ((vectors[:, None, :] - self.vectors_[None, :, :]) ** 2).sum(axis=2)
            return self.labels_[apart.argmin(axis=1)]
        return np.array([self._voted(vector) for vector in vectors])

    def score(self, X: Sequence, y: Sequence[Hashable] | np.ndarray) -> float:
        """The share of trees whose label is found."""
        return share_right(self.predict(X).tolist(), list(y))

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """The parameters by name."""
        return parameters_of(self)

    def set_params(self, **values: Any) -> "SpectralClassifier":
        """Set parameters by name."""
        set_parameters(self, values)
        return self

    def __sklearn_tags__(self) -> Any:
        return tags()

    def _attributes(self, trees: list[Tree]) -> Float[np.ndarray, "trees n"]:
        return np.array([attributes(tree, self.kinds, self.tolerance) for tree in trees])

    def _voted(self, vector: Float[np.ndarray, " n"]) -> Hashable:
        votes = self.tree_.votes(vector)
        return max(self.classes_.tolist(), key=lambda label: votes[label])
