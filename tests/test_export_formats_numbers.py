"""Decimal numbers in text against Python's own."""

import math
import re
import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from export.formats.decimal_kernels import real


def bits(number: float) -> bytes:
    return struct.pack("<d", number)


def read(text: str) -> tuple[float, int]:
    return real(np.frombuffer(text.encode(), np.uint8), 0)


@settings(deadline=None, max_examples=250)
@given(st.one_of(
    st.floats(allow_nan=False, allow_infinity=False).map(repr),
    st.floats(-1e6, 1e6).map("{:.25f}".format),
    st.from_regex(r"[+-]?[0-9]{0,25}(\.[0-9]{0,25})?([eE][+-]?[0-9]{1,3})?", fullmatch=True),
    st.tuples(st.integers(2**53, 2**64), st.integers(-40, 40)).map("{0[0]}e{0[1]}".format),
))  # fmt: skip
def test_numbers_are_those_of_python_or_left_to_it(text) -> None:
    value, end = read(text)
    if not re.search("[0-9]", text.lower().split("e")[0]):
        assert math.isnan(value)
    elif value == value:
        assert end == len(text)
        assert bits(value) == bits(float(text))


@settings(deadline=None, max_examples=300)
@given(st.floats(1e-30, 1e30), st.booleans())
def test_numbers_of_17_digits_are_decided(size, minus) -> None:
    number = -size if minus else size
    assert bits(read(repr(number))[0]) == bits(number)
    assert bits(read(f"{number:.16e}")[0]) == bits(number)


def test_halves_between_two_numbers() -> None:
    for whole in range(2**54 + 2, 2**54 + 42, 4):  # between two neighbours
        for text in (f"{whole}.0000001", f"{whole}", f"{whole - 1}.9999999"):
            value, _ = read(text)
            assert math.isnan(value) or value == float(text)
    assert math.isnan(read(f"{2**54 + 2}")[0])
    assert read(f"{2**54 + 3}")[0] == 2**54 + 4
    assert read(f"{2**54 + 1}")[0] == 2**54


@pytest.mark.parametrize("text", ["", "-", ".", "e5", "1e", "1e+", "+-1", "x", "nan"])
def test_what_is_no_number(text) -> None:
    assert math.isnan(read(text)[0])
