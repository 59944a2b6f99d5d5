"""Values from the command line: reading them, and setting them over those of a file."""

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

import automata
import subdivision
from bcifs.values import parse_settings, spread
from subdivision import WrongValue, overridden


def test_several_values_after_one_set():
    given_ = ["print", "f.toml", "--set", "a=1", "b=2", "-o", "x=y.3mf", "--set=c=3", "d=4"]
    assert spread(given_) == [
        *("print", "f.toml", "--set", "a=1", "--set", "b=2", "-o", "x=y.3mf"),
        *("--set=c=3", "--set", "d=4"),
    ]


def test_nothing_after_two_dashes_is_a_value():
    assert spread(["solve", "--set", "a=1", "--", "b=2"]) == ["solve", "--set", "a=1", "--", "b=2"]


@given(st.fractions())
def test_every_fraction_is_read_exactly(value):
    assert parse_settings([f"a={value}"]) == {"a": value}


@pytest.mark.parametrize("text", ["a", "a=", "=1", "a=1/0", "a=b", "a=__import__('os')", "a=1=2"])
def test_a_text_that_is_no_value(text):
    with pytest.raises(WrongValue, match="--set"):
        parse_settings([text])


def test_a_name_set_twice():
    with pytest.raises(WrongValue, match="twice"):
        parse_settings(["a=1", "a=2"])


def test_new_values_go_over_those_of_the_file_through_any_entry():
    file = automata.read("corner-cutting")
    chosen = subdivision.solve(overridden(file, {"edge.1[2,2]": Fraction(5, 8)})).numbers()
    assert chosen["edge"]["0"][1][0] == Fraction(1, 4)  # what the file says, where it still can
    assert chosen["edge"]["0"][0][1] == Fraction(3, 8)


def test_values_that_exclude_each_other():
    with pytest.raises(WrongValue, match="other values"):
        overridden(automata.read("corner-cutting"), {"a": Fraction(1, 2), "edge.0[0,0]": Fraction(1, 3)})


def test_near_takes_several_values_like_set():
    given_ = [
        "choose",
        "f.toml",
        "--near",
        "a=1",
        "b=2",
        "--json",
        "--set",
        "c=3",
        "d=4",
        "--near=e=5",
        "f=6",
    ]
    assert spread(given_) == [
        *("choose", "f.toml", "--near", "a=1", "--near", "b=2", "--json"),
        *("--set", "c=3", "--set", "d=4", "--near=e=5", "--near", "f=6"),
    ]
