"""Curve schemes: every automaton is consistent, solved, and draws the curve of its closed form."""

from fractions import Fraction
from itertools import pairwise
from math import comb, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BSpline

import ifs
import subdivision
from automata.consistency import require_consistency
from subdivision.schemes import (
    b_spline,
    bezier,
    cesaro,
    chain,
    corner_cutting,
    de_rham,
    hilbert,
    interpolation,
    koch,
    nonuniform,
    nonuniform_b_spline,
    takagi,
)

THIRD = Fraction(1, 3)
FREEDOM = [
    *((bezier(d), d * (d - 1) + d // 2) for d in (1, 2, 3, 4, 7)),
    *((b_spline(d), d // 2) for d in (1, 2, 3, 4, 7)),
    (corner_cutting(0.2, 0.3), 2),
    (de_rham(THIRD), 1),
    (takagi(THIRD), 3),
    (koch(), 7),
    (cesaro(85), 7),
    (hilbert(), 16),
    (nonuniform_b_spline(2, [1, 1, 1]), 2),
    (nonuniform_b_spline(2, [1, 2, 4]), 4),
    (nonuniform_b_spline(2, [2, 3, 5]), 6),
    (nonuniform_b_spline(3, [1, 1, 1, 1, 1]), 3),
    *((interpolation([(i * i, i % 2) for i in range(n + 1)], [0.3] * n), n * (n * n - 1)) for n in (2, 3, 4)),
]


def walked(mesh: ifs.Mesh) -> np.ndarray:
    """The vertices along a curve that is one path, or one ring from the start of its first piece."""
    following = dict(mesh.faces.tolist())
    assert len(following) == len(mesh.faces) == len(set(following.values()))
    starts = set(following) - set(following.values())
    walk = [starts.pop() if starts else int(mesh.faces[0][0])]
    while len(walk) < len(mesh.vertices):
        walk.append(following[walk[-1]])
    assert not starts
    assert len(set(walk)) == len(mesh.vertices)
    return mesh.vertices[walk]


def drawn(segments, control: np.ndarray, depth: int) -> ifs.Mesh:
    shape = ifs.shape(segments.automaton)
    return ifs.draw(
        ifs.refined(ifs.patchwork(shape.topology, shape.system, control, segments.patches), depth)
    )


def assert_close(found: np.ndarray, expected: np.ndarray, size: float = 1.0) -> None:
    assert found.shape == expected.shape
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * size)


def nearest_first(vertices: np.ndarray, first: np.ndarray) -> np.ndarray:
    """A ring turned so that it begins with the vertex nearest to a point."""
    return np.roll(vertices, -int(np.linalg.norm(vertices - first, axis=1).argmin()), axis=0)


@pytest.mark.parametrize(("automaton", "freedom"), FREEDOM, ids=lambda x: getattr(x, "name", ""))
def test_every_scheme_is_consistent_and_has_the_stated_degrees_of_freedom(automaton, freedom):
    require_consistency(automaton)
    solution = subdivision.solve(automaton)
    assert solution.degrees_of_freedom == freedom
    for table in solution.numbers().values():
        for rows in table.values():
            assert {sum(column) for column in zip(*rows, strict=True)} == {1}


@pytest.mark.parametrize("degree", [1, 2, 3, 8])
def test_bezier_curves_are_bernsteins(degree):
    control = np.random.default_rng(degree).normal(size=(degree + 1, 3))
    t = np.arange(9) / 8
    weights = np.stack([comb(degree, i) * t**i * (1 - t) ** (degree - i) for i in range(degree + 1)], axis=1)
    assert_close(walked(ifs.mesh(ifs.shape(bezier(degree), control=control), 3)), weights @ control)


@pytest.mark.parametrize(("degree", "closed"), [(1, False), (2, True), (3, False), (6, True)])
def test_uniform_splines_of_many_segments(degree, closed):
    count = degree + 4
    control = np.random.default_rng(degree).normal(size=(count, 2))
    found = walked(drawn(chain(b_spline(degree), count, closed), control, 2))
    wrapped = np.concatenate([control, control[:degree]]) if closed else control
    spline = BSpline(np.arange(len(wrapped) + degree + 1.0) - degree, wrapped, degree)
    t = np.arange(4 * (len(wrapped) - degree) + (not closed)) / 4
    assert_close(nearest_first(found, spline(0.0)) if closed else found, spline(t))


def test_bezier_segments_share_their_ends():
    control = np.random.default_rng(5).normal(size=(9, 2))
    found = walked(drawn(chain(bezier(3), 9, closed=True), control, 2))
    assert len(found) == 12
    for i in (0, 3, 6):
        assert np.abs(found - control[i]).sum(axis=1).min() < 1e-12


def test_corner_cutting_takes_its_points_from_the_segments():
    solved = subdivision.solve(corner_cutting(Fraction(1, 5), Fraction(2, 7))).numbers()["edge"]
    assert [row[0] for row in solved["0"]] == [Fraction(4, 5), Fraction(1, 5), 0]
    assert [row[1] for row in solved["0"]] == [Fraction(2, 7), Fraction(5, 7), 0]
    assert subdivision.solve(de_rham(Fraction(1, 4))).numbers() == subdivision.solve(b_spline(2)).numbers()


@pytest.mark.parametrize("w", [Fraction(1, 2), Fraction(2, 3), Fraction(1, 4)])
def test_takagi_is_the_sum_of_its_sawteeth(w):
    shape = ifs.shape(takagi(w), control=np.array([[0, 0], [0.5, 0.5], [1, 0]]))
    found = walked(ifs.mesh(shape, 5))
    x = np.arange(33) / 32
    y = sum(float(w) ** n * np.abs(2**n * x - np.round(2**n * x)) for n in range(6))
    assert_close(found, np.stack([x, y], axis=1))
    if w == Fraction(1, 4):
        assert_close(found[:, 1], 2 * x * (1 - x))


@pytest.mark.parametrize(("automaton", "degrees"), [(koch(), 60), (cesaro(60), 60), (cesaro(85), 85)])
def test_cesaros_pieces_are_equally_long_and_turn_by_the_angle(automaton, degrees):
    found = walked(ifs.mesh(ifs.shape(automaton), 3)) @ (1, 1j) / 90
    angle = np.radians(degrees)
    turns = [0, angle, -angle, 0]
    steps = np.array([1])
    for _ in range(3):
        steps = np.concatenate([steps * np.exp(1j * turn) / (2 + 2 * np.cos(angle)) for turn in turns])
    assert_close(np.diff(found), steps)


def test_koch_is_the_built_in_one():
    assert (
        subdivision.solve(koch()).numbers() == subdivision.solve(ifs.shape("koch-curve").automaton).numbers()
    )


def test_hilbert_visits_every_cell_of_the_grid_once_in_steps_to_neighbours():
    depth = 4
    shape = ifs.shape(hilbert(), control=np.array([[0.0, 0], [0, 1], [1, 1], [1, 0]]))
    complex_ = ifs.refined(ifs.initial(shape.topology, shape.system, shape.control), depth)
    centres = np.asarray(complex_.control["edge"]).mean(axis=1) * 2**depth
    assert len(np.unique(np.round(centres - 0.5, 9), axis=0)) == 4**depth
    mesh = ifs.draw(complex_)
    order = {(a, b): i for i, (a, b) in enumerate(mesh.faces.tolist())}
    following = {a: (a, b) for a, b in order}
    walk = [following[int(mesh.faces[0][0])]]
    while walk[-1][1] in following:
        walk.append(following[walk[-1][1]])
    steps = np.diff(centres[[order[edge] for edge in walk]], axis=0)
    assert len(walk) == 4**depth
    assert_close(np.abs(steps).sum(axis=1), np.ones(4**depth - 1))


def test_interpolation_goes_through_its_points_and_solves_the_functional_equation():
    points = np.array([[0, 0], [1, 3], [4, -1], [6, 2]], dtype=float)
    scales = [0.5, -0.3, 0.2]
    found = walked(ifs.mesh(ifs.shape(interpolation(points.tolist(), scales)), 4))
    for point in points:
        assert np.abs(found - point).max(axis=1).min() < 1e-12
    chord = lambda x: points[0, 1] + (points[-1, 1] - points[0, 1]) * x / 6  # noqa: E731
    for i, d in enumerate(scales):
        piece, coarse = found[27 * i : 27 * i + 28], found[::3]
        (x0, y0), (x1, y1) = points[i : i + 2]
        t = coarse[:, 0] / 6
        whole = np.stack(
            [x0 + (x1 - x0) * t, y0 + (y1 - y0) * t + d * (coarse[:, 1] - chord(coarse[:, 0]))], axis=1
        )
        assert_close(piece, whole, 10)


def splined(degree: int, intervals, control: np.ndarray, depth: int) -> np.ndarray:
    """The open spline, by scipy, at the ends of the pieces of every positive interval of the curve."""
    inner = np.concatenate([[0.0], np.cumsum(np.array(intervals, dtype=float))])
    knots = np.concatenate([inner[:1] - 1, inner, inner[-1:] + 1])
    ends = np.unique(inner[degree - 1 : len(inner) - degree + 1])
    t = [a + (b - a) * np.arange(2**depth) / 2**depth for a, b in pairwise(ends)]
    return BSpline(knots, control, degree)(np.concatenate([*t, ends[-1:]]))


def assert_spline(degree: int, intervals, depth: int = 2) -> None:
    control = np.random.default_rng(len(intervals)).normal(size=(len(intervals) - degree + 2, 2))
    segments = nonuniform(degree, intervals)
    require_consistency(segments.automaton)
    assert segments.control_points == len(control)
    expected = splined(degree, intervals, control, depth)
    assert_close(walked(drawn(segments, control, depth)), expected, np.abs(control).max())


@pytest.mark.parametrize(("degree", "seed"), [(2, 0), (3, 1), (3, 2)])
def test_nonuniform_splines_of_random_knots(degree, seed):
    assert_spline(degree, (10 ** np.random.default_rng(seed).uniform(-1.5, 1.5, size=7)).tolist())


@settings(max_examples=4, deadline=None)
@given(st.sampled_from([2, 3]), st.lists(st.integers(1, 1000), min_size=5, max_size=6))
def test_nonuniform_splines_of_whole_numbers(degree, intervals):
    assert_spline(degree, intervals, 1)


@pytest.mark.parametrize(
    ("degree", "intervals"),
    [
        (2, [0, 1, 3, 0]),
        (2, [0, 2, 0, 3, 1, 0]),
        (3, [0, 0, 5, 0, 0]),
        (3, [0, 0, 1, 2, 7, 0, 0]),
        (3, [1, 0, 2, 3, 0, 4]),
        (3, [0, 0, 1, 0, 2, 0, 0, 3, 1, 0, 0]),
    ],
)
def test_nonuniform_splines_of_repeated_knots(degree, intervals):
    assert_spline(degree, intervals)


def test_a_knot_repeated_too_often_breaks_the_curve():
    control = np.random.default_rng(0).normal(size=(6, 2))
    mesh = drawn(nonuniform(2, [0, 1, 0, 0, 2, 0]), control, 2)
    assert len(mesh.vertices) == 10
    assert len(mesh.faces) == 8


@pytest.mark.parametrize("degree", [2, 3])
@pytest.mark.parametrize("intervals", [[1, 2, 4, 8, 3], [1, 0, 2, 3]])
def test_closed_nonuniform_splines(degree, intervals):
    n = len(intervals)
    control = np.random.default_rng(n).normal(size=(n, 2))
    found = walked(drawn(nonuniform(degree, intervals, closed=True), control, 2))
    around = [intervals[(i + 2 - degree) % n] for i in range(n + 2 * degree - 2)]
    expected = splined(degree, around, np.concatenate([control, control[:degree]]), 2)
    assert_close(expected[-1], expected[0], 1.0)
    assert_close(nearest_first(found, expected[0]), expected[:-1], np.abs(control).max())


@pytest.mark.parametrize(("degree", "kinds"), [(2, 4), (3, 8)])
def test_one_piece_needs_finitely_many_states_and_segments_share_them(degree, kinds):
    intervals = [1, 2, 4, 8, 16][: 2 * degree - 1]
    single = nonuniform_b_spline(degree, intervals)
    require_consistency(single)
    assert sum(bool(cell.boundary) for cell in single.cells.values()) == kinds
    few, many = ([1, 2] * count for count in (6, 40))
    assert set(nonuniform(degree, few).automaton.cells) == set(nonuniform(degree, many).automaton.cells)


def test_uniform_intervals_give_the_uniform_spline():
    for degree in (2, 3):
        uniform = subdivision.solve(b_spline(degree)).numbers()["edge"]
        spline = nonuniform_b_spline(degree, [7] * (2 * degree - 1))
        assert subdivision.solve(spline).numbers()[spline.shape] == uniform


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: bezier(0), "degree is 1 to"),
        (lambda: takagi(1), "-1 < w < 1"),
        (lambda: cesaro(91), "degrees"),
        (lambda: corner_cutting(float("nan"), 0.25), "a is a finite number"),
        (lambda: interpolation([(0, 0), (2, 1), (1, 1)], [0, 0]), "point 2 has 1 after 2"),
        (lambda: interpolation([(0, 0), (2, 1), (3, 1)], [0, 1]), "scale 1 is between"),
        (lambda: nonuniform_b_spline(4, [1] * 9), "degree 2 or 3"),
        (lambda: nonuniform_b_spline(3, [1] * 4), "5 or more"),
        (lambda: nonuniform_b_spline(2, [1, -1, 1]), "interval 1 is -1"),
        (lambda: nonuniform_b_spline(2, [1, 0, 1]), "positive length"),
        (lambda: chain(bezier(3), 6), "1 and a multiple of 3"),
        (lambda: chain(b_spline(2), 2, closed=True), "3 or more"),
    ],
)
def test_wrong_input_is_refused_with_its_numbers(make, words):
    with pytest.raises(ValueError, match=words):
        make()


def test_apexes_of_cesaro_stand_at_their_height():
    assert np.array(cesaro(90).control)[1] == pytest.approx([45, 45])
    assert np.array(koch().control)[1] == pytest.approx([45, 90 * sqrt(1 / 12)])
