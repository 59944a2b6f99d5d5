"""Control meshes from the command line: smooth surfaces, and STEP."""

import numpy as np
import pytest

from export import read_mesh
from export.control_files import read_control_mesh

CUBE = """
v 0 0 0
v 40 0 0
v 0 40 0
v 40 40 0
v 0 0 40
v 40 0 40
v 0 40 40
v 40 40 40
f 1 3 4 2
f 5 6 8 7
f 1 2 6 5
f 3 7 8 4
f 1 5 7 3
"""


@pytest.fixture
def run(run, tmp_path):
    (tmp_path / "cube.obj").write_text(CUBE + "f 2 4 8 6\n")
    (tmp_path / "box.obj").write_text(CUBE)

    def command(*arguments):
        files = (".obj", ".stl", ".step", ".png", ".doc")
        return run(*(tmp_path / a if str(a).endswith(files) else a for a in arguments))

    return command


def test_a_cube_becomes_a_smooth_solid(run, tmp_path):
    code, out, _ = run("smooth", "cube.obj", "-o", "ball.stl", "--depth", 4)
    assert code == 0
    assert "1538 vertices, 1536 faces at depth 4" in out
    code, out, _ = run("check", "ball.stl")
    assert code == 0
    # The limit of the face point of a cube's side: by symmetry all six are at one distance from the centre.
    ball = read_mesh(tmp_path / "ball.stl")
    assert np.ptp(ball.vertices, axis=0) == pytest.approx(np.ptp(ball.vertices[:, 0]), abs=1e-3)


def test_quadrangles_stay_quadrangles_in_obj(run, tmp_path):
    assert run("smooth", "cube.obj", "-o", "ball.obj", "--depth", 2, "--scheme", "doo-sabin")[0] == 0
    vertices, faces = read_control_mesh(tmp_path / "ball.obj")
    assert {len(face) for face in faces} == {4}
    assert len(vertices) - 2 * len(faces) + len(faces) == 2


def test_an_open_mesh_wants_a_rule_for_its_boundary(run):
    code, _, err = run("smooth", "box.obj", "-o", "box.png")
    assert code == 2
    assert "the edge from vertex" in err
    assert "--boundary" in err
    code, out, _ = run("smooth", "box.obj", "-o", "box.png", "--boundary", "corners", "--depth", 3)
    assert code == 0
    assert "320 faces" in out


def test_creases_keep_the_edges(run):
    code, out, _ = run("smooth", "cube.obj", "-o", "cube.step", "--crease-angle", 60)
    assert code == 0
    assert "6 faces (6 exact" in out
    assert "a solid of 64000 mm3, valid" in out


def test_step_says_how_exact_it_is(run):
    code, out, _ = run("smooth", "cube.obj", "-o", "ball.step", "--tolerance", 0.1)
    assert code == 0
    assert "fitted)" not in out
    assert "valid in OpenCASCADE" in out
    assert "(G0)" in out
    assert "(G1)" in out


def test_fractal_surfaces_leave_as_step_only_in_facets(run, tmp_path):
    code, _, err = run("mesh", "fractal-patch", "-o", "f.step")
    assert code == 2
    assert "Write 3MF or STL" in err
    assert "--facets" in err
    assert not (tmp_path / "f.step").exists()
    code, out, _ = run("mesh", "fractal-patch", "-o", "f.step", "--facets", "--depth", 2)
    assert code == 0
    assert "32 plane" in out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("nothing.obj", "-o", "a.stl"), "no such file"),
        (("cube.obj", "-o", "a.doc"), "ends in"),
        (("cube.obj", "-o", "a.stl", "--depth", 99), "more than can be drawn"),
        (("cube.obj", "-o", "a.step", "--tolerance", 0), "positive number of millimetres"),
        (("cube.obj", "-o", "a.stl", "--scheme", "doo-sabin", "--crease-angle", 10), "no creases"),
    ],
)
def test_wrong_input_is_refused(run, words, message):
    code, _, err = run("smooth", *words)
    assert code == 2
    assert message in err
