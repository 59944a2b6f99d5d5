"""The command `bcifs choose`: what it prints can be pasted into the file."""

import json
from fractions import Fraction

import pytest

import automata


@pytest.fixture
def run(run):
    return lambda *arguments: run("choose", *arguments)


def test_the_table_can_be_pasted(run):
    code, out, err = run(
        "corner-cutting", "--eigenvalue", "edge.0=1/2", "--near", "a=1/10", "--near", "b=1/5"
    )
    assert (code, err) == (0, "")
    assert "1 degree of freedom left" in out
    table = out[out.index("[set]") :]
    assert table == '[set]\n"edge.0[1,0]" = "1/5"\n"edge.0[0,1]" = "3/10"\n'
    text = (
        'format = "bcifs/1"\nname = "C"\nshape = "edge"\n'
        '[cells.vertex]\npoints = 2\nsubdivision = { s = "vertex" }\n'
        '[cells.edge]\npoints = 3\nsubdivision = { 0 = "edge", 1 = "edge" }\n'
        'boundary = { left = { cell = "vertex", points = [0, 1] }, '
        'right = { cell = "vertex", points = [1, 2] } }\n'
        'incidence = ["left s = 0 left", "right s = 1 right"]\nadjacency = ["0 right = 1 left"]\n'
    )
    values = automata.parse_text(text + table).values
    assert values == {"edge.0[1,0]": Fraction(1, 5), "edge.0[0,1]": Fraction(3, 10)}


def test_a_smooth_positive_curve_near_the_files_own_values(run):
    code, out, _ = run("corner-cutting", "--smooth", "--positive", "--json")
    found = json.loads(out)
    assert code == 0
    assert found["ok"]
    assert found["values"] == {"a": 0.25, "b": 0.25}
    assert found["distance"] == 0
    assert found["degrees_of_freedom"] == 2
    assert [request["met"] for request in found["requests"]] == [True, True]


def test_what_is_not_met_is_said_and_ends_with_2(run):
    code, out, err = run(
        "corner-cutting", "--set", "a=1/4", "b=1/4", "--eigenvalue", "vertex.s=1/3", "--json"
    )
    assert code == 2
    assert not json.loads(out)["ok"]
    assert "off by 0.167" in err


@pytest.mark.parametrize(
    ("option", "message"),
    [
        (("--eigenvalue", "edge=1/2"), "expected CELL.WORD=VALUE"),
        (("--eigenvalue", "edge.0=1/x"), "--eigenvalue edge.0=1/x"),
        (("--dominant", "edge.7=1/2"), "no '7'"),
        (("--near", "a"), "--near a"),
    ],
)
def test_wrong_options_are_named(run, option, message):
    code, out, err = run("corner-cutting", *option)
    assert (code, out) == (2, "")
    assert message in err


def test_the_table_holds_what_was_set_beforehand(run):
    code, out, _ = run("corner-cutting", "--set", "a=1/8", "--near", "b=1/5")
    assert code == 0
    assert out.endswith('[set]\n"edge.0[1,0]" = "1/8"\n"edge.0[0,1]" = "1/5"\n')


def test_values_that_are_expressions_are_wished_for_too(run):
    code, out, _ = run("nonuniform-quadratic-spline", "--set", "u=1", "v=3", "--json")
    found = json.loads(out)
    assert code == 0
    assert found["distance"] == 0
    assert found["values"]["a(u,v)"] == pytest.approx(1 / 8)  # u / (2 (u + v))
    assert found["values"]["b(u,v)"] == pytest.approx(3 / 8)  # v / (2 (u + v))


def test_what_a_cell_has_is_listed_once(run):
    _, _, err = run("corner-cutting", "--dominant", "edge.7=1/2")
    assert err.count("left, right") == 1
