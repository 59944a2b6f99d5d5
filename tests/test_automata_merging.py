"""Cells that gluing makes one."""

from fractions import Fraction

import pytest

import ifs
from automata import AutomatonError, parse_text
from automata.merging import merged
from automata.topology import Topology
from subdivision import solve
from subdivision.display import as_data, as_text

TWO_ENDS = """\
format = "bcifs/1"
shape = "edge"
[cells.start]
points = 2
subdivision = { s = "start" }
[cells.finish]
points = 2
subdivision = { t = "finish" }
[cells.edge]
points = 3
subdivision = { 0 = "edge", 1 = "edge" }
boundary = { left = { cell = "start", points = [0, 1] }, right = { cell = "finish", points = [1, 2] } }
incidence = ["left s = 0 left", "right t = 1 right"]
adjacency = ["0 right = 1 left"]
[control]
points = [[0, 0], [10, 30], [40, 0]]
"""
NOTE = "cells start and finish are one: '0 right = 1 left' glues them"


def test_different_ends_become_one_cell_and_are_listed_under_both_names():
    family = solve(parse_text(TWO_ENDS))
    assert family.degrees_of_freedom == 2
    assert family.notes == (NOTE,)
    assert NOTE in as_text(family)
    assert as_data(family)["notes"] == [NOTE]
    assert family.operators["finish"]["t"] == family.operators["start"]["s"]
    assert as_data(family)["matrices"]["edge"]["0"] == [
        ["1 - a", "b", "0"],
        ["a", "1 - b", "1 - a"],
        ["0", "0", "a"],
    ]


def test_values_and_names_go_by_either_name():
    text = TWO_ENDS + '[names]\nq = "finish.t[0,1]"\n'
    family = solve(parse_text(text))
    assert "q" in [parameter.name for parameter in family.parameters]
    quarter = Fraction(1, 4)
    chosen = family.with_values({"finish.t[0,1]": quarter, "start.s[1,0]": quarter})
    assert chosen.numbers()["finish"]["t"] == ((Fraction(3, 4), quarter), (quarter, Fraction(3, 4)))


def test_the_mesh_of_a_curve_with_two_kinds_of_ends_is_one_chain():
    quarter = Fraction(1, 4)
    shape = ifs.shape(parse_text(TWO_ENDS), {"start.s[1,0]": quarter, "finish.t[0,1]": quarter})
    mesh = ifs.mesh(shape, 4)
    assert (len(mesh.vertices), len(mesh.faces)) == (17, 16)


def test_topology_sees_one_vertex_inside():
    assert list(Topology(parse_text(TWO_ENDS)).subdivided("edge").interior.values()) == ["start"]


def test_sub_cells_and_symmetries_are_merged_too():
    text = TWO_ENDS.replace('{ t = "finish" }', '{ t = "later" }').replace("right t", "right t")
    text += '[cells.later]\npoints = 2\nsubdivision = { t = "finish" }\n'
    text += 'symmetry.swap = { points = [1, 0], subdivision = { t = "t" } }\n'
    text = text.replace('subdivision = { t = "finish" }\nsymmetry', 'subdivision = { t = "later" }\nsymmetry')
    text = text.replace('"right t = 1 right"', '"right t = 1 right t"')
    whole = merged(parse_text(text.replace('"right t = 1 right t"', '"left s = 0 left"')))
    assert set(whole.automaton.cells) == {"start", "edge"}
    assert whole.automaton.cells["start"].symmetry["swap"].subdivision == {"s": ("s",)}
    assert whole.entry("later.t[0,1]") == "start.s[0,1]"


@pytest.mark.parametrize(
    ("old", "new", "fragment"),
    [
        ("points = 2\nsubdivision = { t", "points = 3\nsubdivision = { t", "expected 3 point numbers"),
        ('{ t = "finish" }', '{ t = "finish", u = "finish" }', "their sub-cells need the same labels"),
    ],
)
def test_cells_that_cannot_be_one(old, new, fragment):
    with pytest.raises(AutomatonError, match=fragment):
        parse_text(TWO_ENDS.replace(old, new, 1))


def test_cells_of_different_sizes_are_an_error_at_the_equation():
    text = TWO_ENDS.replace("points = 2\nsubdivision = { t", "points = 1\nsubdivision = { t")
    with pytest.raises(AutomatonError, match="of 1 and 2 points, which cannot be one") as caught:
        parse_text(text.replace("points = [1, 2]", "points = [2]"))
    assert (caught.value.line, caught.value.column) == (14, 14)
