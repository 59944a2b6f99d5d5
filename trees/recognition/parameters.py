"""What both classifiers share with those of scikit-learn: parameters by name, and a score."""

import inspect
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from trees.errors import TreeError
from trees.tree import Tree


def parameters_of(classifier: object) -> dict[str, Any]:
    """The values of the parameters that the constructor takes."""
    return {name: getattr(classifier, name) for name in inspect.signature(type(classifier)).parameters}


def set_parameters(classifier: object, values: dict[str, Any]) -> None:
    """Set parameters by name. Raises `TreeError` where a name is unknown."""
    known = list(inspect.signature(type(classifier)).parameters)
    for name, value in values.items():
        if name not in known:
            raise TreeError(f"parameter {name!r}: one of {', '.join(known)} is needed")
        setattr(classifier, name, value)


def checked(X: Sequence, y: Sequence | np.ndarray | None) -> list[Tree]:
    """The trees as a list, or `TreeError`: no trees, unequal dimensions, an empty set, too few labels."""
    if not isinstance(X, Iterable) or isinstance(X, Tree):
        raise TreeError(f"a {type(X).__name__}: a list of trees is needed")
    trees = list(X)
    if not trees:
        raise TreeError("no trees: give one or more")
    for place, tree in enumerate(trees):
        if not isinstance(tree, Tree):
            raise TreeError(f"example {place} is a {type(tree).__name__}: a Tree is needed")
        if tree.dimension != trees[0].dimension:
            raise TreeError(f"example {place} has dimension {tree.dimension}, the first {trees[0].dimension}")
        if not tree:
            raise TreeError(f"example {place} is the empty set, which has no attributes")
    if y is not None and len(y) != len(trees):
        raise TreeError(f"{len(trees)} trees and {len(y)} labels: one label a tree is needed")
    return trees


def share_right(found: Sequence, y: Sequence) -> float:
    """The share of labels that are right. Raises `TreeError` where there is not one label a tree."""
    if len(found) != len(y):
        raise TreeError(f"{len(found)} trees and {len(y)} labels: one label a tree is needed")
    return float(np.mean([a == b for a, b in zip(found, y, strict=True)]))


def fitted(classifier: object, X: Sequence) -> list[Tree]:
    """The trees to be judged.

    Raises `TreeError` where `fit` was not called, or was with trees of another dimension.
    """
    if not hasattr(classifier, "classes_"):
        raise TreeError(f"this {type(classifier).__name__} is not fitted: call fit(X, y) first")
    trees, dimension = checked(X, None), getattr(classifier, "dimension_", None)
    if trees[0].dimension != dimension:
        raise TreeError(f"trees of dimension {trees[0].dimension}, where those of `fit` have {dimension}")
    return trees


def tags() -> Any:
    """What scikit-learn, from 1.6 on, asks a classifier; only it calls this."""
    from sklearn.utils import ClassifierTags, Tags, TargetTags  # pyright: ignore[reportMissingImports]

    return Tags(
        estimator_type="classifier",
        target_tags=TargetTags(required=True),
        classifier_tags=ClassifierTags(),
    )
