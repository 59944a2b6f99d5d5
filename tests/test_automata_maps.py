"""Plain affine maps as barycentric operators."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from automata import AutomatonError, describe


def operator(**entries):
    """The operator of one map, and the frame that it acts on."""
    automaton = describe({"format": "bcifs/1", "maps": [entries]})
    return automaton.cells[automaton.shape].matrices["0"], automaton.control


def affine(**entries):
    """Linear part and translation read back from the operator, in exact numbers."""
    rows, _ = operator(**entries)
    columns = [[entry.value for entry in column] for column in zip(*rows, strict=True)]
    assert all(sum(column) == 1 for column in columns)
    origin, *ends = [column[1:] for column in columns]
    return [[end[i] - origin[i] for end in ends] for i in range(len(origin))], origin


NUMBERS = st.fractions(-3, 3, max_denominator=20)


ROWS = st.integers(1, 4).flatmap(
    lambda d: st.lists(st.tuples(*[NUMBERS] * d), min_size=d + 2, max_size=d + 2)
)


@settings(max_examples=25)
@given(ROWS)
def test_columns_are_the_images_of_the_frame(rows):
    *linear, factors, shift = [[str(entry) for entry in row] for row in rows]
    found, origin = affine(linear=linear, scale=factors, translation=shift)
    d = len(shift)
    assert found == [[rows[i][j] * rows[d][j] for j in range(d)] for i in range(d)]
    assert origin == list(rows[d + 1])


def test_one_scale_stands_for_all_axes():
    assert affine(scale="1/3", translation=[0, 1]) == ([[Fraction(1, 3), 0], [0, Fraction(1, 3)]], [0, 1])


@pytest.mark.parametrize(
    ("degrees", "cosine", "sine"),
    [(0, 1, 0), (90, 0, 1), (180, -1, 0), (270, 0, -1), (-90, 0, -1), (450, 0, 1), ("1800/2", -1, 0)],
)
def test_quarter_turns_are_exact(degrees, cosine, sine):
    assert affine(rotation=degrees, translation=[0, 0])[0] == [[cosine, -sine], [sine, cosine]]
    about_z = affine(rotation={"axis": [0, 0, 7], "angle": degrees}, translation=[0, 0, 0])[0]
    assert about_z == [[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]]


@settings(max_examples=40)
@given(st.integers(-720, 720))
def test_rotations_of_the_plane(degrees):
    angle = np.radians(degrees)
    expected = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    found = np.array(affine(rotation=degrees, translation=[0, 0])[0], dtype=float)
    np.testing.assert_allclose(found, expected, atol=1e-13)


@settings(max_examples=40)
@given(st.lists(st.integers(-9, 9), min_size=3, max_size=3).filter(any), st.integers(-720, 720))
def test_rotations_of_space(axis, degrees):
    found = np.array(affine(rotation={"axis": axis, "angle": degrees}, translation=[0, 0, 0])[0], dtype=float)
    unit = np.array(axis) / np.linalg.norm(axis)
    np.testing.assert_allclose(
        found, Rotation.from_rotvec(np.radians(degrees) * unit).as_matrix(), atol=1e-13
    )


def test_the_order_is_linear_then_rotation_then_scale():
    found, _ = affine(linear=[[1, 1], [0, 1]], rotation=90, scale=[2, 3], translation=[0, 0])
    expected = np.array([[1, 1], [0, 1]]) @ [[0, -1], [1, 0]] @ np.diag([2, 3])
    assert found == expected.tolist()


def test_the_frame_is_the_origin_and_the_ends_of_the_axes():
    assert operator(translation=[0, 0, 0])[1] == ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))


@pytest.mark.parametrize(
    ("entries", "fragment"),
    [
        ({"rotation": 1, "translation": [0]}, "maps of the plane or of space"),
        ({"rotation": {"axis": [0, 0, 0], "angle": 1}, "translation": [0, 0, 0]}, "not zero"),
        ({"rotation": {"axis": ["1e999", 0, 0], "angle": 1}, "translation": [0, 0, 0]}, "too large"),
        ({"translation": [0] * 7}, "1 to 6"),
    ],
)
def test_wrong_maps_are_refused(entries, fragment):
    with pytest.raises(AutomatonError, match=fragment):
        operator(**entries)


def test_an_axis_of_any_length_turns_the_same_way():
    for length in ("1e-200", "1e200"):
        found, _ = affine(rotation={"axis": [0, 0, length], "angle": 90}, translation=[0, 0, 0])
        assert found == [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
