"""Stamped meshes against those of step-by-step refinement, face by face, and against Euler's formula."""

from collections import Counter
from dataclasses import replace
from fractions import Fraction
from functools import cache

import numpy as np
import pytest

import ifs
from automata import AutomatonError, Figure, builtin_names, parse_text, read
from ifs import complex as complex_module
from ifs import stencil
from ifs.stamp import stamped, supports
from ifs.stencil import Stencils
from ifs.surfaces.control_mesh import surface
from ifs.template import NotStamped, Templates

SHAPES = {name: ifs.shape(name) for name in builtin_names()}
DRAWN = [name for name in SHAPES if name != "menger-sponge"]


@pytest.fixture(autouse=True)
def _plain_numpy(monkeypatch):
    """Refinement step by step in plain NumPy: the same products, without a compilation for each shape."""

    def subdivide(state, control):
        result = {target: [] for target in state.targets}
        for operator, target in zip(state.operators, state.targets, strict=True):
            result[target].append(np.swapaxes(np.swapaxes(control, 1, 2) @ operator, 1, 2))
        return result

    monkeypatch.setattr(complex_module, "subdivide", subdivide)


def initial(shape):
    return ifs.initial(shape.topology, shape.system, shape.control)


def drawn_faces(complex_, depth):
    """The mesh of step-by-step refinement; of each face its state, piece, address and place in the figure.

    The pieces are followed in the order in which `refine` lists them: by state as counted, label, piece.
    """
    names = {s: [(s, i, ()) for i in range(len(found))] for s, found in complex_.control.items()}
    cells = complex_.topology.automaton.cells
    refined = complex_
    for _ in range(depth):
        following = {}
        for state in [state for state in refined.counts if state in names]:
            found = names[state]
            for label, target in cells[state].subdivision.items():
                following.setdefault(target, []).extend((s, i, (*word, label)) for s, i, word in found)
        names = following
        refined = ifs.refine(refined)
    mesh = ifs.draw(refined)
    keys = []
    for state in refined.control:
        figure = cells[state].figure
        faces = len(figure.faces) if figure and figure.faces else 1
        keys += [(*name, number) for number in range(faces) for name in names[state]]
    assert len(keys) == len(mesh.faces)
    return mesh, keys


def require_same(complex_, depth):
    """The same faces at the same addresses on the same vertices, which are numbered otherwise."""
    expected, keys = drawn_faces(complex_, depth)
    found = stamped(complex_, depth)
    mesh = found.mesh
    assert mesh.vertices.shape == expected.vertices.shape
    assert mesh.faces.shape == expected.faces.shape
    assert mesh.vertices.dtype == np.float64
    assert mesh.faces.dtype == np.int64
    number = {key: i for i, key in enumerate(keys)}
    seen: Counter = Counter()
    order = []
    for face in range(len(mesh.faces)):
        key = found.located(face)
        order.append(number[(*key, seen[key])])
        seen[key] += 1
    assert sorted(order) == list(range(len(keys)))
    twin = np.full(len(mesh.vertices) + 1, -2)
    twin[mesh.faces] = expected.faces[order]
    np.testing.assert_array_equal(twin[mesh.faces], expected.faces[order])
    assert twin[-1] in (-1, -2)
    assert sorted(twin[:-1].tolist()) == list(range(len(expected.vertices)))
    size = np.abs(expected.vertices).max(initial=1)
    np.testing.assert_allclose(mesh.vertices, expected.vertices[twin[:-1]], rtol=0, atol=1e-12 * size)
    return found


@pytest.mark.parametrize("name", DRAWN)
@pytest.mark.parametrize("depth", [0, 1, 3])
def test_built_in_shapes_are_those_of_step_by_step_refinement(name, depth):
    require_same(initial(SHAPES[name]), depth)


# ---- closed surfaces with several kinds of patches ---------------------------------------------------------

CUBE = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]


def prism(n):
    sides = [(i, (i + 1) % n, n + (i + 1) % n, n + i) for i in range(n)]
    return [tuple(range(n))[::-1], tuple(range(n, 2 * n)), *sides]


def torus(rows, columns):
    i, j = np.divmod(np.arange(rows * columns), columns)
    down, right = (i + 1) % rows, (j + 1) % columns
    corners = [i * columns + j, down * columns + j, down * columns + right, i * columns + right]
    return [tuple(face) for face in np.stack(corners, axis=1).tolist()]


def rods(n):
    """Three rods of n cubes along the axes, joined at their first cube: vertices of valence 3 to 6."""
    cells = {tuple(i * (a == axis) for a in range(3)) for axis in range(3) for i in range(n)}
    numbers: dict[tuple, int] = {}
    faces = []
    for cell in sorted(cells):
        for axis, side in np.ndindex(3, 2):
            beside = tuple(c + (2 * side - 1) * (a == axis) for a, c in enumerate(cell))
            if beside not in cells:
                u, v = np.eye(3, dtype=int)[[(axis + 1) % 3, (axis + 2) % 3]]
                ring = [0 * u, u, u + v, v] if side else [v, u + v, u, 0 * u]
                base = np.array(cell) + side * np.eye(3, dtype=int)[axis]
                keys = [tuple((base + step).tolist()) for step in ring]
                faces.append(tuple(numbers.setdefault(key, len(numbers)) for key in keys))
    return faces


CLOSED = {"cube": CUBE, "prism": prism(7), "torus": torus(3, 4), "rods": rods(2)}


@cache
def patches(name, scheme="catmull-clark", seed=0):
    faces = CLOSED[name]
    count = max(map(max, faces)) + 1
    return surface(np.random.default_rng(seed).normal(size=(count, 3)), faces, scheme).complex()


def require_closed(mesh, euler):
    """Every edge is met once in each direction."""
    ends = np.stack([mesh.faces, np.roll(mesh.faces, -1, axis=1)], axis=-1).reshape(-1, 2)
    count = len(mesh.vertices)
    forward, backward = (np.sort(ends @ weights) for weights in ([count, 1], [1, count]))
    assert (np.diff(forward) > 0).all()
    np.testing.assert_array_equal(forward, backward)
    assert count - len(ends) // 2 + len(mesh.faces) == euler


@pytest.mark.parametrize("name", CLOSED)
@pytest.mark.parametrize("scheme", ["catmull-clark", "doo-sabin"])
def test_closed_surfaces_are_those_of_step_by_step_refinement(name, scheme):
    found = require_same(patches(name, scheme), 2)
    require_closed(found.mesh, 0 if name == "torus" else 2)


@pytest.mark.parametrize("name", ["cube", "torus", "rods"])
@pytest.mark.parametrize("depth", [0, 5])
def test_closed_surfaces_keep_their_counts(name, depth):
    mesh = stamped(patches(name), depth).mesh
    assert len(mesh.faces) == len(CLOSED[name]) * 4**depth
    require_closed(mesh, 0 if name == "torus" else 2)
    assert np.isfinite(mesh.vertices).all()


def test_a_complex_that_is_already_refined_goes_on_from_there():
    complex_ = patches("cube")
    once = require_same(ifs.refine(complex_), 2).mesh
    whole = stamped(complex_, 3).mesh
    assert once.vertices.shape == whole.vertices.shape
    rounded = [np.unique(mesh.vertices.round(9) + 0.0, axis=0) for mesh in (once, whole)]
    np.testing.assert_allclose(*rounded, atol=2e-9)


# ---- pieces over common control points, glued in every way -------------------------------------------------


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("name", "points"), [("doo-sabin-patch", 9), ("corner-cutting", 3)])
def test_patches_glued_to_themselves_and_each_other_at_random(name, points, seed):
    """Few control points make many boundaries the same, as they are or turned."""
    shape = SHAPES[name]
    random = np.random.default_rng(seed)
    rows = random.integers(2 + seed % 2, size=(6, points))
    control = random.normal(size=(3, 2))
    require_same(ifs.patchwork(shape.topology, shape.system, control, {shape.automaton.shape: rows}), 2)


def test_one_patch_closed_upon_itself():
    shape = SHAPES["doo-sabin-patch"]
    across = np.array([[3 * i + j for i in (0, 1, 2) for j in (0, 1, 0)]])
    control = np.random.default_rng(0).normal(size=(9, 3))
    tube = ifs.patchwork(shape.topology, shape.system, control, {"face": across})
    require_same(tube, 3)
    curve = SHAPES["corner-cutting"]
    ring = ifs.patchwork(curve.topology, curve.system, control[:2], {"edge": np.array([[0, 1, 0]])})
    mesh = require_same(ring, 3).mesh
    assert (len(mesh.vertices), len(mesh.faces)) == (9, 8)


# ---- other automata ----------------------------------------------------------------------------------------

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


@pytest.mark.parametrize("text", [LOOP, LOOP.replace(', "2 right = 0 left"', "")])
def test_pieces_of_another_kind(text):
    complex_ = initial(ifs.shape(parse_text(text)))
    require_same(complex_, 3)
    assert supports(complex_, 1)
    assert not supports(complex_, 0)
    with pytest.raises(NotStamped, match="cell 'loop' draws the box") as caught:
        stamped(complex_, 0)
    assert caught.value.cell == "loop"


LEAVES = """
format = "bcifs/1"
shape = "leaf"
[cells.vertex]
points = 1
subdivision = { s = "vertex" }
[cells.edge]
points = 2
subdivision = { 0 = "edge", 1 = "edge" }
boundary = { left = { cell = "vertex", points = [0] }, right = { cell = "vertex", points = [1] } }
incidence = ["left s = 0 left", "right s = 1 right"]
adjacency = ["0 right = 1 left"]
symmetry.flip = { points = [1, 0], subdivision = { 0 = "1 flip", 1 = "0 flip" }, \
boundary = { left = "right", right = "left" } }
matrices = { 0 = [["1", "1/2"], ["0", "1/2"]], 1 = [["1/2", "0"], ["1/2", "1"]] }
[cells.triangle]
points = 3
subdivision = { 0 = "triangle", m = "triangle", 1 = "triangle", 2 = "triangle" }
incidence = ["a 0 = 0 a", "a 1 = 1 c", "b 0 = 1 a", "b 1 = 2 c", "c 0 = 2 a", "c 1 = 0 c"]
adjacency = ["0 b = m b flip", "1 b = m c flip", "2 b = m a flip"]
[cells.triangle.boundary]
a = { cell = "edge", points = [0, 1] }
b = { cell = "edge", points = [1, 2] }
c = { cell = "edge", points = [2, 0] }
[cells.triangle.symmetry.turn]
points = [1, 2, 0]
subdivision = { 0 = "1", 1 = "2", 2 = "0", m = "m turn" }
boundary = { a = "b", b = "c", c = "a" }
[cells.triangle.symmetry.flip]
points = [0, 2, 1]
subdivision = { 0 = "0 flip", 1 = "2 flip", 2 = "1 flip", m = "m flip" }
boundary = { a = "c flip", b = "b flip", c = "a flip" }
[cells.triangle.matrices]
0 = [["1", "1/2", "1/2"], ["0", "1/2", "0"], ["0", "0", "1/2"]]
1 = [["0", "0", "1/2"], ["1", "1/2", "1/2"], ["0", "1/2", "0"]]
2 = [["0", "1/2", "0"], ["0", "0", "1/2"], ["1", "1/2", "1/2"]]
m = [["0", "1/2", "1/2"], ["1/2", "0", "1/2"], ["1/2", "1/2", "0"]]
[cells.leaf]
points = 3
subdivision = { 0 = "leaf", 1 = "leaf", 2 = "leaf", m = "leaf" }
boundary = { side = { cell = "triangle", points = [0, 1, 2] } }
incidence = ["side 0 = 0 side", "side 1 = 1 side", "side 2 = 2 side", "side m = m side"]
[control]
points = [[0, 0], [3, 0], [0, 4]]
"""
"""A leaf lies on a triangle cut in four, seen in any of six ways; its edges are seen in two."""


@pytest.mark.parametrize("seed", range(3))
def test_boundaries_seen_through_turns_and_reflections(seed):
    shape = ifs.shape(parse_text(LEAVES))
    random = np.random.default_rng(seed)
    triangles = np.array([[0, 1, 2], [1, 2, 3], [0, 1, 3]])
    rows = random.permuted(triangles[random.integers(3, size=12)], axis=1)
    control = random.normal(size=(4, 3))
    complex_ = ifs.patchwork(shape.topology, shape.system, control, {"leaf": rows})
    assert complex_.boundary["leaf"]["side"].turn.max() > 2
    require_same(complex_, 3)


def with_figure(name, figure):
    automaton = read(name)
    cell = replace(automaton.cells[automaton.shape], figure=figure)
    return initial(ifs.shape(replace(automaton, cells={**automaton.cells, cell.name: cell})))


def test_figures():
    weights = tuple(tuple(Fraction(int(i == j)) for j in range(3)) for i in range(3))
    for figure in (
        Figure("faces", weights, ((0, 1, 2), (0, 2))),
        Figure("faces", (), ((0, 1), (1, 0, 1))),
        Figure("faces", (), ((1,),)),
        Figure("segment"),
        Figure("polygon"),
    ):
        require_same(with_figure("koch-curve", figure), 2)
    require_same(with_figure("menger-sponge", Figure("polygon")), 1)
    assert not supports(with_figure("koch-curve", Figure("box")), 1)
    with pytest.raises(AutomatonError, match="a face names corner 4; the cell has 4"):
        stamped(with_figure("doo-sabin-patch", Figure("faces", (), ((0, 1, 4),))), 1)


# ---- what the mesh does and does not depend on -------------------------------------------------------------


def test_the_faces_do_not_depend_on_coordinates():
    faces = CLOSED["rods"]
    count = max(map(max, faces)) + 1
    collapsed = stamped(surface(np.zeros((count, 3)), faces).complex(), 2).mesh
    mesh = stamped(patches("rods"), 2).mesh
    np.testing.assert_array_equal(collapsed.faces, mesh.faces)
    assert collapsed.vertices.shape == mesh.vertices.shape
    assert (collapsed.vertices == 0).all()


def test_templates_serve_for_other_control_points():
    one, other = patches("cube", seed=1), patches("cube", seed=2)
    stencils = Stencils(Templates(one.topology), one.system)
    stamped(one, 2, stencils)
    moved = replace(one, control=other.control)
    np.testing.assert_array_equal(stamped(moved, 2, stencils).mesh.vertices, stamped(other, 2).mesh.vertices)


def test_large_tables_are_avoided_by_one_more_subdivision(monkeypatch):
    complex_ = patches("cube")
    expected = stamped(complex_, 4).mesh
    monkeypatch.setattr(stencil, "LARGEST", 100)
    found = stamped(complex_, 4).mesh
    np.testing.assert_array_equal(found.faces, expected.faces)
    np.testing.assert_allclose(found.vertices, expected.vertices, rtol=0, atol=1e-13)


def test_the_piece_and_the_address_of_each_face():
    complex_ = patches("rods")
    found = stamped(complex_, 2)
    pieces, addresses = found.piece(), found.addresses()
    starts = dict(zip(found.pieces, np.cumsum([0, *found.pieces.values()]), strict=False))
    for face in range(0, len(found.mesh.faces), 7):
        state, number, word = found.located(face)
        assert pieces[face] == starts[state] + number
        assert [str(label) for label in addresses[face]] == list(word)
    assert set(Counter(pieces.tolist()).values()) == {16}
    with pytest.raises(IndexError, match="the mesh has"):
        found.located(len(found.mesh.faces))


def test_the_depth_is_not_negative():
    with pytest.raises(ValueError, match="found -1"):
        stamped(initial(SHAPES["koch-curve"]), -1)
