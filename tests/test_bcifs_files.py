"""The files that commands write: meshes, pictures and parts; and that nothing is left half-written."""

import re
from itertools import pairwise

import numpy as np
import pytest
from PIL import Image

import bcifs
import export
import ifs
from bcifs import demo
from bcifs.__main__ import main
from bcifs.depth import drawn, pieces
from bcifs.polygon_file import obj
from bcifs.strokes import strokes
from bcifs.view import MARGIN, sheet
from ifs import Mesh


def parsed(text: str) -> tuple[np.ndarray, list[list[int]]]:
    rows = [line.split() for line in text.splitlines()]
    points = np.array([row[1:] for row in rows if row[0] == "v"], dtype=float)
    return points, [[int(c) - 1 for c in row[1:]] for row in rows if row[0] in ("p", "l", "f")]


@pytest.mark.parametrize("name", ["koch-curve", "doo-sabin-patch"])
def test_an_obj_file_holds_the_mesh_to_the_last_digit(tmp_path, name):
    path = tmp_path / "x.obj"
    assert main(["mesh", name, "-o", str(path), "--depth", "3"]) == 0
    made = ifs.mesh(ifs.shape(name), 3)
    points, faces = parsed(path.read_text())
    assert (points == made.points_3d()).all()
    assert faces == made.faces.tolist()
    assert "# Detail: at depth 3" in path.read_text()


def test_a_mesh_of_faces_in_the_binary_formats_has_shared_vertices(tmp_path):
    for ending in ("ply", "stl"):
        path = tmp_path / f"x.{ending}"
        assert main(["mesh", "catmull-clark-patch", "-o", str(path), "--depth", "2"]) == 0
        found = export.read_mesh(path)
        assert (len(found.vertices), len(found.faces)) == (25, 32)


def test_points_segments_and_faces_have_their_own_elements():
    mesh = Mesh(np.arange(12.0).reshape(4, 3), np.array([[0, -1, -1], [0, 1, -1], [1, 2, 3]]))
    assert [line for line in obj(mesh, {}).splitlines() if line[0] in "plf"] == ["p 1", "l 1 2", "f 2 3 4"]


def test_strokes_hold_every_segment_once():
    branching = np.array([[0, 1], [2, 1], [2, 3], [1, 4], [5, 6], [6, 7], [7, 5]])
    found = [pair for stroke in strokes(branching) for pair in pairwise(stroke.tolist())]
    assert sorted(map(sorted, found)) == sorted(map(sorted, branching.tolist()))
    ring = next(stroke for stroke in strokes(branching) if 5 in stroke)
    assert ring[0] == ring[-1]
    assert len(ring) == 4


def test_a_whole_curve_is_one_stroke():
    mesh = ifs.mesh(ifs.shape("koch-curve"), 4)
    assert [len(stroke) for stroke in strokes(mesh.faces)] == [4**4 + 1]


@pytest.mark.parametrize("size", [(90.0, 30.0), (1e-9, 3.0), (5.0, 0.0), (2e6, 2e6)])
def test_everything_is_on_the_sheet(size):
    page = sheet(np.array([[7.0, -3.0], [7.0 + size[0], -3.0 + size[1]]]))
    places = page.place(np.array([[7.0, -3.0], [7.0 + size[0], -3.0 + size[1]]]))
    margin = 0.9 * MARGIN * min(page.width, page.height)
    assert (places > margin).all()
    assert (places < np.array([page.width, page.height]) - margin).all()


def test_pieces_are_counted_as_they_are_drawn():
    shape = ifs.shape("sierpinski-triangle")
    assert [pieces(shape, depth) for depth in range(4)] == [len(ifs.mesh(shape, d).faces) for d in range(4)]


def test_a_drawing_stops_where_more_cannot_be_seen():
    made = drawn(ifs.shape("corner-cutting"))
    lengths = np.linalg.norm(np.diff(made.mesh.vertices[made.mesh.faces], axis=1)[:, 0], axis=1)
    assert lengths.max() < 60 / 1500
    assert drawn(ifs.shape("menger-sponge"), 1).mesh.faces.shape == (6 * 20, 4)


def test_a_picture_of_a_curve_as_svg(tmp_path):
    paths = [tmp_path / "one.svg", tmp_path / "two.svg"]
    for path in paths:
        assert main(["render", "koch-curve", "-o", str(path), "--depth", "3"]) == 0
    assert paths[0].read_bytes() == paths[1].read_bytes()
    text = paths[0].read_text()
    drawing = re.search(r'stroke-width="[\d.]+" d="(M[^"]+)"', text)
    assert drawing
    assert len(re.findall("[ML]", drawing[1])) == 4**3 + 1
    assert "at depth 3" in text


def test_a_picture_of_a_plane_shape_has_its_area_and_recipe(tmp_path):
    paths = [tmp_path / "one.png", tmp_path / "two.png"]
    for path in paths:
        assert main(["render", "sierpinski-triangle", "-o", str(path), "--depth", "3"]) == 0
    assert paths[0].read_bytes() == paths[1].read_bytes()
    with Image.open(paths[0]) as picture:
        assert picture.text["bcifs:Name"] == "Sierpinski triangle"
        assert picture.text["bcifs:Values"] == "triangle.0[0,1] = 1/2"
        shade = np.asarray(picture.convert("L")).astype(float)
    share = (shade.max() - shade).sum() / (shade.max() - shade.min())
    mesh = ifs.mesh(ifs.shape("sierpinski-triangle"), 3)
    scale = sheet(mesh.vertices).scale
    area = (3 / 4) ** 3 * 80 * 69.282032302755092 / 2 * scale**2
    assert share == pytest.approx(area, rel=0.02)


def test_a_picture_of_a_solid_shows_it_whole(tmp_path):
    path = tmp_path / "cube.png"
    cube = ifs.mesh(ifs.shape("menger-sponge"), 0)
    bcifs.draw_mesh(cube, path, {"Name": "cube"})
    with Image.open(path) as picture:
        assert picture.text["bcifs:Name"] == "cube"
        pixels = np.asarray(picture).astype(int)
    drawn_at = np.argwhere(np.abs(pixels - pixels[0, 0]).sum(axis=2) > 30)
    low, high = drawn_at.min(axis=0), drawn_at.max(axis=0)
    shown = np.array([*low, *(np.array(pixels.shape[:2]) - 1 - high)])
    assert shown.min() >= 0.8 * MARGIN * max(pixels.shape)  # nothing is cut off
    assert shown.min() <= 1.2 * MARGIN * max(pixels.shape)  # and the sheet is filled


def test_a_part_goes_from_a_name_to_a_file_that_is_printable(tmp_path, capsys):
    path = tmp_path / "sponge.3mf"
    assert main(["print", "menger-sponge", "-o", str(path), "--size", "27", "--depth", "1"]) == 0
    assert "printable" in capsys.readouterr().out
    assert main(["check", str(path)]) == 0
    report = export.check(export.read_mesh(path))
    assert report.genus == (5,)
    assert report.volume == pytest.approx(20 * 9**3)


def test_a_mesh_that_is_not_printable_ends_with_5(tmp_path, capsys):
    path = tmp_path / "open.stl"
    export.write_part(Mesh(np.eye(3), np.array([[0, 1, 2]])), path)
    assert main(["check", str(path)]) == 5
    assert "not printable" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("command", "broken", "output"),
    [
        ("mesh", "bcifs.polygon_file.obj", "x.obj"),
        ("render", "bcifs.flat.svg", "x.svg"),
        ("render", "bcifs.flat._painted", "x.png"),
        ("print", "export.make_part", "x.3mf"),
        ("print", "export.formats.threemf._rows", "x.3mf"),
    ],
)
def test_an_interrupted_command_leaves_nothing(tmp_path, monkeypatch, capsys, command, broken, output):
    def interrupt(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(broken, interrupt)
    options = ["--resolution", "20"] if command == "print" else ["--depth", "2"]
    assert main([command, "koch-curve", "-o", str(tmp_path / output), *options]) == 130
    assert list(tmp_path.iterdir()) == []
    assert "Traceback" not in capsys.readouterr().err


def test_the_demonstration_makes_its_parts(tmp_path, capsys):
    parts = {"menger-sponge": {"size": 27.0, "depth": 1}}
    assert demo.main(tmp_path / "out", parts) == 0
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"menger-sponge.3mf", "menger-sponge.png"}
    assert "genus 5" in capsys.readouterr().out


def test_every_public_name_is_there():
    for name in bcifs.__all__:
        assert getattr(bcifs, name) is not None
    with pytest.raises(AttributeError):
        _ = bcifs.nothing  # pyright: ignore[reportAttributeAccessIssue]
