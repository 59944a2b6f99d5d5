"""Addresses, the points that they name, and where pieces meet."""

from fractions import Fraction

import numpy as np
import pytest

import fld.address
import ifs
from automata.plain import plain_automaton
from automata.turtle import lsystem_automaton
from fld.curve import curve
from ifs.orbits.addresses import (
    UnknownLabel,
    address,
    joints,
    parse_address,
    path_of,
    split_address,
    twins,
    vertex_address,
)
from ifs.orbits.limits import ManyFixedPoints, point_at, points_at

ARROWHEAD = "A { Angle 6\n Axiom F\n F=G-F-G\n G=F+G+F }"


def line(*maps):
    """A plain IFS of the line, maps as (factor, shift)."""
    return ifs.shape(plain_automaton("Line", [([[Fraction(a)]], [Fraction(b)]) for a, b in maps]))


HALVES = line(("1/2", 0), ("1/2", "1/2"))


def followed(shape, where, count=90):
    """The point of an address by applying operators to some point, many times."""
    cells, cell = [], shape.system.shape
    for place in range(count):
        state = shape.system.states[cell]
        number = state.labels.index(where.label(place))
        cells.append(state.operators[number])
        cell = state.targets[number]
    column = np.full(shape.system.states[cell].points, 1 / shape.system.states[cell].points)
    for operator in reversed(cells):
        column = operator @ column
    return column @ shape.control


@pytest.mark.parametrize(
    "text", ["0", "1", "0 1", "1 0 (1 0)*", "(0 1 1)*", "1 1 0 1 (0 0 1)*", "0 1 1 (1 0 1 0)*"]
)
def test_binary_addresses_are_binary_expansions(text):
    word, repeat = split_address(text)
    value = sum((Fraction(int(b), 2**k) for k, b in enumerate(word, start=1)), Fraction(0))
    period = sum((Fraction(int(b), 2**k) for k, b in enumerate(repeat, start=1)), Fraction(0))
    value += period / (1 - Fraction(1, 2 ** len(repeat))) / 2 ** len(word)
    assert point_at(HALVES, text).exact == (value,)


@pytest.mark.parametrize(
    "name", ["corner-cutting", "koch-curve", "sierpinski-triangle", "menger-sponge", "fractal-patch"]
)
def test_points_are_the_limits_of_their_words(name):
    shape = ifs.shape(name)
    rng = np.random.default_rng(3)
    labels = shape.system.states[shape.system.shape].labels
    words = [[labels[i] for i in rng.integers(len(labels), size=size)] for size in (0, 1, 5, 8)]
    cycles = [[labels[i] for i in rng.integers(len(labels), size=size)] for size in (3, 1, 2, 4)]
    places = [address(word, cycle) for word, cycle in zip(words, cycles, strict=True)]
    for found, where in zip(points_at(shape, places), places, strict=True):
        assert found.exact is not None
        assert np.abs(found.point - followed(shape, where)).max() < 1e-9 * np.abs(shape.control).max()
        assert sum(found.exact_column) == 1


def test_points_of_operators_that_are_only_known_as_floats():
    shape = ifs.shape("corner-cutting")
    states = {
        name: ifs.State(s.name, s.points, s.labels, s.targets, tuple(0.9 * t + 0.1 * t for t in s.operators))
        for name, s in shape.system.states.items()
    }
    moved = {**states, "edge": shape.system.states["edge"]}
    bent = np.array([[0.8, 0.3, 0.0], [0.2, 0.7, 0.75], [0.0, 0.0, 0.25]])
    edge = moved["edge"]
    moved["edge"] = ifs.State("edge", 3, edge.labels, edge.targets, (bent, edge.operators[1]))
    other = ifs.Shape("Bent", shape.topology, ifs.System("edge", moved), shape.control)
    found = point_at(other, "1 (0 1)*")
    assert found.exact is None
    assert np.abs(found.point - followed(other, parse_address("1 (0 1)*"))).max() < 1e-9


def test_a_graph_directed_cycle_is_gone_through_until_a_cell_comes_again():
    shape = ifs.shape(lsystem_automaton(ARROWHEAD))
    path = path_of(shape.system, parse_address("1 (0)*"))
    assert (path.word, path.cell, path.cycle) == (("1",), "F", ("0", "0"))
    for text in ("(0)*", "(2)*", "1 0 (2 1)*"):
        where = parse_address(text)
        assert np.abs(point_at(shape, where).point - followed(shape, where)).max() < 1e-9
    assert point_at(shape, "0").exact_column == (1, 0, 0)


@pytest.mark.parametrize(
    ("text", "normal"),
    [
        ("0", "(0)*"),
        ("1 0 0", "1 (0)*"),
        ("0 1 (0 1)*", "(0 1)*"),
        ("0 1 0 (1 0)*", "(0 1)*"),
        ("2 (0 1 0 1)*", "2 (0 1)*"),
        ("0 (1 2 0)*", "(0 1 2)*"),
    ],
)
def test_equal_infinite_words_have_one_normal_form(text, normal):
    assert str(parse_address(text)) == normal
    assert parse_address(normal) == parse_address(text)


@pytest.mark.parametrize("count", range(9))
def test_what_follows_some_labels(count):
    where = parse_address("2 0 1 (0 0 1)*")
    rest = where.after(count)
    assert [rest.label(k) for k in range(12)] == [where.label(k + count) for k in range(12)]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "must repeat one label"),
        ("0 ()*", "must repeat one label"),
        ("0 (1", "parentheses elsewhere"),
        ("(0)* 1", "parentheses elsewhere"),
        ("0 " * 300, "300 labels; at most 200"),
        ("(((" * 5000, "parentheses elsewhere"),
    ],
)
def test_texts_that_are_no_address(text, words):
    with pytest.raises(ValueError, match=words):
        parse_address(text)


def test_unknown_labels_name_the_cell_and_its_labels():
    shape = ifs.shape(lsystem_automaton(ARROWHEAD))
    with pytest.raises(UnknownLabel, match=r"'7' at place 3 .* cell 'F'.* 0, 1, 2") as caught:
        point_at(shape, "1 1 (7)*")
    assert (caught.value.label, caught.value.place, caught.value.cell) == ("7", 2, "F")


def test_words_without_a_single_limit():
    still = line((1, 0), ("1/2", 0))
    with pytest.raises(ManyFixedPoints, match="eigenvalue 1 with multiplicity 2") as caught:
        point_at(still, "1 0")
    assert caught.value.multiplicity == 2
    assert caught.value.word == ("0",)
    for factor in (-1, 2, "-3/2"):
        with pytest.raises(ifs.NotContracting, match="'0 1'"):
            point_at(line((factor, 0), (1 if factor == -1 else "9/10", 1)), "(0 1)*")


def test_only_what_repeats_needs_to_contract():
    growing = line((3, 1), ("1/2", 0))
    assert point_at(growing, "0 0 (1)*").exact == (4,)
    assert point_at(growing, "(1 1 0)*").exact == (1,)


@pytest.mark.parametrize(
    ("source", "count"),
    [
        ("koch-curve", 3),
        ("corner-cutting", 1),
        ("sierpinski-triangle", 3),
        ("sierpinski-tetrahedron", 6),
        ("menger-sponge", 0),
        ("doo-sabin-patch", 5),
    ],
)
def test_joints_have_one_point(source, count):
    shape = ifs.shape(source)
    found = joints(shape)
    assert len(found) == count
    for joint in found:
        exact = {place.exact for place in points_at(shape, joint.addresses)}
        assert len(exact) == 1


def test_joints_of_every_cell_of_a_graph_directed_curve():
    shape = ifs.shape(lsystem_automaton("G { Angle 6\n Axiom F\n F=F+G++G-F--FF-G+\n G=-F+GG++G+F--F-G }"))
    for cell in ("F", "G"):
        found = joints(shape, cell)
        assert len(found) == 6
        for joint in found:
            assert len(joint.addresses) == 2
    for joint in joints(shape):
        first, second = points_at(shape, joint.addresses)
        assert first.exact_column == second.exact_column
    assert joints(shape, "vertex") == ()
    with pytest.raises(ValueError, match="no cell 'H'; there are F, G, vertex"):
        joints(shape, "H")


def test_the_ends_of_a_curve():
    assert str(vertex_address(ifs.shape("corner-cutting"), "edge", ("left",))) == "(0)*"
    assert str(vertex_address(ifs.shape("corner-cutting"), "edge", ("right",))) == "(1)*"
    patch = ifs.shape("doo-sabin-patch")
    face = patch.automaton.shape
    side = next(iter(patch.automaton.cells[face].boundary))
    with pytest.raises(ValueError, match="no point"):
        vertex_address(patch, face, (side,))


@pytest.mark.parametrize(
    "text", ["1 0", "0 3", "2 (3)*", "1 2 (0)*", "3 1 1 (3)*", "(0)*", "1 (2)*", "0 (1 2)*"]
)
def test_twins_are_those_of_the_differential_behaviour(text):
    shape = ifs.shape("koch-curve")
    found = twins(shape, parse_address(text))
    for other in found:
        assert parse_address(text) in twins(shape, other)
        assert point_at(shape, other).exact == point_at(shape, text).exact
    if text == "0 (1 2)*":
        assert found == ()
        return
    own = curve(shape)
    known = fld.address.twin(fld.address.parse_address(text, own), own)
    assert [str(a) for a in found] == ([str(known)] if known else [])


def test_four_pieces_that_meet_in_a_point_have_four_addresses():
    shape = ifs.shape("doo-sabin-patch")
    middle = [joint for joint in joints(shape) if len(joint.addresses) == 4]
    assert len(middle) == 1
    first, *others = middle[0].addresses
    assert set(twins(shape, first)) == set(others)
