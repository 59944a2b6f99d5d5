"""Smooth surfaces of closed control meshes against a plain refinement written here and the limit formulas."""

from collections import Counter, defaultdict
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import ifs
import subdivision
from automata.consistency import require_consistency
from ifs.surfaces.control_mesh import smooth, surface
from ifs.surfaces.polygon_mesh import WrongMesh, polygon_mesh
from subdivision.schemes import catmull_clark, doo_sabin, patches

SCHEMES = {"catmull-clark": catmull_clark.SCHEME, "doo-sabin": doo_sabin.SCHEME}

CUBE = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
TETRAHEDRON = [(0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)]


def cube(size: float = 10.0) -> np.ndarray:
    return size * np.array([(i & 1, i >> 1 & 1, i >> 2) for i in range(8)], dtype=float)


def torus(rows: int, columns: int) -> list[tuple[int, ...]]:
    def number(i, j):
        return (i % rows) * columns + j % columns

    return [
        (number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1))
        for i in range(rows)
        for j in range(columns)
    ]


def voxels(cells: list[tuple[int, int, int]]) -> list[tuple[int, ...]]:
    """The outer squares of a solid of unit cubes: valences 3 to 6, extraordinary vertices side by side."""
    numbers: dict[tuple, int] = {}
    result = []
    for cell in cells:
        for axis in range(3):
            for side in (0, 1):
                beside = tuple(c + (2 * side - 1) * (a == axis) for a, c in enumerate(cell))
                if beside in cells:
                    continue
                u, v = (axis + 1) % 3, (axis + 2) % 3
                ring = [(0, 0), (1, 0), (1, 1), (0, 1)]
                corners = []
                for s, t in ring if side else ring[::-1]:
                    corner = list(cell)
                    corner[axis] += side
                    corner[u] += s
                    corner[v] += t
                    corners.append(numbers.setdefault(tuple(corner), len(numbers)))
                result.append(tuple(corners))
    return result


def prism(n: int) -> list[tuple[int, ...]]:
    """Two faces of n corners with n quadrangles between them."""
    sides = [(i, (i + 1) % n, n + (i + 1) % n, n + i) for i in range(n)]
    return [tuple(range(n))[::-1], tuple(range(n, 2 * n)), *sides]


def trapezohedron(n: int) -> list[tuple[int, ...]]:
    """2n quadrangles: two vertices of valence n, all others of valence 3, next to them and to each other."""
    ring = range(2, 2 * n + 2)
    top = [(0, ring[2 * i], ring[2 * i + 1], ring[(2 * i + 2) % (2 * n)]) for i in range(n)]
    low = [(1, ring[2 * i + 1], ring[2 * i], ring[2 * i - 1]) for i in range(n)]
    return top + low


L_SHAPE = voxels([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
MESHES = {
    "cube": CUBE,
    "torus": torus(3, 4),
    "corner of cubes": L_SHAPE,
    **{f"trapezohedron {n}": trapezohedron(n) for n in (3, 4, 5, 7)},
    "tetrahedron": TETRAHEDRON,
    "prism 7": prism(7),
    "prism 3": prism(3),
    "mixed": [*prism(5)[1:], *((i, (i + 4) % 5, 10) for i in range(5))],
}


def control(faces, seed: int = 0) -> np.ndarray:
    count = max(max(face) for face in faces) + 1
    return np.random.default_rng(seed).normal(size=(count, 3))


# ---- the plain schemes, by dictionaries of points, faces and edges -----------------------------------------


def plain_catmull_clark(points, faces):
    points = [np.array(p) for p in points]
    centre = [np.mean([points[v] for v in face], axis=0) for face in faces]
    beside, neighbours, touching = defaultdict(list), defaultdict(set), defaultdict(list)
    for number, face in enumerate(faces):
        for v, w in zip(face, (*face[1:], face[0]), strict=True):
            beside[frozenset((v, w))].append(number)
            neighbours[v].add(w)
            neighbours[w].add(v)
            touching[v].append(number)
    new, name = [], {}
    for v, p in enumerate(points):
        n = len(touching[v])
        name[v] = len(new)
        ring = sum(points[w] for w in neighbours[v]) + sum(centre[f] for f in touching[v])
        new.append((n - 2) / n * p + ring / n**2)
    for edge, (f, g) in beside.items():
        name[edge] = len(new)
        new.append((sum(points[v] for v in edge) + centre[f] + centre[g]) / 4)
    for number, point in enumerate(centre):
        name["face", number] = len(new)
        new.append(point)
    quads = [
        (
            name[v],
            name[frozenset((v, face[(i + 1) % len(face)]))],
            name["face", number],
            name[frozenset((v, face[i - 1]))],
        )
        for number, face in enumerate(faces)
        for i, v in enumerate(face)
    ]
    return np.array(new), quads


def limits_catmull_clark(points, quads):
    """Each vertex of a mesh of quadrangles at its limit: (n^2 V + 4 sum E + sum D) / (n (n + 5))."""
    edges, corners = np.zeros_like(points), np.zeros_like(points)
    valence = np.zeros(len(points))
    for quad in quads:
        for i, v in enumerate(quad):
            edges[v] += (points[quad[i - 1]] + points[quad[(i + 1) % 4]]) / 2
            corners[v] += points[quad[i - 2]]
            valence[v] += 1
    n = valence[:, None]
    return (n**2 * points + 4 * edges + corners) / (n * (n + 5)), quads


def plain_doo_sabin(points, faces):
    new, name = [], {}
    for number, face in enumerate(faces):
        n = len(face)
        weights = (3 + 2 * np.cos(2 * np.pi * np.arange(n) / n)) / (4 * n)
        weights[0] = (n + 5) / (4 * n)
        for j, v in enumerate(face):
            name[v, number] = len(new)
            new.append(sum(weights[(k - j) % n] * points[face[k]] for k in range(n)))
    faces_after = [[name[v, number] for v in face] for number, face in enumerate(faces)]
    directed = {
        (v, w): number
        for number, face in enumerate(faces)
        for v, w in zip(face, (*face[1:], face[0]), strict=True)
    }
    for (v, w), f in directed.items():
        if v < w:
            g = directed[w, v]
            faces_after.append([name[w, f], name[v, f], name[v, g], name[w, g]])
    for v in {v for v, _ in directed}:
        before = {f: w for (w, end), f in directed.items() if end == v}
        fan = [next(iter(before))]
        while (following := directed[v, before[fan[-1]]]) != fan[0]:
            fan.append(following)
        faces_after.append([name[v, f] for f in fan])
    return np.array(new), faces_after


def limits_doo_sabin(points, faces):
    """The centroids of the faces; a face for each vertex."""
    centres = np.array([np.mean([points[v] for v in face], axis=0) for face in faces])
    around = defaultdict(list)
    for number, face in enumerate(faces):
        for v in face:
            around[v].append(number)
    return centres, list(around.values())


PLAIN = {
    "catmull-clark": (plain_catmull_clark, limits_catmull_clark),
    "doo-sabin": (plain_doo_sabin, limits_doo_sabin),
}


def expected(scheme, points, faces, depth):
    """The limits of the vertices of a plain refinement, after the first step where the mesh needs one."""
    step, limits = PLAIN[scheme]
    if scheme == "catmull-clark":
        ready = all(len(face) == 4 for face in faces)
    else:
        ready = set(Counter(v for face in faces for v in face).values()) == {4}
    for _ in range(depth + (not ready)):
        points, faces = step(points, faces)
    return limits(points, faces)


def edges_of(mesh) -> Counter:
    return Counter(
        pair
        for face in mesh.polygons()
        for pair in zip(face.tolist(), np.roll(face, -1).tolist(), strict=True)
    )


def require_same(mesh, points, faces):
    """The same vertices, and the same faces on them."""
    assert mesh.vertices.shape == points.shape
    distance = np.abs(mesh.vertices[:, None] - points[None]).max(axis=2)
    twin = distance.argmin(axis=1)
    assert len(set(twin.tolist())) == len(points)
    np.testing.assert_allclose(mesh.vertices, points[twin], rtol=0, atol=1e-10)
    found = Counter(frozenset(twin[face].tolist()) for face in mesh.polygons())
    assert found == Counter(frozenset(face) for face in faces)


def require_closed(mesh, euler: int):
    edges = edges_of(mesh)
    assert set(edges.values()) == {1}
    assert all((w, v) in edges for v, w in edges)
    assert len(mesh.vertices) - len(edges) // 2 + len(mesh.faces) == euler


def euler_of(faces) -> int:
    edges = {frozenset(pair) for face in faces for pair in zip(face, (*face[1:], face[0]), strict=True)}
    return len({v for face in faces for v in face}) - len(edges) + len(faces)


# ---- the tests ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("depth", [1])
@pytest.mark.parametrize("name", MESHES)
@pytest.mark.parametrize("scheme", SCHEMES)
def test_limits_equal_those_of_a_plain_refinement(scheme, name, depth):
    faces = MESHES[name]
    points = control(faces, depth)
    mesh = smooth(points, faces, depth, scheme)
    require_same(mesh, *expected(scheme, points, faces, depth))
    require_closed(mesh, euler_of(faces))


CORNER = {"catmull-clark": catmull_clark.ring, "doo-sabin": doo_sabin.Corner}


@pytest.mark.parametrize("valences", [(3, 3, 3, 3), (7, 3, 5, 4), (3, 3, 4, 6)])
@pytest.mark.parametrize("scheme", SCHEMES)
def test_the_equations_hold_exactly_for_any_valences(scheme, valences):
    whole = patches.automaton(SCHEMES[scheme], [tuple(map(CORNER[scheme], valences))])
    solution = subdivision.solve(whole)
    assert solution.degrees_of_freedom == 0
    require_consistency(whole)
    for rows in (rows for cell in whole.cells.values() for rows in cell.matrices.values()):
        assert {sum(entry.value for entry in column) for column in zip(*rows, strict=True)} == {1}


def test_a_wrong_coefficient_contradicts_the_equations():
    good = doo_sabin.SCHEME

    def vertex(star):
        corner, (first, second, *rest) = good.vertex(star)
        moved = patches.mixed((Fraction(9, 10), first), (Fraction(1, 10), second))
        return patches.Star(corner, (moved, second, *rest))

    with pytest.raises(AssertionError, match="do not agree"):
        patches.automaton(replace(good, vertex=vertex), [(doo_sabin.Corner(4),) * 4])


@pytest.mark.parametrize(
    ("scheme", "name"), [("catmull-clark", "catmull-clark-patch"), ("doo-sabin", "doo-sabin-patch")]
)
def test_a_regular_patch_is_that_of_the_built_in_automaton(scheme, name):
    """The same limit mesh, whatever the order in which the two list their control points."""
    width = {"catmull-clark": 4, "doo-sabin": 3}[scheme]
    faces = torus(5, 6)
    points = control(faces, 5)
    i, j, r, c = np.ogrid[:5, :6, :width, :width]
    rows = (((i + r) % 5) * 6 + (j + c) % 6).reshape(30, width * width)
    shape = ifs.shape(name)
    known = ifs.draw(ifs.refined(ifs.patchwork(shape.topology, shape.system, points, {"face": rows}), 2))
    require_same(smooth(points, faces, 2, scheme), known.vertices, known.polygons())


@pytest.mark.parametrize("scheme", SCHEMES)
def test_states_grow_with_the_kinds_of_patches_and_not_with_the_mesh(scheme):
    small, large = torus(4, 5), torus(9, 11)
    states = [len(surface(control(f), f, scheme).topology.automaton.cells) for f in (small, large)]
    assert states == [3, 3]
    kinds = surface(control(CUBE), CUBE, "catmull-clark").topology.automaton.cells
    faces = {"face-3-3-3-3", "face-3-4-4-4", "face-4-4-4-4"}
    assert set(kinds) == {*faces, "edge-3-3", "edge-4-3", "edge-4-4", "vertex-3", "vertex-4"}


def test_every_state_contracts():
    whole = surface(control(L_SHAPE), L_SHAPE)
    assert {"face-5", "vertex-5"} <= {
        n[:8] if n.startswith("v") else n[:6] for n in whole.topology.automaton.cells
    }
    ifs.require_contraction(whole.complex().system)


def test_the_order_of_a_mesh_does_not_matter():
    """Faces begun at another corner, and listed in another order, give the same surface."""
    random = np.random.default_rng(1)
    faces, points = L_SHAPE, control(L_SHAPE)
    turned = [tuple(np.roll(face, random.integers(4)).tolist()) for face in faces]
    shuffled = [turned[i] for i in random.permutation(len(turned))]
    one, other = smooth(points, faces, 2), smooth(points, shuffled, 2)
    require_same(one, other.vertices, other.polygons())


@pytest.mark.parametrize("scheme", SCHEMES)
def test_an_affine_map_of_the_control_mesh_moves_the_surface_alike(scheme):
    points = control(L_SHAPE)
    matrix, shift = np.random.default_rng(2).normal(size=(3, 3)), np.array([3.0, -1, 2])
    before, after = (smooth(p, L_SHAPE, 1, scheme).vertices for p in (points, points @ matrix + shift))
    np.testing.assert_allclose(after, before @ matrix + shift, atol=1e-12)


def test_a_cube_becomes_a_ball_with_the_cubes_symmetries():
    mesh = smooth(cube(), CUBE, 3)
    centred = mesh.vertices - 5
    keys = {tuple(row) for row in np.round(centred, 9) + 0.0}
    for image in (centred[:, [1, 2, 0]], centred * [-1, 1, 1], centred[:, [1, 0, 2]]):
        assert {tuple(row) for row in np.round(image, 9) + 0.0} == keys
    # The corner: (9 V + 4 sum E + sum D) / 24 with V = (5, 5, 5), sum E = V, sum D = -V: V / 2.
    corner = centred[np.argmax(centred.sum(axis=1))]
    np.testing.assert_allclose(corner, [2.5, 2.5, 2.5], atol=1e-12)
    assert mesh.to_trimesh().volume > 0


def test_rows_that_end_in_minus_one_are_shorter_faces():
    faces = prism(3)
    padded = np.array([(*face, -1) if len(face) == 3 else face for face in faces])
    points = control(faces)
    one, other = smooth(points, faces, 1), smooth(points, padded, 1)
    np.testing.assert_array_equal(one.vertices, other.vertices)
    np.testing.assert_array_equal(one.faces, other.faces)


def two_cubes(shared: int) -> list[tuple[int, ...]]:
    """Two cubes with the first vertices in common."""
    return CUBE + [tuple(v if v < shared else v + 8 for v in face) for face in CUBE]


WRONG = [
    ([], None, "no faces"),
    (CUBE[:-1], 0, "close the hole"),
    ([*CUBE, (0, 1, 8)], 0, "more than two faces"),
    ([*CUBE, CUBE[3]], 6, "same vertices as face 3"),
    ([*CUBE, CUBE[3][::-1]], 6, "same vertices as face 3"),
    ([*CUBE, (0, 1)], 6, "3 corners or more"),
    ([*CUBE, ()], 6, "3 corners or more"),
    ([*CUBE, (0, 1, 1, 2)], 6, "vertex 1 comes twice"),
    ([*CUBE, (0, 1, 99)], 6, "no vertex 99"),
    ([*CUBE, (0, 1, -2)], 6, "no vertex -2"),
    ([CUBE[0], CUBE[1][::-1], *CUBE[2:]], None, "turn one of them over"),
    (two_cubes(1), None, "several fans"),
    (two_cubes(2), None, "more than two faces"),
    ([(0, 1, 2), (0, 2, 3), (3, 2, 1, 0)], None, "3 or more must"),
]


@pytest.mark.parametrize(("faces", "face", "words"), WRONG)
def test_wrong_meshes_are_refused_by_face(faces, face, words):
    with pytest.raises(WrongMesh, match=words) as caught:
        surface(np.random.default_rng(0).normal(size=(20, 3)), faces)
    if face is not None:
        assert caught.value.face == face
    if faces:
        assert f"face {caught.value.face}: " in str(caught.value)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_vertices_that_are_not_finite_are_refused_by_face(bad):
    points = cube()
    points[7, 1] = bad
    with pytest.raises(WrongMesh, match="vertex 7 is not finite") as caught:
        polygon_mesh(points, CUBE)
    assert caught.value.face == 1


def test_other_wrong_arguments_are_refused():
    with pytest.raises(WrongMesh, match="rows of 3 coordinates"):
        polygon_mesh(cube()[:, :2], CUBE)
    with pytest.raises(ValueError, match="unknown scheme"):
        surface(cube(), CUBE, "loop")
    with pytest.raises(ValueError, match="depth"):
        smooth(cube(), CUBE, -1)
    with pytest.raises(ValueError, match="at least 3"):
        catmull_clark.ring(2)
    with pytest.raises(ValueError, match="at least one kind"):
        patches.automaton(catmull_clark.SCHEME, [])
