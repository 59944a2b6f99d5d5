"""Files that share cells."""

import pytest

from automata import AutomatonError, parse_text, read

CELLS = """\
format = "bcifs/1"
[cells.vertex]
points = 2
subdivision = { s = "vertex" }
"""
EDGE = """\
format = "bcifs/1"
include = ["parts/vertex.toml"]
shape = "edge"
[cells.edge]
points = 3
subdivision = { 0 = "edge", 1 = "edge" }
boundary = { left = { cell = "vertex", points = [0, 1] }, right = { cell = "vertex", points = [1, 2] } }
incidence = ["left s = 0 left", "right s = 1 right"]
adjacency = ["0 right = 1 left"]
"""


@pytest.fixture
def folder(tmp_path):
    inner = tmp_path / "shapes"
    (inner / "parts").mkdir(parents=True)
    (inner / "parts" / "vertex.toml").write_text(CELLS)
    (inner / "edge.toml").write_text(EDGE)
    (tmp_path / "outside.toml").write_text(CELLS)
    return inner


def test_cells_come_from_another_file(folder):
    assert read(folder / "edge.toml").cells["edge"] == read("corner-cutting").cells["edge"]
    assert list(read(folder / "edge.toml").cells) == ["vertex", "edge"]


def test_the_fractal_patch_has_the_cells_of_catmull_and_clark():
    assert read("fractal-patch").cells == read("catmull-clark-patch").cells


def test_faults_are_placed_in_the_file_that_has_them(folder):
    vertex = folder / "parts" / "vertex.toml"
    vertex.write_text(CELLS.replace('"vertex" }', '"vertx" }'))
    with pytest.raises(AutomatonError) as caught:
        read(folder / "edge.toml")
    assert (caught.value.source, caught.value.line, caught.value.column) == (str(vertex), 4, 21)
    vertex.write_text(CELLS + "[")
    with pytest.raises(AutomatonError) as caught:
        read(folder / "edge.toml")
    assert (caught.value.source, caught.value.line) == (str(vertex), 5)


@pytest.mark.parametrize(
    ("name", "fragment"),
    [
        ("../outside.toml", "in the folder of this one"),
        ("parts/../../outside.toml", "in the folder of this one"),
        ("/etc/passwd", "in the folder of this one"),
        ("link.toml", "leads out of the folder"),
        ("absent.toml", "no such file"),
        ("edge.toml", "includes itself"),
        ("loop.toml", "includes itself"),
    ],
)
def test_inclusions_that_are_refused(folder, name, fragment):
    (folder / "link.toml").symlink_to(folder.parent / "outside.toml")
    (folder / "loop.toml").write_text('format = "bcifs/1"\ninclude = ["loop.toml"]\n')
    (folder / "edge.toml").write_text(EDGE.replace("parts/vertex.toml", name))
    with pytest.raises(AutomatonError, match=fragment) as caught:
        read(folder / "edge.toml")
    assert caught.value.line is not None


def test_a_chain_of_inclusions_has_an_end(folder):
    for k in range(40):
        (folder / f"{k}.toml").write_text(f'format = "bcifs/1"\ninclude = ["{k + 1}.toml"]\n')
    with pytest.raises(AutomatonError, match="at most 8 deep"):
        read(folder / "0.toml")


def test_a_text_without_a_folder_includes_built_in_automata_only():
    with pytest.raises(AutomatonError, match="only built-in automata"):
        parse_text(EDGE)
    text = EDGE.replace("parts/vertex.toml", "takagi-curve").split("[cells.edge]")[0]
    assert parse_text(text).cells == read("takagi-curve").cells
