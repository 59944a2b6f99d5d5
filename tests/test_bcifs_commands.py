"""The command line: answers, exit codes and messages."""

import json
import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import pytest

import automata

CURVE = """
format = "bcifs/1"
name = "Test"
shape = "edge"
[cells.vertex]
points = 2
subdivision = { s = "vertex" }
[cells.edge]
points = 3
subdivision = { 0 = "edge", 1 = "edge" }
boundary = { left = { cell = "vertex", points = [0, 1] }, right = { cell = "vertex", points = [1, 2] } }
incidence = ["left s = 0 left", "right s = 1 right"]
adjacency = ["0 right = 1 left"]
[set]
"edge.0[1,0]" = "1/4"
"edge.0[0,1]" = "1/4"
[control]
points = [[0, 0], [30, 60], [60, 0]]
"""


def written(folder: Path, change: tuple[str, str] = ("", "")) -> Path:
    assert change[0] in CURVE
    path = folder / "curve.toml"
    path.write_text(CURVE.replace(*change) if change[0] else CURVE)
    return path


def test_solve_shows_the_whole_family_even_where_the_file_sets_values(run):
    code, out, err = run("solve", "corner-cutting")
    assert (code, err) == (0, "")
    assert "2 degrees of freedom" in out
    assert "[     a  1 - b  1 - a ]" in out
    assert "the file sets 1/4" in out


def test_solve_as_data(run):
    code, out, _ = run("solve", "corner-cutting", "--json")
    found = json.loads(out)
    assert code == 0
    assert found["degrees_of_freedom"] == 2
    assert found["parameters"] == ["a", "b"]
    assert found["entries"] == {"a": "edge.0[1,0]", "b": "edge.0[0,1]"}
    assert found["matrices"]["edge"]["0"] == [["1 - a", "b", "0"], ["a", "1 - b", "1 - a"], ["0", "0", "a"]]
    assert found["matrices"]["edge"]["1"] == [["b", "0", "0"], ["1 - b", "1 - a", "b"], ["0", "a", "1 - b"]]


def test_solve_with_values_gives_exact_numbers(run):
    code, out, _ = run("solve", "--set", "a=1/3", "b=2/7", "corner-cutting", "--json")
    found = json.loads(out)
    assert code == 0
    assert (found["degrees_of_freedom"], found["parameters"]) == (0, [])
    assert found["values"] == {"a": "1/3", "b": "2/7"}
    columns = zip(*found["matrices"]["edge"]["0"], strict=True)
    assert [sum(map(Fraction, column)) for column in columns] == [1, 1, 1]
    assert found["matrices"]["edge"]["0"][1] == ["1/3", "5/7", "2/3"]


@pytest.mark.parametrize(("name", "freedom"), [("doo-sabin-patch", 3), ("catmull-clark-patch", 4)])
def test_degrees_of_freedom_of_the_patches(run, name, freedom):
    assert json.loads(run("solve", name, "--json")[1])["degrees_of_freedom"] == freedom


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('0 = "edge", 1', '0 = "egde", 1'), "did you mean 'edge'"),
        (("points = [0, 1] }, right", "points = [0] }, right"), ""),
        (("points = [0, 1] }, right", "points = [0, 7] }, right"), ""),
        (('"0 right = 1 left"', '"right 0 = 1 left"'), ""),
        (("[set]", "[sat]"), "did you mean 'set'"),
        (("[[0, 0], ", "["), "3 control points"),
        (("points = 3", "points = "), ""),
    ],
)
def test_a_wrong_file_is_named_with_its_line(run, tmp_path, change, message):
    path = written(tmp_path, change)
    code, out, err = run("solve", path)
    assert (code, out) == (2, "")
    place = err.removeprefix(f"bcifs: {path}:").split(":")
    assert place[0].isdigit()
    assert place[1].isdigit()
    assert message in err


@pytest.mark.parametrize("command", ["solve", "info", "fld", "render", "mesh", "print"])
def test_a_missing_file(run, tmp_path, command):
    rest = {"render": ["-o", "x.png"], "mesh": ["-o", "x.obj"], "print": ["-o", "x.3mf"], "fld": ["0"]}
    rest = [str(tmp_path / text) if "." in text else text for text in rest.get(command, [])]
    code, out, err = run(command, "corner-cuting", *rest)
    assert (code, out) == (2, "")
    assert "did you mean 'corner-cutting'" in err


def test_binary_junk_is_no_file(run, tmp_path):
    for name, command in (("junk.toml", "solve"), ("junk.stl", "check"), ("junk.3mf", "check")):
        (tmp_path / name).write_bytes(bytes(range(256)) * 8)
        code, out, err = run(command, tmp_path / name)
        assert (code, out) == (2, "")
        assert name in err


def test_a_file_of_100_megabytes_is_refused_unread(run, tmp_path):
    path = tmp_path / "large.toml"
    with path.open("wb") as file:
        file.truncate(100_000_000)
    code, _, err = run("solve", path)
    assert code == 2
    assert "100000000 bytes" in err


def test_a_folder_is_no_file(run, tmp_path):
    assert run("solve", tmp_path)[0] == 2


def test_constraints_that_contradict_each_other_are_named(run, tmp_path):
    given = 'matrices = { 0 = [["1/2","*","*"],["1/4","*","*"],["1/4","*","*"]] }'
    path = written(tmp_path, ("[set]", f"{given}\n[set]"))
    code, out, err = run("solve", path)
    assert (code, out) == (3, "")
    assert "contradict" in err
    assert err.count("\n  - ") >= 2


def test_a_system_that_does_not_contract_is_proved_by_a_word(run, tmp_path):
    output = tmp_path / "x.png"
    for command in (["info"], ["fld", "0"], ["render", "-o", output], ["mesh", "-o", tmp_path / "x.obj"]):
        name, *rest = command
        code, _, err = run(name, "corner-cutting", *rest, "--set", "a=-1/2")
        assert code == 4
        assert "does not contract" in err
    code, out, _ = run("info", "corner-cutting", "--set", "a=-1/2", "--json")
    found = json.loads(out)
    assert found["convergence"]["verdict"] == "does not contract"
    assert found["convergence"]["word"]
    assert "bounds_mm" not in found


@pytest.mark.parametrize("setting", ["z=1", "a=one", "a", "edge.0[9,9]=1", "edge.0[2,0]=1"])
def test_a_wrong_setting(run, setting):
    code, out, err = run("solve", "corner-cutting", "--set", setting)
    assert (code, out) == (2, "")
    assert setting.partition("=")[0] in err


def test_free_parameters_are_asked_for(run, tmp_path):
    path = written(tmp_path, ('"edge.0[0,1]" = "1/4"\n', ""))
    code, _, err = run("info", path)
    assert code == 2
    assert "edge.0[0,1]" in err
    assert "--set" in err
    assert run("info", path, "--set", "b=1/4")[0] == 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["render", "koch-curve", "-o", "{}/none/x.png"], "no folder"),
        (["render", "koch-curve", "-o", "{}/x.jpg"], ".png or .svg"),
        (["mesh", "koch-curve", "-o", "{}/x.doc"], ".obj, .ply, .stl or .step"),
        (["mesh", "koch-curve", "-o", "{}/x.stl"], ".obj"),
        (["mesh", "koch-curve", "-o", "{}/folder.obj"], "folder"),
        (["mesh", "koch-curve", "-o", "/proc/x.obj"], "/proc/x.obj"),
        (["print", "koch-curve", "-o", "{}/x.doc"], ".3mf"),
        (["print", "koch-curve", "-o", "{}/x.3mf", "--picture", "{}/x.gif"], ".png"),
        (["render", "doo-sabin-patch", "-o", "{}/x.svg", "--depth", "1"], ".png"),
        (["render", "koch-curve", "-o", "{}/x.svg", "--depth", "30"], "fits"),
    ],
)
def test_an_output_that_cannot_be_written(run, tmp_path, arguments, message):
    (tmp_path / "folder.obj").mkdir()
    code, out, err = run(*(text.replace("{}", str(tmp_path)) for text in arguments))
    assert (code, out) == (2, "")
    assert message in err
    assert [path.name for path in tmp_path.iterdir()] == ["folder.obj"]


@pytest.mark.parametrize(
    "arguments",
    [
        ["nothing"],
        ["solve"],
        ["list", "--depth"],
        ["mesh", "koch-curve", "--depth", "-1"],
    ],
)
def test_a_wrong_command_line(run, arguments):
    assert run(*arguments)[0] == 2


@pytest.mark.parametrize("depth", [7, 10**9])
def test_a_part_of_too_many_pieces_is_refused_before_the_work(run, tmp_path, depth):
    code, out, err = run("print", "menger-sponge", "-o", tmp_path / "p.3mf", "--depth", depth)
    assert (code, out) == (2, "")
    assert f"--depth {depth} is more than can be printed" in err
    assert "; 6 fits" in err  # 20^6 = 6.4e7


def test_two_kinds_of_answer_at_once_are_refused(run):
    code, out, err = run("solve", "corner-cutting", "--json", "--latex")
    assert (code, out) == (2, "")
    assert "ask for one of them" in err


def test_bounds_are_shown_without_room_for_rounding(run, tmp_path):
    dust = tmp_path / "dust.toml"
    places = [("0", "0"), ("2/3", "0"), ("0", "2/3"), ("2/3", "2/3")]
    maps = "".join(f'[[maps]]\nscale = "1/3"\ntranslation = ["{x}", "{y}"]\n' for x, y in places)
    dust.write_text('format = "bcifs/1"\nname = "Dust"\n' + maps)
    assert "bounds          [0, 1] x [0, 1] mm" in run("info", dust)[1]


def test_info_of_a_similar_shape(run):
    found = json.loads(run("info", "menger-sponge", "--json")[1])
    assert found["bounds_mm"]["low"] == pytest.approx([0, 0, 0], abs=1e-9)
    assert found["bounds_mm"]["high"] == pytest.approx([54, 54, 54])
    assert 3 ** found["dimension"] == pytest.approx(20, rel=1e-12)
    assert found["convergence"]["lower"] <= 1 / 3 <= found["convergence"]["upper"]


def test_info_leaves_the_dimension_out_where_maps_are_no_similarities(run):
    found = json.loads(run("info", "takagi-curve", "--json")[1])
    assert "dimension" not in found
    assert found["convergence"]["verdict"] == "contracts"
    text = run("info", "takagi-curve")[1]
    assert "contracts: joint spectral radius in [0.5, 0.5" in text


def test_the_list_has_every_built_in_automaton(run):
    rows = run("list")[1].splitlines()
    assert [row.split()[0] for row in rows] == list(automata.builtin_names())
    assert "2 degrees of freedom" in next(row for row in rows if row.startswith("corner-cutting"))


def test_fld_as_data_and_as_text(run):
    found = json.loads(run("fld", "koch-curve", "0", "--json")[1])
    assert 4 ** -found["critical_order"] == pytest.approx(1 / 3)
    assert "critical order" in run("fld", "koch-curve", "0")[1]


@pytest.mark.parametrize("arguments", [["fld", "koch-curve", "7"], ["fld", "menger-sponge", "0"]])
def test_fld_of_what_it_cannot_answer(run, arguments):
    assert run(*arguments)[0] == 2


def test_a_real_process_answers_and_fails_with_its_code(tmp_path):
    def process(*arguments):
        command = [sys.executable, "-m", "bcifs", *arguments]
        return subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)

    good = process("solve", "corner-cutting", "--set", "a=1/4", "b=1/4")
    assert (good.returncode, good.stderr) == (0, "")
    assert "[ 3/4  1/4    0 ]" in good.stdout
    wrong = process("solve", "none.toml")
    assert (wrong.returncode, wrong.stdout) == (2, "")
    assert wrong.stderr.startswith("bcifs: none.toml: ")
