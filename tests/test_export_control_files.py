"""Control meshes read from files that other programs wrote, and from damaged ones."""

import numpy as np
import pytest
import pyvista
import trimesh

from export.control_files import read_control_mesh
from export.files import UnreadableMesh, UnsupportedFormat

CUBE = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
CORNERS = 10.0 * np.array([(i & 1, i >> 1 & 1, i >> 2) for i in range(8)])


def placed(vertices, faces) -> set:
    """The faces by the positions of their corners, from the least one on."""
    found = set()
    for face in faces:
        points = [tuple(vertices[v].tolist()) for v in face]
        first = points.index(min(points))
        found.add((*points[first:], *points[:first]))
    return found


def test_obj_keeps_polygons_of_any_size(tmp_path):
    place = tmp_path / "a.obj"
    place.write_text(
        "# a roof\nmtllib a.mtl\no roof\nv 0 0 0 # first\nv 10 0 0\nv 10 10 0\nv 0 10 0\nv 5 5 8\n"
        "vt 0 0\nvn 0 0 1\nusemtl red\nf 1/1/1 4/1/1 3/1/1 2/1/1\nf -5//1 -4//1 -1//1\nf 2 3 5\n"
    )
    vertices, faces = read_control_mesh(place)
    assert vertices.shape == (5, 3)
    assert faces == [[0, 3, 2, 1], [0, 1, 4], [1, 2, 4]]


@pytest.mark.parametrize("binary", [True, False])
def test_ply_of_another_program_keeps_its_polygons(tmp_path, binary):
    mesh = pyvista.PolyData(CORNERS, np.hstack([[4, *face] for face in CUBE[1:]] + [[3, 0, 2, 3]]))
    mesh.save(tmp_path / "a.ply", binary=binary)
    vertices, faces = read_control_mesh(tmp_path / "a.ply")
    np.testing.assert_array_equal(vertices, CORNERS)
    assert sorted(map(len, faces)) == [3, 4, 4, 4, 4, 4]
    assert placed(vertices, faces) == placed(CORNERS, [*CUBE[1:], (0, 2, 3)])


@pytest.mark.parametrize("shuffled", [False, True])
def test_stl_of_quadrangles_becomes_quadrangles_again(tmp_path, shuffled):
    triangles = [t for a, b, c, d in CUBE for t in ((a, b, c), (a, c, d))]
    if shuffled:
        triangles = [triangles[i] for i in np.random.default_rng(1).permutation(len(triangles))]
    trimesh.Trimesh(CORNERS, triangles, process=False).export(tmp_path / "a.stl")
    vertices, faces = read_control_mesh(tmp_path / "a.stl")
    assert len(vertices) == 8
    assert placed(vertices, faces) == placed(CORNERS, CUBE)


def test_stl_of_a_mesh_of_triangles_stays_so(tmp_path):
    trimesh.creation.icosahedron().export(tmp_path / "a.stl")
    vertices, faces = read_control_mesh(tmp_path / "a.stl")
    assert len(vertices) == 12
    assert {len(face) for face in faces} == {3}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("v 0 0\n", ":1: expected `v x y z`, found 'v 0 0'"),
        ("v 0 0 0\nv one 0 0\n", ":2: expected `v x y z`"),
        ("v 0 0 0\nf 1 2 3\n", ":2: expected `f` and numbers of vertices above, found 'f 1 2 3'"),
        ("v 0 0 0\nf 0 0 0\n", ":2: expected `f`"),
        ("v 0 0 0\n", "holds no polygons"),
        ("", "holds no polygons"),
    ],
)
def test_damaged_obj_files_are_refused_by_line(tmp_path, text, words):
    place = tmp_path / "a.obj"
    place.write_text(text)
    with pytest.raises(UnreadableMesh) as caught:
        read_control_mesh(place)
    assert words in str(caught.value)


@pytest.mark.parametrize("content", [b"", b"ply\nformat ascii 1.0\nelement vertex 3\nrubbish", b"\x00" * 50])
def test_damaged_ply_files_are_refused(tmp_path, content, capfd):
    place = tmp_path / "a.ply"
    place.write_bytes(content)
    with pytest.raises(UnreadableMesh):
        read_control_mesh(place)
    assert capfd.readouterr().err == ""


def test_other_places_are_refused(tmp_path):
    with pytest.raises(FileNotFoundError, match="no such file"):
        read_control_mesh(tmp_path / "none.obj")
    (tmp_path / "a.blend").write_text("")
    with pytest.raises(UnsupportedFormat, match=r"read \.obj, \.ply, \.stl"):
        read_control_mesh(tmp_path / "a.blend")
    (tmp_path / "folder.obj").mkdir()
    with pytest.raises(UnreadableMesh, match="folder"):
        read_control_mesh(tmp_path / "folder.obj")
