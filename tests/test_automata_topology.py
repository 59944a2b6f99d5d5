"""Gluing and symmetry without coordinates."""

from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from automata import AutomatonError, builtin_names, parse_text, read
from automata.symmetry import compose, inverse, symmetry_groups
from automata.topology import Topology, embedding

PATCHES = ("doo-sabin-patch", "catmull-clark-patch", "fractal-patch")


def matrix(element):
    return np.eye(len(element), dtype=int)[:, element]


PERMUTATIONS = st.integers(1, 7).flatmap(
    lambda n: st.lists(st.permutations(range(n)), min_size=2, max_size=2)
)


@given(PERMUTATIONS)
def test_permutations_multiply_as_their_matrices(pair):
    first, second = map(tuple, pair)
    assert (matrix(compose(first, second)) == matrix(first) @ matrix(second)).all()
    assert (matrix(inverse(first)) == matrix(first).T).all()


@pytest.mark.parametrize(
    ("name", "cell", "order"),
    [
        ("doo-sabin-patch", "vertex", 4),
        ("doo-sabin-patch", "edge", 2),
        ("doo-sabin-patch", "face", 1),
        ("catmull-clark-patch", "vertex", 4),
        ("sierpinski-triangle", "triangle", 6),
        ("sierpinski-tetrahedron", "tetrahedron", 24),
        ("koch-curve", "edge", 2),
        ("menger-sponge", "attractor", 1),
    ],
)
def test_orders_of_symmetry_groups(name, cell, order):
    elements = symmetry_groups(read(name)).elements[cell]
    assert len(elements) == order
    assert {compose(a, b) for a in elements for b in elements} == set(elements)


@pytest.mark.parametrize("name", builtin_names())
def test_moving_a_symmetry_past_labels_keeps_the_cell_and_the_product(name):
    automaton = read(name)
    groups = symmetry_groups(automaton)
    for cell in automaton.cells.values():
        for first, moves in groups.elements[cell.name].items():
            for second in groups.elements[cell.name]:
                both = groups.elements[cell.name][compose(first, second)]
                for label in (*cell.subdivision, *cell.boundary):
                    middle, after = groups.elements[cell.name][second][label]
                    image, before = moves[middle]
                    assert both[label] == (image, compose(before, after))
                    assert automaton.target(cell.name, image) == automaton.target(cell.name, label)


@pytest.mark.parametrize("name", builtin_names())
def test_a_symmetry_moves_boundary_embeddings_as_it_says(name):
    """`S B_b = B_c g`: the control points that a boundary selects, seen through a symmetry."""
    automaton = read(name)
    groups = symmetry_groups(automaton)
    for cell in automaton.cells.values():
        for element, moves in groups.elements[cell.name].items():
            for label in cell.boundary:
                image, after = moves[label]
                chosen, other = (
                    [column[0][0] for column in embedding(automaton, cell.name, (b,))] for b in (label, image)
                )
                assert [element[point] for point in chosen] == [other[place] for place in after]


@pytest.mark.parametrize("name", PATCHES)
def test_a_quadrangle_cut_in_four_has_four_edges_and_a_vertex_inside(name):
    face = Topology(read(name)).subdivided("face")
    assert Counter(face.interior.values()) == {"edge": 4, "vertex": 1}
    assert face.folded == ()
    edges = {face.place[str(i), side][0] for i in range(4) for side in ("bottom", "right", "top", "left")}
    assert len(edges) == 4 + 8
    corners = {
        face.place[str(i), side, end][0]
        for i in range(4)
        for side in ("bottom", "right", "top", "left")
        for end in ("left", "right")
    }
    assert len(corners) == 9


@pytest.mark.parametrize("name", PATCHES)
def test_neighbours_see_the_edge_between_them_from_both_ends(name):
    topology = Topology(read(name))
    flip = topology.automaton.cells["edge"].symmetry["flip"].points
    place = topology.subdivided("face").place
    for one, other in ((("0", "right"), ("1", "left")), (("1", "top"), ("2", "bottom"))):
        assert place[one][0] == place[other][0]
        assert compose(inverse(place[one][1]), place[other][1]) == flip


@pytest.mark.parametrize(
    ("name", "cell", "inside"),
    [
        ("corner-cutting", "edge", 1),
        ("koch-curve", "edge", 3),
        ("sierpinski-triangle", "triangle", 3),
        ("sierpinski-tetrahedron", "tetrahedron", 6),
        ("menger-sponge", "attractor", 0),
    ],
)
def test_vertices_inside(name, cell, inside):
    assert Counter(Topology(read(name)).subdivided(cell).interior.values())["vertex"] == inside


def test_a_patch_has_four_corners_each_on_two_edges():
    coincident = Topology(read("doo-sabin-patch")).coincident("face")
    standing = Counter(first for path, (first, _) in coincident.items() if len(path) == 2)
    assert sorted(standing.values()) == [2, 2, 2, 2]


def test_which_cells_are_points():
    topology = Topology(read("doo-sabin-patch"))
    assert [topology.is_point(cell) for cell in ("vertex", "edge", "face")] == [True, False, False]


HALF = """
format = "bcifs/1"
shape = "edge"
[cells.vertex]
points = 1
subdivision = { s = "vertex" }
[cells.edge]
points = 2
subdivision = { 0 = "edge", 1 = "edge" }
boundary = { left = { cell = "vertex", points = [0] }, right = { cell = "vertex", points = [1] } }
"""


@pytest.mark.parametrize(
    ("symmetry", "fragment"),
    [
        ('subdivision = { 0 = "1 flip" }', "'1'"),
        ('subdivision = { 0 = "1 flip", 1 = "0 flip" }, boundary = { left = "right" }', "'right'"),
        ('subdivision = { 0 = "flip 1", 1 = "0 flip" }', "expected one of 0, 1 first"),
        (
            'subdivision = { 0 = "1", 1 = "0 flip" }, boundary = { left = "0 left", right = "left" }',
            "left, right",
        ),
        ('subdivision = { 0 = "1 0", 1 = "0" }', "no symmetry '0'"),
    ],
)
def test_a_symmetry_must_say_where_every_label_goes(symmetry, fragment):
    text = HALF + f"symmetry.flip = {{ points = [1, 0], {symmetry} }}\n"
    with pytest.raises(AutomatonError, match=fragment):
        Topology(parse_text(text))


def test_large_groups_are_refused():
    """The symmetric group of 7 points has 5040 elements."""
    text = """
        format = "bcifs/1"
        shape = "dust"
        [cells.dust]
        points = 7
        subdivision = { 0 = "dust" }
        symmetry.swap = { points = [1, 0, 2, 3, 4, 5, 6], subdivision = { 0 = "0 swap" } }
        symmetry.cycle = { points = [1, 2, 3, 4, 5, 6, 0], subdivision = { 0 = "0 cycle" } }
    """
    with pytest.raises(AutomatonError, match="over 1152 products"):
        Topology(parse_text(text))
