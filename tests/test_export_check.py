"""The check: each fault is found, counted and placed; sound meshes pass."""

import json

import numpy as np
import pytest
import trimesh

from export.check import check
from ifs.mesh import Mesh

TETRA = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
TETRA_FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])


def ball(radius: float, centre: tuple[float, float, float] = (0, 0, 0), inward: bool = False) -> Mesh:
    sphere = trimesh.creation.icosphere(subdivisions=1, radius=radius)
    faces = np.asarray(sphere.faces, dtype=np.int64)
    return Mesh(np.asarray(sphere.vertices) + centre, faces[:, ::-1] if inward else faces)


def together(*meshes: Mesh) -> Mesh:
    starts = np.cumsum([0, *(len(m.vertices) for m in meshes)])
    return Mesh(
        np.vstack([m.vertices for m in meshes]),
        np.vstack([m.faces + start for m, start in zip(meshes, starts[:-1], strict=True)]),
    )


def sierpinski(level: int) -> Mesh:
    """Tetrahedra that touch at points, equal positions as one vertex."""
    corners = TETRA[None]
    for _ in range(level):
        corners = np.concatenate([(corners + TETRA[k]) / 2 for k in range(4)])
    points, number = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    return Mesh(points, number.reshape(-1, 4)[:, TETRA_FACES].reshape(-1, 3))


def kinds(mesh: Mesh) -> dict[str, int]:
    return {fault.kind: fault.count for fault in check(mesh).details}


@pytest.mark.parametrize("genus", [0, 1])
def test_sound_meshes_pass(genus) -> None:
    shape = trimesh.creation.torus(2, 0.5) if genus else trimesh.creation.icosphere(2)
    report = check(Mesh(np.asarray(shape.vertices), np.asarray(shape.faces)))
    assert report.ok
    assert report.genus == (genus,)
    assert report.euler == 2 - 2 * genus
    assert report.volume == pytest.approx(shape.volume)
    assert report.area == pytest.approx(shape.area)
    np.testing.assert_allclose([report.low, report.high], shape.bounds)


@pytest.mark.parametrize("level", [1, 2, 3])
def test_tetrahedra_that_touch_at_points_fail(level) -> None:
    mesh = sierpinski(level)
    assert mesh.to_trimesh().is_watertight
    report = check(mesh)
    assert not report.ok
    assert report.components == 4**level
    assert report.nonmanifold_vertices == 2 * (4**level - 1)  # all vertices but the four corners
    assert kinds(mesh) == {"nonmanifold_vertices": 2 * (4**level - 1)}
    assert len(report.details[0].places) == min(5, 2 * (4**level - 1))
    for place in report.details[0].places:
        assert (np.array(place) == TETRA).all(axis=1).sum() == 0
        assert (np.array(place) == mesh.vertices).all(axis=1).sum() == 1
    assert report.volume == pytest.approx(1 / 6 / 2**level)


def test_each_fault_is_named() -> None:
    assert kinds(Mesh(TETRA, TETRA_FACES[:3])) == {"boundary_edges": 3}
    flipped = TETRA_FACES.copy()
    flipped[2] = flipped[2, ::-1]
    assert kinds(Mesh(TETRA, flipped)) == {"misoriented_edges": 3}
    assert kinds(Mesh(TETRA, TETRA_FACES[:, ::-1])) == {"inverted_shells": 1}
    twice = np.vstack([TETRA_FACES, TETRA_FACES[:1]])
    assert kinds(Mesh(TETRA, twice)) == {"nonmanifold_edges": 3, "duplicate_triangles": 1}
    shared_edge = np.vstack([TETRA_FACES, [[0, 1, 4], [0, 4, 5], [1, 5, 4], [0, 5, 1]]])
    points = np.vstack([TETRA, [[0.5, -1, -1], [0.5, -1, 0]]])
    assert kinds(Mesh(points, shared_edge))["nonmanifold_edges"] == 1


def test_a_flat_triangle() -> None:
    """An edge split on one side only, closed by a triangle without area."""
    points = np.vstack([TETRA, [[0.5, 0, 0]]])
    faces = np.vstack([TETRA_FACES[1:], [[0, 2, 4], [4, 2, 1], [0, 4, 1]]])
    mesh = Mesh(points, faces)
    # the edge that is not split runs along the two halves
    assert kinds(mesh) == {"degenerate_triangles": 1, "self_intersections": 2}
    repeated = Mesh(TETRA, np.vstack([TETRA_FACES, [[0, 0, 1]]]))
    assert check(repeated).degenerate_triangles == 1


def test_shells_within_shells() -> None:
    hollow = together(ball(2), ball(1, inward=True))
    report = check(hollow)
    assert report.ok
    assert report.components == 2
    assert report.volume == pytest.approx(7 * check(ball(1)).volume)
    assert check(together(hollow, ball(0.5))).ok
    assert kinds(together(ball(2), ball(1))) == {"nested_shells": 1}
    assert kinds(together(ball(2), ball(1, (9, 0, 0), inward=True))) == {"inverted_shells": 1}
    # within the bounding box of the torus, but not within the torus
    torus = trimesh.creation.torus(3, 1.2)
    ring = Mesh(np.asarray(torus.vertices), np.asarray(torus.faces))
    assert check(together(ring, ball(0.5))).ok
    assert kinds(together(ring, ball(0.5, inward=True))) == {"inverted_shells": 1}
    assert check(together(ring, ball(0.5, (3, 0, 0), inward=True))).ok


def test_the_order_of_shells_and_the_words() -> None:
    torus = trimesh.creation.torus(3, 1)
    ring = Mesh(np.asarray(torus.vertices), np.asarray(torus.faces))
    report = check(together(ball(1, (9, 0, 0)), ring, Mesh(TETRA + 20, TETRA_FACES[1:])))
    assert report.genus == (1, 0, None)
    assert "not printable" in str(report)
    assert "self-intersections: not tested" not in str(report)
    assert report.faults[0].startswith("3 edges with a triangle on one side only, at (")


def test_the_report_as_json() -> None:
    values = json.loads(json.dumps(check(sierpinski(1)).to_dict()))
    assert values["ok"] is False
    assert values["size"] == [1.0, 1.0, 1.0]
    assert values["self_intersections"] == 0
    assert values["faults"][0]["kind"] == "nonmanifold_vertices"
    assert values["faults"][0]["count"] == values["nonmanifold_vertices"] == 6


def test_against_trimesh_on_random_triangles() -> None:
    rng = np.random.default_rng(0)
    for _ in range(20):
        faces = np.array([rng.permutation(8)[:3] for _ in range(12)])
        mesh = Mesh(rng.random((8, 3)), faces)
        report, other = check(mesh), mesh.to_trimesh()
        groups = np.unique(other.edges_sorted, axis=0, return_counts=True)[1]
        assert report.boundary_edges == (groups == 1).sum()
        assert report.nonmanifold_edges == (groups > 2).sum()
        assert report.area == pytest.approx(other.area)
        assert report.volume == pytest.approx(other.volume, abs=0.5)


def test_refusals() -> None:
    with pytest.raises(ValueError, match="no triangles"):
        check(Mesh(TETRA, np.zeros((0, 3), dtype=np.int64)))
    with pytest.raises(ValueError, match="of 4"):
        check(Mesh(TETRA, np.array([[0, 1, 4]])))
    with pytest.raises(ValueError, match="finite"):
        check(Mesh(TETRA * np.nan, TETRA_FACES))
