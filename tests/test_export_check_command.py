"""`bcifs check` on all kinds of files: other people's, damaged ones, and ones with a million faults."""

import json
import shutil

import numpy as np
import pytest
import trimesh
from dense.surface import surface
from dense.voxels import Voxels
from PIL import Image

import trees
from bcifs.__main__ import main
from bcifs.fault_picture import FAULT, marks
from export.check import check
from export.checks.report import MARKS
from export.checks.sewing import sewn
from ifs.mesh import Mesh


@pytest.fixture
def cross(tmp_path) -> str:
    """Two boxes that pass through each other, and a hollow one, as a file."""
    boxes = [
        trimesh.creation.box((20, 20, 20)),
        trimesh.creation.box((4, 4, 30)),
        trimesh.creation.box((6, 6, 6)),
    ]
    boxes[1].apply_translation((7, 1, 3))
    boxes[2].apply_translation((-5, -5, 0))
    boxes[2].invert()
    path = tmp_path / "cross.stl"
    trimesh.util.concatenate(boxes).export(path)
    return str(path)


@pytest.mark.parametrize("ending", ["stl", "obj", "ply", "glb", "off", "3mf"])
def test_files_of_other_programs(tmp_path, capsys, ending) -> None:
    """A sound box is sound in every format, also where each face has vertices of its own."""
    made = trimesh.creation.box((0.01, 0.02, 0.03) if ending == "glb" else (10, 20, 30))
    if ending == "glb":
        made.unmerge_vertices()
    path = tmp_path / f"box.{ending}"
    made.export(path)
    assert main(["check", str(path), "--json"]) == 0
    values = json.loads(capsys.readouterr().out)
    assert values["ok"] is True
    assert values["genus"] == [0]
    assert values["self_intersections"] == 0
    assert values["triangles"] == 12
    assert sorted(values["size"]) == pytest.approx([10, 20, 30], rel=1e-6)
    assert values["walls"][0]["width"] == pytest.approx(10, rel=1e-6)


def test_the_answer_as_text_json_and_picture(tmp_path, capsys, cross) -> None:
    picture = tmp_path / "faults.png"
    assert main(["check", cross, "--json", "-o", str(picture)]) == 5
    said = capsys.readouterr()
    values = json.loads(said.out)
    assert values["ok"] is False
    assert values["self_intersections"] == next(
        one["count"] for one in values["faults"] if one["kind"] == "self_intersections"
    )
    assert [one["kind"] for one in values["notes"]] == ["trapped_voids", "overlapping_shells"]
    assert len(values["overhangs"]) == 6
    assert "fails the check" in said.err
    with Image.open(picture) as drawn:
        assert drawn.text["bcifs:Verdict"] == "not printable"
        pixels = np.asarray(drawn.convert("RGB")).astype(int)
    red = np.array([int(FAULT[i : i + 2], 16) for i in (1, 3, 5)])
    places = np.argwhere(np.abs(pixels - red).sum(axis=2) < 30)
    assert len(places) > 300
    width = pixels.shape[1]
    assert places[:, 1].max() > width / 2  # the shaft stands to the right of the middle
    assert main(["check", cross]) == 5
    assert "not printable" in capsys.readouterr().out


def test_limits_of_walls_and_gaps(tmp_path, capsys) -> None:
    path = tmp_path / "slab.stl"
    trimesh.creation.box((20, 20, 0.8)).export(path)
    assert main(["check", str(path), "--wall", "0.7", "--gap", "0.3"]) == 0
    capsys.readouterr()
    assert main(["check", str(path), "--wall", "0.9", "--json"]) == 5
    values = json.loads(capsys.readouterr().out)
    assert values["thin_walls"] > 0
    assert values["narrow_gaps"] is None
    assert main(["check", str(path), "--wall", "-1"]) == 2


def test_the_cells_of_a_tree(tmp_path, capsys) -> None:
    filled = np.zeros((8, 8, 8), dtype=bool)
    filled[1:7, 2:5, 3] = True
    tree = trees.from_array(filled, trees.Cube((0.0,) * 3, 16.0))
    mesh = surface(Voxels(filled, np.zeros(3), 2.0), "exact")
    mesh.to_trimesh().export(tmp_path / "part.ply")
    trees.write_tree(tree, tmp_path / "part.tree")
    command = ["check", str(tmp_path / "part.ply"), "--json", "--tree", str(tmp_path / "part.tree")]
    assert main(command) == 0
    values = json.loads(capsys.readouterr().out)
    assert values["tree_volume"] == 18 * 8 == pytest.approx(values["volume"])


@pytest.mark.skipif(shutil.which("prusa-slicer") is None, reason="prusa-slicer is not installed")
def test_the_print_time(tmp_path, capsys) -> None:
    path = tmp_path / "box.stl"
    trimesh.creation.box((10, 10, 5)).export(path)
    assert main(["check", str(path), "--slicer", "--json"]) == 0
    small = json.loads(capsys.readouterr().out)["print_time"]
    trimesh.creation.box((30, 30, 5)).export(path)
    assert main(["check", str(path), "--slicer", "--json"]) == 0
    assert 60 < small < json.loads(capsys.readouterr().out)["print_time"] < 7200


def test_no_slicer_on_the_path(tmp_path, capsys, monkeypatch) -> None:
    path = tmp_path / "box.stl"
    trimesh.creation.box((10, 10, 5)).export(path)
    monkeypatch.setenv("PATH", str(tmp_path))
    assert main(["check", str(path), "--slicer"]) == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize("ending", ["stl", "obj", "ply", "glb", "off", "3mf"])
def test_damaged_files_are_one_clean_line(tmp_path, capsys, ending) -> None:
    whole = tmp_path / f"whole.{ending}"
    trimesh.creation.icosphere(1).export(whole)
    content = whole.read_bytes()
    rng = np.random.default_rng(0)
    noisy = bytearray(content)
    for place in rng.integers(0, len(content), 40):
        noisy[place] = rng.integers(256)
    bad = tmp_path / f"bad.{ending}"
    for damaged in (
        b"",
        b"\0" * 200,
        b"nonsense\n",
        content[: len(content) // 2],
        content[:90],
        bytes(noisy),
    ):
        bad.write_bytes(damaged)
        code = main(["check", str(bad)])
        said = capsys.readouterr()
        assert code in (0, 2, 5)
        assert said.err.count("\n") <= 1
        assert "Traceback" not in said.err


def test_positions_that_make_no_sense(tmp_path, capsys) -> None:
    path = tmp_path / "x.obj"
    for number in ("nan", "inf", "1e200", "1e308"):
        path.write_text(f"v 0 0 0\nv {number} 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n")
        assert main(["check", str(path)]) == 2
        assert capsys.readouterr().err.count("\n") == 1


def test_tens_of_thousands_of_faults() -> None:
    """Messages, marks and named pairs stay few."""
    rng = np.random.default_rng(0)
    corners = rng.random((20_000, 1, 3)) * 15 + rng.random((20_000, 3, 3))
    report = check(Mesh(corners.reshape(-1, 3), np.arange(60_000).reshape(-1, 3)))
    assert report.boundary_edges == 60_000
    assert report.self_intersections is not None
    assert report.self_intersections > 5_000
    assert len(str(report)) < 3000
    assert all(len(one.places) <= 5 and len(one.marks) <= MARKS for one in report.details)
    assert len(json.dumps(report.to_dict())) < 20_000
    assert all(len(places) <= MARKS for _, _, places in marks(report))


def test_sewing_only_closes() -> None:
    """Sheets that touch stay apart, and an open mesh that does not close stays as it is."""
    box = trimesh.creation.box((1, 1, 1))
    other = box.copy()
    other.apply_translation((1, 1, 1))
    touching = trimesh.util.concatenate([box, other])
    mesh = Mesh(np.asarray(touching.vertices), np.asarray(touching.faces))
    assert sewn(mesh) == (mesh, None)
    hole = Mesh(mesh.vertices, mesh.faces[1:])
    assert sewn(hole)[1] is None
    loose = Mesh(mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(72).reshape(-1, 3))
    closed, note = sewn(loose)
    assert note is not None
    assert len(closed.vertices) == 15  # the corner at which they touch is one vertex now
    assert check(closed).nonmanifold_vertices == 1


@pytest.mark.parametrize("path", ["x.svg", "missing/x.png"])
def test_a_picture_that_cannot_be_is_refused_first(tmp_path, capsys, path) -> None:
    assert main(["check", str(tmp_path / "none.stl"), "-o", str(tmp_path / path)]) == 2
    assert "x." in capsys.readouterr().err
