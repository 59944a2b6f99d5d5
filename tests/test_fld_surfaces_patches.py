"""Corners, edges and vertices of patches: splines, known masks, and limits in many digits."""

import itertools
import json
import math
from dataclasses import replace
from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import NdBSpline

import ifs
import subdivision
from fld.surfaces import along_edge, patches, product, product_point, quarters, vertex
from subdivision.schemes import bezier, bezier_triangle, corner_cutting, koch, takagi, tensor
from subdivision.schemes.catmull_clark import Coefficients

CUBE = np.array([(x, y, z) for z in (0.0, 9) for y in (0.0, 9) for x in (0.0, 9)])
SIDES = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
UNIT = np.array([(0.0, 0), (1, 0), (1, 1), (0, 1)])
SEED = np.random.default_rng(2)


@cache
def builtin(name):
    return ifs.shape(name)


def way(vector):
    return vector / np.linalg.norm(vector)


def angle(one, other):
    """Between unit vectors, in degrees."""
    return 2 * math.degrees(math.atan2(np.linalg.norm(one - other), np.linalg.norm(one + other)))


def spline(degree, control):
    """The patch of a uniform tensor product spline; v runs along rows, u along columns."""
    knots = np.arange(-float(degree), degree + 2)
    grid = control.reshape(degree + 1, degree + 1, 3)
    return NdBSpline((knots, knots), grid, degree)


@pytest.mark.parametrize(("name", "degree"), [("catmull-clark-patch", 3), ("doo-sabin-patch", 2)])
def test_regular_patches_have_the_derivatives_of_splines(name, degree):
    shape = builtin(name)
    found = patches(shape)
    limit = spline(degree, shape.control)
    ahead = np.roll(UNIT, -1, axis=0) - UNIT
    for number, (u, v) in enumerate(UNIT):
        corner = found.corner("face", 0, number)
        du, dv = limit([[v, u]], nu=(0, 1))[0], limit([[v, u]], nu=(1, 0))[0]
        assert corner.status == "plane"
        assert corner.behaviour == "straight"
        assert np.allclose(corner.orders, 1, atol=1e-9)
        assert np.allclose(corner.point, limit([[v, u]])[0], atol=1e-10)
        assert np.allclose(corner.normal, way(np.cross(du, dv)), atol=1e-10)
        for side, step in zip(corner.sides, (ahead[number], -ahead[number - 1]), strict=True):
            assert side.status == "half-tangent"
            assert np.allclose(side.vector, step[0] * du + step[1] * dv, atol=1e-9)


def test_vertices_along_an_edge_have_the_normals_of_the_spline():
    shape = builtin("catmull-clark-patch")
    limit = spline(3, shape.control)
    for k, found in enumerate(along_edge(patches(shape), "face", 0, "bottom", 2)):
        u = k / 4
        du, dv = limit([[0, u]], nu=(0, 1))[0], limit([[0, u]], nu=(1, 0))[0]
        assert found.joint == "smooth"
        assert np.allclose(found.point, limit([[0, u]])[0], atol=1e-10)
        assert np.allclose(found.normal, way(np.cross(du, dv)), atol=1e-9)
        tangents = [side.direction for _, corner in found.corners for side in corner.sides]
        for wanted in (du, dv) if 0 < k < 4 else ():
            assert min(np.linalg.norm(tangent - way(wanted)) for tangent in tangents) < 1e-9


def trapezohedron(n):
    """2n quadrangles around two poles of valence n; vertices 0 and 1 are the poles."""
    ring = [
        (20 * math.cos(math.pi * i / n), 20 * math.sin(math.pi * i / n), 6 * (-1) ** i) for i in range(2 * n)
    ]
    points = np.array([(0, 0, 25), (0, 0, -25), *ring])
    points = points + np.random.default_rng(n).uniform(-3, 3, points.shape)
    upper = [(0, 2 + i - 1, 2 + i, 2 + (i + 1) % (2 * n)) for i in range(1, 2 * n, 2)]
    lower = [(1, 2 + (i + 1) % (2 * n), 2 + i, 2 + (i - 1) % (2 * n)) for i in range(0, 2 * n, 2)]
    return points, upper + lower


def at_point(surface, point):
    """The vertex of a surface at a point."""
    gaps = np.linalg.norm(ifs.draw(surface.complex).vertices - point, axis=1)
    assert gaps.min() < 1e-9
    return vertex(surface, int(gaps.argmin()))


@pytest.mark.parametrize("n", [3, 5, 6])
def test_extraordinary_vertices_of_catmull_and_clark_have_the_normals_of_the_known_masks(n):
    points, faces = trapezohedron(n)
    surface = patches(ifs.surface(points, faces).complex())
    around = sorted(
        (face[face.index(0) :] + face[: face.index(0)] for face in faces if 0 in face),
        key=lambda face: face[1],
    )
    order = [around[0]]
    while len(order) < n:
        order.append(next(face for face in around if face[1] == order[-1][3]))
    edges, corners = points[[face[1] for face in order]], points[[face[2] for face in order]]
    limit = (n**2 * points[0] + 4 * edges.sum(axis=0) + corners.sum(axis=0)) / (n * (n + 5))
    # Halstead, Kass and DeRose 1993: the tangent mask of a vertex of valence n.
    c = math.cos(2 * math.pi / n)
    a = 1 + c + math.cos(math.pi / n) * math.sqrt(2 * (9 + c))
    cosines = np.cos(2 * math.pi * np.arange(n + 2) / n)
    edge_weights, face_weights = a * cosines[:n], cosines[:n] + cosines[1 : n + 1]
    one = edge_weights @ edges + face_weights @ corners
    other = np.roll(edge_weights, 1) @ edges + np.roll(face_weights, 1) @ corners
    found = at_point(surface, limit)
    assert len(found.corners) == n
    assert found.joint == "smooth"
    assert np.allclose(found.normal, way(np.cross(one, other)), atol=1e-9)
    eigenvalue = (5 + c + math.sqrt((c + 9) * (c + 1))) / 16
    for _, corner in found.corners:
        assert np.allclose(corner.moduli, eigenvalue, atol=1e-12)
        assert np.allclose(corner.orders, -math.log2(eigenvalue), atol=1e-9)
        assert all(abs(side.order + math.log2(eigenvalue)) < 1e-9 for side in corner.sides)
        for side in corner.sides:
            assert abs(side.direction @ found.normal) < 1e-9
    assert min(angle(side.direction, way(one)) for _, corner in found.corners for side in corner.sides) < 1e-6


@pytest.mark.parametrize(("scheme", "eigenvalue"), [("doo-sabin", 0.5), ("doo-sabin-rational", 0.375)])
def test_extraordinary_faces_of_doo_and_sabin_have_the_normals_of_their_points(scheme, eigenvalue):
    points = CUBE + np.random.default_rng(5).uniform(-2, 2, CUBE.shape)
    control = ifs.surface(points, SIDES, scheme)
    surface = patches(control.complex())
    lim = ifs.vertex_limits(surface.complex)
    triangles = [number for number, corners in surface.faces.items() if len(corners) == 3]
    assert len(triangles) == 8
    for number in (triangles[0], 1):
        corners = surface.faces[number]
        found = vertex(surface, number)
        assert found.joint == "smooth"
        assert np.allclose(found.normal, lim.normals[number], atol=1e-9)
        if len(corners) != 3:
            continue
        # A triangle of control points shrinks to its mean, in its own plane.
        rows = [
            {tuple(p) for p in surface.complex.control[cell][piece].round(9)} for cell, piece, _ in corners
        ]
        three = np.array(sorted(set.intersection(*rows)))
        assert np.allclose(three.mean(axis=0), found.point, atol=1e-8)
        assert abs(abs(way(np.cross(three[1] - three[0], three[2] - three[0])) @ found.normal) - 1) < 1e-9
        assert np.allclose(found.corners[0][1].moduli, eigenvalue, atol=1e-12)


def test_normals_agree_with_those_of_vertex_limits_on_a_mesh():
    points, faces = trapezohedron(5)
    surface = patches(ifs.surface(points, faces).complex())
    limits = ifs.vertex_limits(surface.complex)
    for number in (0, 4):
        found = vertex(surface, number)
        assert np.allclose(found.normal, limits.normals[number], atol=1e-9)
        assert np.allclose(found.point, limits.positions[number], atol=1e-9)


def test_creases_and_boundaries():
    creased = ifs.surface(CUBE, SIDES, creases={(0, 1): 10, (1, 3): 10, (3, 2): 10, (2, 0): 10})
    surface = patches(creased.complex())
    limits = ifs.vertex_limits(surface.complex)
    joints = []
    faces = [list(row) for row in ifs.draw(surface.complex).faces]
    heights = ifs.draw(surface.complex).vertices[:, 2]
    for number in (int(heights.argmin()), int(heights.argmax())):
        corners, found = surface.faces[number], vertex(surface, number)
        joints.append(found.joint)
        normals = [
            limits.corner_normals[i, row.index(number)] for i, row in enumerate(faces) if number in row
        ]
        assert len(normals) == len(corners)
        turn = max(angle(one, other) for one, other in itertools.combinations(normals, 2))
        assert abs(found.turn - turn) < 1e-5
    assert joints == ["crease", "smooth"]
    opened = patches(ifs.surface(CUBE, SIDES[1:], boundary="corners").complex())
    assert {vertex(opened, number).joint for number in (0,)} == {"smooth"}


def integers(shape):
    """The operators of the shape's cell times their common denominator, and that."""
    numbers = subdivision.solve(shape.automaton).numbers()[shape.system.shape]
    scale = math.lcm(*(Fraction(x).denominator for rows in numbers.values() for row in rows for x in row))
    whole = {
        label: np.array([[int(x * scale) for x in row] for row in rows], object)
        for label, rows in numbers.items()
    }
    return whole, scale


def chord(shape, operators, labels, corner):
    """The unit vector from the corner to a point of the piece `labels`, exact up to the last division."""
    whole, scale = operators
    size = len(shape.control)
    end = np.full(size, 1, object)
    for label in reversed(labels):
        end = whole[label] @ end
    start, more = np.full(size, 1, object), 80  # further steps to the corner itself
    for _ in range(len(labels) + more):
        start = whole[corner] @ start
    found = (end * scale**more - start) @ shape.control.astype(int).astype(object)
    return way(np.array([float(Fraction(x, max(map(abs, found)))) for x in found]))


def turning():
    """Doo and Sabin's constraints with weights that turn: alpha = (9, 4, 1, 2)/16 around a face."""
    return ifs.shape(
        "doo-sabin-patch", {"vertex.s[1,0]": "4/16", "vertex.s[2,0]": "2/16", "vertex.s[3,0]": "1/16"}
    )


def test_weights_that_turn_give_a_spiral_in_a_plane():
    shape = turning()
    found = patches(shape).corner("face", 0, 0)
    value = complex(9 - 1, 4 - 2) / 16  # alpha_0 - alpha_2 + i (alpha_1 - alpha_3)
    turn = math.degrees(math.atan2(value.imag, value.real))
    assert found.status == "plane"
    assert found.behaviour == "spiral"
    assert np.allclose(found.moduli, abs(value), atol=1e-12)
    assert f"turning by {turn:.6g} degrees" in found.words
    assert all(side.status == "spiral" for side in found.sides)
    operators = integers(shape)
    chords = [chord(shape, operators, [*["0"] * k, "2"], "0") for k in (60, 61)]
    for k in chords:
        assert abs(k @ found.normal) < 1e-8
    assert vertex(patches(shape), 0).joint == "smooth"
    assert angle(*chords) > 1


def test_the_fractal_patch_leaves_its_corners_in_a_cone():
    shape = builtin("fractal-patch")
    found = patches(shape).corner("face", 0, 0)
    assert found.status == "several directions"
    assert found.normal is None
    assert "3 directions shrink alike" in found.words
    assert np.allclose(found.moduli, 0.5, atol=1e-12)
    assert np.linalg.svd(found.cone, compute_uv=False)[2] > 0.1
    operators = integers(shape)
    ways = []
    for rest in (["1"], ["2"], ["3"]):
        far, near = (chord(shape, operators, [*["0"] * k, *rest], "0") for k in (250, 270))
        assert np.allclose(far, near, atol=1e-9)  # each point keeps its own direction
        ways.append(near)
    assert abs(np.linalg.det(ways)) > 1e-3
    assert vertex(patches(shape), 0).joint is None
    assert "cone" in vertex(patches(shape), 0).words
    side = found.sides[0]
    assert side.status == "several directions"
    assert "degrees apart" in side.words


def test_edges_of_other_coefficients_have_the_order_of_their_own_automaton():
    values = {"vertex.s[1,0]": "21/100", "vertex.s[2,0]": "21/100", "vertex.s[3,0]": "49/100"}
    shape = ifs.shape("doo-sabin-patch", values)
    found = patches(shape).corner("face", 0, 0)
    operators = integers(shape)
    # The weights (9, 21, 49, 21)/100 of the source: the outer points of an edge shrink by 49 + 21 percent.
    assert np.allclose(found.moduli, 0.7, atol=1e-12)
    for side, end in zip(found.sides, ("1", "3"), strict=True):
        assert abs(side.order + math.log2(0.7)) < 1e-9
        assert side.status == "half-tangent"
        assert angle(chord(shape, operators, [*["0"] * 200, *[end] * 200], "0"), side.direction) < 1e-5
    for rest in (["2"], ["1"], ["3", "2"]):
        assert abs(chord(shape, operators, [*["0"] * 200, *rest], "0") @ found.normal) < 1e-8


def test_two_orders_span_the_plane_of_the_quarter():
    pair = corner_cutting(Fraction(2, 5), Fraction(1, 10)), corner_cutting(Fraction(1, 10), Fraction(1, 3))
    at = product_point(product(*pair), "0", "0")
    quarter = quarters(at).quarters[0]
    surface = patches(ifs.shape(tensor(*pair)))
    corner = next(
        c for k in range(4) if np.allclose((c := surface.corner("edge*edge", 0, k)).point, at.point)
    )
    assert corner.status == "two orders"
    assert abs(abs(corner.normal @ quarter.normal) - 1) < 1e-12
    assert np.allclose(corner.moduli, (17 / 30, 1 / 2), atol=1e-12)
    for tangent in quarter.tangents:
        assert min(np.linalg.norm(side.direction - tangent) for side in corner.sides) < 1e-10


def test_what_is_not_proven_is_said():
    # All points but those over the edge u = 0 leave vertically, like h log(1/h).
    found = patches(ifs.shape(tensor(takagi(), bezier(3)))).corner("edge*edge", 0, 0)
    assert found.status == "undecided"
    assert found.block == 2
    assert found.normal is None
    assert found.sides[0].block == 2
    assert found.sides[1].block == 1
    assert "log(1/h)" in found.words
    uneven = patches(ifs.shape(tensor(koch(), bezier(2)))).corner("edge*edge", 0, 0)
    assert uneven.orders == (None, None)
    assert abs(uneven.sides[0].order - math.log(3) / math.log(4)) < 1e-9
    assert uneven.sides[0].status == "several directions"


def test_triangles_of_bezier_have_the_planes_of_their_control_points():
    control = np.array([[0, 0, 0], [1, 0, 0.3], [2, 0, 0], [0, 1, 0], [1, 1, 1], [0, 2, 0.0]])
    surface = patches(ifs.shape(bezier_triangle(2), control=control))
    cell = next(iter(surface.complex.control))
    found = [surface.corner(cell, 0, number) for number in range(3)]
    planes = {
        (0, 0): np.cross(control[1] - control[0], control[3] - control[0]),
        (2, 0): np.cross(control[1] - control[2], control[4] - control[2]),
        (0, 2): np.cross(control[3] - control[5], control[4] - control[5]),
    }
    for corner in found:
        normal = planes[round(corner.point[0]), round(corner.point[1])]
        assert corner.status == "plane"
        assert abs(abs(corner.normal @ way(normal)) - 1) < 1e-10
        assert corner.normal[2] > 0


def test_regions_of_other_coefficients_get_words_at_every_vertex():
    rough = ifs.Region([0], Coefficients(end=Fraction(1, 4)))
    surface = patches(ifs.surface(CUBE, SIDES, regions=[rough]).complex())
    for number in surface.faces:
        found = vertex(surface, number)
        assert found.words
        assert found.joint is not None or "undecided" in found.words or "no tangent plane" in found.words
        assert "NaN" not in json.dumps(found.as_data())


REGULAR = patches(builtin("doo-sabin-patch"))


@settings(max_examples=4, deadline=None)
@given(st.integers(0, 999))
def test_affine_maps_carry_tangents_and_planes(seed):
    rng = np.random.default_rng(seed)
    linear, shift = rng.normal(size=(3, 3)) + 2 * np.eye(3), rng.normal(size=3)
    surface = REGULAR
    moved = {"face": np.asarray(surface.complex.control["face"]) @ linear.T + shift}
    same = replace(surface, complex=replace(surface.complex, control=moved))
    one, other = surface.corner("face", 0, 1), same.corner("face", 0, 1)
    assert np.allclose(other.sides[0].vector, linear @ one.sides[0].vector, atol=1e-7)
    sign = np.sign(np.linalg.det(linear))
    assert np.allclose(other.normal, sign * way(np.linalg.inv(linear).T @ one.normal), atol=1e-6)
    assert other.status == one.status


def test_a_patch_of_one_point_is_constant_and_a_straight_one_has_a_line():
    shape = builtin("doo-sabin-patch")
    still = patches(ifs.Shape("still", shape.topology, shape.system, np.full((9, 3), 2.5)))
    found = still.corner("face", 0, 0)
    assert found.status == "constant"
    assert found.normal is None
    control = shape.control.copy()
    control[:, 1:] = 0
    line = patches(ifs.Shape("line", shape.topology, shape.system, control)).corner("face", 0, 0)
    assert line.normal is None
    assert "(1, 0, 0)" in line.words


def test_wrong_input_is_named():
    surface = patches(builtin("doo-sabin-patch"))
    with pytest.raises(ValueError, match="no vertex 4"):
        vertex(surface, 4)
    with pytest.raises(ValueError, match="is a curve"):
        patches(ifs.shape("koch-curve"))
    with pytest.raises(ValueError, match="no side 'north'; it has bottom, right, top, left"):
        along_edge(surface, "face", 0, "north")
    with pytest.raises(ValueError, match="no piece 1 of cell 'face'"):
        along_edge(surface, "face", 1, "bottom")
    with pytest.raises(ifs.NotParametrised):
        patches(ifs.shape("sierpinski-tetrahedron"))
