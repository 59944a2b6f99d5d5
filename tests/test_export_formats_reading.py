"""Readers of plain text against the readers of anything; equal positions; the rows of STL."""

import io
import random
import re
import struct
import zipfile

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from export.formats import obj_reader, threemf_reader, threemf_skim
from export.formats.damage import Damaged
from export.formats.stl import write_stl
from export.formats.welding import weld
from ifs.mesh import Mesh


def changed(text: bytes, words: list[bytes], chance: random.Random) -> bytes:
    found = bytearray(text)
    for _ in range(chance.randrange(4)):
        at = chance.randrange(len(found))
        found[at : at + chance.randrange(3)] = chance.choice(words)
    return bytes(found)


def outcome(call, content: bytes):
    try:
        mesh = call(content)
    except Damaged as error:
        return str(error)
    return bytes(mesh.vertices.data), mesh.faces.tolist()


OBJ = (
    b"# a\no b\nv 0 0 0 1 1 1\nv\t2 0 1e-3\r\nv 2.5 2 0\nv 0 .5 -0 # x\nvn 0 0 1\nf 1 2 3\n"
    b"f -4//1 -3//1 -2//1 -1//1 # all\nf 1/2/3 2/1 4\n f 4 3 2\nv 12345678901234567890.123 1_0 inf\n"
)
OBJ_WORDS = [
    *(b"%c" % byte for byte in b"0- \n\r\tvf/#.e19\v\xff+_"),
    b"\\\n",
    b"nan",
    b"f 1 2 3\n",
    b"v 1 2 3\n",
]


def test_plain_obj_is_read_as_line_by_line() -> None:
    chance, plain = random.Random(5), 0
    for _ in range(800):
        content = changed(OBJ, OBJ_WORDS, chance)
        lines = content.replace(b"\\\n", b" ").split(b"\n")
        assert outcome(obj_reader.read_obj, content) == outcome(
            lambda _, rows=lines: obj_reader._read_lines(rows), b""
        )
        plain += b"\\" not in content and obj_reader._read_plain(content) is not None
    assert plain > 100


def model(chance: random.Random) -> bytes:
    numbers = [
        "0",
        "1",
        "-1.5",
        "2.25e-3",
        "123456.789012",
        "1234567890123456789012.5",
        "9007199254740993",
        "+1",
    ]
    end, line = chance.choice(["/>", " />"]), chance.choice(["\n", "", "\r\n", "\r", " \t"])
    text = f'<model unit="inch">{chance.choice(["", "<!-- <vertices> ü -->"])}<resources>'
    for name in (1, 2):
        text += f'<object id="{name}"><mesh><vertices>{line}'
        for _ in range(9):
            x, y, z = chance.choices(numbers, k=3)
            text += f'<vertex x="{x}" y="{y}" z="{z}"{end}{line}'
        text += (
            chance.choice(["", "", "<!--c--><vertex y='1' x='2' z='3'/>"]) + "</vertices><triangles>" + line
        )
        for _ in range(9):
            a, b, c = chance.choices(range(9), k=3)
            more = chance.choice(["", "", ' pid="1" p1="0"', ' p1="0" p2="1" p3="2"', ' p1="0" pid="2"'])
            text += f'<triangle v1="{a}" v2="{b}" v3="{c}"{more}{end}{line}'
        text += "</triangles></mesh></object>"
    return f'{text}</resources><build><item objectid="1"/><item objectid="2"/></build></model>'.encode()


XML_WORDS = [
    *(b"%c" % byte for byte in b"0- \n\r</&\"'e\x01"), b"&#49;", b"<!--", b"-->", b"<vertices>",
    b'<vertex x="1" y="2" z="3"/>', b'x="1"', b"<![CDATA[", b"]]>", b"9" * 20,
    b"<triangles>", b'<object id="9">',
]  # fmt: skip


def packed(content: bytes) -> bytes:
    room = io.BytesIO()
    with zipfile.ZipFile(room, "w") as archive:
        archive.writestr("3D/3dmodel.model", content)
    return room.getvalue()


def test_elements_taken_out_change_nothing(monkeypatch) -> None:
    """The parser that sees all of the text finds the same mesh, or says the same."""
    chance, whole = random.Random(6), 0
    for _ in range(250):
        content = packed(changed(model(chance), XML_WORDS, chance))
        with monkeypatch.context() as context:
            context.setattr(threemf_skim, "OPENS", re.compile(b"(?!)"))
            expected = outcome(threemf_reader.read_3mf, content)
        monkeypatch.setattr(threemf_reader, "PIECE", chance.choice([7, 50, 200, 1 << 20]))
        monkeypatch.setattr(threemf_skim, "HELD", chance.choice([16, 100, 1024]))
        assert outcome(threemf_reader.read_3mf, content) == expected
        whole += not isinstance(expected, str)
    assert whole > 30


def test_plain_elements_are_taken_out(monkeypatch) -> None:
    taken = {"vertices": 0, "triangles": 0}
    skim = threemf_skim._skim

    def counting(name: str, text: bytes, at: int) -> tuple[int, np.ndarray]:
        end, rows = skim(name, text, at)
        taken[name] += len(rows)
        return end, rows

    monkeypatch.setattr(threemf_skim, "_skim", counting)
    monkeypatch.setattr(threemf_reader, "PIECE", 5000)
    vertex, triangle = '<vertex x="0.5" y="1" z="-2"/>\n', '<triangle v1="0" v2="1" v3="2" pid="3" p1="1"/>\n'
    text = f'<model><resources><object id="1"><mesh><vertices>{vertex * 900}</vertices>\n<triangles>'
    text += (
        triangle * 700 + '</triangles></mesh></object></resources><build><item objectid="1"/></build></model>'
    )
    mesh = threemf_reader.read_3mf(packed(text.encode()))
    assert taken == {"vertices": 900, "triangles": 700}
    assert (mesh.vertices == [0.5, 1, -2]).all()
    assert (mesh.faces == [0, 1, 2]).all()


@pytest.mark.parametrize("encoding", ["none-such", "shift_jis"])
def test_encodings_that_are_not_read(encoding) -> None:
    with pytest.raises(Damaged, match="line 1: XML"):
        threemf_reader.read_3mf(packed(f'<?xml version="1.0" encoding="{encoding}"?><model/>'.encode()))


@settings(deadline=None, max_examples=60)
@given(st.integers(0, 2**32), st.integers(0, 300), st.integers(1, 9))
def test_equal_positions_become_one(seed, triangles, values) -> None:
    chance = np.random.default_rng(seed)
    points = chance.choice(chance.normal(size=values), (3 * triangles, 3)) * chance.choice(
        [0, 1, -1], (3 * triangles, 1)
    )
    mesh = weld(Mesh(points, np.arange(3 * triangles).reshape(-1, 3)))
    assert np.array_equal(mesh.vertices, np.unique(points + 0.0, axis=0))
    assert np.array_equal(mesh.vertices[mesh.faces], points.reshape(-1, 3, 3))


def test_rows_of_stl(tmp_path) -> None:
    points = np.random.default_rng(2).normal(size=(20, 3))
    faces = np.array([[0, 1, 2], [7, 5, 6], [3, 3, 4], [19, 0, 8]])
    write_stl(Mesh(points, faces), tmp_path / "a.stl")
    content = (tmp_path / "a.stl").read_bytes()
    assert content[80:84] == struct.pack("<I", 4)
    for row, face in enumerate(faces):
        *numbers, rest = struct.unpack_from("<12fH", content, 84 + 50 * row)
        corners = points[face].astype(np.float32)
        assert np.array_equal(numbers[3:], corners.ravel())
        normal = np.cross(*(corners[1:].astype(float) - corners[0]))
        np.testing.assert_allclose(numbers[:3], normal / (np.linalg.norm(normal) or 1), atol=1e-7)
        assert rest == 0
