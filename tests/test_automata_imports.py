"""Fractint's files: maps with probabilities, and L-systems that rewrite edges."""

import cmath
import math
from fractions import Fraction

import networkx as nx
import numpy as np
import pytest

import ifs
from automata import AutomatonError
from automata.fractint import fractint_ifs, fractint_names
from automata.growth import NotACurveSystem
from automata.lsystem import lsystem
from automata.turtle import lsystem_automaton
from ifs.dimensions.dimension import similarity_dimension
from ifs.maps.plain import maps_of
from subdivision.schemes import hilbert

FILE = """; two of the plane, one of space
comment {
 free text; with { a brace
}
Fern {  ; Barnsley's
  0    0    0    .16 0 0   .01
  .85  .04 -.04  .85 0 1.6 .85
  .2  -.26  .23  .22 0 1.6 .07
 -.15  .28  .26  .24 0 .44 .07
}
Pair { .5 0 0 .5 0 0 .333333
  .5 0 0 .5 1 0 .333333 }
Box (3D) {
  .5 0 0  0 .25 0  0 0 -1.25e-1  1 2 3  .5
  0 -.5 0  .5 0 0  0 0 .5  0 0 0  .5
}
"""

CURVES = {
    "koch": (6, "F", {"F": "F+F--F+F"}),
    "dragon": (8, "F", {"F": "-F++G-", "G": "+F--G+"}),
    "gosper": (6, "F", {"F": "F+G++G-F--FF-G+", "G": "-F+GG++G+F--F-G"}),
    "arrowhead": (6, "F", {"F": "G-F-G", "G": "F+G+F"}),
    "levy": (8, "F", {"F": "+F--F+"}),
    "reversed": (8, "F", {"F": "-!F!++F-"}),
    "terdragon": (3, "F", {"F": "F+F-F"}),
    "pentigree": (10, "F", {"F": "F+F----F+F"}),
    "quadric": (4, "F", {"F": "F+F-F-FF+F+F-F"}),
    "back": (6, "F", {"F": "F+F|+F-F"}),
}
HILBERT = (4, "X", {"X": "-YF+XFX+FY-", "Y": "+XF-YFY-FX+"})


def text(angle, axiom, rules, name="Curve"):
    lines = [f"Angle {angle}", f"Axiom {axiom}", *(f"{a}={rule}" for a, rule in rules.items())]
    return f"{name} {{\n" + "\n".join(lines) + "\n}\n"


def turtle(angle, axiom, rules, level, drawing="FG"):
    """The turtle's places, by rewriting the text and walking along it."""
    for _ in range(level):
        axiom = "".join(rules.get(letter, letter) for letter in axiom)
    at, heading, sign, places = 0j, 0, 1, [0j]
    for letter in axiom:
        if letter in drawing:
            at += cmath.exp(2j * math.pi * heading / angle)
            places.append(at)
        heading += {"+": sign, "-": -sign, "|": angle // 2}.get(letter, 0)
        sign = -sign if letter == "!" else sign
    return np.array(places)


def ordered(mesh):
    """The vertices of a curve from end to end, as complex numbers."""
    graph = nx.Graph(mesh.faces.tolist())
    assert nx.is_connected(graph)
    ends = [node for node, degree in graph.degree if degree == 1]
    assert len(ends) == 2
    assert graph.number_of_edges() == graph.number_of_nodes() - 1
    walk = list(nx.dfs_preorder_nodes(graph, ends[0]))
    points = mesh.vertices[walk] @ [1, 1j]
    return points if abs(points[0]) < abs(points[-1]) else points[::-1]


def test_maps_are_read_exactly():
    found = fractint_ifs(FILE, "FERN")
    maps = maps_of(ifs.shape(found.automaton, control=np.array([[0, 0], [1, 0], [0, 1]])))
    assert maps[1].rows[0] == (Fraction(17, 20), Fraction(1, 25), 0)
    assert maps[1].rows[1] == (Fraction(-1, 25), Fraction(17, 20), Fraction(8, 5))
    assert found.probabilities == {"0": Fraction(1, 100), "1": Fraction(17, 20), "2": Fraction(7, 100),
                                   "3": Fraction(7, 100)}  # fmt: skip
    assert found.total == 1
    assert fractint_names(FILE) == ("Fern", "Pair", "Box")


def test_a_unit_is_20_mm_and_space_has_13_numbers():
    found = fractint_ifs(FILE, "box")
    first, second = maps_of(ifs.shape(found.automaton))
    assert first.linear.tolist() == [[0.5, 0, 0], [0, 0.25, 0], [0, 0, -0.125]]
    assert first.translation.tolist() == [20, 40, 60]
    assert second.linear.tolist() == [[0, -0.5, 0], [0.5, 0, 0], [0, 0, 0.5]]


def test_probabilities_are_divided_by_their_total():
    found = fractint_ifs(FILE, "Pair")
    assert set(found.probabilities.values()) == {Fraction(1, 2)}
    assert found.total == Fraction(333333 * 2, 1_000_000)


@pytest.mark.parametrize(
    ("source", "place", "words"),
    [
        ("a {\n 1 0 0 1 0 0\n}", (2, 2), "7 numbers, found 6"),
        ("a (3d) {\n 1 0 0 1 0 0 1\n}", (2, 2), "13 numbers, found 7"),
        ("a {\n .5 0 0 .5 0 zero 1\n}", (2, 14), "found 'zero'"),
        ("a {\n .5 0 0 .5 0 0 -1\n}", (2, 16), "not negative"),
        ("a {\n .5 0 0 .5 0 0 0\n}", (1, 1), "all 0"),
        ("a { }", (1, 1), "0 maps"),
        ("a {\n .5 0 0 .5 0 0 1e999\n}", (2, 16), "expected a number"),
        ("a {\n .5 0 0 .5 0 0 __import__('os')\n}", (2, 16), "expected a number"),
        ("x\na { }", (1, 1), "expected an entry"),
        ("a {\n b { }", (2, 4), "'{' inside"),
        ("\n  a {\n", (2, 3), "never closed"),
        ("a {\n\0 }", (2, 1), "NUL"),
    ],
)
def test_faults_of_maps_are_placed(source, place, words):
    with pytest.raises(AutomatonError, match=words) as caught:
        fractint_ifs(source, source="file.ifs")
    assert (caught.value.source, caught.value.line, caught.value.column) == ("file.ifs", *place)


def test_names_that_are_missing_are_listed():
    with pytest.raises(AutomatonError, match="no IFS 'tree'; there are: Fern, Pair, Box"):
        fractint_ifs(FILE, "tree")
    with pytest.raises(AutomatonError, match="name one of: Fern, Pair"):
        fractint_ifs(FILE)
    with pytest.raises(AutomatonError, match="there is no IFS"):
        fractint_ifs("; nothing")


@pytest.mark.parametrize(
    "source",
    [
        "a " * 600_000,
        "{" * 100_000,
        "a {" * 100_000,
        "a {}\n" * 20_000,
        "a {\n" + " .5" * 300_000 + "}",
        "a {\n" + ".5 0 0 .5 0 0 1\n" * 2000 + "}",
        "a {\n" + "9" * 100_000 + " 0 0 .5 0 0 1\n}",
    ],
)
def test_hostile_files_end_in_errors(source):
    for read in (fractint_ifs, lsystem_automaton):
        with pytest.raises(AutomatonError):
            read(source)


@pytest.mark.parametrize("name", CURVES)
def test_curves_are_those_of_a_turtle(name):
    angle, axiom, rules = CURVES[name]
    shape = ifs.shape(lsystem_automaton(text(angle, axiom, rules)))
    level = 3 if name == "back" else 4  # turns repeat every three levels there
    walked = turtle(angle, axiom, rules, level)
    found = ordered(ifs.mesh(shape, level))
    assert np.abs(90 * walked / walked[-1] - found).max() < 1e-9


def test_cells_for_each_level_follow_the_turtle_at_every_second_one():
    angle, axiom, rules = CURVES["pentigree"]
    automaton = lsystem_automaton(text(angle, axiom, rules))
    assert set(automaton.cells) == {"F", "F1", "vertex"}
    assert set(automaton.cells["F"].subdivision.values()) == {"F1"}


def test_hilberts_curve_is_the_built_in_one():
    shape = ifs.shape(lsystem_automaton(text(*HILBERT)))
    own = ordered(ifs.mesh(shape, 4))
    other = ordered(ifs.mesh(ifs.shape(hilbert()), 4))
    assert np.abs(own.conjugate() - other).max() < 1e-9
    walked = turtle(*HILBERT, 7, drawing="F")
    place = 90 * walked / walked[-1]
    finest = ordered(ifs.mesh(shape, 7))
    nearest = [np.abs(finest - z).min() for z in place[:: len(place) // 50]]
    assert max(nearest) < 2 * 90 / 2**7


def test_kochs_curve_and_the_arrowhead_are_the_built_in_ones():
    koch = ifs.shape(lsystem_automaton(text(*CURVES["koch"])))
    built = ordered(ifs.mesh(ifs.shape("koch-curve"), 3))
    assert np.abs(ordered(ifs.mesh(koch, 3)) - built).max() < 1e-9
    arrow = ifs.mesh(ifs.shape(lsystem_automaton(text(*CURVES["arrowhead"]))), 4).vertices @ [1, 1j]
    triangle = ifs.mesh(ifs.shape("sierpinski-triangle"), 4).vertices @ [1, 1j] * 90 / 80
    arrow = arrow if arrow.imag.max() > 1 else arrow.conjugate()
    assert max(np.abs(triangle - z).min() for z in arrow) < 1e-9


@pytest.mark.parametrize(
    ("name", "dimension"),
    [
        ("koch", math.log(4, 3)),
        ("dragon", 2),
        ("gosper", 2),
        ("arrowhead", math.log(3, 2)),
        ("levy", 2),
        ("terdragon", 2),
        ("quadric", 1.5),
        ("pentigree", math.log(4) / math.log(math.sqrt(5))),
    ],
)
def test_dimensions(name, dimension):
    found = similarity_dimension(ifs.shape(lsystem_automaton(text(*CURVES[name]))))
    assert found == pytest.approx(dimension, abs=1e-9)


def test_what_is_known_exactly_is_exact():
    for name, largest in (("koch", 3), ("dragon", 2), ("gosper", 7), ("quadric", 4)):
        automaton = lsystem_automaton(text(*CURVES[name]))
        entries = [
            entry.value
            for cell in automaton.cells.values()
            for rows in cell.matrices.values()
            for row in rows
            for entry in row
        ]
        assert max(x.denominator for x in entries) <= 2 * largest


def test_a_closed_axiom_is_a_closed_curve():
    shape = ifs.shape(lsystem_automaton(text(6, "F--F--F", {"F": "F+F--F+F"})))
    mesh = ifs.mesh(shape, 3)
    graph = nx.Graph(mesh.faces.tolist())
    assert len(mesh.vertices) == len(mesh.faces) == 48
    assert nx.is_connected(graph)
    assert {degree for _, degree in graph.degree} == {2}
    walked = turtle(6, "F--F--F", {"F": "F+F--F+F"}, 2)[:-1] * 10
    found = mesh.vertices @ [1, 1j]
    assert max(np.abs(found - z).min() for z in walked) < 1e-9


def test_an_open_axiom_keeps_its_joints():
    angle, axiom, rules = 6, "+F-F++F", {"F": "F+F--F+F"}
    shape = ifs.shape(lsystem_automaton(text(angle, axiom, rules)))
    found = ordered(ifs.mesh(shape, 3))
    assert np.abs(found - 10 * turtle(angle, axiom, rules, 2)).max() < 1e-9


def test_letters_that_never_draw_are_gaps():
    shape = ifs.shape(lsystem_automaton(text(4, "F", {"F": "FGF", "G": "GGG"})))
    mesh = ifs.mesh(shape, 3)
    assert (len(mesh.vertices), len(mesh.faces)) == (16, 8)
    assert similarity_dimension(shape) == pytest.approx(math.log(2, 3))


@pytest.mark.parametrize(
    ("angle", "axiom", "rules", "words"),
    [
        (3, "FXF", {"F": "FF", "X": "--FXF++FXF++FXF--"}, "net displacement of 'X' is zero"),
        (3, "GF", {"F": "FF", "G": "GGG"}, "grow at different rates"),
        (3, "FG", {"F": "FF", "G": "GGG"}, "different rates"),
        (4, "F", {"F": "F+F+F+F+"}, "net displacement"),
        (4, "F", {"F": "F"}, "no letter of its axiom grows"),
        (4, "+-", {"F": "FF"}, "no letter"),
        (4, "F", {"F": "GFG", "G": "GGG"}, "starts or ends with letters that only move"),
        (4, "G", {"G": "GGG"}, "nothing of it is drawn"),
        (359, "F", {"F": "FF+"}, "does not repeat"),
    ],
)
def test_what_rewrites_no_edges_is_refused(angle, axiom, rules, words):
    with pytest.raises(NotACurveSystem, match=words):
        lsystem_automaton(text(angle, axiom, rules))


@pytest.mark.parametrize(
    ("source", "place", "words"),
    [
        ("a { Angle 6\n Axiom F\n F=F[+F]F\n}", (3, 5), r"'\[' is refused: branches"),
        ("a { Angle 6\n Axiom F\n F=F@.5F\n}", (3, 5), "'@' is refused: lengths"),
        ("a { Angle 6\n Axiom F\n F=F/30F\n}", (3, 5), "'/' is refused: turns by degrees"),
        ("a { Angle 5\n Axiom F|F\n F=FF\n}", (2, 9), "Angle 5 has no turns for"),
        ("a { Angle 6\n Axiom F\n F=F$F\n}", (3, 5), r"unknown symbol '\$'"),
        ("a { Angle 2\n Axiom F\n}", (1, 5), "from 3 to 360"),
        ("a { Axiom F\n F=FF\n}", (1, 1), "no 'Angle n'"),
        ("a { Angle 4\n F=FF\n}", (1, 1), "no 'Axiom"),
        ("a { Angle 4\n Axiom F\n F=FF\n F=F+F\n}", (4, 2), "given twice"),
        ("a { Angle 4\n turn left\n}", (2, 2), "expected 'Angle n'"),
        ("a { Angle 4\n Axiom F\n F=" + "F" * 5000 + "\n}", (3, 4), "at most 4096"),
    ],
)
def test_faults_of_l_systems_are_placed(source, place, words):
    with pytest.raises(AutomatonError, match=words) as caught:
        lsystem_automaton(source, source="file.l")
    assert (caught.value.source, caught.value.line, caught.value.column) == ("file.l", *place)


def test_colours_are_passed_over_and_case_does_not_matter():
    assert lsystem("a { angle 4\n axiom c12f\n f=f<1+f>2 }") == lsystem("a { Angle 4\n Axiom F\n F=F+F }")
