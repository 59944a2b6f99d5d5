"""The commands print and slices: what they write, what they tell, and how they refuse."""

import json
import zipfile
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import export
from bcifs.part_options import build_volume


def block(*options: object) -> list[object]:
    """A cube of 20 mm in voxels of 0.5 mm: the sponge at level 0."""
    return ["menger-sponge", "--size", 20, "--depth", 0, "--resolution", 40, *options]


def test_print_tells_what_it_did_line_by_line(run, tmp_path):
    path = tmp_path / "block.3mf"
    asked = ["--hollow", 2, "--drain", 1, "--base", 3, "--margin", 2, "--turn", "-x", "--fit", "30x30x30"]
    code, out, err = run("print", *block("-o", path, *asked))
    assert (code, err) == (0, "")
    names = [line.partition(":")[0] for line in out.splitlines()]
    assert names[:6] == ["hollow", "turn", "base", "drain", "fit", str(path)]
    assert "1 cavity of 4096 mm^3 taken out" in out
    assert "(x, y, z) is now " in out
    assert "no void is left" in out
    mesh = export.read_mesh(path)
    assert np.ptp(mesh.vertices, axis=0).tolist() == pytest.approx([24, 24, 23], abs=1e-3)
    assert "Drain" in zipfile.ZipFile(path).read("3D/3dmodel.model").decode()


def test_islands_go_through(run, tmp_path):
    parts = {}
    for rule in ("keep", "drop", "link"):
        path = tmp_path / f"{rule}.stl"
        code, out, _ = run(
            "print", dust(tmp_path), "-o", path, "--depth", 1, "--resolution", 30, "--islands", rule
        )
        assert code == 0
        parts[rule] = export.check(export.read_mesh(path), quick=True)
        assert ("islands:" in out) == (rule != "keep")
    assert parts["keep"].components == 4
    assert parts["drop"].components == parts["link"].components == 1
    assert parts["drop"].volume < parts["keep"].volume < parts["link"].volume


@pytest.mark.parametrize(("rule", "shells"), [("join", 1), ("separate", 2)])
def test_contacts_go_through(run, tmp_path, rule, shells):
    maps = '[[maps]]\nscale = "1/2"\ntranslation = [0, 0, 0]\n'
    maps += '[[maps]]\nscale = "1/2"\ntranslation = ["1/2", "1/2", 0]\n'
    file, path = tmp_path / "cubes.toml", tmp_path / "cubes.stl"
    file.write_text(f'format = "bcifs/1"\nname = "Cubes"\n{maps}[control]\n{CORNERS}\n')
    code, out, _ = run("print", file, "-o", path, "--depth", 1, "--contacts", rule)
    assert code == 0
    assert f" {shells} shells" in out


CORNERS = "points = [[0, 0, 0], [30, 0, 0], [0, 30, 0], [0, 0, 30]]"


def dust(folder: Path) -> Path:
    """Four pieces that do not touch, a third as large as the whole."""
    file = folder / "dust.toml"
    corners = ["[0, 0, 0]", '["2/3", 0, 0]', '[0, "2/3", 0]', '[0, 0, "2/3"]']
    maps = "\n".join(f'[[maps]]\nscale = "1/3"\ntranslation = {corner}' for corner in corners)
    file.write_text(f'format = "bcifs/1"\nname = "Dust"\n{maps}\n[control]\n{CORNERS}\n')
    return file


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--hollow", 0.2], "a hollow wall of 0.2 mm is less than a voxel of 0.5 mm"),
        (["--hollow", 0], "a hollow wall in mm is 0.0: a finite number above 0 is needed"),
        (["--drain", -1], "a drain in mm is -1.0: a finite number above 0 is needed"),
        (["--wall", "nan"], "a least wall in mm is nan"),
        (["--strut", 2], "islands are not linked"),
        (["--margin", 2], "there is no base"),
        (["--turn", "fit"], "give the build volume"),
        (["--fit", "20x20"], "--fit 20x20: expected three lengths in mm, as in 200x200x180"),
        (["--fit", "20x20x0"], "is 0.0: a finite number above 0 is needed"),
        (["--fit", "10x20x30"], "the part is 20 x 20 x 20 mm and does not fit into 10 x 20 x 30 mm"),
        (["--smallest", 9e9], "ask for less"),
    ],
)
def test_wrong_requests_are_refused_in_a_line(run, tmp_path, options, words):
    code, out, err = run("print", *block("-o", tmp_path / "x.stl", *options))
    assert (code, out) == (2, "")
    assert words in err
    assert err.startswith("bcifs: ")
    assert err.count("\n") == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("option", "value"), [("--turn", "up"), ("--islands", "melt"), ("--contacts", "glue")]
)
def test_other_choices_are_named(run, tmp_path, option, value):
    code, _, err = run("print", *block("-o", tmp_path / "x.stl", option, value))
    assert code == 2
    assert option in err
    assert value in err


def test_help_has_groups(run):
    _, out, _ = run("print", "--help")
    heads = [line for line in out.splitlines() if line and not line.startswith(" ") and line.endswith(":")]
    assert heads == [
        "Arguments:",
        "Options:",
        "Size and detail:",
        "Made printable, in this order:",
        "Surface:",
    ]


def test_a_lowered_resolution_is_told(run, tmp_path):
    path = tmp_path / "s.stl"
    words = ("print", "menger-sponge", "-o", path, "--resolution", 2000, "--triangles", 20_000)
    code, _, err = run(*words, "--coarsen")
    assert code == 0
    assert "instead of 2000, which fits" in err
    assert err.count("triangles") == 1
    code, _, err = run(*words)
    assert code == 2
    assert "--coarsen" in err


def test_slices_are_those_of_the_part(run, tmp_path):
    """The pixels of all layers, as high as a voxel, are the voxels of the part."""
    options = block("--hollow", 2, "--drain", 1)
    path = tmp_path / "block.zip"
    code, out, _ = run("slices", *options, "-o", path)
    assert code == 0
    assert f"{path}: 40 layers of 0.5 mm, pixels of 0.5 mm" in out
    with zipfile.ZipFile(path) as archive:
        told = json.loads(archive.read("manifest.json"))
        pictures = [np.array(Image.open(archive.open(name))) for name in archive.namelist()[1:]]
    assert told["pixels"] == [40, 40]
    assert told["recipe"]["Hollow"].startswith("walls of 2 mm")
    assert sum(int(np.count_nonzero(picture)) for picture in pictures) == 40**3 - 32**3 - 5 * 4


def test_slices_by_pixel_and_layer_into_a_folder(run, tmp_path):
    folder = tmp_path / "layers"
    options = ["menger-sponge", "--size", 18, "--depth", 1, "--pixel", 0.5, "--layer", 0.9, "--format", "svg"]
    code, out, _ = run("slices", *options, "-o", folder)
    assert code == 0
    assert "20 layers of 0.9 mm, pixels of 0.5 mm" in out
    assert len(list(folder.glob("*.svg"))) == 20
    code, _, err = run("slices", *options, "-o", folder)
    assert code == 2
    assert "is no empty folder" in err


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["-o", "{}/x.png"], "expected an archive, .zip, or a folder"),
        (["-o", "{}/none/x"], "there is no folder"),
        (["-o", "{}/x.zip", "--layer", 0], "the layer height is a length above 0 mm"),
        (["-o", "{}/x.zip", "--pixel", -1], "the pitch is above 0 mm"),
        (["-o", "{}/x.zip", "--pixel", 1, "--resolution", 9], "give one of them"),
    ],
)
def test_wrong_slices_are_refused(run, tmp_path, options, words):
    filled = [str(option).format(tmp_path) for option in options]
    code, _, err = run("slices", "menger-sponge", "--depth", 1, *filled)
    assert code == 2
    assert words in err
    assert not list(tmp_path.iterdir())


def test_build_volumes():
    assert build_volume("200X200 x 180") == (200.0, 200.0, 180.0)
