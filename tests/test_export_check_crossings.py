"""Self-intersections: exact signs, pairs of triangles in fractions, and whole meshes."""

from fractions import Fraction

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from export.check import check
from export.checks.crossings import crossings
from export.checks.triangle_tree import triangle_tree
from ifs.mesh import Mesh


def exact(rows):
    return [[Fraction(float(x)) for x in row] for row in rows]


def minus(a, b):
    return [x - y for x, y in zip(a, b, strict=True)]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def clipped(polygon, normal, offset):
    """The part of a convex polygon where normal . x >= offset."""
    kept = []
    for a, b in zip(polygon, polygon[1:] + polygon[:1], strict=True):
        p, q = dot(normal, a) - offset, dot(normal, b) - offset
        if p >= 0:
            kept.append(a)
        if p * q < 0:
            kept.append([x + (y - x) * p / (p - q) for x, y in zip(a, b, strict=True)])
    return kept


def meet_in_fractions(p, q) -> bool:
    """Whether the polygon that two triangles have in common is more than their common corners span."""
    p, q = exact(p), exact(q)
    normal = cross(minus(q[1], q[0]), minus(q[2], q[0]))
    if not any(normal) or not any(cross(minus(p[1], p[0]), minus(p[2], p[0]))):
        return False
    common = clipped(p, normal, dot(normal, q[0]))
    common = clipped(common, [-x for x in normal], -dot(normal, q[0]))
    for i in range(3):
        inward = cross(normal, minus(q[(i + 1) % 3], q[i]))
        common = clipped(common, inward, dot(inward, q[i]))
    shared = [a for a in p if a in q]
    if len(shared) == 3:
        return True
    if len(shared) == 2:
        along = minus(shared[1], shared[0])
        return any(any(cross(along, minus(x, shared[0]))) for x in common)
    if len(shared) == 1:
        return any(x != shared[0] for x in common)
    return bool(common)


def pairs_in_fractions(points, triangles) -> list[list[int]]:
    n = len(triangles)
    found = []
    for i in range(n):
        for j in range(i + 1, n):
            same = set(triangles[i].tolist()) == set(triangles[j].tolist())
            if not same and meet_in_fractions(points[triangles[i]], points[triangles[j]]):
                found.append([i, j])
    return found


def sign(value) -> int:
    return (value > 0) - (value < 0)


def test_signs_of_determinants_are_exact() -> None:
    from export.checks.predicates import sides, turns

    rng = np.random.default_rng(0)
    a, b, c = rng.random((3, 600, 3))
    weights = rng.normal(size=(600, 3))
    weights /= weights.sum(axis=1, keepdims=True)
    d = weights[:, :1] * a + weights[:, 1:2] * b + weights[:, 2:] * c  # in the plane, but for rounding
    a, b, c, d = (np.ascontiguousarray(x / max(1.0, np.abs(d).max())) for x in (a, b, c, d))
    a[::3], b[::3] = np.round(a[::3] * 8) / 8, np.round(b[::3] * 8) / 8
    c[1::4] *= 10.0 ** rng.integers(-70, 0, c[1::4].shape)
    expected, plane = [], []
    for p, q, r, s in zip(*map(exact, (a, b, c, d)), strict=True):
        expected.append(sign(dot(minus(p, s), cross(minus(q, s), minus(r, s)))))
        plane.append(sign((p[0] - s[0]) * (q[1] - s[1]) - (p[1] - s[1]) * (q[0] - s[0])))
    assert sides(a, b, c, d).tolist() == expected
    flat = (np.ascontiguousarray(x[:, :2]) for x in (a, b, d))
    assert turns(*flat).tolist() == plane
    assert {-1, 0, 1} <= set(sides(a, a, c, d).tolist()) | set(expected)


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_soups_on_a_small_grid_against_fractions(data) -> None:
    """Where everything is degenerate: common planes, lines and points at every turn."""
    side = data.draw(st.integers(1, 3))
    place = st.tuples(*[st.integers(0, side)] * 3)
    points = np.array(data.draw(st.lists(place, min_size=4, max_size=9)), dtype=float)
    points *= data.draw(st.sampled_from([1.0, 0.1, 1e30]))
    corner = st.integers(0, len(points) - 1)
    triangles = np.array(
        data.draw(st.lists(st.tuples(corner, corner, corner), min_size=2, max_size=10)), dtype=np.int64
    )
    found = crossings(triangle_tree(points, triangles))
    assert found.complete
    assert found.pairs.tolist() == pairs_in_fractions(points, triangles)
    assert found.count == len(found.pairs)


def test_soups_of_random_triangles_against_fractions() -> None:
    rng = np.random.default_rng(1)
    for _ in range(6):
        points = rng.random((14, 3))
        points[7] = points[0] + (points[1] - points[0]) / 3
        triangles = np.array([rng.permutation(14)[:3] for _ in range(16)])
        found = crossings(triangle_tree(points, triangles))
        assert found.pairs.tolist() == pairs_in_fractions(points, triangles)


def test_the_tree_loses_no_pair() -> None:
    """Many small triangles against all pairs tested one by one."""
    from export.checks.pairs import meetings

    rng = np.random.default_rng(2)
    corners = rng.random((700, 1, 3)) * 4 + rng.random((700, 3, 3)) * 10 ** rng.uniform(-2, 0.3, (700, 1, 1))
    corners[100:140] = corners[100]  # equal boxes cannot be told apart by their middles
    triangles = np.arange(2100).reshape(-1, 3)
    found = crossings(triangle_tree(corners.reshape(-1, 3), triangles))
    i, j = np.triu_indices(700, 1)
    met = meetings(np.ascontiguousarray(corners[i]), np.ascontiguousarray(corners[j])) > 0
    assert found.pairs.tolist() == np.column_stack([i, j])[met].tolist()
    assert met.sum() > 40 * 39 / 2


def test_a_search_that_is_given_up_says_so() -> None:
    rng = np.random.default_rng(3)
    tree = triangle_tree(rng.random((300, 3)), np.arange(300).reshape(-1, 3))
    assert crossings(tree).complete
    short = crossings(tree, work=2000)
    assert not short.complete
    assert 0 < short.count < crossings(tree).count


def box(low, high, steps=1) -> Mesh:
    """A box whose faces are cut into steps x steps squares, on a grid of its own side."""
    from dense.surface import surface
    from dense.voxels import Voxels

    filled = np.ones((steps,) * 3, dtype=bool)
    cube = surface(Voxels(filled, np.zeros(3), 1.0), "exact")
    low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    return Mesh(low + cube.vertices * (high - low) / steps, cube.faces)


def together(*meshes: Mesh) -> Mesh:
    starts = np.cumsum([0, *(len(m.vertices) for m in meshes)])
    return Mesh(
        np.vstack([m.vertices for m in meshes]),
        np.vstack([m.faces + start for m, start in zip(meshes, starts[:-1], strict=True)]),
    )


@pytest.mark.parametrize("steps", [1, 4])
def test_boxes_that_pass_through_each_other(steps) -> None:
    """On a common grid they cross just along edges of both."""
    one, other = box((0, 0, 0), (4, 4, 4), steps), box((1, 1, 1), (5, 5, 5), steps)
    report = check(together(one, other))
    assert report.self_intersections
    assert "self_intersections" in {fault.kind for fault in report.details}
    places = np.array(next(f.marks for f in report.details if f.kind == "self_intersections"))
    assert (places >= 1).all()
    assert (places <= 4).all()


def test_boxes_that_touch_do_not_cross() -> None:
    cube = box((0, 0, 0), (2, 2, 2))
    along_an_edge = check(together(cube, box((2, 2, 0), (4, 4, 2))))
    assert along_an_edge.ok
    assert along_an_edge.touching_vertices == 2
    assert check(together(cube, box((2, 2, 2), (4, 4, 4)))).touching_vertices == 1
    assert check(together(cube, box((2.5, 0, 0), (4, 2, 2)))).notes == ()
    # faces that lie upon each other, and a corner within a face
    assert check(together(cube, box((2, 0, 0), (4, 2, 2)))).self_intersections
    assert check(together(cube, box((2, 0.5, 0.5), (4, 1, 1)))).self_intersections


def test_a_crossing_by_less_than_rounding_is_seen() -> None:
    """Tips that reach exactly to a plane, one step of rounding beyond it, and one before."""
    sheet = np.array([[0.1, 0.1, 0.3], [0.7, 0.2, 0.1], [0.2, 0.9, 0.6]])
    mid = sheet.mean(axis=0)
    normal = np.cross(sheet[1] - sheet[0], sheet[2] - sheet[0])
    told = []
    for step in range(-40, 41):
        tip = mid.copy()
        tip[2] += step * 2.0**-54
        far = [mid + normal + [0.1, 0, 0], mid + normal + [0, 0.1, 0]]
        points = np.vstack([sheet, [tip], far])
        triangles = np.array([[0, 1, 2], [3, 4, 5]])
        found = crossings(triangle_tree(points, triangles)).count
        assert found == meet_in_fractions(points[:3], points[3:])
        told.append(found)
    assert 0 < sum(told) < len(told)


def test_sound_shapes_do_not_cross() -> None:
    for made in (
        trimesh.creation.icosphere(3),
        trimesh.creation.torus(2, 0.5),
        trimesh.creation.annulus(1, 2, 1),
        trimesh.creation.capsule(),
    ):
        turned = made.copy()
        turned.apply_transform(trimesh.transformations.rotation_matrix(1, (1, 2, 3)))
        for one in (made, turned):
            assert check(Mesh(np.asarray(one.vertices), np.asarray(one.faces))).self_intersections == 0
