"""Hostile and damaged files get an error of their own kind, and soon."""

import os
from importlib import resources

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from automata import AutomatonError, builtin_names, parse_text, read
from automata.topology import Topology
from subdivision import Contradiction, NotLinear, Undetermined, WrongValue, solve

HEAD = 'format = "bcifs/1"\nshape = "face"\n'


def whole_way(text):
    """Read, solve and glue; the faults that may come of it are swallowed, all others are not."""
    try:
        automaton = parse_text(text, "file")
        topology = Topology(automaton)
        for cell in automaton.cells:
            topology.subdivided(cell)
        solve(automaton).numbers()
    except (AutomatonError, Contradiction, NotLinear, Undetermined, WrongValue):
        return


def built_in(name):
    return (resources.files("automata") / "builtin" / f"{name}.toml").read_text("utf-8")


ORIGINALS = {name: built_in(name) for name in builtin_names() if name != "menger-sponge"}
WORDS = """
    0 1 -1 "*" "1/2" "1/0" edge face s left right turn flip points cell
    [ ] { } = , " # . 1e400 inf é true
"""
TOKENS = st.sampled_from(WORDS.split()) | st.sampled_from(["\n", "\0", "9" * 50])


@st.composite
def damaged(draw):
    text = draw(st.sampled_from(sorted(ORIGINALS)).map(ORIGINALS.get))
    for _ in range(draw(st.integers(1, 4))):
        kind = draw(st.sampled_from(["byte", "drop", "double", "swap", "insert", "word"]))
        lines = text.split("\n")
        i, j = (draw(st.integers(0, len(lines) - 1)) for _ in range(2))
        at = draw(st.integers(0, len(text) - 1))
        if kind == "byte":
            text = text[:at] + chr(draw(st.integers(0, 255))) + text[at + 1 :]
        elif kind == "drop":
            text = "\n".join(lines[:i] + lines[i + 1 :])
        elif kind == "double":
            text = "\n".join(lines[: i + 1] + lines[i:])
        elif kind == "swap":
            lines[i], lines[j] = lines[j], lines[i]
            text = "\n".join(lines)
        elif kind == "insert":
            text = text[:at] + draw(TOKENS) + text[at:]
        else:
            words = text.split(" ")
            k, m = (draw(st.integers(0, len(words) - 1)) for _ in range(2))
            words[k] = words[m]
            text = " ".join(words)
        text = text or " "
    return text


@settings(max_examples=50, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(damaged())
def test_damaged_files_are_read_or_refused(text):
    whole_way(text)


@settings(max_examples=40, deadline=None)
@given(st.text(max_size=60))
def test_any_text_is_read_or_refused(text):
    whole_way(text)


LOOP = '[cells.v]\npoints = 1\nsubdivision = { s = "v" }\n'


def chain(length):
    """Cells each with the one before it as its boundary twice over: the paths double at every cell."""
    text = f'format = "bcifs/1"\nshape = "c{length}"\n[cells.c0]\npoints = 1\nsubdivision = {{ s = "c0" }}\n'
    for k in range(1, length + 1):
        border = f'{{ cell = "c{k - 1}", points = [0] }}'
        text += f'[cells.c{k}]\npoints = 1\nsubdivision = {{ s = "c{k}" }}\n'
        text += f"boundary = {{ a = {border}, b = {border} }}\n"
    return text


def embeddings(count):
    rows = "".join(f'b{i} = {{ cell = "v", points = {list(range(256))} }}\n' for i in range(count))
    cells = '[cells.v]\npoints = 256\nsubdivision = { s = "v" }\n[cells.face]\npoints = 256\n'
    return HEAD + cells + 'subdivision = { 0 = "face" }\n[cells.face.boundary]\n' + rows


HOSTILE = {
    "brackets": "a = " + "[" * 200_000,
    "closed brackets": "a = " + "[" * 20_000 + "]" * 20_000,
    "tables in tables": "a = " + "{a = " * 20_000 + "1" + "}" * 20_000,
    "a long key": "a" + ".a" * 100_000 + " = 1",
    "a long header": "[a" + ".a" * 100_000 + "]",
    "a long quoted key": "'a'" + ' . "a"' * 50_000 + " = 1",
    "powers of powers": HEAD + LOOP + '[set]\na = "' + "(" * 30 + "9" + "^12)" * 30 + '"',
    "a tower": HEAD + LOOP + '[set]\na = "9^9^9"',
    "a huge exponent": HEAD + LOOP + "[set]\na = 1e999999999",
    "an exponent with many digits": HEAD + LOOP + f"[set]\na = 1e{'9' * 100_000}",
    "many digits": HEAD + LOOP + f"[set]\na = 0.{'9' * 500_000}",
    "a huge integer": HEAD + LOOP + f"[set]\na = {'9' * 500_000}",
    "a long expression": HEAD + LOOP + '[set]\na = "' + "1+" * 200_000 + '1"',
    "zero bytes": "\0" * 1000,
    "many operators": HEAD + '[cells.face]\npoints = 256\nsubdivision = { 0 = "face", 1 = "face" }\n',
    "many embeddings": embeddings(20),
    "long paths": HEAD + LOOP.replace("v", "face") + f'adjacency = ["{"s " * 200_000} = s"]',
    "long names": HEAD + f'[cells.{"x" * 300_000}]\npoints = 1\nsubdivision = {{ s = "{"x" * 299_999}y" }}',
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_texts_are_refused(name):
    assert len(HOSTILE[name]) < 1_000_000
    with pytest.raises(AutomatonError):
        parse_text(HOSTILE[name], "file")


def test_boundaries_of_boundaries_without_end_are_refused():
    with pytest.raises(AutomatonError, match="over 2000 paths"):
        Topology(parse_text(chain(30))).subdivided("c30")


def test_a_fan_of_many_pieces_is_glued_at_one_vertex():
    count = 1200
    labels = ", ".join(f'{i} = "face"' for i in range(count))
    glue = ", ".join(f'"{i} a = {i + 1} a"' for i in range(count - 1))
    border = 'boundary = { a = { cell = "v", points = [0] } }'
    face = f"[cells.face]\npoints = 2\nsubdivision = {{ {labels} }}\n{border}\nadjacency = [{glue}]\n"
    assert len(Topology(parse_text(HEAD + LOOP + face)).subdivided("face").interior) == 1


def test_a_large_file_is_refused_unread(tmp_path):
    with open(tmp_path / "large.toml", "wb") as file:
        file.truncate(100_000_000)
    with pytest.raises(AutomatonError, match="100000000 bytes; an automaton file has at most 1000000"):
        read(tmp_path / "large.toml")


def test_what_is_no_readable_file_is_refused(tmp_path):
    with pytest.raises(AutomatonError, match="expected a file"):
        read(tmp_path)
    with pytest.raises(AutomatonError, match="no such file"):
        read(tmp_path / "absent.toml")
    with pytest.raises(AutomatonError, match="cannot read the file"):
        read("a\0b.toml")
    with pytest.raises(AutomatonError, match="cannot read the file"):
        read("x" * 5000)
    os.symlink("loop.toml", tmp_path / "loop.toml")
    with pytest.raises(AutomatonError, match="cannot read the file"):
        read(tmp_path / "loop.toml")
    (tmp_path / "bytes.toml").write_bytes(b"name = '\xff'")
    with pytest.raises(AutomatonError, match="UTF-8 \\(byte 8"):
        read(tmp_path / "bytes.toml")


@pytest.mark.skipif(os.geteuid() == 0, reason="permissions do not bind the superuser")
def test_a_file_without_permission_is_refused(tmp_path):
    (tmp_path / "closed.toml").write_text("")
    (tmp_path / "closed.toml").chmod(0)
    with pytest.raises(AutomatonError, match="cannot read the file: Permission denied"):
        read(tmp_path / "closed.toml")
