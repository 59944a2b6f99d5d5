"""Both classifiers on shapes made by formulas, under random similarities, with held-out examples."""

import numpy as np
import pytest

from trees import Cube, TreeError, empty, from_array, from_points, unit_cube
from trees.recognition import (
    CorrelatingClassifier,
    SpectralClassifier,
    attribute_names,
    attributes,
    labelled_tree,
)

CORNERS = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], dtype=float)


def ball(x):
    return (x**2).sum(1) < 1


def cube(x):
    return abs(x).max(1) < 0.8


def tetrahedron(x):
    return (x @ CORNERS.T < 1).all(1)


def torus(x):
    return (np.hypot(x[:, 0], x[:, 1]) - 0.85) ** 2 + x[:, 2] ** 2 < 0.3**2


def ell(x):
    foot = (abs(x[:, 0]) < 1) & (abs(x[:, 1] + 0.5) < 0.3)
    leg = (abs(x[:, 0] + 0.7) < 0.3) & (abs(x[:, 1]) < 0.8)
    return (foot | leg) & (abs(x[:, 2]) < 0.3)


def bar(x):
    return (abs(x) < [1.2, 0.4, 0.4]).all(1)


def menger(x):
    inside = cube(x)
    place = (x + 0.8) / 1.6
    for _ in range(2):
        middle = np.floor(place * 3) % 3 == 1
        inside &= middle.sum(1) < 2
        place = place * 3 % 1
    return inside


def sierpinski(x):
    """Two steps of half-size copies at the corners of the tetrahedron."""
    inside = tetrahedron(x)
    for size in (0.5, 0.25):
        x = x + size * CORNERS[(x @ CORNERS.T).argmin(1)]
        inside &= (x @ CORNERS.T < size).all(1)
    return inside


SHAPES = {f.__name__: f for f in (ball, cube, tetrahedron, torus, ell, bar, menger, sierpinski)}


def example(name: str, seed: int):
    """The shape at a random place, turned and scaled at random."""
    rng = np.random.default_rng([seed, list(SHAPES).index(name)])
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    scale = rng.uniform(0.75, 1.0)
    points = (np.indices((64,) * 3).reshape(3, -1).T + 0.5) / 16 - 2 + rng.uniform(-0.1, 0.1, 3)
    near = np.flatnonzero((points**2).sum(1) < 4)
    array = np.zeros((64,) * 3, dtype=bool)
    array.reshape(-1)[near] = SHAPES[name](points[near] @ turn / scale)
    return from_array(array, Cube((5.0,) * 3, 64.0))


@pytest.fixture(scope="module")
def learned():
    return [(example(name, seed), name) for name in SHAPES for seed in range(3)]


@pytest.fixture(scope="module")
def held_out():
    return [(example(name, seed), name) for name in SHAPES for seed in range(100, 102)]


@pytest.mark.parametrize(
    ("classifier", "least"),
    [
        (SpectralClassifier(), 0.95),
        (SpectralClassifier(rule="tree"), 0.85),
        (CorrelatingClassifier(), 0.9),
        (CorrelatingClassifier(base="union"), 0.7),
    ],
)
def test_held_out_shapes_are_recognised(classifier, least, learned, held_out):
    trees, labels = zip(*learned, strict=True)
    assert classifier.fit(list(trees), list(labels)) is classifier
    trees, labels = zip(*held_out, strict=True)
    found = classifier.predict(list(trees))
    assert np.mean(found == np.array(labels)) >= least
    assert classifier.score([trees[0]], [found[0]]) == 1
    assert classifier.score([trees[0]], ["none"]) == 0


def test_attributes_do_not_change_under_similarities(held_out):
    found = {name: [] for name in SHAPES}
    for tree, name in held_out:
        found[name].append(attributes(tree, ("inertia", "kurtosis", "fill")))
    for one, other in found.values():
        assert one == pytest.approx(other, abs=0.1)
    # A solid torus of radii R, r: variances R^2 / 2 + 5 r^2 / 8 across, r^2 / 4 along its axis.
    across, along = 0.85**2 / 2 + 5 * 0.3**2 / 8, 0.3**2 / 4
    assert found["torus"][0][:2] == pytest.approx([1, (along / across) ** 0.5], abs=0.03)


def test_attributes_of_a_cuboid():
    array = np.zeros((16, 16, 16), dtype=bool)
    array[:16, :8, :4] = True
    found = attributes(from_array(array), ("inertia", "skewness", "kurtosis", "fill", "dimension"))
    assert len(found) == len(attribute_names(3, ("inertia", "skewness", "kurtosis", "fill", "dimension")))
    # Along an edge the mean fourth power is 9/5 of the variance squared.
    quarter = 1.8**0.25
    expected = [0.5, 0.25, 0, 0, 0, quarter, quarter / 2, quarter / 4, 12**-0.5]
    assert found[:-1] == pytest.approx(expected)
    # Boxes of edge 8, 4, 2, 1 cells.
    assert found[-1] == pytest.approx(np.polyfit(range(4), np.log2([2, 8, 64, 512]), 1)[0])
    assert attribute_names(3)[:5] == ["inertia 2", "inertia 3", "skewness 1", "skewness 2", "skewness 3"]


def test_votes_are_those_of_the_smallest_node_around_the_point():
    points = np.array([[0.1, 0.1], [0.15, 0.1], [0.4, 0.4], [0.9, 0.9]])
    tree = labelled_tree(points, ["a", "a", "b", "b"], unit_cube(2), bits=6)
    assert tree.votes(np.array([0.1, 0.1])) == {"a": 1, "b": 0}
    # Cells 12, 12 and 9, 6 of 64 are in the same half, from 8 to 16, of a square of 16; 6, 6 is in the other.
    assert tree.votes(np.array([0.2, 0.2])) == {"a": 1, "b": 0}
    assert tree.votes(np.array([0.2, 0.45])) == {"a": 2, "b": 0}
    assert tree.votes(np.array([0.1, 0.9])) == {"a": 2, "b": 1}
    assert tree.votes(np.array([0.6, 0.1])) == {"a": 0, "b": 1}
    assert tree.votes(np.array([5.0, 5.0])) == {"a": 0, "b": 1}
    with pytest.raises(TreeError, match="4 points and 1 labels"):
        labelled_tree(points, ["a"], unit_cube(2), bits=6)


@pytest.mark.parametrize("kind", [SpectralClassifier, CorrelatingClassifier])
def test_wrong_examples_and_parameters_are_named(kind):
    one, two = from_points([[0, 0], [1, 0], [2, 0]], 2), from_points([[0, 0, 1]], 2)
    for trees, labels, words in (
        ([], [], "no trees"),
        ([one, two], ["a", "b"], "example 1 has dimension 3"),
        ([one, empty(unit_cube(2), 2)], ["a", "b"], "example 1 is the empty set"),
        ([one, "two"], ["a", "b"], "example 1 is a str"),
        ([one], ["a", "b"], "1 trees and 2 labels"),
    ):
        with pytest.raises(TreeError, match=words):
            kind().fit(trees, labels)
    with pytest.raises(TreeError, match="not fitted"):
        kind().predict([one])
    with pytest.raises(TreeError, match="parameter 'depth'"):
        kind().set_params(depth=3)
    with pytest.raises(TreeError, match="one of"):
        kind(**({"rule": "best"} if kind is SpectralClassifier else {"base": "best"})).fit([one], ["a"])
    with pytest.raises(TreeError, match="kinds"):
        attributes(one, ("colour",))


@pytest.mark.parametrize("kind", [SpectralClassifier, CorrelatingClassifier])
def test_the_tools_of_scikit_learn_accept_the_classifiers(kind):
    model_selection = pytest.importorskip("sklearn.model_selection")
    base = pytest.importorskip("sklearn.base")
    side = np.indices((16, 16))
    bars = [from_array((side[0] < n) & (side[1] < 14)) for n in (2, 3, 4, 5)]
    discs = [from_array(((side - 7.5) ** 2).sum(0) < n) for n in (20, 30, 40, 50)]
    trees, labels = bars + discs, np.repeat(["bar", "disc"], 4)
    copied = base.clone(kind(bits=4))
    assert copied.get_params() == kind(bits=4).get_params()
    assert base.is_classifier(copied)
    scores = model_selection.cross_val_score(copied, trees, labels, cv=2)
    assert scores.tolist() == [1.0, 1.0]
