"""What users give: numbers of NumPy, lists in place of arrays, and wrong input, named by a TreeError."""

import jaxtyping
import numpy as np
import pytest

from trees import (
    Cube,
    TreeError,
    cells_of_hilbert,
    distance,
    empty,
    from_array,
    from_depth_first_code,
    from_leaf_codes,
    from_morton,
    from_points,
    from_predicate,
    from_reals,
    from_states,
    from_substitution,
    full,
    hilbert_indices,
    map_tree,
    read_tree,
    to_array,
    unit_cube,
    write_tree,
)
from trees.geometry import (
    branch,
    from_half_spaces,
    from_hull,
    homography,
    insert,
    permute,
    reflect,
    scale,
    scaling,
    section,
    translate,
    visible,
    window,
)
from trees.measures import (
    cell_distance,
    hausdorff_distance,
    jaccard_distance,
    moments,
    node_distance,
    normalised,
)
from trees.morphology import Ball, Box, dilation, distances, rank
from trees.recognition import CorrelatingClassifier, SpectralClassifier
from trees.recognition.labelled import labelled_tree
from trees.topology import adjacent_cells, adjacent_nodes, components

# pyright: reportArgumentType=false, reportOperatorIssue=false
TREE = from_array(np.arange(64).reshape(8, 8) % 3 == 0)
SOLID = from_array(np.indices((4, 4, 4)).sum(0) < 4)
SIERPINSKI = {"t": ["t", "t", "t", False]}


@pytest.fixture(autouse=True)
def as_users_call_it():
    """The checks of types, which only tests have, would answer first."""
    jaxtyping.config.update("jaxtyping_disable", True)
    yield
    jaxtyping.config.update("jaxtyping_disable", False)


@pytest.mark.parametrize("kind", [np.int64, np.uint8, np.int16, np.uint64])
def test_integers_of_numpy_are_integers(kind):
    assert from_substitution(SIERPINSKI, "t", kind(40)).count == 3**40
    assert from_array(np.ones((8, 8), dtype=bool)).at(kind(8)).count == 2**16
    assert TREE.at(kind(2)) == TREE.at(2)
    assert full(unit_cube(kind(2)), kind(40)).count == 2**80
    assert type(empty(unit_cube(2), kind(3)).bits) is int
    assert from_points([[5, 2]], kind(3)) == from_points([[5, 2]], 3)
    assert from_points([[5, 2]], kind(50)).count == 1
    assert from_morton([3], unit_cube(2), kind(3)) == from_morton([3], unit_cube(2), 3)
    assert from_reals([[0.3, 0.1]], kind(9), unit_cube(2)) == from_reals([[0.3, 0.1]], 9, unit_cube(2))
    assert from_leaf_codes(["03"], kind(2), kind(2)) == from_leaf_codes(["03"], 2, 2)
    assert from_depth_first_code("2 0 0 1 0", kind(2), kind(1)).count == 1
    assert from_predicate(lambda a, b: np.full(len(a), 2), unit_cube(2), kind(3)).count == 64
    assert section(TREE, kind(1), kind(5)) == section(TREE, 1, 5)
    assert permute(SOLID, [kind(2), kind(0), kind(1)]) == permute(SOLID, [2, 0, 1])
    assert reflect(TREE, [kind(1)]) == reflect(TREE, [1])
    assert branch(TREE, kind(1), [kind(1), kind(0)]) == branch(TREE, 1, [1, 0])
    assert window(TREE, [kind(3), kind(2)], kind(2)) == window(TREE, [3, 2], 2)
    assert scale(TREE, kind(1)) == scale(TREE, 1)
    assert moments(TREE, kind(2)).table == moments(TREE, 2).table
    assert rank(TREE, Box(kind(1)), kind(3)) == rank(TREE, Box(1), 3)
    assert hilbert_indices([[3, 1]], kind(2)).tolist() == hilbert_indices([[3, 1]], 2).tolist()
    assert cells_of_hilbert([3], kind(2), kind(2)).tolist() == cells_of_hilbert([3], 2, 2).tolist()
    assert (
        cell_distance([[1, 2]], [[3, 3]], kind(2)).tolist() == cell_distance([[1, 2]], [[3, 3]], 2).tolist()
    )
    low, high = (kind(1), kind(1)), (kind(4), kind(3))
    assert (distances(TREE, low, high) == distances(TREE, (1, 1), (4, 3))).all()
    assert (kind(0), kind(3)) in TREE


def test_lists_do_in_place_of_arrays():
    cells, points = [[0, 0], [0, 1], [7, 7], [9, 0]], [[0.01, 0.01], [0.01, 0.2], [3.0, 0.0]]
    assert TREE.holds_cells(cells).tolist() == [True, False, True, False]
    assert TREE.holds(points).tolist() == [True, False, False]
    assert TREE.holds_cells([]).tolist() == TREE.holds([]).tolist() == []
    found = components(TREE)
    assert found.labels_of(cells).tolist() == found.labels_of(np.array(cells)).tolist()
    assert found.labels_of_points(points).tolist() == found.labels_of_points(np.array(points)).tolist()
    assert len(found.kept([True] + [False] * (len(found) - 1))) == 1
    assert adjacent_cells(TREE, [0, 3]).tolist() == [[0, 2], [0, 4], [1, 3]]
    assert adjacent_nodes(TREE, [0, 3]).keys.tolist() == adjacent_nodes(TREE, np.array([0, 3])).keys.tolist()
    assert from_morton([9, 3, 3], unit_cube(2), 2) == from_morton(np.array([3, 9]), unit_cube(2), 2)
    assert homography(TREE, [[1, 0, 0], [0, 1, 0], [0, 0, 1]], closed=False) == TREE
    assert dilation(TREE, Box([1, 0])) == dilation(TREE, Box((1, 0)))
    votes = labelled_tree([[0.1, 0.1], [0.9, 0.8]], ["low", "high"], unit_cube(2), 3)
    assert votes.votes([0.3, 0.2]) == {"low": 1, "high": 0}
    assert from_hull([[0.1, 0.1]], unit_cube(2), 1).count == 1


def test_numbers_that_equal_colours_are_states():
    assert list(from_substitution({0: [0, False]}, 0, 2)) == [(0,)]
    assert list(from_substitution({1: [1, False]}, 1, 2)) == [(0,)]
    assert list(from_substitution({1: [0, 1], 0: [True, False]}, 1, 3)) == [(0,), (1,), (4,), (6,), (7,)]
    halves = {0: (1, False), 1: (True, 0)}
    named = {"a": ("b", False), "b": (True, "a")}
    for bits in range(7):
        numbered = from_states(lambda state, axis: halves[state], 0, unit_cube(1), bits)
        assert numbered == from_states(lambda state, axis: named[state], "a", unit_cube(1), bits)
    mixed = {"s": [1, 0, True, False], 0: [False, 0, False, False], 1: [True, 1, True, True]}
    names = {"s": ["y", "x", True, False], "x": [False, "x", False, False], "y": [True, "y", True, True]}
    assert from_substitution(mixed, "s", 4) == from_substitution(names, "s", 4)


WRONG = {
    "at": lambda: from_points([[5, 2]], 3).at(1.5),
    "index": lambda: section(TREE, 0, 1.9),
    "axis": lambda: section(TREE, 0.5, 1),
    "axis seen": lambda: visible(TREE, 0.5),
    "bits": lambda: from_points([[5, 2]], 3.0),
    "bits of a word": lambda: full(unit_cube(2), "3"),
    "below 0": lambda: full(unit_cube(2), -1),
    "level": lambda: branch(TREE, 0.5, [0, 0]),
    "corner": lambda: window(TREE, [1.9, 0], 1),
    "corner of one": lambda: window(TREE, [1], 1),
    "vector": lambda: translate(TREE, [0.5, 1]),
    "axes": lambda: reflect(TREE, 0),
    "power": lambda: scale(TREE, 0.5),
    "box": lambda: distances(TREE, (0, 0.5), (3, 3)),
    "unhashable": lambda: from_states(lambda s, axis: ([1], [2]), "s", unit_cube(1), 3),
    "unhashable child": lambda: from_substitution({"a": ["a", ["b"]]}, "a", 2),
    "no rule": lambda: from_substitution({"a": 5}, "a", 2),
    "cell distance": lambda: cell_distance([[1, 2]], [[1, 2, 3]], 2),
    "cell distance of rows": lambda: cell_distance([[1, 2]], [[1, 2], [0, 0]], 2),
    "huge order": lambda: moments(TREE, 10**9),
    "broken order": lambda: moments(TREE, 1.5),
    "normal bits": lambda: normalised(TREE, -1),
    "keys": lambda: from_morton(np.zeros((2, 2), dtype=np.int64), unit_cube(2), 2),
    "rank": lambda: rank(TREE, Box(1), 1.5),
    "nan": lambda: (float("nan"), 0) in TREE,
    "infinity": lambda: (float("inf"), 0) in TREE,
    "half a cell": lambda: (0.5, 0) in TREE,
    "a number": lambda: 3 in TREE,
    "words": lambda: "ab" in TREE,
    "three axes": lambda: (1, 2, 3) in TREE,
    "ragged cells": lambda: from_points([[1, 2], [3]], 2),
    "ragged points": lambda: from_reals([[1, 2], [3]], 2),
    "ragged hull": lambda: from_hull([[1, 2], [3]], unit_cube(2), 2),
    "ragged faces": lambda: from_half_spaces([[1, 2, 3], [3]], unit_cube(2), 2),
    "ragged held": lambda: TREE.holds_cells([[1, 2], [3]]),
    "ragged matrix": lambda: homography(TREE, [[1, 0], [0]]),
    "words held": lambda: TREE.holds([["a", "b"]]),
    "flat cells": lambda: TREE.holds_cells([1, 2]),
    "hilbert": lambda: hilbert_indices([1, 2], 2),
    "places": lambda: cells_of_hilbert([[1, 2]], 2, 2),
    "cube": lambda: Cube(("a",), 1.0),
    "cube of a number": lambda: Cube(1.0, 1.0),
    "large cube": lambda: Cube((10**400,), 1.0),
    "size": lambda: Cube((0.0,), None),
    "dimension": lambda: unit_cube(1.5),
    "leaf codes": lambda: from_leaf_codes([3], 2, 1),
    "code": lambda: from_depth_first_code(3, 2, 1),
    "distance": lambda: distance(TREE, 3),
    "other distances": lambda: jaccard_distance(TREE, None),
    "node distance": lambda: node_distance(3, TREE),
    "hausdorff": lambda: hausdorff_distance(TREE, "a"),
    "radius": lambda: Ball("a"),
    "scaling": lambda: scaling([1.0], about=[0.0, 0.0]),
    "mask": lambda: components(TREE).kept([True]),
    "cell": lambda: adjacent_nodes(TREE, [0.5, 1]),
    "point": lambda: labelled_tree([[0.1, 0.1]], ["a"], unit_cube(2), 3).votes([0.1]),
    "nan point": lambda: labelled_tree([[0.1, float("nan")]], ["a"], unit_cube(2), 3),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_input_is_a_tree_error(name):
    with pytest.raises(TreeError):
        WRONG[name]()


@pytest.mark.parametrize("make", [CorrelatingClassifier, SpectralClassifier])
def test_classifiers_refuse_trees_of_another_dimension(make):
    learned = make().fit([TREE, from_array(np.indices((8, 8))[0] < 2)], ["a", "b"])
    with pytest.raises(TreeError, match="dimension 3, where those of `fit` have 2"):
        learned.predict([SOLID])
    with pytest.raises(TreeError, match="1 trees and 2 labels"):
        learned.score([TREE], ["a", "b"])
    with pytest.raises(TreeError, match="a list of trees"):
        learned.predict(TREE)
    assert learned.score([TREE], ["a"]) == 1.0


def test_a_file_of_a_shared_tree_is_read_whole(tmp_path):
    tree = from_substitution(SIERPINSKI, "t", 20)
    write_tree(tree, tmp_path / "a.tree")
    with pytest.raises(TreeError, match="`read_tree` reads it whole"):
        map_tree(tmp_path / "a.tree")
    assert read_tree(tmp_path / "a.tree") == tree
    write_tree(TREE, tmp_path / "b.tree")
    with map_tree(tmp_path / "b.tree") as mapped:
        assert mapped.holds_cells([[0, 0], [0, 1]]).tolist() == [True, False]
        assert mapped.holds([[0.01, 0.01]]).tolist() == [True]
        assert mapped.branch(np.int64(1), (np.int64(1), 0)) == branch(TREE, 1, [1, 0])
        for cell in ((float("nan"), 0), 3, (0.5, 0)):
            with pytest.raises(TreeError):
                _ = cell in mapped


def test_windows_reach_beyond_the_cube():
    array = np.pad(to_array(TREE), 8)
    for corner in ((-3, 2), (6, 6), (-8, 0), (0, 9), (3, 1)):
        found = window(TREE, corner, 2)
        x, y = corner[0] + 8, corner[1] + 8
        part = array[x : x + 4, y : y + 4]
        assert (to_array(found) == np.pad(part, [(0, 4 - n) for n in part.shape])).all()
        assert found.origin == (corner[0] / 8, corner[1] / 8)
    assert insert(TREE, branch(TREE, 1, [1, 1]), 1, [1, 1]) == TREE
