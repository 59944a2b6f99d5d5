"""The engine against a plain evaluator, B-splines and closed forms."""

from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BSpline

import ifs
from automata import AutomatonError, builtin_names, parse_text, read
from subdivision import Undetermined, WrongValue, solve

SHAPES = {name: ifs.shape(name) for name in builtin_names()}
PATCHES = ("doo-sabin-patch", "catmull-clark-patch", "fractal-patch")


@cache
def exact_operators(name):
    """The operators of every cell, by cell and label, from the exact solution."""
    automaton = read(name)
    numbers = solve(automaton).numbers()
    return {
        cell: [(target, np.array(numbers[cell][label], dtype=float)) for label, target in table.items()]
        for cell, table in ((c.name, c.subdivision) for c in automaton.cells.values())
    }


def plain_pieces(name, control, depth):
    """The control points of all pieces by their cell, one piece and one operator at a time."""
    operators = exact_operators(name)
    pieces = {read(name).shape: [control.T]}
    for _ in range(depth):
        smaller = {}
        for cell, found in pieces.items():
            for target, operator in operators[cell]:
                smaller.setdefault(target, []).extend(piece @ operator for piece in found)
        pieces = smaller
    return {cell: np.array([piece.T for piece in found]) for cell, found in pieces.items()}


def one_cell(name):
    shape = read(name).shape
    return set(read(name).cells[shape].subdivision.values()) == {shape}


@pytest.mark.parametrize("name", builtin_names())
@pytest.mark.parametrize("depth", [0, 1, 2])
def test_pieces_are_those_of_the_plain_evaluator(name, depth):
    shape = SHAPES[name]
    control = np.random.default_rng(depth).normal(size=(len(shape.control), 3))
    found = ifs.refined(ifs.initial(shape.topology, shape.system, control), depth)
    expected = plain_pieces(name, control, depth)
    assert found.control.keys() == expected.keys()
    for cell, pieces in expected.items():
        np.testing.assert_allclose(found.control[cell], pieces, rtol=0, atol=1e-13)


@pytest.mark.parametrize("name", [n for n in builtin_names() if n != "menger-sponge" and one_cell(n)])
def test_each_piece_finds_its_own_limit_points_at_the_shared_vertices(name):
    """What one piece puts at a vertex is what its neighbours put there."""
    shape, depth = SHAPES[name], 3 if len(SHAPES[name].control) < 9 else 2
    mesh = ifs.draw(ifs.refined(ifs.initial(shape.topology, shape.system, shape.control), depth))
    first = ifs.draw(ifs.initial(shape.topology, shape.system, np.eye(len(shape.control))))
    corner_points = first.vertices[first.faces[0]]
    pieces = plain_pieces(name, shape.control, depth)[shape.automaton.shape]
    if len(first.faces) == 1:
        expected = np.einsum("kj,cjd->ckd", corner_points, pieces)
        np.testing.assert_allclose(mesh.vertices[mesh.faces], expected, rtol=0, atol=1e-10)
    else:
        corners = np.einsum("kj,cjd->ckd", first.vertices, pieces)
        found = mesh.vertices[mesh.faces].reshape(len(first.faces), len(pieces), -1, shape.control.shape[1])
        for face, corner in zip(found, first.faces, strict=True):
            np.testing.assert_allclose(face, corners[:, corner], rtol=0, atol=1e-10)


def basis(degree, parameters):
    """Values of the uniform B-splines on whole knots, a row each parameter."""
    knots = np.arange(2.0 * (degree + 1))
    inside = np.clip(parameters, degree, degree + 1)
    np.testing.assert_allclose(inside, parameters, rtol=0, atol=1e-12)
    return np.array(
        [BSpline.basis_element(knots[i : i + degree + 2], False)(inside) for i in range(degree + 1)]
    ).T


def greville(degree):
    """The control heights of the function t -> t."""
    return np.array([np.mean(np.arange(i + 1, i + degree + 1)) for i in range(degree + 1)])


def with_control(shape, control):
    return ifs.Shape(shape.name, shape.topology, shape.system, control)


CONTROL = st.integers(0, 2**32 - 1).map(np.random.default_rng)


@settings(max_examples=8, deadline=None)
@given(CONTROL, st.integers(0, 7))
def test_corner_cutting_at_a_quarter_is_the_quadratic_b_spline(random, depth):
    shape, control = SHAPES["corner-cutting"], random.uniform(-1, 1, (3, 2))
    mesh = ifs.mesh(with_control(shape, control), depth)
    (parameters,) = ifs.mesh(with_control(shape, greville(2)[:, None]), depth).vertices.T
    assert len(parameters) == 2**depth + 1
    np.testing.assert_allclose(np.sort(parameters), np.linspace(2, 3, 2**depth + 1), rtol=0, atol=1e-12)
    np.testing.assert_allclose(mesh.vertices, basis(2, parameters) @ control, rtol=0, atol=1e-12)


@pytest.mark.parametrize(("name", "degree"), [("doo-sabin-patch", 2), ("catmull-clark-patch", 3)])
@settings(max_examples=5, deadline=None)
@given(random=CONTROL, depth=st.integers(0, 4))
def test_classical_patches_are_tensor_product_b_splines(name, degree, random, depth):
    shape, size = SHAPES[name], degree + 1
    control = random.uniform(-1, 1, (size * size, 3))
    mesh = ifs.mesh(with_control(shape, control), depth)
    heights = np.stack(np.meshgrid(greville(degree), greville(degree)), axis=-1).reshape(-1, 2)
    u, v = ifs.mesh(with_control(shape, heights), depth).vertices.T
    assert len(u) == (2**depth + 1) ** 2
    grid = control.reshape(size, size, 3)
    expected = np.einsum("pi,pj,ijd->pd", basis(degree, v), basis(degree, u), grid)
    np.testing.assert_allclose(mesh.vertices, expected, rtol=0, atol=1e-12)


@given(st.fractions("1/20", "9/20", max_denominator=40), st.fractions("1/20", "9/20", max_denominator=40))
@settings(max_examples=6, deadline=None)
def test_corner_cutting_keeps_affine_maps(a, b):
    """A map of the control points maps the curve, for all members of the family."""
    shape = ifs.shape("corner-cutting", {"a": a, "b": b})
    linear, shift = np.array([[2.0, -1.0], [0.5, 3.0]]), np.array([7.0, -5.0])
    mapped = ifs.mesh(with_control(shape, shape.control @ linear.T + shift), 5)
    mesh = ifs.mesh(shape, 5)
    np.testing.assert_allclose(mapped.vertices, mesh.vertices @ linear.T + shift, rtol=0, atol=1e-10)


def test_the_takagi_curve_is_the_sum_of_its_triangle_waves():
    x, y = ifs.mesh(SHAPES["takagi-curve"], 6).vertices.T / 80
    waves = [abs(2**n * x - np.round(2**n * x)) / 2**n for n in range(7)]
    np.testing.assert_allclose(y, sum(waves), rtol=0, atol=1e-14)
    assert len(x) == 65


def test_the_segments_of_the_koch_curve_shrink_by_three():
    mesh = ifs.mesh(SHAPES["koch-curve"], 4)
    ends = mesh.vertices[mesh.faces]
    lengths = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)
    np.testing.assert_allclose(lengths, 90 / 3**4, rtol=1e-12)


# Shapes.


def test_values_go_over_those_of_the_file():
    shape = ifs.shape("corner-cutting", {"a": Fraction(1, 3)})
    first = shape.system.states["edge"].operators[0]
    np.testing.assert_allclose(first[:, 0], [2 / 3, 1 / 3, 0])
    np.testing.assert_allclose(first[0, 1], 1 / 4)
    assert shape.automaton.values["a"] == Fraction(1, 3)
    assert "edge.0[1,0]" not in shape.automaton.values
    with pytest.raises(WrongValue, match="in every solution"):
        ifs.shape("corner-cutting", {"edge.0[2,0]": Fraction(1)})


def test_a_shape_needs_all_its_numbers():
    text = 'format = "bcifs/1"\nshape = "dust"\n[cells.dust]\npoints = 2\nsubdivision = { 0 = "dust" }\n'
    with pytest.raises(AutomatonError, match="no control points"):
        ifs.shape(parse_text(text + '[set]\na = "1/2"\nb = "1/2"\n'))
    with pytest.raises(Undetermined, match="2 parameters without a value"):
        ifs.shape(parse_text(text), control=np.zeros((2, 1)))


@pytest.mark.parametrize(
    ("control", "fragment"),
    [
        (np.zeros((2, 2)), "expected 3 control points"),
        (np.array([[0.0], [np.nan], [1.0]]), "control point 1 is not finite"),
    ],
)
def test_wrong_control_points_are_refused(control, fragment):
    with pytest.raises(ValueError, match=fragment):
        ifs.shape("corner-cutting", control=control)


def test_a_scaled_shape_has_a_scaled_mesh():
    shape = SHAPES["doo-sabin-patch"]
    scaled, mesh = ifs.mesh(shape.scaled(2.5), 2), ifs.mesh(shape, 2)
    np.testing.assert_allclose(scaled.vertices, 2.5 * mesh.vertices)
    assert (scaled.faces == mesh.faces).all()


def test_control_points_are_not_the_callers():
    control = np.zeros((3, 2))
    shape = ifs.shape("corner-cutting", control=control)
    control[0] = 9
    assert (shape.control == 0).all()
    with pytest.raises(ValueError, match="read-only"):
        shape.control[0] = 1
