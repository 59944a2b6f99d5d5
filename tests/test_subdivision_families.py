"""The families of operators that known automata allow."""

from dataclasses import replace
from fractions import Fraction
from functools import reduce

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from automata import Equation, builtin_names, parse_text, read
from automata.expression import evaluate, parse
from subdivision import Contradiction, NotLinear, Undetermined, WrongValue, solve
from subdivision.constraints import constraints
from subdivision.display import as_data, as_text, expression
from subdivision.elimination import Inconsistent, LinearSystem
from subdivision.form import CONSTANT
from subdivision.unknowns import unknowns

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
"""

SOLUTIONS = {name: solve(read(name)) for name in builtin_names()}


def product(left, right):
    return [
        [sum(x * y for x, y in zip(row, col, strict=True)) for col in zip(*right, strict=True)]
        for row in left
    ]


def numbers_of(rows, values):
    """A matrix of affine forms at given values of the parameters."""
    return [
        [sum((c * (1 if k == CONSTANT else values[k]) for k, c in form.items()), Fraction(0)) for form in row]
        for row in rows
    ]


def matrices(solution, values):
    """All matrices of a member of a family, by cell and label: operators, embeddings, symmetries."""
    found = {}
    for name, cell in solution.automaton.cells.items():
        for label, rows in solution.operators[name].items():
            found[name, label] = numbers_of(rows, values)
        for label, border in cell.boundary.items():
            found[name, label] = [[entry.value for entry in row] for row in border.matrix]
        for label, symmetry in cell.symmetry.items():
            size = range(cell.points)
            found[name, label] = [[int(symmetry.points[j] == i) for j in size] for i in size]
    return found


def path(automaton, table, cell, word):
    factors = []
    for label in word:
        factors.append(table[cell, label])
        cell = automaton.target(cell, label)
    return reduce(product, factors)


@pytest.mark.parametrize(
    ("name", "count"),
    [
        ("corner-cutting", 2),
        ("doo-sabin-patch", 3),
        ("catmull-clark-patch", 4),
        ("fractal-patch", 4),
        ("koch-curve", 7),
        ("takagi-curve", 3),
        ("sierpinski-triangle", 1),
        ("sierpinski-tetrahedron", 1),
        ("menger-sponge", 0),
    ],
)
def test_degrees_of_freedom(name, count):
    assert SOLUTIONS[name].degrees_of_freedom == count
    assert len(as_data(SOLUTIONS[name])["parameters"]) == count


def test_the_counts_of_the_patches_need_their_symmetries():
    """Without the symmetries that gluing twice implies, more freedom remains."""
    automaton = read("doo-sabin-patch")
    cells = dict(automaton.cells)
    for name in ("vertex", "edge"):
        symmetries = {key: replace(s, subdivision={}) for key, s in cells[name].symmetry.items()}
        cells[name] = replace(cells[name], symmetry=symmetries)
    assert solve(replace(automaton, cells=cells)).degrees_of_freedom > 3


def test_corner_cutting_has_the_matrices_of_the_design():
    a, b = Fraction(3, 17), Fraction(5, 23)
    solution = replace(SOLUTIONS["corner-cutting"], automaton=replace(read("corner-cutting"), values={}))
    numbers = solution.with_values({"edge.0[1,0]": a, "edge.0[0,1]": b}).numbers()
    assert numbers["edge"]["0"] == ((1 - a, b, 0), (a, 1 - b, 1 - a), (0, 0, a))
    assert numbers["edge"]["1"] == ((b, 0, 0), (1 - b, 1 - a, b), (0, a, 1 - b))
    assert numbers["vertex"]["s"] == ((1 - a, b), (a, 1 - b))
    assert as_data(solution)["matrices"]["edge"]["0"] == [
        ["1 - a", "b", "0"],
        ["a", "1 - b", "1 - a"],
        ["0", "0", "a"],
    ]


FRACTIONS = st.fractions(-2, 2, max_denominator=12)


@pytest.mark.parametrize("name", [name for name in builtin_names() if name != "menger-sponge"])
@settings(max_examples=2, deadline=None)
@given(data=st.data())
def test_every_member_satisfies_every_equation(name, data):
    solution = SOLUTIONS[name]
    count = solution.degrees_of_freedom
    table = matrices(solution, data.draw(st.lists(FRACTIONS, min_size=count, max_size=count)))
    for cell in solution.automaton.cells.values():
        for label in cell.subdivision:
            assert all(sum(column) == 1 for column in zip(*table[cell.name, label], strict=True))
        for equation in (*cell.equations, *cell.symmetry_equations()):
            left, right = (
                path(solution.automaton, table, cell.name, word) for word in (equation.left, equation.right)
            )
            assert left == right, equation.text


@pytest.mark.parametrize("name", builtin_names())
def test_a_parameter_is_the_entry_that_it_is_named_after(name):
    solution = SOLUTIONS[name]
    for i, parameter in enumerate(solution.parameters):
        entry = parameter.entry
        assert solution.operators[entry.cell][entry.label][entry.row][entry.column] == {i: Fraction(1)}
        assert solution.form(str(entry)) == solution.form(parameter.name)


@pytest.mark.parametrize("name", ["corner-cutting", "doo-sabin-patch", "koch-curve"])
def test_an_implied_equation_changes_nothing(name):
    automaton = read(name)
    shape = automaton.cells[automaton.shape]
    swapped = tuple(Equation(e.right, e.left, e.text) for e in shape.adjacency)
    cells = {**automaton.cells, shape.name: replace(shape, adjacency=shape.adjacency + swapped + swapped)}
    again = solve(replace(automaton, cells=cells))
    assert again.operators == SOLUTIONS[name].operators
    assert again.parameters == SOLUTIONS[name].parameters


@pytest.mark.parametrize("name", builtin_names())
def test_the_text_of_a_matrix_reads_back(name):
    solution = SOLUTIONS[name]
    names = [p.name for p in solution.parameters]
    values = {text: Fraction(i + 2, 7) for i, text in enumerate(names)}
    for cell, table in as_data(solution)["matrices"].items():
        for label, rows in table.items():
            found = [[evaluate(parse(text), values) for text in row] for row in rows]
            assert found == numbers_of(solution.operators[cell][label], list(values.values()))


@settings(max_examples=50)
@given(st.dictionaries(st.integers(-1, 3), st.fractions(max_denominator=9).filter(bool), max_size=4))
def test_a_form_reads_back_whatever_its_names(form):
    names = ["a", "e1", "E2x", "_9"]
    values = {name: Fraction(i + 1, 5) for i, name in enumerate(names)}
    expected = sum(c * (1 if k == CONSTANT else values[names[k]]) for k, c in form.items())
    assert evaluate(parse(expression(form, names)), values) == expected


def test_the_text_names_the_parameters_and_what_the_file_sets():
    text = as_text(SOLUTIONS["corner-cutting"])
    assert "Corner cutting: 2 degrees of freedom" in text
    assert "a = edge.0[1,0]    (the file sets 1/4)" in text
    assert "[ 1 - a      b      0 ]" in text


# Values and names.


def test_numbers_need_a_value_for_every_parameter():
    with pytest.raises(Undetermined) as caught:
        solve(parse_text(EDGE)).numbers()
    assert caught.value.parameters == ("a (edge.0[0,1])",)


def test_values_by_name_and_by_entry_agree():
    family = solve(parse_text(EDGE))
    by_name = family.with_values({"a": Fraction(2, 7)})
    assert by_name.degrees_of_freedom == 0
    assert by_name.numbers() == family.with_values({"edge.0[0,1]": Fraction(2, 7)}).numbers()
    assert by_name.numbers() == family.with_values({"edge.1[1, 0]": Fraction(5, 7)}).numbers()
    assert by_name.with_values({"edge.0[1,1]": Fraction(5, 7)}).numbers() == by_name.numbers()


def test_a_value_that_ties_two_parameters_leaves_one():
    family = replace(SOLUTIONS["corner-cutting"], automaton=replace(read("corner-cutting"), values={}))
    tied = family.with_values({"edge.0[0,0]": Fraction(2, 3)})
    assert [p.name for p in tied.free] == ["b"]
    assert tied.with_values({"b": Fraction(1, 4)}).numbers()["edge"]["0"][0] == (
        Fraction(2, 3),
        Fraction(1, 4),
        0,
    )


@pytest.mark.parametrize(
    ("key", "fragment"),
    [
        ("c", "neither a parameter nor an entry"),
        ("egde.0[0,0]", "no cell 'egde'; did you mean 'edge'"),
        ("edge.2[0,0]", "no sub-cell '2'"),
        ("edge.0[2,0]", "2 by 2"),
        ("edge.0[0,99999999999]", "neither a parameter nor an entry"),
        ("edge.0[0]", "neither a parameter nor an entry"),
    ],
)
def test_values_for_what_is_not_there(key, fragment):
    with pytest.raises(WrongValue, match=fragment):
        solve(parse_text(EDGE)).with_values({key: Fraction(1)})


def test_values_that_are_impossible():
    family = solve(parse_text(EDGE))
    with pytest.raises(WrongValue, match=r"edge.0\[0,0\] = 2 is impossible: it is 1 in every solution"):
        family.with_values({"edge.0[0,0]": Fraction(2)})
    with pytest.raises(WrongValue, match="it is 1/4 by the other values"):
        family.with_values({"a": Fraction(1, 4), "edge.1[0,0]": Fraction(1, 3)})
    with pytest.raises(WrongValue, match="it is 1/4 by the other values"):
        family.with_values({"a": Fraction(1, 4)}).with_values({"a": Fraction(1, 3)})


def test_names_that_the_file_gives():
    family = solve(parse_text(EDGE + '[names]\nw = "edge.0[0, 1]"\n'))
    assert [p.name for p in family.parameters] == ["w"]
    with pytest.raises(WrongValue, match="is no free entry; the free ones are edge"):
        solve(parse_text(EDGE + '[names]\nw = "edge.0[0,0]"\n'))


def test_given_names_do_not_collide_with_those_that_are_made():
    text = EDGE.replace("incidence", "#").replace("adjacency", "#") + '[names]\nb = "edge.0[0,1]"\n'
    names = [p.name for p in solve(parse_text(text)).parameters]
    assert names == ["a", "b", "c", "d"]


def test_many_parameters_are_numbered():
    text = EDGE.split("boundary")[0].replace("points = 2", "points = 6")
    names = [p.name for p in solve(parse_text(text)).parameters]
    assert names == [f"p{i}" for i in range(1, 61)]


# Given matrices.


def test_a_matrix_given_in_part_and_whole():
    part = solve(parse_text(EDGE + 'matrices = { 0 = [["*", "1/3"], ["*", "*"]] }\n'))
    assert part.degrees_of_freedom == 0
    assert part.numbers()["edge"]["1"] == ((Fraction(1, 3), 0), (Fraction(2, 3), 1))
    whole = solve(parse_text(EDGE + 'matrices = { 0 = [[1, "1-2/3"], [0, "(1/3)2"]] }\n'))
    assert whole.operators == part.operators


def test_powers_in_a_given_matrix_count():
    family = solve(parse_text(EDGE + 'matrices = { 0 = [["*", "(1/3)^2"], ["*", "*"]] }\n'))
    assert family.numbers()["edge"]["0"][0][1] == Fraction(1, 9)


TWO_STEPS = EDGE.replace('"0 right = 1 left"', '"0 right = 1 left", "0 1 left = 1 0 left"')


def test_paths_through_two_unknown_operators_are_not_linear():
    with pytest.raises(NotLinear) as caught:
        solve(parse_text(TWO_STEPS))
    assert caught.value.equations == ("edge: 0 1 left = 1 0 left",)


def test_paths_through_one_unknown_and_one_given_operator_are_linear():
    given_1 = 'matrices = { 1 = [["1/2", 0], ["1/2", 1]] }\n'
    text = EDGE.replace('adjacency = ["0 right = 1 left"]', 'adjacency = ["0 1 left = 0 right"]') + given_1
    family = solve(parse_text(text))
    left, right = family.operators["edge"]["0"][0]
    assert left == {CONSTANT: 1} == right


# Contradictions.

CONTRADICTIONS = {
    "two values for one joint": (
        EDGE + 'matrices = { 0 = [["*", "1/3"], ["*", "*"]], 1 = [["1/2", "*"], ["*", "*"]] }\n',
        {"edge: the matrix given for 0", "edge: the matrix given for 1", "edge: 0 right = 1 left"},
    ),
    "an end that moves": (
        EDGE + 'matrices = { 0 = [["1/2", "*"], ["*", "*"]] }\n',
        {"edge: the matrix given for 0", "edge: left s = 0 left", "vertex: the columns of s sum to 1"},
    ),
    "disjoint ends of one piece": (
        EDGE.replace('"right s = 1 right"', '"right s = 0 left"'),
        {"edge: left s = 0 left", "edge: right s = 0 left", "vertex: the columns of s sum to 1"},
    ),
}


@pytest.mark.parametrize("name", CONTRADICTIONS)
def test_contradictions_are_named_without_a_word_too_many(name):
    text, expected = CONTRADICTIONS[name]
    with pytest.raises(Contradiction) as caught:
        solve(parse_text(text))
    assert set(caught.value.equations) == expected
    assert caught.value.residual != 0
    assert all(equation in str(caught.value) for equation in expected)


def consistent(automaton, texts):
    """Whether the constraints of the given texts have a solution together."""
    table = unknowns(automaton)
    chosen = [constraint for constraint in constraints(automaton, table)[0] if constraint.text in texts]
    assert {constraint.text for constraint in chosen} == set(texts)
    try:
        LinearSystem(len(table.entries)).require(form for constraint in chosen for form in constraint.forms)
    except Inconsistent:
        return False
    return True


def test_a_contradiction_in_a_patch_is_irreducible():
    automaton = read("doo-sabin-patch")
    face = automaton.cells["face"]
    wrong = [
        Equation(("0", "left"), ("1", "right", "flip"), "0 left = 1 right flip"),
        Equation(("0", "bottom"), ("2", "top", "flip"), "0 bottom = 2 top flip"),
    ]
    cells = {**automaton.cells, "face": replace(face, adjacency=(*face.adjacency, *wrong))}
    automaton = replace(automaton, cells=cells)
    with pytest.raises(Contradiction) as caught:
        solve(automaton)
    texts = caught.value.equations
    assert not consistent(automaton, texts)
    assert all(consistent(automaton, texts[:i] + texts[i + 1 :]) for i in range(len(texts)))
