"""Meshes: shared vertices, counts, figures."""

from collections import Counter
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import ifs
from automata import AutomatonError, Figure, builtin_names, parse_text, read
from ifs.mesh import Mesh

SHAPES = {name: ifs.shape(name) for name in builtin_names()}
PATCHES = ("doo-sabin-patch", "catmull-clark-patch", "fractal-patch")


def directed_edges(mesh):
    return Counter(
        (int(a), int(b)) for face in mesh.polygons() for a, b in zip(face, np.roll(face, -1), strict=True)
    )


def euler(mesh):
    edges = {frozenset(edge) for edge in directed_edges(mesh)}
    return len(mesh.vertices) - len(edges) + len(mesh.faces)


def assert_conformal_square(mesh, depth):
    """A disk of 4^depth quadrangles, every inner edge met once from each side."""
    edges = directed_edges(mesh)
    assert mesh.faces.shape == (4**depth, 4)
    assert len(mesh.vertices) == (2**depth + 1) ** 2
    assert set(edges.values()) == {1}
    rim = [edge for edge in edges if edge[::-1] not in edges]
    assert len(rim) == 4 * 2**depth
    assert sorted(a for a, _ in rim) == sorted({b for _, b in rim})
    assert euler(mesh) == 1
    assert set(mesh.faces.ravel()) == set(range(len(mesh.vertices)))


@pytest.mark.parametrize("name", PATCHES)
@pytest.mark.parametrize("depth", range(5))
def test_patches_are_conformal(name, depth):
    assert_conformal_square(ifs.mesh(SHAPES[name], depth), depth)


@pytest.mark.parametrize("name", PATCHES)
@settings(max_examples=2, deadline=None)
@given(data=st.data())
def test_patches_are_conformal_for_other_members_of_the_family(name, data):
    automaton = read(name)
    shift = st.fractions(Fraction(-1, 32), Fraction(1, 32), max_denominator=320)
    values = {key: value + data.draw(shift) for key, value in automaton.values.items()}
    shape = ifs.shape(replace(automaton, values=values))
    mesh = ifs.mesh(shape, 3)
    assert_conformal_square(mesh, 3)
    assert (mesh.faces == ifs.mesh(SHAPES[name], 3).faces).all()
    fine = ifs.refined(ifs.initial(shape.topology, shape.system, shape.control), 3)
    pieces, mesh = fine.control["face"], ifs.draw(fine)
    assert_conformal_square(mesh, 3)
    corner = ifs.mesh(ifs.Shape("", shape.topology, shape.system, np.eye(len(shape.control))), 0)
    own = np.einsum("kj,cjd->ckd", corner.vertices[corner.faces[0]], pieces)
    np.testing.assert_allclose(mesh.vertices[mesh.faces], own, rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", builtin_names())
@pytest.mark.parametrize("depth", [0, 1, 2])
def test_sharing_comes_from_the_automaton_and_not_from_coordinates(name, depth):
    shape = SHAPES[name]
    collapsed = ifs.Shape(name, shape.topology, shape.system, np.zeros_like(shape.control))
    mesh, point = ifs.mesh(shape, depth), ifs.mesh(collapsed, depth)
    assert (point.faces == mesh.faces).all()
    assert point.vertices.shape == mesh.vertices.shape
    assert (point.vertices == 0).all()
    if name != "menger-sponge":
        assert len(np.unique(mesh.vertices.round(7), axis=0)) == len(mesh.vertices)


@pytest.mark.parametrize("depth", range(6))
def test_counts_of_fractals(depth):
    triangle = ifs.mesh(SHAPES["sierpinski-triangle"], depth)
    assert (len(triangle.vertices), len(triangle.faces)) == ((3 ** (depth + 1) + 3) // 2, 3**depth)
    tetrahedron = ifs.mesh(SHAPES["sierpinski-tetrahedron"], depth)
    assert (len(tetrahedron.vertices), len(tetrahedron.faces)) == (2 * 4**depth + 2, 4 * 4**depth)
    koch = ifs.mesh(SHAPES["koch-curve"], depth)
    assert (len(koch.vertices), len(koch.faces)) == (4**depth + 1, 4**depth)
    curve = ifs.mesh(SHAPES["corner-cutting"], depth)
    assert (len(curve.vertices), len(curve.faces)) == (2**depth + 1, 2**depth)


@pytest.mark.parametrize("name", ["koch-curve", "corner-cutting", "takagi-curve"])
def test_curves_are_one_path(name):
    mesh = ifs.mesh(SHAPES[name], 3)
    uses = Counter(mesh.faces.ravel().tolist())
    assert Counter(uses.values()) == {1: 2, 2: len(mesh.vertices) - 2}
    assert len(set(mesh.faces[:, 0])) == len(mesh.faces)


def test_triangles_have_the_area_that_is_left():
    mesh = ifs.mesh(SHAPES["sierpinski-triangle"], 4)
    whole = 80 * 69.282032302755092 / 2
    assert mesh.to_trimesh().area == pytest.approx(whole * (3 / 4) ** 4, rel=1e-12)


def test_the_menger_sponge_is_made_of_cubes():
    for depth in range(4):
        mesh = ifs.mesh(SHAPES["menger-sponge"], depth)
        assert (len(mesh.vertices), len(mesh.faces)) == (8 * 20**depth, 6 * 20**depth)
        assert mesh.to_trimesh().volume == pytest.approx(54**3 * (20 / 27) ** depth, rel=1e-9)
        lowest = np.round(mesh.vertices.reshape(-1, 8, 3).min(axis=1) / 54 * 3**depth).astype(int)
        assert len(np.unique(lowest, axis=0)) == 20**depth
        assert set(lowest.ravel()) <= set(range(3**depth))


def test_the_tetrahedra_of_the_sierpinski_tetrahedron_face_outwards():
    mesh = ifs.mesh(SHAPES["sierpinski-tetrahedron"], 2)
    whole = 60**3 / (6 * np.sqrt(2))
    assert mesh.to_trimesh().volume == pytest.approx(whole / 4, rel=1e-9)


LOOP = """
format = "bcifs/1"
shape = "loop"
[cells.vertex]
points = 1
subdivision = { s = "vertex" }
[cells.edge]
points = 2
subdivision = { 0 = "edge", 1 = "edge" }
boundary = { left = { cell = "vertex", points = [0] }, right = { cell = "vertex", points = [1] } }
incidence = ["left s = 0 left", "right s = 1 right"]
adjacency = ["0 right = 1 left"]
[cells.loop]
points = 3
subdivision = { 0 = "edge", 1 = "edge", 2 = "edge" }
adjacency = ["0 right = 1 left", "1 right = 2 left", "2 right = 0 left"]
[cells.loop.matrices]
0 = [[1, 0], [0, 1], [0, 0]]
1 = [[0, 0], [1, 0], [0, 1]]
2 = [[0, 1], [0, 0], [1, 0]]
[set]
"edge.0[0,1]" = "1/2"
[control]
points = [[0, 0], [30, 0], [0, 40]]
"""


@pytest.mark.parametrize("depth", [1, 2, 4])
def test_pieces_of_another_kind_close_to_a_loop(depth):
    mesh = ifs.mesh(ifs.shape(parse_text(LOOP)), depth)
    assert len(mesh.vertices) == len(mesh.faces) == 3 * 2 ** (depth - 1)
    assert set(Counter(mesh.faces.ravel().tolist()).values()) == {2}
    ends = mesh.vertices[mesh.faces]
    assert np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).sum() == pytest.approx(120)


def test_the_joints_of_a_loop_that_are_not_glued_stay_apart():
    """Without the last adjacency the ends lie at one place, and are two vertices all the same."""
    mesh = ifs.mesh(ifs.shape(parse_text(LOOP.replace(', "2 right = 0 left"', ""))), 3)
    assert len(mesh.vertices) == len(mesh.faces) + 1
    assert len(np.unique(mesh.vertices.round(9), axis=0)) == len(mesh.faces)


def drawn(name, figure, depth=1):
    automaton = read(name)
    cell = replace(automaton.cells[automaton.shape], figure=figure)
    return ifs.mesh(ifs.shape(replace(automaton, cells={**automaton.cells, cell.name: cell})), depth)


def test_figures():
    polygon = drawn("doo-sabin-patch", Figure("polygon"))
    assert (polygon.faces == ifs.mesh(SHAPES["doo-sabin-patch"], 1).faces).all()
    box = drawn("corner-cutting", Figure("box"), 3)
    assert box.faces.shape == (8, 4)
    assert box.vertices.shape == (32, 2)
    segment = drawn("koch-curve", Figure("segment"), 2)
    assert segment.faces.shape == (16, 2)
    weights = (tuple(Fraction(int(i == j)) for j in range(3)) for i in range(3))
    own = drawn("koch-curve", Figure("faces", tuple(weights), ((0, 1, 2), (0, 2))), 2)
    assert own.faces.shape == (32, 3)
    assert own.vertices.shape == (48, 2)
    assert Counter((own.faces >= 0).sum(axis=1).tolist()) == {2: 16, 3: 16}
    assert np.isfinite(own.vertices).all()


def test_a_figure_of_corners_that_are_not_there_is_refused():
    with pytest.raises(AutomatonError, match=r"cells\.face\.figure: a face names corner 4; the cell has 4"):
        drawn("doo-sabin-patch", Figure("faces", (), ((0, 1, 4),)))
    with pytest.raises(AutomatonError, match="a face names corner 2; the cell has 0"):
        drawn("menger-sponge", Figure("faces", (), ((0, 1, 2),)))


def test_the_depth_is_not_negative():
    with pytest.raises(ValueError, match="found -1"):
        ifs.mesh(SHAPES["koch-curve"], -1)


def test_a_mesh_converts():
    mesh = ifs.mesh(SHAPES["doo-sabin-patch"], 2)
    assert mesh.to_pyvista().n_cells == 16
    assert mesh.to_trimesh().faces.shape == (32, 3)
    assert mesh.to_trimesh().body_count == 1
    curve = ifs.mesh(SHAPES["koch-curve"], 2)
    assert curve.to_pyvista().n_lines == 16
    assert (curve.points_3d()[:, 2] == 0).all()


def test_polygons_of_several_sizes_lie_in_one_mesh():
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [2.0, 0.5]])
    mesh = Mesh(corners, np.array([[0, 1, 2, 3], [1, 4, 2, -1]]))
    assert [polygon.tolist() for polygon in mesh.polygons()] == [[0, 1, 2, 3], [1, 4, 2]]
    assert len(mesh.triangles()) == 3
    assert mesh.to_trimesh().area == pytest.approx(1.5)
    assert mesh.to_pyvista().n_cells == 2
