"""Faults of automaton files: each has its line, its column and what was expected."""

import pytest

from automata import AutomatonError, builtin_names, describe, parse_text, read

EDGE = """\
format = "bcifs/1"
shape = "edge"
[cells.vertex]
points = 2
subdivision = { s = "vertex" }
[cells.edge]
points = 3
subdivision = { 0 = "edge", 1 = "edge" }
boundary = { left = { cell = "vertex", points = [0, 1] }, right = { cell = "vertex", points = [1, 2] } }
incidence = ["left s = 0 left", "right s = 1 right"]
adjacency = ["0 right = 1 left"]
"""

MAPS = """\
format = "bcifs/1"
[[maps]]
scale = "1/2"
translation = [0, 0]
[[maps]]
scale = "1/2"
rotation = 90
translation = ["1/2", 0]
"""

# What to replace in the text above, by what, where the fault then is, and a part of what is said.
FAULTS = [
    ('format = "bcifs/1"', 'format = "bcifs/2"', (1, 10), "expected format = 'bcifs/1'"),
    ('format = "bcifs/1"', "", (1, 1), "'format' is missing"),
    ('shape = "edge"', "", (1, 1), "'shape' is missing"),
    ('shape = "edge"', 'shape = "egde"', (2, 9), "unknown cell 'egde'; did you mean 'edge'?"),
    ('shape = "edge"', 'shap = "edge"', (2, 8), "unknown key 'shap'; did you mean 'shape'?"),
    ('shape = "edge"', "shape = 3", (2, 9), "expected the name of cell, found 3"),
    ("points = 2", "pionts = 2", (4, 10), "unknown key 'pionts'; did you mean 'points'?"),
    ("points = 3", 'points = "3"', (7, 10), "expected a whole number from 1 to 256, found '3'"),
    ("points = 3", "points = true", (7, 10), "found true"),
    ("points = 3", "points = 0", (7, 10), "found 0"),
    ("points = 3", "points = 257", (7, 10), "found 257"),
    ("points = 3", "points = 1e99999", (7, 10), "out of range"),
    ("points = 3", "points = 1e200", (7, 10), "very large"),
    ("points = 3\n", "", (6, 2), "'points' is missing"),
    ("points = 3\n", "points = 3\npoints = 4\n", (8, 11), "overwrite"),
    ('{ s = "vertex" }', '{ s = "vertx" }', (5, 21), "did you mean 'vertex'?"),
    ('{ s = "vertex" }', "{ }", (5, 15), "1 to 4096 cells"),
    ('{ s = "vertex" }', '["vertex"]', (5, 15), "expected a table, found a list of 1"),
    ('{ s = "vertex" }', '{ "s s" = "vertex" }', (5, 25), "no spaces"),
    ('{ 0 = "edge"', '{ 0 = "édge"', (8, 21), "did you mean 'edge'?"),
    ("points = [0, 1]", "points = [0]", (9, 49), "expected 2 point numbers (cell 'vertex' has 2"),
    ("points = [0, 1]", "points = [0, 3]", (9, 53), "expected a whole number from 0 to 2, found 3"),
    ("points = [0, 1]", "points = [0, -1]", (9, 53), "found -1"),
    ("points = [0, 1]", "matrix = [[1, 0], [0, 1]]", (9, 49), "expected 3 rows, found 2"),
    ("points = [0, 1]", "matrix = [[1, 0], [0], [0, 0]]", (9, 58), "expected 2 entries in this row"),
    ("points = [0, 1]", "matrix = [[1, 0], [0, 1], [0, 1]]", (9, 49), "column 1 sums to 2"),
    ("points = [0, 1]", 'matrix = [["1/", 0], [0, 1], [0, 0]]', (9, 51), "character 3: expected"),
    ("points = [0, 1]", "points = [0, 1], matrix = []", (9, 21), "either 'points' or 'matrix'"),
    (", points = [0, 1] }", " }", (9, 21), "either 'points' or 'matrix'"),
    ('cell = "vertex", points = [0, 1]', "points = [0, 1]", (9, 21), "'cell' is missing"),
    ('cell = "vertex", points = [0, 1]', 'cell = "edge", points = [0, 1, 2]', (9, 12), "cycle"),
    ("left = {", "0 = {", (9, 12), "the label '0' is used twice"),
    ('"left s = 0 left"', '"left s = 2 left"', (10, 14), "there is no '2'"),
    (
        '"left s = 0 left"',
        '"left s = 0 lef"',
        (10, 14),
        "after '0', in cell 'edge', there is no 'lef'; did you",
    ),
    ('"left s = 0 left"', '"left s = 0"', (10, 14), "lead to different cells: 'vertex' and 'edge'"),
    ('"left s = 0 left"', '"left s"', (10, 14), "expected one '='"),
    ('"left s = 0 left"', '"left s = 0 left = 0 left"', (10, 14), "expected one '='"),
    ('"left s = 0 left"', '"= 0 left"', (10, 14), "a path on each side"),
    ('"left s = 0 left"', '"' + "0 " * 33 + '= 0"', (10, 14), "at most 32 labels"),
    ('"right s = 1 right"', "7", (10, 33), "expected an equation"),
    ('["0 right = 1 left"]', '"0 right = 1 left"', (11, 13), "expected a list of equations"),
    ('left"]\n', 'left"]\nsymmetry = { f = { points = [2, 1] } }', (12, 29), "expected 3 point numbers"),
    ('left"]\n', 'left"]\nsymmetry = { f = { points = [2, 1, 1] } }', (12, 29), "every number from 0 to 2"),
    (
        'left"]\n',
        'left"]\nsymmetry.f = { points = [2, 1, 0], subdivision = { 0 = "2 f" } }',
        (12, 56),
        "there is no '2'",
    ),
    ('left"]\n', 'left"]\nsymmetry.f = { points = [2, 1, 0], subdivision = { 0 = " " } }', (12, 56), "empty"),
    ('left"]\n', 'left"]\nmatrices = { 2 = [] }', (12, 18), "no sub-cell '2'"),
    (
        'left"]\n',
        'left"]\nmatrices = { 0 = [[1, 0, 0], [0, 1, 0], [0, 0, 2]] }',
        (12, 18),
        "column 2 sums to 2",
    ),
    ('left"]\n', 'left"]\nfigure = "polygone"', (12, 10), "did you mean 'polygon'?"),
    ('left"]\n', 'left"]\nfigure = { points = [[1, 1, 0]], faces = [[0]] }', (12, 22), "sum to 1"),
    ('left"]\n', 'left"]\nfigure = { points = [[1, 0, 0]], faces = [[1]] }', (12, 44), "from 0 to 0"),
    ('left"]\n', 'left"]\nfigure = { points = [[1, 0, 0]] }', (12, 10), "expected 'faces'"),
    ('left"]\n', 'left"]\n[set]\na = "1/0"', (13, 5), "character 2: division by zero"),
    ('left"]\n', 'left"]\n[set]\na = "(((9^12)^12)^12)"', (13, 5), "too large"),
    ('left"]\n', 'left"]\n[set]\na = "1e99999"', (13, 5), "character 1: numbers have at most"),
    ('left"]\n', f'left"]\n[set]\na = {"9" * 4000}', (13, 5), "out of range"),
    ('left"]\n', 'left"]\n[set]\na = nan', (13, 5), "out of range"),
    ('left"]\n', 'left"]\n[names]\n"1a" = "edge.0[0,0]"', (13, 8), "letters, digits and _"),
    ('left"]\n', 'left"]\n[names]\nx = "edge.0[0,0]"\ny = "edge.0[0, 0]"', (14, 5), "has a name already"),
    ('left"]\n', 'left"]\n[control]\npoints = [[0, 0], [1, 1]]', (13, 10), "3 control points, found 2"),
    ('left"]\n', 'left"]\n[control]\npoints = [[0, 0], [1], [1, 1]]', (13, 19), "expected 2 coordinates"),
    ('left"]\n', 'left"]\n[control]\npoints = [[], [], []]', (13, 11), "1 to 6"),
    ('left"]\n', 'left"]\n[control]\npoints = [[1e10], [0], [0]]', (13, 12), "at most 1e9"),
    ('left"]\n', 'left"]\n[control]\npoints = [["x"], [0], [0]]', (13, 12), "found the name 'x'"),
    ('left"]\n', 'left"]\n[control]\npoint = []', (13, 9), "unknown key 'point'; did you mean 'points'?"),
    ('left"]\n', 'left"]\n[[maps]]\ntranslation = [0]', (3, 2), "'cells' and [[maps]] exclude each other"),
    ('left"]\n', 'left"\n', (12, 1), "Unclosed array"),
]

MAP_FAULTS = [
    ("translation = [0, 0]", "translation = []", (4, 15), "1 to 6 coordinates"),
    ("translation = [0, 0]\n", "", (2, 3), "'translation' is missing"),
    ('["1/2", 0]', '["1/2"]', (8, 15), "expected 2 numbers, found 1"),
    ('["1/2", 0]', '["1/2", "x"]', (8, 23), "found the name 'x'"),
    ("rotation = 90", "rotation = { angle = 1 }", (7, 12), "expected a number"),
    ("rotation = 90", "linear = [[1, 0]]", (7, 10), "expected 2 rows, found 1"),
    ("rotation = 90", "linear = [[1, 0], [1]]", (7, 19), "expected 2 numbers, found 1"),
    ("rotation = 90", "scal = 2", (7, 8), "unknown key 'scal'; did you mean 'scale'?"),
]


def fault(text):
    with pytest.raises(AutomatonError) as caught:
        parse_text(text, "shape.toml")
    return caught.value


@pytest.mark.parametrize(("old", "new", "place", "fragment"), FAULTS)
def test_faults_of_cells(old, new, place, fragment):
    error = fault(EDGE.replace(old, new, 1))
    assert fragment in error.message
    assert (error.line, error.column) == place
    assert str(error).startswith(f"shape.toml:{place[0]}:{place[1]}: ")


@pytest.mark.parametrize(("old", "new", "place", "fragment"), MAP_FAULTS)
def test_faults_of_maps(old, new, place, fragment):
    error = fault(MAPS.replace(old, new, 1))
    assert fragment in error.message
    assert (error.line, error.column) == place


def test_the_place_is_found_behind_letters_of_several_bytes_and_windows_line_ends():
    cells = 'cells = { "é" = { points = 1, subdivision = 3 } }'
    error = fault(f'format = "bcifs/1"\r\nname = "é"\r\n{cells}\r\nshape = "é"\r\n')
    assert (error.line, error.column) == (3, cells.index("3") + 1)


def test_the_place_is_found_in_a_table_given_in_several_parts():
    text = EDGE.replace("boundary = {", "other = {") + "[cells.edge.other]\n"
    assert fault(text).line in (9, 12)
    text = EDGE + "[cells.edge.symmetry.flip]\n# the points\npoints = [2, 1, 5]\n"
    assert (fault(text).line, fault(text).column) == (14, 17)
    assert fault(text).path == ("cells", "edge", "symmetry", "flip", "points", 2)


def test_a_description_without_a_text_has_the_path_of_its_fault():
    with pytest.raises(AutomatonError, match=r"cells\.dust\.points: expected a whole number") as caught:
        describe(
            {"format": "bcifs/1", "shape": "dust", "cells": {"dust": {"points": 0.5, "subdivision": {}}}}
        )
    assert caught.value.path == ("cells", "dust", "points")
    assert caught.value.line is None


def test_the_built_in_automata_are_read_by_name_and_from_files(tmp_path):
    assert {"corner-cutting", "doo-sabin-patch", "menger-sponge"} <= set(builtin_names())
    (tmp_path / "edge.toml").write_text(EDGE)
    assert read(tmp_path / "edge.toml").cells == parse_text(EDGE).cells
    with pytest.raises(AutomatonError, match="did you mean 'corner-cutting'"):
        read("corner-cuting")


def test_the_numbers_of_a_file_are_exact():
    automaton = parse_text(EDGE + '[set]\na = 0.1\nb = "1/3"\nc = 1_000.5e-1\n')
    assert {key: str(value) for key, value in automaton.values.items()} == {
        "a": "1/10",
        "b": "1/3",
        "c": "2001/20",
    }
