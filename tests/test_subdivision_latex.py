"""LaTeX: read back, it is the same family."""

import re
from fractions import Fraction
from itertools import chain

import pytest
from hypothesis import given
from hypothesis import strategies as st

import automata
import subdivision
from automata.expression import Name, Number, Operation, evaluate, names, parse
from bcifs.__main__ import main
from subdivision.display import as_data
from subdivision.latex import as_latex, entry_latex

_FRACTION = re.compile(r"\\frac\{([^{}]*)\}\{([^{}]*)\}")
_POWER = re.compile(r"\{([^{}]*)\}\^\{(-?\d+)\}")


def plain(text: str) -> str:
    """LaTeX of an entry in the description's grammar again."""
    text = re.sub(r"_\{(\d+)\}", r"\1", text)
    text = re.sub(r"\\mathrm\{([A-Za-z_\\]+)\}", lambda m: m[1].replace("\\", ""), text)
    text = text.replace(r"\cdot", "*")
    while _FRACTION.search(text) or _POWER.search(text):
        text = _FRACTION.sub(r"((\1)/(\2))", text)
        text = _POWER.sub(r"((\1)^\2)", text)
    return text


def read_back(latex: str) -> list[list[list[str]]]:
    bodies = re.findall(r"\\begin\{pmatrix\}\n(.*?)\n\\end\{pmatrix\}", latex, re.S)
    return [[row.strip().split(" & ") for row in body.split(r"\\")] for body in bodies]


@pytest.mark.parametrize("name", automata.builtin_names())
def test_every_entry_of_every_family_reads_back_as_itself(name):
    solution = subdivision.solve(automata.read(name))
    matrices = [rows for table in as_data(solution)["matrices"].values() for rows in table.values()]
    found = read_back(as_latex(solution))
    assert len(found) == len(matrices) > 0
    for rows, latex in zip(matrices, found, strict=True):
        assert [len(row) for row in latex] == [len(row) for row in rows]
        for text, shown in zip(chain(*rows), chain(*latex), strict=True):
            assert_equal(text, plain(shown))


def assert_equal(text: str, other: str) -> None:
    """Equal as functions: at values of the names that no small formula takes for special."""
    left, right = parse(text), parse(other)
    assert names(left) == names(right)
    for prime in (101, 211):
        values = {name: Fraction(prime + 7 * k, 13 + k) for k, name in enumerate(sorted(names(left)))}
        assert evaluate(left, values) == evaluate(right, values), (text, other)


numbers = st.fractions(min_value=-9, max_value=9, max_denominator=12).map(Number)
leaves = st.one_of(numbers, st.sampled_from(["a", "b", "p12", "alpha", "u_v"]).map(Name))
expressions = st.recursive(
    leaves,
    lambda inner: st.builds(Operation, st.sampled_from("+-*"), inner, inner),
    max_leaves=8,
)


def written(expression) -> str:
    match expression:
        case Number(value):
            return f"({value})"
        case Name(name):
            return name
        case Operation(operator, left, right):
            return f"({written(left)} {operator} {written(right)})"
    raise AssertionError


@given(expressions)
def test_expressions_of_any_shape_read_back(expression):
    text = written(expression)
    assert_equal(text, plain(entry_latex(text)))


@pytest.mark.parametrize(
    ("text", "latex"),
    [
        ("1 - a", "1 - a"),
        ("-1/4", r"-\frac{1}{4}"),
        ("1 - 3a/2", r"1 - \frac{3 a}{2}"),
        ("(u+2v)/(2(u+v))", r"\frac{u + 2 v}{2 (u + v)}"),
        ("1 - (a - b)", "1 - (a - b)"),
        ("p12", "p_{12}"),
        ("a(u,v)", "a(u, v)"),
        ("alpha2", r"\mathrm{alpha}_{2}"),
        ("(a+b)^2", "{(a + b)}^{2}"),
    ],
)
def test_how_entries_look(text, latex):
    assert entry_latex(text) == latex


def test_the_command_writes_one_align_block(capsys):
    assert main(["solve", "corner-cutting", "--latex"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("\\begin{align*}\n")
    assert out.endswith("\\end{align*}\n")
    assert "1 - a & b & 0" in out
    assert out.count(r"\begin{pmatrix}") == out.count(r"\end{pmatrix}") == 3
    assert out.count("{") == out.count("}")
