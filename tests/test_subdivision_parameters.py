"""Entries in parameters, unknown embeddings, and systems large or dense."""

from fractions import Fraction
from importlib import resources

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BSpline

import ifs
from automata import AutomatonError, describe, parse_text, read
from bench.solve_size import tensor
from subdivision import NotLinear, TooMuchWork, Undetermined, WrongValue, elimination, solve
from subdivision.display import as_data

SPLINE = (resources.files("automata") / "builtin" / "nonuniform-quadratic-spline.toml").read_text()
OPEN = SPLINE.replace("u = 1\nv = 2\nw = 4\n", "")
RATIOS = st.fractions(1, 1000, max_denominator=20)


def test_the_structure_of_the_source_comes_out_of_the_solver():
    """p0, p1, q0 … q3, r0, r1 of §4.3.2."""
    found = as_data(solve(read("nonuniform-quadratic-spline")))["matrices"]
    pairs = {"uv": ("a(u,v)", "b(u,v)"), "vw": ("a(v,w)", "b(v,w)"), "vv": ("c", "d")}
    edges = {"uvw": ("uv", "vw"), "uvv": ("uv", "vv"), "vvw": ("vv", "vw"), "vvv": ("vv", "vv")}
    for name, (left, right) in edges.items():
        (a, b), (c, d) = pairs[left], pairs[right]
        assert found[name]["0"] == [
            [f"1 - {a}", b, "0"],
            [a, f"1 - {b}", f"1 - {c}"],
            ["0", "0", c],
        ]
        assert found[name]["1"] == [
            [b, "0", "0"],
            [f"1 - {b}", f"1 - {c}", d],
            ["0", c, f"1 - {d}"],
        ]


@settings(max_examples=10, deadline=None)
@given(RATIOS, RATIOS, RATIOS)
def test_the_limit_is_the_b_spline_of_the_knot_intervals(u, v, w):
    shape = ifs.shape("nonuniform-quadratic-spline", {"u": u, "v": v, "w": w})
    mesh = ifs.mesh(shape, 5)
    order = np.argsort(mesh.vertices[:, 0])
    intervals = [float(x) for x in (u, v, w)]
    knots = np.concatenate(
        [[-1 - intervals[0], -intervals[0], 0], intervals[1] + np.array([0, intervals[2], 0])]
    )
    knots[-1] = knots[-2] + 1
    spline = BSpline(knots, shape.control, 2)
    exact = spline(np.linspace(0, intervals[1], 33))
    assert np.abs(mesh.vertices[order] - exact).max() < 1e-12 * 60


def test_numbers_ask_for_parameters_without_a_value():
    family = solve(parse_text(OPEN))
    with pytest.raises(Undetermined) as caught:
        family.numbers()
    assert caught.value.parameters == ("u", "v", "w")
    values = {"u": Fraction(1), "v": Fraction(2), "w": Fraction(4)}
    assert family.with_values(values).numbers() == solve(parse_text(SPLINE)).numbers()


def test_a_value_that_divides_by_zero_is_refused():
    with pytest.raises(WrongValue, match="division by zero"):
        solve(parse_text(OPEN)).with_values({"u": Fraction(1), "v": Fraction(-1)}).numbers()


EDGE = """
format = "bcifs/1"
shape = "edge"
[cells.vertex]
points = 1
subdivision = { s = "vertex" }
[cells.edge]
points = 2
subdivision = { 0 = "edge", 1 = "edge" }
boundary = { left = { cell = "vertex", points = [0] }, right = { cell = "vertex", points = [1] } }
incidence = ["left s = 0 left", "right s = 1 right"]
adjacency = ["0 right = 1 left"]
matrices = { 0 = [["*", "u/(u + v)"], ["*", "*"]] }
"""


def test_matrices_in_parameters_are_shown_in_them_and_take_their_values():
    family = solve(parse_text(EDGE))
    assert as_data(family)["matrices"]["edge"]["1"] == [["u/(u + v)", "0"], ["v/(u + v)", "1"]]
    chosen = family.with_values({"u": Fraction(1), "v": Fraction(2)}).numbers()
    assert chosen["edge"]["1"][0][0] == Fraction(1, 3)
    file = parse_text(EDGE + '[parameters]\nu = 1\nv = "4/2"\n')
    assert solve(file).numbers() == chosen
    assert solve(file).with_values({"u": Fraction(2)}).numbers()["edge"]["1"][0][0] == Fraction(1, 2)


def test_a_parameter_that_places_control_points_is_changed_in_the_file():
    text = EDGE + '[parameters]\nu = 1\nv = 2\n[control]\npoints = [[0], ["3u"]]\n'
    automaton = parse_text(text)
    assert automaton.control == ((0.0,), (3.0,))
    with pytest.raises(WrongValue, match="places control points"):
        solve(automaton).with_values({"u": Fraction(2)})
    with pytest.raises(AutomatonError, match="found the name 'x'"):
        parse_text(text.replace("3u", "3x"))


UNKNOWN = EDGE.replace("points = [1] }", 'matrix = [["*"], ["*"]] }').replace('"u/(u + v)"', '"1/3"')


def test_an_unknown_embedding_is_found_once_the_operators_are():
    """`0 right = 1 left` with both operators given makes right the solution of a linear system."""
    text = UNKNOWN.replace(
        'matrices = { 0 = [["*", "1/3"], ["*", "*"]] }',
        'matrices = { 0 = [[1, "1/3"], [0, "2/3"]], 1 = [["1/3", 0], ["2/3", 1]] }',
    )
    found = solve(parse_text(text)).numbers()["edge"]
    assert found["right"] == ((Fraction(0),), (Fraction(1),))


def test_products_that_stay_are_named():
    with pytest.raises(NotLinear) as caught:
        solve(parse_text(UNKNOWN))
    assert (
        "edge: right s = 1 right" in caught.value.equations
        or "edge: 0 right = 1 left" in caught.value.equations
    )


def test_a_volume_of_64_points_is_solved_within_the_work_allowed():
    document = tensor(3, 3)
    assert [cell["points"] for cell in document["cells"].values()] == [27, 36, 48, 64]
    assert solve(describe(document)).degrees_of_freedom > 0


def test_the_b_spline_is_in_the_family_of_its_tensor_product():
    half = [[Fraction(x, 4) for x in row] for row in ([3, 1, 0], [1, 3, 3], [0, 0, 1])]
    family = solve(describe(tensor(2, 2)))
    rows = [[half[i // 3][j // 3] * half[i % 3][j % 3] for j in range(9)] for i in range(9)]
    values = {f"c2.00[{i},{j}]": rows[i][j] for i in range(9) for j in range(9)}
    assert family.with_values(values).degrees_of_freedom == 0


def test_dense_embeddings_run_out_of_work(monkeypatch):
    monkeypatch.setattr(elimination, "MOST_WORK", 2000)
    rows = [[f"{(3 * i + 7 * j) % 11}/{i + j + 1}" for j in range(3)] for i in range(5)]
    last = ["1 - (" + " + ".join(row[j] for row in rows) + ")" for j in range(3)]
    embedding = {"cell": "v", "matrix": [*rows, last]}
    document = {
        "format": "bcifs/1",
        "shape": "e",
        "cells": {
            "v": {"points": 3, "subdivision": {"s": "v"}},
            "e": {
                "points": 6,
                "subdivision": {"0": "e", "1": "e"},
                "boundary": {"l": embedding, "r": {"cell": "v", "points": [3, 4, 5]}},
                "incidence": ["l s = 0 l", "r s = 1 r"],
                "adjacency": ["0 r = 1 l"],
            },
        },
    }
    with pytest.raises(TooMuchWork, match="over 2000 steps"):
        solve(describe(document))
