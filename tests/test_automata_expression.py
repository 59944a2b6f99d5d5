"""The grammar of expressions against Python's fractions."""

from fractions import Fraction

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from automata.expression import ExpressionError, Name, Number, evaluate, names, number, parse

VALUES = {"a": Fraction(2, 3), "b": Fraction(-5, 7), "u_1": Fraction(11)}


def written(children):
    """A text of the grammar, and the same in Python with fractions."""
    binary = st.tuples(children, st.sampled_from("+-*/"), children)
    power = st.tuples(children, st.integers(-2, 3))
    implicit = st.tuples(st.integers(0, 9), children)
    return (
        binary.map(lambda t: (f"({t[0][0]} {t[1]} {t[2][0]})", f"({t[0][1]} {t[1]} {t[2][1]})"))
        | power.map(lambda t: (f"({t[0][0]})^{t[1]}", f"(({t[0][1]}) ** ({t[1]}))"))
        | implicit.map(lambda t: (f"({t[0]}({t[1][0]}))", f"(Fraction({t[0]}) * {t[1][1]})"))
        | children.map(lambda t: (f"( -{t[0]})", f"(-{t[1]})"))
    )


LEAVES = (
    st.integers(0, 99).map(lambda n: (str(n), f"Fraction({n})"))
    | st.tuples(st.integers(0, 99), st.integers(0, 99)).map(lambda t: (f"{t[0]}.{t[1]}",) * 2)
    | st.sampled_from(sorted(VALUES)).map(lambda name: (name, name))
).map(lambda t: (t[0], f"Fraction('{t[1]}')" if t[1][0].isdigit() else t[1]))

TEXTS = st.recursive(LEAVES, written, max_leaves=12)


@given(TEXTS)
def test_expressions_have_the_value_that_fractions_give(pair):
    text, python = pair
    assume(len(text) <= 400)
    try:
        expected = eval(python, {"Fraction": Fraction, **VALUES})
    except ZeroDivisionError:
        with pytest.raises((ExpressionError, ZeroDivisionError)):
            evaluate(parse(text), VALUES)
        return
    assert evaluate(parse(text), VALUES) == expected
    assert names(parse(text)) == {name for name in VALUES if name in text}


@given(st.text(alphabet="0123456789abu_ .+-*/^(),eE²é\n\0", max_size=30) | st.text(max_size=30))
def test_any_text_is_an_expression_or_an_expression_error(text):
    position = 0
    try:
        parse(text)
    except ExpressionError as error:
        position = error.position
    assert 0 <= position <= len(text)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1/2*3", Fraction(3, 2)),
        ("1/2(3)", Fraction(3, 2)),
        ("2-3-4", -5),
        ("-2^2", -4),
        ("2^-2", Fraction(1, 4)),
        ("(1/2)^3", Fraction(1, 8)),
        (" .5e1 ", 5),
        ("1.e-2", Fraction(1, 100)),
        ("2(3)(4)", 24),
    ],
)
def test_precedence(text, value):
    assert number(text) == value
    assert parse(text) == Number(Fraction(value))


def test_the_example_of_the_design():
    expression = parse("(u+2v)/(2(u+v))")
    assert evaluate(expression, {"u": Fraction(3), "v": Fraction(5)}) == Fraction(13, 16)


def test_a_name_before_parentheses_of_names_is_one_unknown():
    assert parse("a( u ,v)") == Name("a(u,v)")
    assert names(parse("u(v+1)")) == {"u", "v"}


@pytest.mark.parametrize(
    ("text", "position", "fragment"),
    [
        ("", 0, "the end"),
        ("1 + ", 4, "the end"),
        ("1 + * 2", 4, "'*'"),
        ("(1 + 2", 6, "')'"),
        ("1 + 2)", 5, "')'"),
        ("2 ^ a", 4, "whole number"),
        ("2^13", 2, "powers go up to 12"),
        ("2^1.5", 2, "whole number"),
        ("1 - 3/0", 5, "zero"),
        ("1 / (2 - 2)", 2, "zero"),
        ("0^-1", 1, "zero"),
        ("3 $ 4", 2, "'$'"),
        ("²", 0, "'²'"),
        ("2^²", 2, "'²'"),
        ("1 + é", 4, "'é'"),
        ("1\u00a02", 1, "found"),
        ("9^9^9", 3, "'^'"),
        ("(((9^12)^12)^12)^12", 12, "too large"),
        ("1e999", 0, "too large"),
        ("1e99999", 0, "digits"),
        ("7" * 61, 0, "digits"),
        ("+".join("1" * 300), 400, "400 characters"),
        ("(" * 60 + "1" + ")" * 60, 40, "deep"),
    ],
)
def test_faults_have_their_position(text, position, fragment):
    with pytest.raises(ExpressionError) as caught:
        parse(text)
    assert caught.value.position == position
    assert fragment in str(caught.value)


def test_a_number_has_no_names():
    with pytest.raises(ExpressionError, match="'b'"):
        number("1 + b")
