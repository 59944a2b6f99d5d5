"""Points, tangents, normals and adaptive meshes at the limit, against closed forms and scipy."""

from collections import Counter
from fractions import Fraction

import numpy as np
import pytest
from scipy.interpolate import BSpline
from scipy.spatial import KDTree

import automata
import ifs
from ifs.adaptivity.adaptive import adaptive
from ifs.certificates.bounds import sample
from ifs.patchwork import patchwork
from ifs.surfaces.control_mesh import surface
from ifs.system import State, System
from ifs.tangency.frames import NotParametrised
from ifs.tangency.modes import modes
from ifs.tangency.points import at
from ifs.tangency.tangents import half_tangents, vertex_limits
from subdivision.schemes import bezier

SCHEMES = ["catmull-clark", "doo-sabin"]
CUBE = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
KNOTS = np.arange(-3.0, 5.0)


def trapezohedron(n: int) -> list[tuple[int, ...]]:
    """2n quadrangles: vertices 0 and 1 have valence n, all others valence 3."""
    ring = range(2, 2 * n + 2)
    top = [(0, ring[2 * i], ring[2 * i + 1], ring[(2 * i + 2) % (2 * n)]) for i in range(n)]
    low = [(1, ring[2 * i + 1], ring[2 * i], ring[2 * i - 1]) for i in range(n)]
    return top + low


def random(faces, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(max(map(max, faces)) + 1, 3))


def block(n: int) -> tuple[np.ndarray, list[tuple[int, ...]]]:
    """A cube with n by n squares on each face, of side 1, corners at integers."""
    numbers: dict[tuple[int, ...], int] = {}
    faces = []
    for axis in range(3):
        for side in (0, n):
            for i in range(n):
                for j in range(n):
                    ring = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
                    corners = [np.roll((side, s, t), axis) for s, t in (ring if side else ring[::-1])]
                    faces.append(tuple(numbers.setdefault(tuple(c.tolist()), len(numbers)) for c in corners))
    return np.array(list(numbers), dtype=float), faces


def whole(shape):
    return ifs.initial(shape.topology, shape.system, shape.control)


def patch(control, name: str = "catmull-clark-patch"):
    return whole(ifs.shape(name, control=np.asarray(control, dtype=float)))


def b_spline(parameters, control, orders=(0, 0)) -> np.ndarray:
    """A uniform bicubic B-spline and its derivatives by scipy; control points by rows of constant v."""
    rows = []
    for t, order in zip(parameters.T, orders, strict=True):
        splines = [BSpline(KNOTS, np.eye(4)[i], 3).derivative(order)(t) for i in range(4)]
        rows.append(np.stack(splines, axis=1))
    return np.einsum("nj,ni,ijd->nd", *rows, control.reshape(4, 4, 3))


def nearest(points, wanted) -> tuple[np.ndarray, np.ndarray]:
    """How far the nearest of some points is from each wanted one, and its number."""
    apart, number = KDTree(points).query(wanted)
    return np.asarray(apart), np.asarray(number)


def unit(vectors) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


# ---- triangles: quadratic Bezier patches, with or without the middle one -----------------------------------

POINTS = [(0, 0), (0, 1), (1, 1), (1, 2), (2, 2), (2, 0)]  # the blossom's arguments of the control points
CORNERS = [(2, 0, 0), (0, 2, 0), (0, 0, 2)]  # doubled barycentric coordinates
CUT = [((2, 0, 0), (1, 1, 0), (1, 0, 1)), ((1, 1, 0), (0, 2, 0), (0, 1, 1))]
CUT += [((1, 0, 1), (0, 1, 1), (0, 0, 2)), ((0, 1, 1), (1, 0, 1), (1, 1, 0))]


def blossom(x, y) -> list[Fraction]:
    """The weights of the six control points at two points in doubled barycentric coordinates."""
    return [Fraction(x[i] * y[j] + (x[j] * y[i] if i != j else 0), 4) for i, j in POINTS]


def text_of(rows) -> str:
    return str([[str(entry) for entry in row] for row in rows])


def triangles(middle: bool = True):
    """The automaton of a quadratic Bezier triangle; without the middle triangle it is Sierpinski's."""
    cut = CUT if middle else CUT[:3]
    matrices = [list(zip(*(blossom(part[i], part[j]) for i, j in POINTS), strict=True)) for part in cut]
    sides = ["a 0 = 0 a", "a 1 = 1 a", "b 0 = 1 b", "b 1 = 2 b", "c 0 = 2 c", "c 1 = 0 c"]
    inner = ["0 b = 3 b flip", "1 c = 3 c flip", "2 a = 3 a flip"] if middle else []
    border = "{{ cell = 'edge', points = [{}, {}, {}] }}"
    halves = [[["1", "1/2", "1/4"], ["0", "1/2", "1/2"], ["0", "0", "1/4"]]]
    halves.append([row[::-1] for row in halves[0][::-1]])
    lines = [
        "format = 'bcifs/1'\nname = 'Triangles'\nshape = 'face'",
        "[cells.vertex]\npoints = 1\nsubdivision = { s = 'vertex' }",
        "[cells.edge]\npoints = 3\nsubdivision = { 0 = 'edge', 1 = 'edge' }",
        "boundary = { left = { cell = 'vertex', points = [0] }, right = { cell = 'vertex', points = [2] } }",
        "incidence = ['left s = 0 left', 'right s = 1 right']\nadjacency = ['0 right = 1 left']",
        f"matrices = {{ 0 = {halves[0]}, 1 = {halves[1]} }}",
        "[cells.edge.symmetry.flip]\npoints = [2, 1, 0]\nsubdivision = { 0 = '1 flip', 1 = '0 flip' }",
        "boundary = { left = 'right', right = 'left' }",
        "[cells.face]\npoints = 6",
        f"subdivision = {{ {', '.join(f'{i} = {chr(34)}face{chr(34)}' for i in range(len(cut)))} }}",
        f"incidence = {sides}\nadjacency = {inner}",
        f"boundary = {{ {', '.join(f'{s} = {border.format(*p)}' for s, p in EDGES.items())} }}",
        f"matrices = {{ {', '.join(f'{i} = {text_of(m)}' for i, m in enumerate(matrices))} }}",
        f"[control]\npoints = {[[float(i), float(j)] for i, j in POINTS]}",
    ]
    return automata.parse_text("\n".join(lines).replace("'", '"'))


EDGES = {"a": (0, 1, 2), "b": (2, 3, 4), "c": (4, 5, 0)}


def octahedron():
    """Eight quadratic triangles glued to a closed surface: six corners, and a point for each of 12 edges."""
    shape = ifs.shape(triangles())
    corners = np.array([(9, 0, 0), (0, 9, 0), (0, 0, 9), (-9, 0, 0), (0, -9, 0), (0, 0, -9)], dtype=float)
    faces = [(0, 1, 2), (1, 3, 2), (3, 4, 2), (4, 0, 2), (1, 0, 5), (3, 1, 5), (4, 3, 5), (0, 4, 5)]
    middle: dict[frozenset, int] = {}
    points, rows = list(corners), []
    for face in faces:
        row = []
        for i, j in POINTS:
            key = frozenset((face[i], face[j]))
            if i != j and key not in middle:
                middle[key] = len(points)
                points.append(0.7 * (corners[face[i]] + corners[face[j]]))
            row.append(face[i] if i == j else middle[key])
        rows.append(row)
    return patchwork(shape.topology, shape.system, np.array(points), {"face": np.array(rows)})


# ---- points ------------------------------------------------------------------------------------------------


def test_points_of_a_bicubic_patch_are_those_of_scipy():
    generator = np.random.default_rng(1)
    control, parameters = generator.normal(size=(16, 3)), generator.random((300, 2))
    found = at(patch(control), "face", np.zeros(300, dtype=int), parameters)
    np.testing.assert_allclose(found, b_spline(parameters, control), rtol=0, atol=1e-13)


def test_points_of_a_bezier_curve_are_those_of_de_casteljau():
    generator = np.random.default_rng(2)
    control, t = generator.normal(size=(5, 2)), generator.random((50, 1))
    found = at(whole(ifs.shape(bezier(4), control=control)), "edge", np.zeros(50, dtype=int), t)
    points = np.repeat(control[None], 50, axis=0)
    while points.shape[1] > 1:
        points = (1 - t[:, None]) * points[:, :-1] + t[:, None] * points[:, 1:]
    np.testing.assert_allclose(found, points[:, 0], rtol=0, atol=1e-13)


def test_addresses_of_kochs_curve():
    """t = 0.(d1 d2 d3) in base 4 is the image of the left end under three similarities of the plane."""
    turn = np.exp(1j * np.pi / 3)
    maps = [(1, 0), (turn, 1), (1 / turn, 1 + turn), (1, 2)]
    digits = np.array([(i, j, k) for i in range(4) for j in range(4) for k in range(4)])
    t = digits @ [1 / 4, 1 / 16, 1 / 64]
    found = at(whole(ifs.shape("koch-curve")), "edge", np.zeros(64, dtype=int), t[:, None])
    z = np.zeros(64, dtype=complex)
    for column in digits.T[::-1]:
        a, b = np.array(maps).T[:, column]
        z = (a * z + 90 * b) / 3
    np.testing.assert_allclose(found, np.stack([np.real(z), np.imag(z)], axis=1), atol=1e-11)
    # 1/5 = 0.(03) in base 4: the fixed point of the maps 0 and 3 in turn is at (2 / 9) / (1 - 1 / 9).
    odd = at(whole(ifs.shape("koch-curve")), "edge", np.zeros(1, dtype=int), np.array([[0.2]]))
    np.testing.assert_allclose(odd, [[90 * 0.25, 0]], atol=1e-9)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_points_at_dyadic_parameters_are_the_vertices_of_a_refined_mesh(scheme):
    faces = trapezohedron(5)
    complex_ = surface(random(faces), faces, scheme).complex()
    deep = ifs.draw(ifs.refined(complex_, 2)).vertices
    grid = np.stack(np.meshgrid(*[np.linspace(0, 1, 5)] * 2), axis=-1).reshape(-1, 2)
    points = []
    for cell, control in complex_.control.items():
        pieces = np.repeat(np.arange(len(control)), len(grid))
        points.append(at(complex_, cell, pieces, np.tile(grid, (len(control), 1))))
    found = np.concatenate(points)
    distance, number = nearest(deep, found)
    assert distance.max() < 1e-13
    assert set(number.tolist()) == set(range(len(deep)))


@pytest.mark.parametrize("scheme", SCHEMES)
def test_neighbours_agree_along_their_sides_at_any_parameter(scheme):
    faces = trapezohedron(4)
    complex_ = surface(random(faces, 3), faces, scheme).complex()
    drawn = ifs.draw(complex_).faces
    t = np.random.default_rng(0).random(7)
    corners = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], dtype=float)
    ways = np.roll(corners, -1, axis=0) - corners
    there = corners[:, None] + t[:, None] * ways[:, None]
    back = corners[:, None] + (1 - t)[:, None] * ways[:, None]
    parameters = np.stack([there, back]).reshape(-1, 2)
    found = [
        at(complex_, cell, np.repeat(np.arange(len(c)), 56), np.tile(parameters, (len(c), 1)))
        for cell, c in complex_.control.items()
    ]
    sides = {
        (face[k], face[(k + 1) % 4]): points[:, k]
        for face, points in zip(drawn.tolist(), np.concatenate(found).reshape(-1, 2, 4, 7, 3), strict=True)
        for k in range(4)
    }
    for (i, j), points in sides.items():
        np.testing.assert_allclose(points[0], sides[j, i][1], rtol=0, atol=1e-13)


def test_points_of_a_triangle_are_those_of_its_polynomial_and_a_hole_has_none():
    control = np.random.default_rng(5).normal(size=(6, 3))
    uv = np.random.default_rng(6).random((200, 2))
    uv = np.where(uv.sum(axis=1, keepdims=True) > 1, 1 - uv, uv)
    weights = np.column_stack([1 - uv.sum(axis=1), uv])
    products = [weights[:, i] * weights[:, j] * (1 if i == j else 2) for i, j in POINTS]
    numbers = np.zeros(200, dtype=int)
    found = at(whole(ifs.shape(triangles(), control=control)), "face", numbers, uv)
    np.testing.assert_allclose(found, np.stack(products, axis=1) @ control, rtol=0, atol=1e-13)
    holed = at(whole(ifs.shape(triangles(False), control=control)), "face", numbers, uv)
    np.testing.assert_array_equal(np.isnan(holed).any(axis=1), ~in_gasket(uv))
    side = at(
        whole(ifs.shape(triangles(False), control=control)), "face", numbers[:1], np.array([[1 / 3, 0]])
    )
    np.testing.assert_allclose(side[0], np.array([4, 4, 1, 0, 0, 0]) / 9 @ control, atol=1e-12)


def in_gasket(uv) -> np.ndarray:
    """Whether no step of doubling leads into the middle triangle."""
    inside = np.ones(len(uv), dtype=bool)
    for _ in range(50):
        uv = 2 * uv
        u, v = (uv >= 1).T
        inside &= (uv.sum(axis=1) <= 1) | u | v
        uv = uv - np.stack([u, v], axis=1)
    return inside


def test_wrong_points_are_refused():
    complex_ = patch(np.zeros((16, 3)))
    one = np.zeros(1, dtype=int)
    with pytest.raises(ValueError, match="outside"):
        at(complex_, "face", one, np.array([[0.5, 1.5]]))
    with pytest.raises(ValueError, match="outside"):
        at(complex_, "face", one, np.array([[0.5, np.nan]]))
    with pytest.raises(ValueError, match="2 parameters"):
        at(complex_, "face", one, np.array([[0.5]]))
    with pytest.raises(ValueError, match="piece 3"):
        at(complex_, "face", one + 3, np.array([[0.5, 0.5]]))
    with pytest.raises(ValueError, match="no pieces"):
        at(complex_, "edge", one, np.array([[0.5]]))
    with pytest.raises(NotParametrised, match="boundaries"):
        at(whole(ifs.shape("sierpinski-triangle")), "triangle", one, np.array([[0.1, 0.1]]))


# ---- positions and normals ---------------------------------------------------------------------------------


def test_the_limit_of_a_chain_of_vertex_cells_that_ends_in_another_one():
    random_ = np.random.default_rng(0)
    steps = [random_.random((n, m)) for n, m in ((2, 4), (4, 3), (3, 3))]
    steps = [step / step.sum(axis=0) for step in steps]
    names = ["first", "second", "last", "last"]
    states = {
        name: State(name, len(step), ("s",), (target,), (step,))
        for name, target, step in zip(names, names[1:], steps, strict=False)
    }
    found = sample(System("first", states))["first"]
    values, vectors = np.linalg.eig(steps[2])
    limit = np.real(vectors[:, np.abs(values - 1).argmin()])
    np.testing.assert_allclose(found, steps[0] @ steps[1] @ (limit / limit.sum()), rtol=0, atol=1e-15)
    deep = steps[0] @ steps[1] @ np.linalg.matrix_power(steps[2], 60)
    np.testing.assert_allclose(deep, np.repeat(found[:, None], 3, axis=1), rtol=0, atol=1e-14)


@pytest.mark.parametrize("n", [3, 5, 7])
def test_normals_of_catmull_and_clark_are_those_of_the_tangent_masks(n):
    faces = trapezohedron(n)
    points = random(faces, n)
    limits = vertex_limits(surface(points, faces).complex())
    assert limits.exists.all()
    edges, corners = points[2::2], points[3::2]
    k = np.arange(n)
    c, s = np.cos(2 * np.pi * k / n), np.sin(2 * np.pi * k / n)
    cos = np.cos(2 * np.pi / n)
    weight = 1 + cos + np.cos(np.pi / n) * np.sqrt(2 * (9 + cos))
    tangents = [weight * w @ edges + (w + np.roll(w, -1)) @ corners for w in (c, s)]
    position = (n * n * points[0] + 4 * edges.sum(axis=0) + corners.sum(axis=0)) / (n * (n + 5))
    found = np.abs(limits.positions - position).max(axis=1).argmin()
    np.testing.assert_allclose(limits.positions[found], position, atol=1e-14)
    np.testing.assert_allclose(limits.normals[found], unit(np.cross(*tangents)), atol=1e-12)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_the_normals_of_ever_finer_faces_tend_to_those_at_the_limit(scheme):
    faces = trapezohedron(5)
    complex_ = surface(random(faces, 1), faces, scheme).complex()
    limits = vertex_limits(complex_)
    apart = []
    for depth in (2, 3):
        mesh = ifs.draw(ifs.refined(complex_, depth))
        corners = mesh.vertices[mesh.faces]
        area = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
        normals = np.zeros_like(mesh.vertices)
        for column in mesh.faces.T:
            np.add.at(normals, column, area)
        near = nearest(mesh.vertices, limits.positions)[1]
        apart.append(np.linalg.norm(unit(normals[near]) - limits.normals, axis=1))
    # Surfaces of bounded curvature: the error of such a normal is at most of the order of a face's side.
    assert np.median(apart[1]) < 0.05
    assert np.median(apart[1]) < 0.65 * np.median(apart[0])


def test_normals_of_a_bicubic_patch_are_those_of_scipy():
    control = np.random.default_rng(4).normal(size=(16, 3))
    complex_ = patch(control)
    limits = vertex_limits(ifs.refined(complex_, 2))
    grid = np.stack(np.meshgrid(*[np.linspace(0, 1, 5)] * 2), axis=-1).reshape(-1, 2)
    near = nearest(limits.positions, b_spline(grid, control))[1]
    assert len(set(near.tolist())) == 25
    normals = unit(np.cross(b_spline(grid, control, (1, 0)), b_spline(grid, control, (0, 1))))
    np.testing.assert_allclose(limits.normals[near], normals, atol=1e-11)


def test_a_parabola_has_the_normals_of_its_equation():
    """x = u, y = v, z = u^2: the blossom of u^2 at (i - 1, i, i + 1) is i^2 - 1/3."""
    i, j = np.meshgrid(np.arange(4.0) - 1, np.arange(4.0) - 1)
    limits = vertex_limits(ifs.refined(patch(np.stack([i, j, i**2 - 1 / 3], axis=-1).reshape(16, 3)), 2))
    x, _, z = limits.positions.T
    np.testing.assert_allclose(z, x**2, atol=1e-14)
    np.testing.assert_allclose(limits.normals, unit(np.stack([-2 * x, 0 * x, 1 + 0 * x], axis=1)), atol=1e-12)


def test_faces_that_meet_at_an_angle_have_normals_of_their_own():
    complex_ = octahedron()
    flat = {cell: c.copy() for cell, c in complex_.control.items()}
    for i in (1, 3, 5):
        flat["face"][:, i] = (flat["face"][:, i - 1] + flat["face"][:, (i + 1) % 6]) / 2
    limits = vertex_limits(ifs.Complex(**{**vars(complex_), "control": flat}))
    assert not limits.exists.any()
    assert np.isnan(limits.normals).all()
    corners = flat["face"][:, ::2]
    normals = unit(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    np.testing.assert_allclose(limits.corner_normals, np.repeat(normals[:, None], 3, axis=1), atol=1e-12)
    # Inside the flat faces the finer ones agree.
    finer = vertex_limits(ifs.refined(ifs.Complex(**{**vars(complex_), "control": flat}), 2))
    inside = (np.abs(finer.positions) > 1e-9).all(axis=1)
    assert inside.sum() == 24
    np.testing.assert_array_equal(finer.exists, inside)


def test_a_fractal_surface_has_positions_and_no_normals():
    limits = vertex_limits(whole(ifs.shape("fractal-patch")))
    assert np.isfinite(limits.positions).all()
    assert not limits.exists.any()


def test_normals_are_for_surfaces_in_space():
    with pytest.raises(ValueError, match="in space"):
        vertex_limits(patch(np.random.default_rng(0).normal(size=(16, 2))))
    with pytest.raises(ValueError, match="in space"):
        vertex_limits(whole(ifs.shape("koch-curve")))


def test_normals_beside_a_crease_and_at_its_end_are_those_of_fine_faces():
    """One cube face inside a ring of creases (its sides meet at 180 degrees), and a crease that ends."""
    points = 10 * np.array([(i & 1, i >> 1 & 1, i >> 2) for i in range(8)]) + random(CUBE)
    for creases, smooth in (({(4, 5): 10, (5, 7): 10, (7, 6): 10, (6, 4): 10}, 4), ({(4, 5): 10}, 8)):
        complex_ = surface(points, CUBE, creases=creases).complex()
        limits, faces = vertex_limits(complex_), ifs.draw(complex_).faces
        assert limits.exists.sum() == smooth
        fine = ifs.draw(ifs.refined(complex_, 3))
        quads = fine.vertices[fine.faces]
        normals = unit(np.cross(quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1]))
        near = nearest(fine.vertices, limits.positions)[1][faces]
        for vertices, expected in zip(near, limits.corner_normals, strict=True):
            for vertex, normal in zip(vertices, expected, strict=True):
                beside = normals[(fine.faces == vertex).any(axis=1)]
                assert np.linalg.norm(beside - normal, axis=1).min() < 0.2


# ---- half-tangents -----------------------------------------------------------------------------------------


def test_half_tangents_of_curves():
    chaikin = half_tangents(
        whole(ifs.shape("corner-cutting", control=np.array([[0.0, 0], [3, 4], [6, 4]]))), "edge"
    )
    np.testing.assert_allclose(chaikin[0, :, 0], [[0.6, 0.8], [-1, 0]], atol=1e-12)
    takagi = half_tangents(whole(ifs.shape("takagi-curve")), "edge")
    np.testing.assert_allclose(takagi[0, :, 0], [[0, 1], [0, 1]], atol=1e-9)
    assert np.isnan(half_tangents(whole(ifs.shape("koch-curve")), "edge")).all()


def test_kochs_curve_over_points_in_line_has_half_tangents():
    flat = ifs.shape("koch-curve", control=np.array([[0.0, 0], [3, 4], [6, 8]]))
    found = half_tangents(whole(flat), "edge")
    np.testing.assert_allclose(found[0, :, 0], [[0.6, 0.8], [-0.6, -0.8]], atol=1e-12)


@pytest.mark.parametrize("repeated", [1, 2, 3, 4])
def test_control_points_that_coincide_pass_the_tangent_on_to_the_next(repeated):
    control = np.array([[1.0, 2, 3]] * repeated + [[1, 5, 7]] + [[8.0, 0, 1]] * (4 - repeated))
    found = half_tangents(whole(ifs.shape(bezier(4), control=control)), "edge")
    np.testing.assert_allclose(found[0, 0, 0], [0, 0.6, 0.8], atol=1e-9)


def test_a_point_has_no_half_tangent():
    found = half_tangents(whole(ifs.shape(bezier(3), control=np.ones((4, 2)))), "edge")
    assert np.isnan(found).all()


def test_modes_add_up_and_turn_as_the_operator_says():
    angle = 0.3
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    linear = np.zeros((4, 4))
    linear[:2, :2], linear[2:, 2:] = 0.5 * turn, [[0.25, 1], [0, 0.25]]
    basis = np.random.default_rng(0).normal(size=(5, 4))
    basis -= basis.mean(axis=0)
    operator = basis @ linear @ np.linalg.pinv(basis)
    found = modes(operator, basis)
    by_rate = {rate: [m for m in found if abs(m.modulus - rate) < 1e-6] for rate in (0.5, 0.25)}
    turning, (first, second) = by_rate[0.5][-1], by_rate[0.25][-2:]
    np.testing.assert_array_equal(turning.straight, [False, False, True, True])
    np.testing.assert_allclose(turning.parts[:, :2], basis[:, :2], atol=1e-9)
    np.testing.assert_allclose(turning.parts[:, 2:], 0, atol=1e-9)
    # L / r - 1 takes the last difference to four times the one before it.
    assert first.straight[2:].all()
    np.testing.assert_allclose(first.parts[:, 2:], [0, 4] * basis[:, [2]], atol=1e-6)
    np.testing.assert_allclose(second.parts[:, 2:], basis[:, 2:], atol=1e-6)


# ---- adaptive meshes ---------------------------------------------------------------------------------------


def directed(mesh) -> Counter:
    return Counter(
        pair
        for face in mesh.polygons()
        for pair in zip(face.tolist(), np.roll(face, -1).tolist(), strict=True)
    )


def require_closed(mesh, euler: int):
    edges = directed(mesh)
    assert set(edges.values()) == {1}
    assert all((w, v) in edges for v, w in edges)
    assert len(mesh.vertices) - len(edges) // 2 + len(mesh.faces) == euler


def distances(points, mesh) -> np.ndarray:
    import trimesh

    return trimesh.proximity.closest_point_naive(mesh.to_trimesh(), points)[1]


@pytest.mark.parametrize("scheme", SCHEMES)
def test_flat_parts_stay_coarse_and_the_mesh_stays_closed(scheme):
    points, faces = block(5)
    complex_ = surface(points, faces, scheme).complex()
    tolerance = 0.02
    mesh = adaptive(complex_, tolerance, 3)
    require_closed(mesh, 2)
    fine = ifs.draw(ifs.refined(complex_, 3))
    assert nearest(fine.vertices, mesh.vertices)[0].max() < 1e-12
    assert len(mesh.faces) < len(fine.faces) / 5
    assert len(set((mesh.faces >= 0).sum(axis=1).tolist())) > 1
    chosen = np.random.default_rng(0).choice(len(fine.vertices), 200)
    assert distances(fine.vertices[chosen], mesh).max() < tolerance


def test_any_pattern_of_subdivision_is_closed():
    """Pieces that stop by chance, at every level: triangles, and quadrangles of mixed valences."""
    generator = np.random.default_rng(0)

    def stop(cell, control, rim):
        assert not rim.any()
        return generator.random(len(control)) < 0.6

    faces = trapezohedron(5)
    for complex_ in (octahedron(), surface(random(faces), faces).complex()):
        mesh = adaptive(complex_, stop, 3)
        require_closed(mesh, 2)
        assert np.isfinite(mesh.vertices).all()
        fine = ifs.draw(ifs.refined(complex_, 3)).vertices
        assert nearest(fine, mesh.vertices)[0].max() < 1e-12


def test_without_stops_the_mesh_is_the_uniform_one():
    faces = trapezohedron(3)
    complex_ = surface(random(faces), faces).complex()
    mesh = adaptive(complex_, lambda cell, control, rim: np.zeros(len(control), dtype=bool), 2)
    known = ifs.draw(ifs.refined(complex_, 2))
    twin = nearest(known.vertices, mesh.vertices)[1]
    assert sorted(twin.tolist()) == list(range(len(known.vertices)))
    expected = Counter(frozenset(face) for face in known.faces.tolist())
    assert Counter(frozenset(face) for face in twin[mesh.faces].tolist()) == expected


def test_a_flat_patch_is_refined_along_its_rim_alone():
    i, j = np.meshgrid(np.arange(4.0), np.arange(4.0))
    control = 30 * np.stack([i + 0.3 * (j - 1.5) ** 2, j, 0 * i], axis=-1).reshape(16, 3)
    complex_ = patch(control)
    mesh = adaptive(complex_, 0.2, 7)
    edges = directed(mesh)
    assert set(edges.values()) == {1}
    rim = [pair for pair in edges if pair[::-1] not in edges]
    assert len({v for v, _ in rim}) == len(rim)
    assert len(mesh.vertices) - (len(edges) + len(rim)) // 2 + len(mesh.faces) == 1
    assert len(mesh.faces) < 100
    t = np.random.default_rng(0).random((300, 2))
    inside = at(complex_, "face", np.zeros(300, dtype=int), t)
    assert distances(inside, mesh).max() < 0.2
    # The rim's two bent sides are parabolas of second derivative 18 mm: 18 / 8 / 4^2 is below 0.2 mm.
    assert 2 * 4 + 2 <= len(rim) <= 2 * 8 + 2


def test_curves_stay_within_the_tolerance_of_their_chords():
    generator = np.random.default_rng(3)
    complex_ = whole(ifs.shape(bezier(4), control=generator.normal(size=(5, 3)) * 10))
    mesh = adaptive(complex_, 0.05, 12)
    t = generator.random((400, 1))
    points = at(complex_, "edge", np.zeros(400, dtype=int), t)
    start, end = (mesh.vertices[mesh.faces[:, i]] for i in (0, 1))
    share = np.einsum("nmd,md->nm", points[:, None] - start, end - start) / ((end - start) ** 2).sum(axis=1)
    foot = start + np.clip(share, 0, 1)[:, :, None] * (end - start)
    apart = np.linalg.norm(points[:, None] - foot, axis=2).min(axis=1)
    assert apart.max() < 0.05
    assert 10 < len(mesh.faces) < 128
    assert sorted(Counter(mesh.faces.reshape(-1).tolist()).values())[:3] == [1, 1, 2]


def test_wrong_tolerances_and_depths_are_refused():
    complex_ = patch(np.zeros((16, 3)))
    for wrong in (0.0, -1.0, np.nan):
        with pytest.raises(ValueError, match="above 0"):
            adaptive(complex_, wrong)
    with pytest.raises(ValueError, match="depth"):
        adaptive(complex_, 1.0, -1)
