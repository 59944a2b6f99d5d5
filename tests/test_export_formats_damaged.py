"""Damaged and hostile mesh files: one clean sentence with the place, what was expected, and what to do."""

import io
import json
import re
import resource
import struct
import subprocess
import sys
import time
import zipfile

import numpy as np
import pytest
import trimesh

from export.files import READABLE, UnreadableMesh, read_mesh

PLACE = re.compile(
    r"byte \d|line \d|after \d+ bytes|the end of \d+ bytes|archive|the JSON chunk|the head|"
    r"triangle \d+|vertex \d+|holds no triangles|is empty"
)
WORDS = [
    b"-1",
    b"99999999999",
    b"4294967295",
    b"nan",
    b"inf",
    b"1e999",
    b"",
    b'"',
    b"0",
    b"[",
    b"null",
    b"1.5",
]


def made(ball: trimesh.Trimesh, ending: str) -> list[bytes]:
    """The same mesh in each kind that an ending can mean."""
    match ending:
        case ".stl":
            return [as_bytes(ball, "stl"), as_bytes(ball, "stl_ascii")]
        case ".ply":
            return [as_bytes(ball, "ply"), as_bytes(ball, "ply", encoding="ascii")]
        case _:
            return [as_bytes(ball, ending[1:])]


def as_bytes(ball: trimesh.Trimesh, kind: str, **options) -> bytes:
    content = ball.export(file_type=kind, **options)
    return content.encode() if isinstance(content, str) else bytes(content)  # pyright: ignore


@pytest.fixture(scope="module")
def ball() -> trimesh.Trimesh:
    return trimesh.creation.icosphere(1)


def packed(model: bytes) -> bytes:
    """A 3MF file with this model."""
    room = io.BytesIO()
    with zipfile.ZipFile(room, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("3D/3dmodel.model", model)
    return room.getvalue()


def model(resources: str, build: str = '<item objectid="1"/>') -> bytes:
    return f"<model><resources>{resources}</resources><build>{build}</build></model>".encode()


TRIANGLE = (
    '<object id="1"><mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/>'
    '<vertex x="0" y="1" z="0"/></vertices><triangles><triangle v1="0" v2="1" v3="2"/></triangles>'
    "</mesh></object>"
)


def glb(document: dict | bytes, numbers: bytes = b"") -> bytes:
    text = document if isinstance(document, bytes) else json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    body = (
        struct.pack("<I", len(text)) + b"JSON" + text + struct.pack("<I", len(numbers)) + b"BIN\0" + numbers
    )
    return b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body


def mutated(content: bytes, rng: np.random.Generator) -> bytes:
    """Cut, with bytes changed, a number replaced, a stretch taken out, or something put in."""
    found = bytearray(content)
    at = int(rng.integers(len(found)))
    match rng.integers(5):
        case 0:
            return content[:at]
        case 1:
            for place in rng.integers(0, len(found), rng.integers(1, 6)):
                found[place] = rng.integers(256)
        case 2:
            numbers = [one.span() for one in re.finditer(rb"-?\d+(\.\d+)?", content)] or [(0, 1)]
            start, end = numbers[rng.integers(len(numbers))]
            found[start:end] = WORDS[rng.integers(len(WORDS))]
        case 3:
            del found[at : at + int(rng.integers(1, 60))]
        case _:
            found[at:at] = rng.bytes(int(rng.integers(1, 20)))
    return bytes(found)


@pytest.mark.parametrize("ending", READABLE)
def test_any_damage_is_told_in_one_sentence(tmp_path, ball, ending) -> None:
    rng, path = np.random.default_rng(7), tmp_path / f"a{ending}"
    seeds, refused, inner = made(ball, ending), 0, b""
    if ending == ".3mf":
        with zipfile.ZipFile(io.BytesIO(seeds[0])) as archive:
            inner = next(archive.read(name) for name in archive.namelist() if name.endswith(".model"))
    for turn in range(120):
        if ending == ".3mf" and turn % 2:
            path.write_bytes(packed(mutated(inner, rng)))
        else:
            path.write_bytes(mutated(seeds[turn % len(seeds)], rng))
        try:
            mesh = read_mesh(path)
        except UnreadableMesh as error:
            said, refused = str(error), refused + 1
            assert "\n" not in said
            assert len(said) < 500
            assert said.startswith(str(path))
            assert PLACE.search(said.removeprefix(str(path))), said
            assert "; " in said
        else:
            assert np.isfinite(mesh.vertices[mesh.faces]).all()
    assert refused > 40


@pytest.mark.parametrize("ending", READABLE)
def test_readers_agree_with_trimesh(tmp_path, ball, ending) -> None:
    for content in made(ball, ending):
        (tmp_path / f"a{ending}").write_bytes(content)
        mesh = read_mesh(tmp_path / f"a{ending}")
        assert (mesh.vertices.shape, mesh.faces.shape) == ((42, 3), (80, 3))
        scale = 1000 if ending == ".glb" else 1
        assert mesh.to_trimesh().volume == pytest.approx(ball.volume * scale**3, rel=1e-4)


@pytest.mark.parametrize(
    ("ending", "content", "words"),
    [
        (".stl", b"\0" * 80 + struct.pack("<I", 4_000_000_000), "byte 80: 4000000000 triangles"),
        (".stl", b"solid a\nfacet normal 0 0 1\n outer loop\n  vertex 1 x 2\n", "line 4: three numbers"),
        (".stl", b"hello world", "after 11 bytes"),
        (".ply", b"ply\nformat ascii 1.0\nelement vertex 999999999999\nproperty float x\nproperty float y\n"
         b"property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n",
         "line 3: 999999999999 rows of vertex"),
        (".ply", b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n", "x, y, z"),
        (".ply", b"ply\n" + b"comment x\n" * 200_000, "the head does not end"),
        (".obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "line 4: vertex 4 is named, the file has 3"),
        (".obj", b"v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n", "vertex 1 .* finite"),
        (".obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -9\n", "line 4: '-9' names no vertex"),
        (".obj", b"v 0 0 0\nf 1 1 " + b"9" * 5000 + b"\n", "line 2"),
        (".off", b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n9 0 1 2\n", "line 6: 9 corners"),
        (".off", b"OFF\n1000000000 1 0\n", "line 2: 1000000000 vertices"),
        (".3mf", b"PK\3\4 not a zip", "no zip archive"),
        (".3mf", packed(b"<!DOCTYPE a [<!ENTITY b 'c'>]><model>&b;</model>"), "line 1: a document type"),
        (".3mf", packed(b"<model><vertex></model>"), "line 1: XML was expected: mismatched tag"),
        (".3mf", packed(model(TRIANGLE.replace('v3="2"', 'v3="7"'))), "names vertex 7 of 3"),
        (".3mf", packed(model(TRIANGLE.replace('v3="2"', 'v3="x"'))), "v3, the number of a vertex"),
        (".3mf", packed(model(TRIANGLE, '<item objectid="4"/>')), "'4', which is missing"),
        (".3mf", packed(model(TRIANGLE, '<item objectid="1" transform="1 0"/>')), "12 numbers"),
        (".3mf", packed(model('<object id="1"><components><component objectid="1"/></components></object>')),
         "without end"),
        (".3mf", packed(b"<model>" + b" " * (80 << 20) + b"</model>"), "do not open it"),
        (".glb", glb(b"{"), r"character \d: JSON was expected"),
        (".glb", glb(b"[" * 100_000), "without end"),
        (".glb", glb({"nodes": [{"children": [1, 1]}, {"children": [0]}]}), "without end"),
        (".glb", glb({"nodes": [{"mesh": 3}]}), "entry 3 of meshes"),
        (".glb", glb({"scenes": 3}), "the JSON chunk"),
        (".glb", glb({"nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
                      "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3",
                                     "count": 10**12}],
                      "bufferViews": [{"buffer": 0, "byteStride": 0}], "buffers": [{}]}), "overlap"),
    ],
)  # fmt: skip
def test_what_is_said_of_hostile_files(tmp_path, ending, content, words) -> None:
    path = tmp_path / f"a{ending}"
    path.write_bytes(content)
    before, began = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, time.monotonic()
    with pytest.raises(UnreadableMesh, match=words):
        read_mesh(path)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 500_000  # kB
    assert time.monotonic() - began < 20  # no hang


def test_doubling_components_are_refused(tmp_path) -> None:
    """Each object is the one before twice: 2^40 triangles."""
    objects = [TRIANGLE] + [
        f'<object id="{k}"><components><component objectid="{k - 1}"/><component objectid="{k - 1}"/>'
        "</components></object>"
        for k in range(2, 42)
    ]
    (tmp_path / "a.3mf").write_bytes(packed(model("".join(objects), '<item objectid="41"/>')))
    with pytest.raises(UnreadableMesh, match="without end"):
        read_mesh(tmp_path / "a.3mf")


def test_what_other_programs_write_is_read(tmp_path) -> None:
    """Quadrangles, counting backwards, textures, other byte orders, further elements, other model parts."""
    square = "v 0 0 0\nv 2 0 0 1 1 1\nv 2 2 0\nv 0 2 0\nvn 0 0 1\n"
    (tmp_path / "a.obj").write_text(square + "f -4//1 -3//1 -2//1 \\\n -1//1 # all\n")
    assert read_mesh(tmp_path / "a.obj").faces.tolist() == [[0, 1, 2], [0, 2, 3]]
    head = (
        b"ply\r\nformat binary_big_endian 1.0\r\nelement vertex 4\r\nproperty float x\r\nproperty float y\r\n"
        b"property float z\r\nproperty uchar red\r\nelement face 2\r\n"
        b"property list uchar int vertex_index\r\nproperty uchar flags\r\nend_header\r\n"
    )
    points = b"".join(struct.pack(">fffB", *row, 7) for row in ((0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0)))
    for faces, expected in (
        (((0, 1, 2, 3), (0, 1, 2)), [[0, 1, 2], [0, 2, 3], [0, 1, 2]]),
        (((0, 1, 2), (2, 3, 0)), [[0, 1, 2], [2, 3, 0]]),
    ):
        rows = b"".join(struct.pack(f">B{len(face)}iB", len(face), *face, 1) for face in faces)
        (tmp_path / "a.ply").write_bytes(head + points + rows)
        mesh = read_mesh(tmp_path / "a.ply")
        assert mesh.faces.tolist() == expected
        assert mesh.vertices[2].tolist() == [2, 2, 0]
    (tmp_path / "a.off").write_text("OFF 4 1 0\n# a square\n0 0 0\n2 0 0\n2 2 0\n0 2 0\n4 0 1 2 3 255 0 0\n")
    assert read_mesh(tmp_path / "a.off").faces.tolist() == [[0, 1, 2], [0, 2, 3]]
    room = io.BytesIO()
    with zipfile.ZipFile(room, "w") as archive:
        archive.writestr("3D/Objects/b.model", model(TRIANGLE, ""))
        archive.writestr(
            "3D/3dmodel.model",
            '<model unit="inch" xmlns:p="x"><resources><object id="8"><components>'
            '<component p:path="/3D/Objects/b.model" objectid="1" transform="1 0 0 0 1 0 0 0 1 5 0 0"/>'
            '</components></object></resources><build><item objectid="8"/></build></model>',
        )
        archive.writestr(
            "_rels/.rels",
            '<Relationships><Relationship Target="/3D/3dmodel.model" Type="http://a/3dmodel"/></Relationships>',
        )
    (tmp_path / "a.3mf").write_bytes(room.getvalue())
    np.testing.assert_allclose(read_mesh(tmp_path / "a.3mf").vertices[:, 0], [5 * 25.4, 6 * 25.4, 5 * 25.4])


def test_a_folder_is_no_mesh(tmp_path) -> None:
    (tmp_path / "a.stl").mkdir()
    with pytest.raises(UnreadableMesh, match="folder"):
        read_mesh(tmp_path / "a.stl")


WRONG = """
import numpy as np
from export.files import read_mesh, write_part
from export.formats.slices import write_slices
from export.formats.tree_files import write_cells
from ifs.mesh import Mesh
from trees import full, unit_cube

mesh, tree = Mesh(np.eye(3), np.array([[0, 1, 2]])), full(unit_cube(3), bits=2)
for call in (
    lambda: write_slices(np.ones((2, 2, 2)), "a.zip"),
    lambda: write_slices(tree, "a.zip", layer_height="x"),
    lambda: write_slices(tree, "a.zip", layer_height=5e-324),
    lambda: write_slices(tree, 3),
    lambda: write_slices(tree, "a.zip", recipe={"a": 2}),
    lambda: write_cells(mesh, "a.vdb"),
    lambda: write_part(tree, "a.stl"),
    lambda: write_part(mesh, "a.glb", {"a": 3}),
    lambda: read_mesh(None),
):
    try:
        call()
    except ValueError as error:
        print(type(error).__name__, error)
"""


def test_wrong_types_are_named(tmp_path) -> None:
    """In a process of its own: here, types are checked before."""
    done = subprocess.run([sys.executable, "-c", WRONG], capture_output=True, text=True, cwd=tmp_path)
    assert done.stderr == ""
    for line, words in zip(
        done.stdout.splitlines(),
        (
            "WrongSlices slices are of a trees.Tree, found a ndarray",
            "WrongSlices the layer height is a length above 0 mm, found 'x'",
            "WrongSlices more than 10^12 layers",
            "UnsupportedFormat the path of a file was expected, found 3",
            "WrongRecipe recipe 'a' is 2: text is needed",
            "TreeError a trees.Tree is written, found a Mesh",
            "WrongMesh a Mesh or a Scene is written, found a Tree",
            "WrongRecipe recipe 'a' is 3: text is needed",
            "UnsupportedFormat the path of a file was expected, found None",
        ),
        strict=True,
    ):
        assert line.startswith(words)
    assert not list(tmp_path.iterdir())
