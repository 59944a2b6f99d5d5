"""Equations from `share`: the same ones, and the same family, as when every path is written out."""

import re
from importlib import resources

import pytest

import automata
import subdivision


def builtin_text(name: str) -> str:
    return (resources.files("automata") / "builtin" / f"{name}.toml").read_text("utf-8")


def shared(name: str, replacements: dict[str, str]) -> automata.Automaton:
    """A built-in whose stated equations, cell by cell, are replaced by a `share` statement."""
    head, *cells = re.split(r"(?m)^(?=\[cells\.\w+\]$)", builtin_text(name))
    out = [head]
    for text in cells:
        cell = re.match(r"\[cells\.(\w+)\]", text)[1]
        if cell in replacements:
            text = re.sub(r"(?ms)^adjacency = \[.*?\]\n", "", text)
            text = re.sub(r"(?ms)^incidence = \[.*?\]\n", f"share = {replacements[cell]}\n", text)
        out.append(text)
    return automata.parse_text("".join(out))


CASES = {
    "corner-cutting": {"edge": '["0 right = 1 left"]'},
    "koch-curve": {"edge": '["0 right = 1 left", "1 right = 2 left", "2 right = 3 left"]'},
    "sierpinski-triangle": {"triangle": '["0 b = 1 a", "1 c = 2 b", "2 a = 0 c"]'},
    "doo-sabin-patch": {
        "edge": '["0 right = 1 left turn"]',
        "face": '["0 right = 1 left", "1 top = 2 bottom", "2 left = 3 right", "3 bottom = 0 top"]',
    },
    "catmull-clark-patch": {
        "face": '["0 right = 1 left", "1 top = 2 bottom", "2 left = 3 right", "3 bottom = 0 top"]',
    },
}


@pytest.mark.parametrize("name", CASES)
def test_the_equations_worked_out_are_those_written_out(name):
    written, worked = automata.read(name), shared(name, CASES[name])
    for cell in CASES[name]:
        for kind in ("incidence", "adjacency"):
            pairs = [{(e.left, e.right) for e in getattr(a.cells[cell], kind)} for a in (written, worked)]
            assert pairs[0] == pairs[1]
    families = [subdivision.solve(a) for a in (written, worked)]
    assert families[0].operators == families[1].operators


@pytest.mark.parametrize(
    ("name", "cell", "statement", "words"),
    [
        ("doo-sabin-patch", "edge", '["0 right = 1 left"]', "leaves open through which symmetry"),
        ("koch-curve", "edge", '["0 right = 1 left", "1 right = 2 left"]', "write the incidences instead"),
        ("corner-cutting", "edge", '["0 = 1"]', "a piece, then one of its boundaries"),
        (
            "doo-sabin-patch",
            "face",
            '["0 right = 1 left", "1 top = 2 bottom"]',
            "write the incidences instead",
        ),
    ],
)
def test_what_stays_open_is_said_with_its_place(name, cell, statement, words):
    with pytest.raises(automata.AutomatonError, match=words) as caught:
        shared(name, {cell: statement})
    assert caught.value.line
    assert "share" in caught.value.path


def test_share_and_equations_exclude_each_other():
    text = builtin_text("corner-cutting").replace("incidence =", 'share = ["0 right = 1 left"]\nincidence =')
    with pytest.raises(automata.AutomatonError, match="either 'share' or"):
        automata.parse_text(text)
