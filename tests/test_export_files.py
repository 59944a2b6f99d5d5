"""Part files: whole or not at all, the same bytes, read back by other programs."""

import os
import zipfile

import lib3mf
import numpy as np
import pytest
import trimesh
from dense.surface import surface
from dense.voxels import Voxels

from export.check import check
from export.files import (
    WRITABLE,
    UnreadableMesh,
    UnsupportedFormat,
    check_writable,
    read_mesh,
    weld,
    write_part,
)
from export.formats.atomic import whole_file
from export.formats.scene import WrongMesh
from export.formats.threemf import NAMESPACE
from ifs.mesh import Mesh

RECIPE = {"depth": "3", "source": 'name = "A & B"\n\tpoints < 3\nü ∂'}


@pytest.fixture(scope="module")
def part() -> Mesh:
    filled = np.random.default_rng(5).random((6, 7, 8)) < 0.4
    return surface(Voxels(filled, np.array([-3.0, 10.0, 0.1]), 0.7))


def corners(mesh: Mesh) -> np.ndarray:
    """The triangles as positions, in an order that does not depend on numbering."""
    rows = np.round(mesh.vertices[mesh.faces], 4) + 0.0
    turned = np.array([np.roll(row, -min(range(3), key=lambda k: tuple(row[k])), 0) for row in rows])
    return np.array(sorted(turned.reshape(-1, 9).tolist()))


@pytest.mark.parametrize("extension", WRITABLE)
def test_written_parts_read_back(part, tmp_path, extension) -> None:
    path = tmp_path / f"part{extension}"
    write_part(part, path, RECIPE, "A part")
    back = read_mesh(path)
    assert back.vertices.shape == part.vertices.shape
    np.testing.assert_allclose(corners(back), corners(part), atol=2e-4)
    one, other = check(part), check(back)
    assert one.ok
    assert other.ok
    assert other.genus == one.genus
    assert other.volume == pytest.approx(one.volume, rel=1e-5)


@pytest.mark.parametrize("extension", WRITABLE)
def test_two_writes_give_the_same_bytes(part, tmp_path, extension) -> None:
    paths = [tmp_path / f"{name}{extension}" for name in ("one", "other")]
    write_part(part, paths[0], RECIPE, "A part")
    write_part(part, paths[1], dict(reversed(RECIPE.items())), "A part")
    assert paths[0].read_bytes() == paths[1].read_bytes()


def test_lib3mf_reads_the_3mf_strictly(part, tmp_path) -> None:
    path = tmp_path / "part.3mf"
    write_part(part, path, {**RECIPE, "lines": "a\r\nb\rc"}, "A part")
    model = lib3mf.get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(str(path))
    assert reader.GetWarningCount() == 0
    assert model.GetUnit() == lib3mf.ModelUnit.MilliMeter
    metadata = model.GetMetaDataGroup()
    assert metadata.GetMetaDataByKey("", "Title").GetValue() == "A part"
    for key, value in {**RECIPE, "lines": "a\nb\nc"}.items():
        assert metadata.GetMetaDataByKey(NAMESPACE, key).GetValue() == value
    objects = model.GetMeshObjects()
    assert objects.MoveNext()
    mesh = objects.GetCurrentMeshObject()
    assert mesh.IsValid()
    assert mesh.IsManifoldAndOriented()
    faces = np.array([list(t.Indices) for t in mesh.GetTriangleIndices()])
    vertices = np.array([list(v.Coordinates) for v in mesh.GetVertices()])
    assert np.array_equal(faces, part.faces)
    np.testing.assert_allclose(vertices, part.vertices, atol=1e-5)
    items = model.GetBuildItems()
    assert items.MoveNext()
    assert not items.MoveNext()


def test_zip_entries_bear_no_date(part, tmp_path) -> None:
    write_part(part, tmp_path / "part.3mf")
    with zipfile.ZipFile(tmp_path / "part.3mf") as archive:
        assert {entry.date_time for entry in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}
        assert archive.testzip() is None


def test_trimesh_reads_a_solid_from_each(part, tmp_path) -> None:
    for extension in WRITABLE:
        write_part(part, tmp_path / f"part{extension}", RECIPE)
        loaded = trimesh.load_mesh(tmp_path / f"part{extension}")
        if extension == ".glb":
            loaded.apply_scale(1000)  # from metres
        assert loaded.is_watertight
        assert loaded.volume == pytest.approx(check(part).volume, rel=1e-5)


def test_recipe_stands_in_comments(part, tmp_path) -> None:
    for extension in (".ply", ".obj"):
        write_part(part, tmp_path / f"part{extension}", {"depth": "3", "text": "a\nb"})
        content = (tmp_path / f"part{extension}").read_bytes()
        assert b"depth: 3\n" in content
        assert b"text: a\\nb\n" in content


@pytest.mark.parametrize("failure", [ValueError, KeyboardInterrupt])
def test_a_failure_leaves_what_was_there(tmp_path, failure) -> None:
    path = tmp_path / "part.stl"
    path.write_bytes(b"before")

    def fail() -> None:
        with whole_file(path) as file:
            file.write(b"half")
            raise failure

    with pytest.raises(failure):
        fail()
    assert os.listdir(tmp_path) == ["part.stl"]
    assert path.read_bytes() == b"before"


def test_a_failed_part_leaves_no_file(part, tmp_path) -> None:
    for recipe, word in (({"no good": "1"}, "recipe key"), ({"a": "\x00"}, "character")):
        with pytest.raises(ValueError, match=word):
            write_part(part, tmp_path / "part.3mf", recipe)
    broken = Mesh(part.vertices, part.faces + len(part.vertices))
    for extension in WRITABLE:
        with pytest.raises(WrongMesh, match=r"face \d+ is .*: vertices from 0 to"):
            write_part(broken, tmp_path / f"part{extension}")
    with pytest.raises(UnsupportedFormat, match=r"\.3mf, \.stl"):
        write_part(part, tmp_path / "part.step")
    with pytest.raises(FileNotFoundError):
        write_part(part, tmp_path / "missing" / "part.stl")
    assert os.listdir(tmp_path) == []


def test_unknown_extensions_are_refused_beforehand() -> None:
    check_writable("PART.STL")
    with pytest.raises(UnsupportedFormat):
        check_writable("part")


def test_files_that_hold_no_mesh(part, tmp_path) -> None:
    with pytest.raises(FileNotFoundError, match="no such file"):
        read_mesh(tmp_path / "missing.stl")
    (tmp_path / "part.doc").write_bytes(b"text")
    with pytest.raises(UnsupportedFormat):
        read_mesh(tmp_path / "part.doc")
    rng = np.random.default_rng(0)
    for extension in WRITABLE:
        path = tmp_path / f"junk{extension}"
        write_part(part, path)
        whole = path.read_bytes()
        cut = [] if extension == ".obj" else [whole[: len(whole) // 2], whole[:60]]
        for content in (b"", b"junk", rng.bytes(1000), *cut):
            path.write_bytes(content)
            with pytest.raises(UnreadableMesh):
                read_mesh(path)


def test_units_of_other_programs_are_converted(part, tmp_path) -> None:
    write_part(part, tmp_path / "mm.3mf")
    with (
        zipfile.ZipFile(tmp_path / "mm.3mf") as old,
        zipfile.ZipFile(tmp_path / "inch.3mf", "w") as new,
    ):
        for name in old.namelist():
            new.writestr(name, old.read(name).replace(b'"millimeter"', b'"inch"'))
    np.testing.assert_allclose(read_mesh(tmp_path / "inch.3mf").vertices, part.vertices * 25.4, atol=1e-4)


def test_welding_by_position() -> None:
    points = np.random.default_rng(3).integers(0, 2, (30, 3)).astype(float)
    points[points == 0] *= -1  # minus zero is zero
    faces = np.arange(30).reshape(10, 3)
    mesh = weld(Mesh(points, faces))
    assert np.array_equal(mesh.vertices, np.unique(points + 0.0, axis=0))
    assert np.array_equal(mesh.vertices[mesh.faces], points[faces])
