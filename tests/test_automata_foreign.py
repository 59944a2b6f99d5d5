"""Fractint files read like automaton files."""

import pytest

import automata
import ifs
from bcifs.__main__ import main

FERN = """; two of them
fern {
  0 0 0 .16 0 0 .01
  .85 .04 -.04 .85 0 1.6 .85
  .2 -.26 .23 .22 0 1.6 .07
  -.15 .28 .26 .24 0 .44 .07
}
Half { .5 0 0 .5 0 0 .5
 .5 0 0 .5 .5 0 .5 }
"""
KOCH = "Koch1 {\n Angle 6\n Axiom F--F--F\n F=F+F--F+F\n}\n"


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "some.ifs").write_text(FERN)
    (tmp_path / "snow.l").write_text(KOCH)
    return tmp_path


def test_an_entry_is_named_after_a_colon(folder):
    assert automata.read(f"{folder}/some.ifs:FERN").name == "fern"
    assert automata.read(folder / "snow.l").name == "Koch1"
    mesh = ifs.mesh(ifs.shape(f"{folder}/snow.l:koch1"), 3)
    assert (len(mesh.vertices), len(mesh.faces)) == (3 * 4**2, 3 * 4**2)


@pytest.mark.parametrize(
    ("place", "words"),
    [
        ("some.ifs", "there are 2 entries, name one of: fern, Half"),
        ("some.ifs:oak", "there is no IFS 'oak'; there are: fern, Half"),
        ("none.ifs", "no such file"),
        ("none.l:a", "no such file"),
    ],
)
def test_what_is_not_there_is_named(folder, place, words, capsys):
    assert main(["info", f"{folder}/{place}"]) == 2
    assert words in capsys.readouterr().err


def test_the_command_line_reads_them(folder, capsys):
    assert main(["info", f"{folder}/snow.l"]) == 0
    assert "1.26185950714" in capsys.readouterr().out


def test_old_code_pages_do_not_matter(folder):
    (folder / "old.ifs").write_bytes(b"; \xb3 \xff\nHalf { .5 0 0 .5 0 0 1 }")
    assert automata.read(folder / "old.ifs").name == "Half"


def test_maps_that_shrink_differently_are_drawn_in_pieces_of_one_size(folder, capsys):
    assert main(["render", f"{folder}/some.ifs:fern", "-o", f"{folder}/fern.png"]) == 0
    assert "in pieces below" in capsys.readouterr().out
