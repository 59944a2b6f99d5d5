"""Control meshes from files: polygons with any number of corners, as they are."""

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from jaxtyping import Float

from export.files import UnreadableMesh, UnsupportedFormat, read_mesh
from ifs.mesh import Mesh

CONTROL_READABLE = (".obj", ".ply", ".stl")
MOST_BYTES = 1 << 30

Polygons = list[list[int]]


def read_control_mesh(path: str | os.PathLike[str]) -> tuple[Float[np.ndarray, "vertices 3"], Polygons]:
    """The vertices (mm) and the polygons of an .obj, .ply or .stl file, for `ifs.surface`.

    STL knows triangles only: where all of them can be paired, each with the next one in the file or along
    their longest sides, they become quadrangles again; equal positions become one vertex. Nothing is
    repaired.
    `FileNotFoundError` for a missing file, `UnsupportedFormat` for another extension, `UnreadableMesh`, for
    OBJ with the line, for a file that is damaged or holds no polygons.

    >>> import tempfile
    >>> place = Path(tempfile.mkdtemp()) / "roof.obj"
    >>> _ = place.write_text("v 0 0 0\\nv 9 0 0\\nv 9 9 0\\nv 0 9 3\\nf 1/1 2/2 3/3 4/4\\n")
    >>> read_control_mesh(place)[1]
    [[0, 1, 2, 3]]
    """
    place = Path(path)
    if not place.exists():
        raise FileNotFoundError(f"{path}: there is no such file")
    if place.is_dir():
        raise UnreadableMesh(f"{path}: is a folder")
    if place.suffix.lower() not in CONTROL_READABLE:
        raise UnsupportedFormat(f"{path}: read {', '.join(CONTROL_READABLE)}")
    if place.stat().st_size > MOST_BYTES:
        raise UnreadableMesh(f"{path}: the file is larger than {MOST_BYTES} bytes")
    vertices, faces = _READERS[place.suffix.lower()](place)
    if not faces:
        raise UnreadableMesh(f"{path}: the file holds no polygons")
    return vertices, faces


def _read_obj(place: Path) -> tuple[np.ndarray, Polygons]:
    """The `v` and `f` lines; all others are of no account here."""
    vertices: list[tuple[float, float, float]] = []
    faces: Polygons = []
    with place.open(encoding="utf-8", errors="replace") as lines:
        for number, line in enumerate(lines, 1):
            words = line.split("#", 1)[0].split()
            try:
                if words[:1] == ["v"]:
                    x, y, z = map(float, words[1:4])
                    vertices.append((x, y, z))
                elif words[:1] == ["f"]:
                    faces.append([_index(word, len(vertices)) for word in words[1:]])
            except ValueError as error:
                expected = "`v x y z`" if words[0] == "v" else "`f` and numbers of vertices above"
                raise UnreadableMesh(
                    f"{place}:{number}: expected {expected}, found {line.strip()!r}"
                ) from error
    return np.array(vertices).reshape(-1, 3), faces


def _index(word: str, count: int) -> int:
    """The vertex of a corner such as `3/1/2`, counted from 1, or from the last one backwards if negative."""
    number = int(word.split("/", 1)[0])
    index = number - 1 if number > 0 else count + number
    if number == 0 or not 0 <= index < count:
        raise ValueError
    return index


def _read_ply(place: Path) -> tuple[np.ndarray, Polygons]:
    from plyfile import PlyData, PlyParseError

    try:
        found = PlyData.read(str(place))
        vertex, face = found["vertex"].data, found["face"]
        vertices = np.stack([np.asarray(vertex[axis], dtype=float) for axis in "xyz"], axis=1)
        (corners,) = (
            prop.name for prop in face.properties if prop.name in ("vertex_indices", "vertex_index")
        )
        faces = [[int(corner) for corner in around] for around in face.data[corners]]
    except (PlyParseError, KeyError, ValueError, MemoryError, EOFError, UnicodeDecodeError) as error:
        reason = f"{error}" or type(error).__name__
        raise UnreadableMesh(f"{place}: this is no PLY file with vertices and faces ({reason})") from error
    return vertices, faces


def _read_stl(place: Path) -> tuple[np.ndarray, Polygons]:
    mesh = read_mesh(place)
    return mesh.vertices, _paired(mesh)


def _paired(mesh: Mesh) -> Polygons:
    """Quadrangles, where the triangles can all be paired: each with the next, or along the longest sides."""
    triangles = mesh.faces.tolist()
    for pairs in (_neighbours_in_file(len(triangles)), _along_longest_sides(mesh)):
        quadrangles = [_joined(triangles[i], triangles[j]) for i, j in pairs]
        if None not in quadrangles and 2 * len(quadrangles) == len(triangles):
            return [corners for corners in quadrangles if corners]
    return triangles


def _neighbours_in_file(count: int) -> Iterator[tuple[int, int]]:
    return zip(range(0, count, 2), range(1, count, 2), strict=False)


def _along_longest_sides(mesh: Mesh) -> Iterator[tuple[int, int]]:
    """The pairs of triangles for both of which the side between them is the longest."""
    ends = mesh.vertices[mesh.faces]
    longest = np.linalg.norm(np.roll(ends, -1, axis=1) - ends, axis=2).argmax(axis=1)
    waiting: dict[tuple[int, int], int] = {}
    for number, (triangle, side) in enumerate(zip(mesh.faces.tolist(), longest.tolist(), strict=True)):
        a, b = triangle[side], triangle[(side + 1) % 3]
        if (b, a) in waiting:
            yield waiting.pop((b, a)), number
        else:
            waiting[a, b] = number


def _joined(one: list[int], other: list[int]) -> list[int] | None:
    """The quadrangle of two triangles that run an edge in opposite directions."""
    for i in range(3):
        a, b, c = one[i], one[(i + 1) % 3], one[(i + 2) % 3]
        for j in range(3):
            if (other[j], other[(j + 1) % 3]) == (b, a) and other[(j + 2) % 3] != c:
                return [a, other[(j + 2) % 3], b, c]
    return None


_READERS = {".obj": _read_obj, ".ply": _read_ply, ".stl": _read_stl}
