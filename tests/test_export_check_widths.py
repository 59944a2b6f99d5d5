"""Walls and gaps of known width, overhangs, voids, and the volume of cells."""

import numpy as np
import pytest
import trimesh
from dense.surface import surface
from dense.voxels import Voxels

import trees
from export.check import check
from export.checks.overhangs import overhangs
from export.checks.slicer import NoSlicer, print_time
from ifs.mesh import Mesh


def mesh_of(made: trimesh.Trimesh, inward: bool = False) -> Mesh:
    faces = np.asarray(made.faces, dtype=np.int64)
    return Mesh(np.asarray(made.vertices), faces[:, ::-1] if inward else faces)


def together(*meshes: Mesh) -> Mesh:
    starts = np.cumsum([0, *(len(m.vertices) for m in meshes)])
    return Mesh(
        np.vstack([m.vertices for m in meshes]),
        np.vstack([m.faces + start for m, start in zip(meshes, starts[:-1], strict=True)]),
    )


@pytest.mark.parametrize("scale", [1.0, 1e-3, 1e6])
def test_a_slab_is_as_thick_as_it_is(scale) -> None:
    slab = trimesh.creation.box((30 * scale, 20 * scale, 0.7 * scale))
    slab.apply_transform(trimesh.transformations.rotation_matrix(0.7, (1, 2, 3)))
    report = check(mesh_of(slab), wall=0.75 * scale, gap=scale)
    assert report.walls[0].width == pytest.approx(0.7 * scale, rel=1e-8)
    assert report.gaps == ()
    assert report.thin_walls is not None
    assert report.thin_walls > 10_000
    assert report.narrow_gaps == 0
    assert check(mesh_of(slab), wall=0.7 * scale * (1 - 1e-8)).ok


def test_a_tube_and_its_bore() -> None:
    tube = mesh_of(trimesh.creation.annulus(8, 10, 30, sections=256))
    report = check(tube)
    assert report.walls[0].width == pytest.approx(2, rel=1e-3)
    assert report.gaps[0].width == pytest.approx(16, rel=1e-3)


def test_a_ball_within_a_shell() -> None:
    outer, inner = trimesh.creation.icosphere(4, radius=10), trimesh.creation.icosphere(4, radius=9)
    core = trimesh.creation.icosphere(4, radius=8.5)
    report = check(together(mesh_of(outer), mesh_of(inner, inward=True), mesh_of(core)), wall=0.9, gap=0.6)
    assert report.walls[0].width == pytest.approx(1, rel=0.01)
    assert report.gaps[0].width == pytest.approx(0.5, rel=0.01)
    assert report.thin_walls == 0
    assert report.narrow_gaps is not None
    assert report.narrow_gaps > 1000
    assert {fault.kind for fault in report.details} == {"narrow_gaps"}
    assert report.trapped_voids == 1
    assert report.void_volume == pytest.approx(inner.volume)
    assert [note.kind for note in report.notes] == ["trapped_voids"]
    for narrow in report.gaps:
        assert np.linalg.norm(narrow.place) == pytest.approx(8.75, rel=0.01)


def test_the_thin_place_is_found_and_named() -> None:
    """A plate with a dent whose floor is thin."""
    filled = np.ones((40, 40, 5), dtype=bool)
    filled[10:14, 20:24, 1:] = False
    report = check(surface(Voxels(filled, np.zeros(3), 0.5), "exact"))
    assert report.walls[0].width == pytest.approx(0.5)
    x, y, z = report.walls[0].place
    assert 5 <= x <= 7
    assert 10 <= y <= 12
    assert z == pytest.approx(0.25)
    assert report.gaps[0].width == pytest.approx(2)


def test_corners_are_no_thin_walls_and_knives_are() -> None:
    def wedge(angle: float) -> float:
        """The least width of a long wedge with this edge."""
        half = 10 * np.tan(np.radians(angle / 2))
        points = [(0, 0), (10, -half), (10, half)]
        solid = trimesh.creation.extrude_triangulation(np.array(points), np.array([[0, 1, 2]]), 10)
        found = check(mesh_of(solid)).walls
        return min(narrow.width for narrow in found)

    assert wedge(60) > 5
    assert wedge(20) < 0.2
    assert check(mesh_of(trimesh.creation.box((1, 2, 3)))).walls[0].width == pytest.approx(1)


def test_many_triangles_are_measured_in_part() -> None:
    from export.checks.triangle_tree import triangle_tree
    from export.checks.widths import walls_and_gaps

    ball = mesh_of(trimesh.creation.icosphere(4))
    walls, gaps = walls_and_gaps(triangle_tree(ball.vertices, ball.faces), most=1000)
    assert walls.measured == gaps.measured
    assert 500 < walls.measured < 2000 < len(ball.faces)
    assert walls.least == pytest.approx(2, rel=0.01)


def test_overhangs_of_a_table_and_of_a_pyramid() -> None:
    """A T stands best upside down; a pyramid on its base."""
    filled = np.zeros((9, 3, 5), dtype=bool)
    filled[4, :, :] = True
    filled[:, :, 4] = True
    report = check(surface(Voxels(filled, np.zeros(3), 1.0), "exact"))
    shares = {one.up: one.share for one in report.overhangs}
    assert report.overhangs[0].up == "-z"
    assert shares["-z"] == 0
    assert shares["+z"] == pytest.approx(24 / report.area)
    assert "best with -z up: free of supports" in str(report)
    corners = np.array([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [0, 0, 0.9]])
    faces = np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [1, 0, 2], [3, 2, 0]])
    pyramid = corners[faces]
    normals = np.cross(pyramid[:, 1] - pyramid[:, 0], pyramid[:, 2] - pyramid[:, 0])
    best = overhangs(pyramid, normals)[0]
    assert best.up == "+z"
    assert best.on_plate == pytest.approx(2)


def test_exactly_45_degrees_need_no_support() -> None:
    points = np.array([(0.0, 0.0), (1, 0), (2, 1), (-1, 1)])
    solid = trimesh.creation.extrude_triangulation(points, np.array([[0, 1, 2], [0, 2, 3]]), 5)
    solid.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, (1, 0, 0)))
    shares = {one.up: one.share for one in check(mesh_of(solid)).overhangs}
    assert shares["+z"] == 0


def test_the_volume_of_the_cells() -> None:
    middles = (np.indices((16, 16, 16)).T + 0.5) / 8 - 1
    ball = trees.from_array((middles**2).sum(axis=-1) < 0.64, trees.Cube((-1.0,) * 3, 2.0))
    mesh = surface(Voxels(trees.to_array(ball), np.full(3, -1.0), ball.cell_size), "exact")
    report = check(mesh, tree=ball)
    assert report.ok
    assert report.tree_volume == ball.measure
    assert report.volume == pytest.approx(ball.measure, rel=1e-12)
    wrong = check(Mesh(mesh.vertices * 1.5, mesh.faces), tree=ball)
    assert [fault.kind for fault in wrong.details] == ["other_volume"]


@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf")])
def test_widths_that_make_no_sense(value) -> None:
    ball = mesh_of(trimesh.creation.icosphere(1))
    with pytest.raises(ValueError, match="above 0"):
        check(ball, wall=value)
    with pytest.raises(ValueError, match="above 0"):
        check(ball, gap=value)


def test_a_quick_check_says_what_it_left_out() -> None:
    report = check(mesh_of(trimesh.creation.icosphere(1)), quick=True)
    assert report.ok
    assert report.self_intersections is None
    assert "self-intersections: not tested" in str(report)
    assert report.walls == ()


def test_no_slicer_is_one_clean_error(tmp_path) -> None:
    ball = mesh_of(trimesh.creation.icosphere(1))
    with pytest.raises(NoSlicer, match="nowhere"):
        print_time(ball, slicer=str(tmp_path / "nowhere"))
    slow, wrong = tmp_path / "slow", tmp_path / "wrong"
    slow.write_text("#!/bin/sh\nexec sleep 30\n")
    wrong.write_text("#!/bin/sh\necho 'no such profile'\nexit 1\n")
    for script in (slow, wrong):
        script.chmod(0o755)
    with pytest.raises(NoSlicer, match=r"more than 0.2 s"):
        print_time(ball, limit=0.2, slicer=str(slow))
    with pytest.raises(NoSlicer, match="no such profile"):
        print_time(ball, slicer=str(wrong))
