"""Cones of directions and spirals, against sampled points and closed forms."""

import dataclasses
import math
from fractions import Fraction
from itertools import pairwise, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_fld_curves import given_curve

import fld
import ifs
from fld.curve import curve, fixed_point


def polygonal(vertices, across):
    """A curve over a polygon: `x -> L_i x + v_i`, L_i e_1 the edge i, other columns given; from 0 to e_1."""
    vertices = [[Fraction(v).limit_denominator(10**6) for v in row] for row in np.asarray(vertices)]
    dim, operators = len(vertices[0]), []
    for (a, b), columns in zip(pairwise(vertices), across, strict=True):
        edge = [y - x for x, y in zip(a, b, strict=True)]
        rest = [[Fraction(v).limit_denominator(10**6) for v in column] for column in columns]
        images = [a, *([x + y for x, y in zip(a, c, strict=True)] for c in rest), None]
        images[-1] = [x + y for x, y in zip(a, edge, strict=True)]
        barycentric = [[1 - sum(p), *p[1:], p[0]] for p in images]
        operators.append([list(row) for row in zip(*barycentric, strict=True)])
    control = [[0.0] * dim, *np.eye(dim)[1:].tolist(), np.eye(dim)[0].tolist()]
    return given_curve(operators, control)


def sampled(shape, period, levels):
    """Directions of points of the fundamental pieces right of `period^omega`, of many words."""
    own = curve(shape)
    here = fixed_point(own.operator(period))
    found = []
    for m, label in enumerate(period):
        for other in own.labels[own.labels.index(label) + 1 :]:
            for word in product(own.labels, repeat=levels):
                column = own.operator((*period[:m], other, *word)) @ fixed_point(own.operators[0])
                found.append((column - here) @ shape.control)
    found = np.array(found)
    return found / np.linalg.norm(found, axis=1, keepdims=True)


@settings(max_examples=3, deadline=None)
@given(
    st.lists(st.integers(-9, 9), min_size=4, max_size=4).filter(lambda m: abs(m[0] * m[3] - m[1] * m[2]) > 5)
)
def test_the_cone_of_koch_is_carried_by_affine_maps(entries):
    linear = np.array(entries, float).reshape(2, 2)
    shape = ifs.shape("koch-curve")
    skewed = dataclasses.replace(shape, control=shape.control @ linear.T)
    cone = fld.half_tangents(skewed)[0].cone
    edges = np.array([[1, 0], [math.sqrt(3) / 2, 0.5]]) @ linear.T
    edges /= np.linalg.norm(edges, axis=1, keepdims=True)
    wanted = edges if np.linalg.det(linear) > 0 else edges[::-1]
    assert np.allclose(cone.directions, wanted, atol=1e-6)
    opening = math.degrees(math.acos(np.clip(edges[0] @ edges[1], -1, 1)))
    assert cone.angle == pytest.approx(opening, abs=1e-6)
    assert cone.angle <= cone.outer <= cone.angle + 0.01


def test_sampled_directions_lie_in_the_cone_and_come_near_its_sides():
    shape = ifs.shape("koch-curve")
    for period in (("1", "2"), ("0", "3"), ("0",), ("0", "0")):
        cone = fld.behaviour(shape, f"({' '.join(period)})*").right.cone
        units = sampled(shape, period, 4)
        low = math.atan2(cone.directions[0, 1], cone.directions[0, 0])
        angles = (np.degrees(np.arctan2(units[:, 1], units[:, 0]) - low) + 90) % 360 - 90
        slack = cone.outer - cone.angle + 1e-9
        assert angles.min() >= -slack
        assert angles.max() <= cone.angle + slack
        assert angles.min() < 0.5
        assert angles.max() > cone.angle - 0.5


def test_a_cone_in_space_holds_all_directions():
    small = [[0, 0.2, 0], [0, 0, 0.2]]
    third = [[0, 1 / 3, 0], [0, 0, 1 / 3]]
    vertices = [[0, 0, 0], [1 / 3, 0, 0], [0.5, 0.3, 0.2], [0.7, -0.1, 0.3], [1, 0, 0]]
    shape = polygonal(vertices, [third, small, small, small])
    found = fld.half_tangents(shape)[0]
    assert found.status == "several directions"
    cone = found.cone
    units = sampled(shape, ("0",), 4)
    away = np.degrees(np.arccos(np.clip(units @ cone.axis, -1, 1)))
    assert away.max() <= cone.outer / 2 + 1e-9
    assert away.max() >= cone.angle / 2 - 0.5
    assert cone.outer - cone.angle < 1
    assert np.allclose(np.linalg.norm(cone.directions, axis=1), 1)


def test_a_spiral_has_its_angle_ratio_and_pitch():
    shape = ifs.shape("koch-curve")
    found = fld.behaviour(shape, "1").right.spiral
    assert found.proven
    assert found.turn == pytest.approx(60, abs=1e-9)
    assert found.ratio == pytest.approx(1 / 3, abs=1e-12)
    assert math.tan(math.radians(found.pitch)) == pytest.approx(math.log(3) / (math.pi / 3), rel=1e-9)
    assert found.flattening == pytest.approx(1, abs=1e-9)
    linear = np.array([[2.0, 0.5], [0, -1]])
    turned = dataclasses.replace(shape, control=shape.control @ linear.T)
    other = fld.behaviour(turned, "1").right.spiral
    sizes = np.linalg.svd(linear, compute_uv=False)
    assert other.turn == pytest.approx(-60, abs=1e-9)
    assert other.flattening == pytest.approx(sizes[1] / sizes[0], rel=1e-9)
    assert other.pitch == pytest.approx(found.pitch, rel=1e-9)


def test_a_spiral_that_winds_the_long_way_round():
    # From the end at 0 degrees by 300, 230, 160 and 110 degrees to z at 60: a turn of 300 clockwise.
    polar = [(0.3, 60), (0.35, 110), (0.45, 160), (0.6, 230), (0.8, 300), (1, 360)]
    points = [[r * math.cos(math.radians(a)), r * math.sin(math.radians(a))] for r, a in polar]
    points[-1] = [1.0, 0.0]
    z = points[0]
    shape = polygonal([[0, 0], *points], [[[-z[1], z[0]]], *[[[0.0, 0.02]]] * 5])
    found = fld.half_tangents(shape)[0]
    assert found.status == "spiral"
    assert found.spiral.proven
    assert found.spiral.turn == pytest.approx(-300, abs=1e-3)
    assert found.spiral.ratio == pytest.approx(0.3, abs=1e-6)


def test_a_spiral_that_never_closes_and_its_derivative():
    z = [0.5, 0.3]
    rotation = [[-z[1], z[0]]]
    shape = polygonal([[0, 0], z, [1, 0]], [rotation, [[0.3, 0.5]]])
    found = fld.derivatives(shape, "0").right
    assert found.status == "spiralling"
    assert found.value is None
    assert found.spiral.turn == pytest.approx(math.degrees(math.atan2(0.3, 0.5)), abs=1e-3)
    assert fld.derivatives(shape, "0", order=1.5).right.holds == "all h"


def test_eigenvalues_of_opposite_signs_show_two_sets_of_directions():
    # L_0 = diag(1/3, -1/3): seen at every second step the curve is its mirror image.
    vertices = [[0, 0], [1 / 3, 0], [0.5, 0.3], [1, 0]]
    shape = polygonal(vertices, [[[0, -1 / 3]], [[0, 0.1]], [[0, 0.1]]])
    found = fld.half_tangents(shape)[0]
    assert found.status == "oscillates"
    angles = np.degrees(np.arctan2(*found.cone.directions.T[::-1]))
    assert angles[0] == pytest.approx(-angles[1], abs=1e-6)
    assert angles[1] >= math.degrees(math.atan2(0.3, 0.5)) - 1e-9


def test_a_negative_eigenvalue_keeps_two_opposite_directions():
    shape = polygonal([[0, 0], [0.2, 0], [0.6, 0.4], [1, 0]], [[[0, -0.5]], [[0, 0.1]], [[0, 0.1]]])
    found = fld.half_tangents(shape)[0]
    assert found.status == "unoriented"
    assert np.allclose(np.abs(found.cone.directions), [[0, 1], [0, 1]], atol=1e-9)
    assert found.cone.angle is None
