"""Boundaries, creases and regions of control meshes, against plain rules written here and scipy."""

from collections import Counter, defaultdict
from fractions import Fraction
from math import inf

import numpy as np
import pytest
from scipy.interpolate import BSpline

import subdivision
from automata.consistency import require_consistency
from ifs.surfaces.control_mesh import Region, smooth, surface
from ifs.surfaces.polygon_mesh import WrongMesh
from ifs.uniform import uniform
from subdivision.schemes import catmull_clark, doo_sabin

CUBE = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
CORNERS = 10.0 * np.array([(i & 1, i >> 1 & 1, i >> 2) for i in range(8)])


def grid(rows: int, columns: int) -> list[tuple[int, ...]]:
    number = np.arange((rows + 1) * (columns + 1)).reshape(rows + 1, columns + 1)
    return [
        tuple(int(number[p]) for p in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)))
        for i in range(rows)
        for j in range(columns)
    ]


def random_points(faces, seed=0) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(max(map(max, faces)) + 1, 3))


# ---- Catmull and Clark's rules with creases, one vertex and one edge at a time -----------------------------


def pairs_of(face):
    return [frozenset(pair) for pair in zip(face, (*face[1:], face[0]), strict=True)]


def plain_step(points, faces, sharp, fixed):
    """New points and faces, and the sharpness of the new edges; `sharp` maps edges to numbers."""
    centre = [sum(points[v] for v in face) / len(face) for face in faces]
    beside, touching = defaultdict(list), defaultdict(list)
    for number, face in enumerate(faces):
        for pair in pairs_of(face):
            beside[pair].append(number)
        for v in face:
            touching[v].append(number)
    hard = {pair: inf if len(beside[pair]) == 1 else sharp.get(pair, 0.0) for pair in beside}
    new, name = [], {}

    def rule(v, edges):
        if v in fixed or len(edges) > 2:
            return points[v]
        if len(edges) == 2:
            return 0.75 * points[v] + sum(points[w] for pair in edges for w in pair - {v}) / 8
        n = len(touching[v])
        ends = sum(points[w] for pair in hard if v in pair for w in pair - {v})
        return (n - 2) / n * points[v] + (ends + sum(centre[f] for f in touching[v])) / n**2

    for v, point in enumerate(points):
        now = [pair for pair in hard if v in pair and hard[pair] > 0]
        later = [pair for pair in now if hard[pair] > 1]
        gone = [hard[pair] for pair in now if pair not in later]
        share = min(1.0, sum(gone) / len(gone)) if gone else 1.0
        name[v] = len(new)
        new.append(share * rule(v, now) + (1 - share) * rule(v, later) if touching[v] else point)
    after = {}
    for pair, found in beside.items():
        middle = sum(points[v] for v in pair) / 2
        if hard[pair] < 1:
            round_ = (2 * middle + centre[found[0]] + centre[found[1]]) / 4
            middle = hard[pair] * middle + (1 - hard[pair]) * round_
        name[pair] = len(new)
        new.append(middle)
        if hard[pair] > 1:
            after |= {frozenset((name[v], name[pair])): hard[pair] - 1 for v in pair}
    for number, point in enumerate(centre):
        name["face", number] = len(new)
        new.append(point)
    quads = []
    for f, face in enumerate(faces):
        for i, v in enumerate(face):
            before, after_ = (name[frozenset((v, face[j % len(face)]))] for j in (i - 1, i + 1))
            quads.append((name[v], after_, name["face", f], before))
    return np.array(new), quads, after, fixed


def plain_limits(points, faces, sharp, fixed):
    """Limits of vertices once every edge is smooth or sharp for ever."""
    assert all(s == inf for s in sharp.values())
    edges = Counter(pair for face in faces for pair in pairs_of(face))
    hard = defaultdict(list)
    for pair, count in edges.items():
        if count == 1 or pair in sharp:
            for v in pair:
                hard[v] += list(pair - {v})
    ring, opposite, valence = np.zeros_like(points), np.zeros_like(points), np.zeros(len(points))
    for face in faces:
        for i, v in enumerate(face):
            ring[v] += (points[face[i - 1]] + points[face[(i + 1) % 4]]) / 2
            opposite[v] += points[face[i - 2]]
            valence[v] += 1
    n = np.maximum(valence, 1)[:, None]
    result = (n**2 * points + 4 * ring + opposite) / (n * (n + 5))
    for v, ends in hard.items():
        if v in fixed or len(ends) > 2:
            result[v] = points[v]
        elif len(ends) == 2:
            result[v] = (4 * points[v] + points[ends].sum(axis=0)) / 6
        elif len(ends) == 1:
            result[v] = dart_limit(points, faces, v, ends[0])
    return result


def dart_limit(points, faces, v, end):
    """Where the one-ring of a vertex with a single crease goes, by iterating its rules."""
    beside = [[face[face.index(v) - i] for i in (3, 2, 1)] for face in faces if v in face]
    following = {a: (b, c) for a, b, c in beside}
    ends, corners, here = [], [], end
    for _ in following:
        ends.append(points[here])
        corner, here = following[here]
        corners.append(points[corner])
    centre, ends, corners, n = points[v], np.array(ends), np.array(corners), len(ends)
    for _ in range(80):
        new = (centre + ends + np.roll(ends, -1, axis=0) + corners) / 4
        middles = (centre + ends + new + np.roll(new, 1, axis=0)) / 4
        middles[0] = (centre + ends[0]) / 2
        centre = (n - 2) / n * centre + (ends.sum(axis=0) + new.sum(axis=0)) / n**2
        ends, corners = middles, new
    return centre


def expected(points, faces, depth, creases=None, fixed=()):
    """The limits of the vertices of the mesh after `depth` steps, and its faces."""
    state = np.array(points), faces, {frozenset(k): float(v) for k, v in (creases or {}).items()}, set(fixed)
    if any(len(face) != 4 for face in faces):
        state = plain_step(*state)
    for _ in range(depth):
        state = plain_step(*state)
    quads, count = state[1], len(state[0])
    while any(0 < s < inf for s in state[2].values()):
        state = plain_step(*state)
    return plain_limits(*state)[:count], quads


def require_same(mesh, points, faces):
    used = np.unique(np.concatenate([list(face) for face in faces]))
    distance = np.abs(mesh.vertices[:, None] - points[None, used]).max(axis=2)
    twin = used[distance.argmin(axis=1)]
    assert len(mesh.vertices) == len(used) == len(set(twin.tolist()))
    np.testing.assert_allclose(mesh.vertices, points[twin], rtol=0, atol=1e-10)
    found = Counter(frozenset(twin[face].tolist()) for face in mesh.polygons())
    assert found == Counter(frozenset(face) for face in faces)


# ---- boundaries --------------------------------------------------------------------------------------------

OPEN = {
    "one face": [(0, 1, 2, 3)],
    "triangle": [(0, 1, 2)],
    "grid": grid(3, 4),
    "strip": grid(1, 3),
    "cube without a face": CUBE[1:],
    "ring": [CUBE[i] for i in (0, 1, 2, 3)],
    "fan of five": [(0, 1 + 2 * i, 2 + 2 * i, 1 + (2 * i + 2) % 10) for i in range(5)],
    "boundary of three faces": [(0, 1, 2, 3), (0, 3, 4, 5), (0, 5, 6, 7)],
}


@pytest.mark.parametrize("boundary", ["smooth", "corners"])
@pytest.mark.parametrize("name", OPEN)
def test_open_meshes_end_in_the_spline_of_their_boundary(name, boundary):
    faces = OPEN[name]
    points = random_points(faces, 3)
    fixed = ()
    if boundary == "corners":
        touching = Counter(v for face in faces for v in face)
        fixed = {v for v, count in touching.items() if count == 1}
    mesh = smooth(points, faces, 2, boundary=boundary)
    require_same(mesh, *expected(points, faces, 2, fixed=fixed))


def spline_rows(points, degree):
    """The limit B-spline of control points at the parameters 0, 1/4, … of its pieces."""
    count = len(points)
    knots = np.arange(count + degree + 1)
    t = np.linspace(degree, count, 4 * (count - degree) + 1)
    return BSpline(knots, points, degree, extrapolate=True)(t)


def test_doo_sabins_surface_ends_in_the_spline_of_doubled_points():
    rows, columns = 3, 4
    points = random_points(grid(rows, columns), 5)
    net = points.reshape(rows + 1, columns + 1, 3)[[0, 0, 1, 2, 3, 3]][:, [0, 0, 1, 2, 3, 4, 4]]
    known = spline_rows(np.swapaxes(spline_rows(net, 2), 0, 1), 2).reshape(-1, 3)
    mesh = smooth(points, grid(rows, columns), 2, "doo-sabin", boundary="corners")
    assert mesh.vertices.shape == known.shape
    distance = np.abs(mesh.vertices[:, None] - known[None]).max(axis=2)
    assert distance.min(axis=1).max() < 1e-12
    assert distance.min(axis=0).max() < 1e-12


def test_doo_sabins_smooth_boundary_is_the_quadratic_spline_of_the_boundary():
    faces = CUBE[1:]
    points = random_points(faces, 7)
    mesh = smooth(points, faces, 3, "doo-sabin", boundary="smooth")
    sides = Counter(pair for face in mesh.polygons() for pair in pairs_of(face.tolist()))
    rim = sorted({v for pair, count in sides.items() if count == 1 for v in pair})
    loop = points[[0, 1, 3, 2, 0, 1]]
    curve = BSpline(np.arange(9), loop, 2)(np.linspace(2, 6, 64 * 4 + 1))
    distance = np.linalg.norm(mesh.vertices[rim][:, None] - curve[None], axis=2).min(axis=1)
    assert len(rim) > 8
    assert distance.max() < 1e-12


def test_a_hole_is_refused_unless_the_boundary_has_a_rule():
    with pytest.raises(WrongMesh, match="face 1: the edge from vertex 0 to 1 has no other face"):
        surface(CORNERS, CUBE[1:])
    with pytest.raises(WrongMesh, match="the boundary is"):
        surface(CORNERS, CUBE[1:], boundary="sharp")


def test_two_fans_at_a_vertex_are_refused():
    with pytest.raises(WrongMesh, match="several fans"):
        surface(random_points([(0, 6)]), [(0, 1, 2, 3), (0, 4, 5, 6)], boundary="smooth")


# ---- creases -----------------------------------------------------------------------------------------------

RING = {(0, 1): inf, (1, 3): inf, (3, 2): inf, (2, 0): inf}
CREASES = {
    "a ring": RING,
    "a semi-sharp ring": dict.fromkeys(RING, 2),
    "fractions": dict(zip(RING, (0.5, 1.5, 1.25, 2), strict=True)),
    "one edge, a dart": {(0, 1): inf},
    "two darts": {(0, 1): inf, (1, 3): inf},
    "three edges meet": {(0, 1): inf, (0, 2): inf, (0, 4): inf},
    "a crease crossed by a semi-sharp edge": {**RING, (0, 4): 1.5},
    "three semi-sharp edges meet": {(0, 1): 1, (0, 2): 2, (0, 4): 0.5},
    "very sharp": dict.fromkeys(RING, 12),
}


@pytest.mark.parametrize("depth", [1, 3])
@pytest.mark.parametrize("name", CREASES)
def test_creases_of_a_cube(name, depth):
    points = random_points(CUBE, 11)
    creases = CREASES[name]
    known = {pair: inf if s >= 10 else s for pair, s in creases.items()}
    require_same(smooth(points, CUBE, depth, creases=creases), *expected(points, CUBE, depth, known))


def test_creases_that_meet_a_boundary_and_polygons():
    faces = [(0, 1, 2), (0, 2, 3, 4), (0, 4, 5), (0, 5, 6, 7, 1)]
    points = random_points(faces, 13)
    for creases in ({(0, 2): 2.5, (0, 5): inf}, {(0, 1): 1, (0, 4): inf, (0, 5): inf}):
        mesh = smooth(points, faces, 1, creases=creases, corners=[3], boundary="smooth")
        require_same(mesh, *expected(points, faces, 1, creases, [3]))
    inner = grid(3, 3)
    points = random_points(inner, 14)
    for creases in ({(1, 5): inf, (5, 9): inf}, {(1, 5): inf, (5, 6): 1.5}, {(4, 5): 2, (1, 5): 0.25}):
        mesh = smooth(points, inner, 1, creases=creases, boundary="corners")
        require_same(mesh, *expected(points, inner, 1, creases, [0, 3, 12, 15]))


def test_a_cube_with_all_edges_sharp_stays_a_cube():
    edges = {tuple(sorted(pair)): inf for face in CUBE for pair in pairs_of(face)}
    mesh = smooth(CORNERS, CUBE, 3, creases=edges)
    assert mesh.to_trimesh().volume == pytest.approx(1000, abs=1e-9)
    assert np.abs(mesh.vertices[:, :, None] - np.array([0, 10])).min(axis=(1, 2)).max() < 1e-12


def test_the_equations_of_creased_surfaces_hold_exactly():
    for creases, kinds in ((CREASES["three edges meet"], 40), (CREASES["fractions"], 150)):
        whole = surface(CORNERS, CUBE, creases=creases).topology.automaton
        assert len(whole.cells) < kinds
        assert subdivision.solve(whole).degrees_of_freedom == 0
        require_consistency(whole)


def test_the_two_sides_of_a_crease_share_only_its_curve():
    found = surface(CORNERS, CUBE, creases=RING)
    assert found.topology.automaton.cells["edge-x|x|-x|x|"].points == 4
    assert {rows.shape[1] for rows in found.patches.values()} <= {4, 8, 12}


def test_wrong_marks_are_refused():
    with pytest.raises(WrongMesh, match="no edge from vertex 0 to 3"):
        surface(CORNERS, CUBE, creases={(0, 3): 1})
    for wrong in (-1, float("nan")):
        with pytest.raises(WrongMesh, match="is 0 or more"):
            surface(CORNERS, CUBE, creases={(0, 1): wrong})
    with pytest.raises(WrongMesh, match="no vertex 8"):
        surface(CORNERS, CUBE, corners=[8])
    with pytest.raises(WrongMesh, match="face 2: it belongs to two regions"):
        surface(CORNERS, CUBE, regions=[Region([1, 2], SOFT), Region([2], SOFT)])
    with pytest.raises(WrongMesh, match="has a face 6"):
        surface(CORNERS, CUBE, regions=[Region([6], SOFT)])
    with pytest.raises(ValueError, match="no creases"):
        surface(CORNERS, CUBE, "doo-sabin", creases={(0, 1): 1})


# ---- regions -----------------------------------------------------------------------------------------------

SOFT = catmull_clark.Coefficients()
ROUGH = catmull_clark.Coefficients(
    end=Fraction(1, 8), vertex=lambda n: (Fraction(1, 4), Fraction(1), Fraction(-1, 4))
)


def skewed(n):
    """Weights that are not the same from both ends, and rough."""
    rest = [Fraction(0)] * (n - 2)
    return (Fraction(4, 5), Fraction(3, 10), *rest[:-1], Fraction(-1, 10)) if n > 2 else ()


def torus(rows, columns):
    number = np.arange(rows * columns).reshape(rows, columns)
    return [
        tuple(int(number[p % rows, q % columns]) for p, q in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)))
        for i in range(rows)
        for j in range(columns)
    ]


def require_closed(mesh, euler):
    sides = Counter(
        pair
        for face in mesh.polygons()
        for pair in zip(face.tolist(), np.roll(face, -1).tolist(), strict=True)
    )
    assert set(sides.values()) == {1}
    assert all((w, v) in sides for v, w in sides)
    assert len(mesh.vertices) - len(sides) // 2 + len(mesh.faces) == euler


def test_a_region_with_the_schemes_own_coefficients_changes_nothing():
    points = random_points(CUBE, 17)
    for scheme, own in (("catmull-clark", SOFT), ("doo-sabin", doo_sabin.coefficients)):
        one, other = (smooth(points, CUBE, 2, scheme, regions=r) for r in ((), [Region([0, 2], own)]))
        require_same(other, one.vertices, [tuple(face.tolist()) for face in one.polygons()])


@pytest.mark.parametrize(("scheme", "rough"), [("catmull-clark", ROUGH), ("doo-sabin", skewed)])
def test_a_mesh_half_smooth_and_half_rough_is_one_surface(scheme, rough):
    faces = torus(6, 5)
    points = random_points(faces, 19)
    half = Region(range(15), rough)
    whole = surface(points, faces, scheme, regions=[half])
    assert subdivision.solve(whole.topology.automaton).degrees_of_freedom == 0
    mixed = smooth(points, faces, 2, scheme, regions=[half])
    require_closed(mixed, 0)
    same = smooth(points, faces, 2, scheme)
    kept = {tuple(np.round(v, 9)) for v in same.vertices} & {tuple(np.round(v, 9)) for v in mixed.vertices}
    assert len(same.vertices) / 10 < len(kept) < len(same.vertices) / 2


def test_a_region_everywhere_is_the_surface_of_its_coefficients():
    """Doo and Sabin's patches with other weights are those of a tensor product of corner cuttings."""
    a = Fraction(3, 10)
    faces = torus(5, 4)
    points = random_points(faces, 23)
    b = 1 - a
    region = Region(range(len(faces)), lambda n: (b * b, a * b, a * a, a * b))
    mesh = smooth(points, faces, 3, "doo-sabin", regions=[region])
    net = points.reshape(5, 4, 3)
    for _ in range(6):
        for axis in (0, 1):
            after = np.roll(net, -1, axis=axis)
            cut = np.stack(
                [float(b) * net + float(a) * after, float(a) * net + float(b) * after], axis=axis + 1
            )
            net = cut.reshape(*(2 * s if i == axis else s for i, s in enumerate(net.shape)))
    size = np.ptp(points)
    distance = np.linalg.norm(mesh.vertices[:40, None] - net.reshape(1, -1, 3), axis=2).min(axis=1)
    assert distance.max() < size * 0.7**6


def test_weights_that_do_not_sum_to_one_are_refused():
    with pytest.raises(ValueError, match="sum to 1"):
        surface(CORNERS, CUBE, "doo-sabin", regions=[Region([0], lambda n: (Fraction(1, 2),) * n)])
    bad = catmull_clark.Coefficients(vertex=lambda n: (Fraction(1), Fraction(1), Fraction(1)))
    with pytest.raises(ValueError, match="sum to 1"):
        surface(CORNERS, CUBE, regions=[Region(range(6), bad)])


# ---- free coefficients -------------------------------------------------------------------------------------


@pytest.mark.parametrize("scheme", ["catmull-clark", "doo-sabin"])
def test_the_coefficients_that_the_constraints_leave_open_can_be_chosen_for_each_kind_of_patch(scheme):
    found = surface(CORNERS, CUBE, scheme)
    family = found.family()
    own = uniform(found.complex(), 2)
    np.testing.assert_allclose(uniform(found.complex(family), 2).vertices, own.vertices, atol=1e-12)
    entry, value = next(iter(family.values.items()))
    other = uniform(found.complex(subdivision.overridden(family, {entry: value + Fraction(1, 20)})), 2)
    require_closed(other, 2)
    assert np.abs(other.vertices - own.vertices).max() > 0.05


@pytest.mark.parametrize(("scheme", "free"), [("catmull-clark", 4), ("doo-sabin", 3)])
def test_a_regular_mesh_has_the_degrees_of_freedom_of_the_source(scheme, free):
    faces = torus(4, 5)
    family = surface(random_points(faces), faces, scheme).family()
    assert subdivision.solve(family).degrees_of_freedom == len(family.values) == free
