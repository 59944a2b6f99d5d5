"""Scenes in files, read back by other programs; packing and text against zlib and Python."""

import hashlib
import itertools
import json
import struct
import zipfile
import zlib

import lib3mf
import numpy as np
import plyfile
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from export.files import WRITABLE, UnreadableMesh, read_mesh, write_part
from export.formats import archive, deflate, threemf
from export.formats.archive import zip_archive
from export.formats.deflate import deflated, zlib_stream
from export.formats.scene import Body, Place, Scene, WrongMesh, WrongScene, moved
from export.formats.text import length_rows, number_rows
from ifs.mesh import Mesh


def box(sides=(1.0, 2.0, 3.0)) -> Mesh:
    solid = trimesh.creation.box(sides)
    return Mesh(np.asarray(solid.vertices, dtype=float), np.asarray(solid.faces, dtype=np.int64))


def quads() -> Mesh:
    """A pyramid: four triangles on a quadrangle."""
    vertices = np.array([[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0], [2, 2, 3]], dtype=float)
    faces = np.array([[3, 2, 1, 0], [0, 1, 4, -1], [1, 2, 4, -1], [2, 3, 4, -1], [3, 0, 4, -1]])
    return Mesh(vertices, faces)


def turned() -> np.ndarray:
    found = trimesh.transformations.rotation_matrix(0.7, [1, 2, 3])
    found[:3, 3] = [10, -20, 30.5]
    return found


PALETTE = np.array([[255, 0, 0], [0, 128, 255], [9, 9, 9]])
PATCHES = np.array([0, 0, 1, 1, 2, 2, 0, 1, 0, 0, 1, 2])


@pytest.fixture(scope="module")
def scene() -> Scene:
    mirrored = np.diag([-1.0, 1, 1, 1])
    mirrored[:3, 3] = [-40, 0, 0]
    return Scene(
        (
            Body(box(), "a <box> & more", PALETTE[PATCHES]),
            Body(quads(), "pyramid", np.array([[10, 20, 30, 128]])),
            Body(box((5, 5, 5))),
        ),
        (
            Place(0),
            Place(1, turned()),
            Place(0, turned() @ np.diag([2.0, 2, 2, 1])),
            Place(1, mirrored),
            Place(2),
        ),
    )


def solids(mesh: Mesh) -> list[tuple[float, ...]]:
    """Volume and centre of each part: the order of the parts does not matter."""
    parts = trimesh.Trimesh(mesh.vertices, mesh.triangles(), process=False).split(only_watertight=True)
    return sorted((round(float(part.volume), 3), *part.center_mass.round(3).tolist()) for part in parts)


def expected() -> list[tuple[float, ...]]:
    found = []
    for volume, centre, transform in (
        (6, [0, 0, 0], np.eye(4)),
        (16, [2, 2, 0.75], turned()),
        (48, [0, 0, 0], turned()),
        (16, [-42, 2, 0.75], np.eye(4)),
        (125, [0, 0, 0], np.eye(4)),
    ):
        place = transform[:3, :3] @ np.array(centre) + transform[:3, 3]
        found.append((round(float(volume), 3), *place.round(3).tolist()))
    return sorted(found)


@pytest.mark.parametrize("extension", WRITABLE)
def test_a_scene_reads_back(scene, tmp_path, extension) -> None:
    write_part(scene, tmp_path / f"a{extension}", {"depth": "3"}, "Several")
    back = read_mesh(tmp_path / f"a{extension}")
    np.testing.assert_allclose(solids(back), expected(), atol=3e-3)
    if extension != ".stl":
        assert len(back.vertices) == 8 + 5 + 8 + 5 + 8
    first = (tmp_path / f"a{extension}").read_bytes()
    write_part(scene, tmp_path / f"a{extension}", {"depth": "3"}, "Several")
    assert (tmp_path / f"a{extension}").read_bytes() == first


def read_3mf(path):
    model = lib3mf.get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(str(path))
    assert reader.GetWarningCount() == 0
    return model


def colours_of(model, mesh) -> list[tuple[int, ...]]:
    found = []
    for triangle in range(mesh.GetTriangleCount()):
        used = mesh.GetTriangleProperties(triangle)
        colour = model.GetColorGroupByID(used.ResourceID).GetColor(used.PropertyIDs[0])
        found.append((colour.Red, colour.Green, colour.Blue, colour.Alpha))
    return found


def test_lib3mf_finds_bodies_components_and_colours(scene, tmp_path) -> None:
    write_part(scene, tmp_path / "a.3mf", title="Several")
    model = read_3mf(tmp_path / "a.3mf")
    found, iterator = {}, model.GetMeshObjects()
    while iterator.MoveNext():
        mesh = iterator.GetCurrentMeshObject()
        assert mesh.IsManifoldAndOriented()
        found[mesh.GetResourceID()] = mesh
    assert [mesh.GetName() for mesh in found.values()] == ["a <box> & more", "pyramid", "", "pyramid"]
    first, second, *_ = found.values()
    assert colours_of(model, first) == [(*row, 255) for row in PALETTE[PATCHES].tolist()]
    assert colours_of(model, second) == [(10, 20, 30, 128)] * 6
    whole = model.GetComponentsObjects()
    assert whole.MoveNext()
    components = whole.GetCurrentComponentsObject()
    parts = [components.GetComponent(i) for i in range(components.GetComponentCount())]
    names = [found[part.GetObjectResourceID()].GetName() for part in parts]
    assert names == ["a <box> & more", "pyramid", "a <box> & more", "pyramid", ""]
    for number in (1, 2):
        fields = np.array([list(row) for row in parts[number].GetTransform().Fields])
        np.testing.assert_allclose(fields.T, scene.places[number].transform[:3], rtol=1e-6)
    items = model.GetBuildItems()
    assert items.MoveNext()
    assert items.GetCurrent().GetObjectResourceID() == components.GetResourceID()
    assert not items.MoveNext()


def test_places_may_be_objects_of_their_own(scene, tmp_path) -> None:
    write_part(Scene(scene.bodies, scene.places, together=False), tmp_path / "a.3mf")
    items, count = read_3mf(tmp_path / "a.3mf").GetBuildItems(), 0
    while items.MoveNext():
        count += 1
    assert count == 5
    np.testing.assert_allclose(solids(read_mesh(tmp_path / "a.3mf")), expected(), atol=3e-3)


def test_faces_keep_their_colours_in_ply(scene, tmp_path) -> None:
    write_part(scene, tmp_path / "a.ply")
    faces = plyfile.PlyData.read(str(tmp_path / "a.ply"))["face"].data
    found = np.stack([faces[part] for part in ("red", "green", "blue", "alpha")], axis=1)
    assert found[:12, :3].tolist() == PALETTE[PATCHES].tolist()
    assert found[12:18].tolist() == [[10, 20, 30, 128]] * 6
    assert found[-12:].tolist() == [[255] * 4] * 12


def test_glb_is_in_metres_with_y_upwards_and_keeps_colours(scene, tmp_path) -> None:
    write_part(scene, tmp_path / "a.glb", {"depth": "3"}, "Several")
    loaded = trimesh.load_scene(tmp_path / "a.glb")
    mesh = read_mesh(tmp_path / "a.glb")
    there = mesh.vertices[:, [0, 2, 1]] * [0.001, 0.001, -0.001]
    np.testing.assert_allclose(loaded.bounds, [there.min(axis=0), there.max(axis=0)], atol=1e-8)
    told = json.loads(
        (tmp_path / "a.glb").read_bytes()[20:].split(b"\0")[0].split(b"  ")[0].rpartition(b"}")[0] + b"}"
    )
    assert told["asset"]["extras"] == {"depth": "3"}
    assert len(told["meshes"]) == 3
    boxes = told["meshes"][0]["primitives"]
    assert {primitive["attributes"]["POSITION"] for primitive in boxes} == {0}
    light = {tuple(m["pbrMetallicRoughness"]["baseColorFactor"]) for m in told["materials"]}
    assert (1, 0, 0, 1) in light
    assert any(
        colour == pytest.approx((0, 0.215861, 1, 1), abs=1e-6) for colour in light
    )  # 128 of 255 in sRGB
    assert [m.get("alphaMode") for m in told["materials"]].count("BLEND") == 1


def test_glb_of_others_is_taken_as_the_format_has_it(tmp_path) -> None:
    solid = trimesh.creation.box((0.01, 0.02, 0.03))
    other = trimesh.Scene()
    transform = trimesh.transformations.translation_matrix([0.1, 0.2, 0.3])
    other.add_geometry(
        solid, transform=transform @ trimesh.transformations.rotation_matrix(np.pi / 2, [0, 0, 1])
    )
    (tmp_path / "a.glb").write_bytes(other.export(file_type="glb"))  # pyright: ignore
    found = read_mesh(tmp_path / "a.glb")
    np.testing.assert_allclose(np.ptp(found.vertices, axis=0), [20, 30, 10], atol=1e-4)
    np.testing.assert_allclose(found.vertices.mean(axis=0), [100, -300, 200], atol=1e-4)
    assert solids(found)[0][0] == pytest.approx(6000, rel=1e-5)


@pytest.mark.parametrize(
    "change",
    [
        ("uri", {"buffers": [{"uri": "a.bin", "byteLength": 4}]}),
        ("draco", {"extensionsRequired": ["KHR_draco_mesh_compression"]}),
        ("loop", {"nodes": [{"children": [0]}]}),
        ("long", {"accessors": []}),
    ],
)
def test_glb_that_cannot_be_read_is_refused(tmp_path, change) -> None:
    write_part(box(), tmp_path / "a.glb")
    content = (tmp_path / "a.glb").read_bytes()
    length = struct.unpack_from("<I", content, 12)[0]
    told = json.loads(content[20 : 20 + length]) | change[1]
    text = json.dumps(told).encode()
    text += b" " * (-len(text) % 4)
    rest = content[20 + length :]
    head = struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text) + len(rest), len(text), b"JSON")
    (tmp_path / "a.glb").write_bytes(head + text + rest)
    with pytest.raises(UnreadableMesh):
        read_mesh(tmp_path / "a.glb")


def test_quadrangles_are_the_same_solid_everywhere(tmp_path) -> None:
    for extension in WRITABLE:
        write_part(quads(), tmp_path / f"a{extension}")
        assert solids(read_mesh(tmp_path / f"a{extension}"))[0][0] == pytest.approx(16)


def test_moving_keeps_the_inside_inside() -> None:
    flipped = moved(quads(), np.diag([1.0, 1, -1, 1]))
    assert solids(flipped)[0][0] == pytest.approx(16)
    assert flipped.faces[1].tolist() == [4, 1, 0, -1]


def test_scenes_that_make_no_sense() -> None:
    body = Body(box())
    with pytest.raises(WrongScene, match="without bodies"):
        Scene(())
    with pytest.raises(WrongScene, match="place 1 is of body 2: there are 1"):
        Scene((body,), (Place(0), Place(2)))
    with pytest.raises(WrongScene, match="place 0 flattens"):
        Scene((body,), (Place(0, np.diag([1.0, 1, 0, 1])),))
    with pytest.raises(WrongScene, match="place 0 is no affine map"):
        Scene((body,), (Place(0, np.full((4, 4), np.nan)),))
    with pytest.raises(WrongScene, match="5 x 3 for 12 faces"):
        Body(box(), colours=np.zeros((5, 3)))
    with pytest.raises(WrongScene, match=r"colour 3 is \[0.0, 0.0, 256.0\]"):
        Body(box(), colours=np.array([[0.0, 0, 0]] * 3 + [[0, 0, 256]] * 9))
    big = Mesh(np.zeros((3, 3)) + np.eye(3), np.tile([0, 1, 2], (5000, 1)))
    numbers = np.arange(5000)
    colours = np.stack([numbers % 256, numbers // 256, numbers * 0], axis=1)
    with pytest.raises(WrongScene, match="5000 colours"):
        write_part(Scene((Body(big, colours=colours),)), "never.glb")


@pytest.mark.parametrize("extension", WRITABLE)
def test_meshes_that_no_file_can_hold(tmp_path, extension) -> None:
    good = box()
    for vertices, faces, words in (
        (np.where(np.arange(8)[:, None] == 5, np.nan, good.vertices), good.faces, r"vertex 5 is \[nan"),
        (good.vertices * 1e13, good.faces, "vertex 0"),
        (good.vertices, good.faces - 1, r"face \d+ is"),
        (good.vertices, good.faces[:0], "a mesh of 0 faces"),
        (good.vertices, good.faces[:, :2], "faces of 2 corners"),
        (np.zeros((8, 4)), good.faces, "4 coordinates"),
    ):
        with pytest.raises(WrongMesh, match=words):
            write_part(Mesh(vertices, faces), tmp_path / f"a{extension}")
    with pytest.raises(WrongMesh, match="body 1: a mesh of 0 faces"):
        write_part(Scene((Body(good), Body(Mesh(good.vertices, good.faces[:0])))), tmp_path / f"a{extension}")
    assert not list(tmp_path.iterdir())


def unpacked(packed: bytes) -> bytes:
    back = zlib.decompressobj(-15)
    found = back.decompress(packed)
    assert back.eof
    assert not back.unused_data
    return found


@settings(deadline=None, max_examples=80)
@given(st.data())
def test_zlib_unpacks_what_is_packed(data) -> None:
    seed, size = data.draw(st.integers(0, 2**32)), data.draw(st.integers(0, 3000))
    random = np.random.default_rng(seed)
    letters = random.integers(0, data.draw(st.integers(1, 256)), size).astype(np.uint8).tobytes()
    text = b"".join(letters[: random.integers(0, size + 1)] for _ in range(data.draw(st.integers(0, 40))))
    assert unpacked(b"".join(deflated([text]))) == text
    assert unpacked(b"".join(deflated(data.draw(st.lists(st.binary()))))) is not None


def test_codes_stay_within_15_bits() -> None:
    counts = [1, 1]
    while sum(counts) < 2**19:
        counts.append(counts[-1] + counts[-2])
    # no repeats of four: each byte is followed by one of its own
    text = np.repeat(np.arange(len(counts), dtype=np.uint8), counts)
    text = np.random.default_rng(0).permutation(text).tobytes()
    assert unpacked(b"".join(deflated([text]))) == text


def test_the_bytes_do_not_depend_on_pieces_or_threads(monkeypatch) -> None:
    random = np.random.default_rng(1)
    text = bytes(random.integers(0, 4, 3_500_000).astype(np.uint8))
    whole = b"".join(deflated([text]))
    assert unpacked(whole) == text
    cuts = [0, 5, 5, 1_048_576, 1_048_577, 3_400_000, len(text)]
    pieces = [text[a:b] for a, b in itertools.pairwise(cuts)]
    assert b"".join(deflated(pieces)) == whole
    monkeypatch.setattr(deflate, "THREADS", 1)
    assert b"".join(deflated([text])) == whole
    told = "".join(f'<vertex x="{k % 7}.{k * k}" y="{k}"/>\n' for k in range(2000)).encode()
    digest = hashlib.sha256(b"".join(deflated([told]))).hexdigest()
    assert digest == "1ea14364c9eda17dc24fcfb5faa37c49c5614402a080f2da2c239437ceaa02c6"
    assert zlib.decompress(zlib_stream(told)) == told


@given(st.lists(st.tuples(*[st.floats(-1e11, 1e11)] * 2), min_size=1, max_size=20))
def test_lengths_are_written_to_the_nearest_millionth(rows) -> None:
    table = np.array(rows)
    text = b"".join(length_rows(["", " ", "\n"], table)).decode()
    back = np.array([[float(x) for x in line.split(" ")] for line in text.splitlines()])
    assert (np.abs(back - table) <= 5e-7 + np.spacing(np.abs(table))).all()
    assert not any(x.endswith(".") or ("." in x and x.endswith("0")) for x in text.split())
    assert "-0 " not in text.replace("\n", " ")


@given(st.lists(st.integers(0, 2**63 - 1), min_size=1, max_size=30))
def test_whole_numbers_are_written_as_they_are(numbers) -> None:
    text = b"".join(number_rows(["<", ">"], np.array(numbers)[:, None])).decode()
    assert text == "".join(f"<{number}>" for number in numbers)


def test_archives_are_what_others_read(tmp_path, monkeypatch) -> None:
    with open(tmp_path / "few.zip", "w+b") as file, zip_archive(file) as add:
        add("ü/a.txt", [b"one ", b"", b"two"])
        add("big", [bytes(3_000_000), b"end"], large=True)
        add("as is", [b"123"], stored=True)
        add("none", [])
    with zipfile.ZipFile(tmp_path / "few.zip") as found:
        assert found.testzip() is None
        assert found.namelist() == ["ü/a.txt", "big", "as is", "none"]
        assert found.read("ü/a.txt") == b"one two"
        assert found.getinfo("big").file_size == 3_000_003
        assert found.getinfo("as is").compress_type == zipfile.ZIP_STORED
        assert {entry.date_time for entry in found.infolist()} == {(1980, 1, 1, 0, 0, 0)}
    monkeypatch.setattr(archive, "LIMIT", 100)
    with open(tmp_path / "a.zip", "w+b") as file, zip_archive(file) as add:
        with pytest.raises(OverflowError, match="the entry a of 101 bytes"):
            add("a", [bytes(101)])
        add("b", [bytes(101)], large=True)
        add("c", [bytes(3)], stored=True)
    # beyond the limit, places are 64 bits wide; none was reached in earnest
    assert zipfile.is_zipfile(tmp_path / "a.zip")


def test_large_models_are_announced(tmp_path, monkeypatch) -> None:
    write_part(box(), tmp_path / "small.3mf")
    monkeypatch.setattr(threemf, "LARGE", 1)
    write_part(box(), tmp_path / "large.3mf")
    with zipfile.ZipFile(tmp_path / "large.3mf") as large, zipfile.ZipFile(tmp_path / "small.3mf") as small:
        assert large.getinfo("3D/3dmodel.model").extra[:4] != small.getinfo("3D/3dmodel.model").extra[:4]
        assert large.testzip() is None
    assert read_3mf(tmp_path / "large.3mf").GetBuildItems().MoveNext()
