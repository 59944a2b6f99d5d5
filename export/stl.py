"""The plain formats: binary STL, binary PLY, OBJ."""

import os
from collections.abc import Mapping

import numpy as np

from export.atomic import whole_file
from ifs.mesh import Mesh

STL_HEADER = b"bcifs binary STL, lengths in millimetres".ljust(80)
STL_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("extra", "<u2")])
PLY_FACE = np.dtype([("count", "u1"), ("corners", "<i4", 3)])


def write_stl(mesh: Mesh, path: str | os.PathLike[str]) -> None:
    """Write a triangle mesh as binary STL: 80 bytes of header, then single precision.

    STL names no unit: slicers take millimetres, which they are here; it keeps no recipe either.
    The file appears whole or not at all.

    >>> import numpy as np, pathlib, tempfile
    >>> place = pathlib.Path(tempfile.mkdtemp()) / "one.stl"
    >>> write_stl(Mesh(np.eye(3), np.array([[0, 1, 2]])), place)
    >>> place.stat().st_size
    134
    """
    corners = mesh.points_3d().astype("<f4")[mesh.triangles()]
    table = np.zeros(len(corners), dtype=STL_TRIANGLE)
    table["corners"] = corners
    table["normal"] = _normals(corners)
    with whole_file(path) as file:
        file.write(STL_HEADER + np.uint32(len(table)).astype("<u4").tobytes())
        file.write(table.tobytes())


def write_ply(mesh: Mesh, path: str | os.PathLike[str], recipe: Mapping[str, str] | None = None) -> None:
    """Write a triangle mesh as binary PLY in double precision, the recipe as comments."""
    points = np.ascontiguousarray(mesh.points_3d(), dtype="<f8")
    triangles = mesh.triangles()
    faces = np.zeros(len(triangles), dtype=PLY_FACE)
    faces["count"], faces["corners"] = 3, triangles
    head = [
        "ply",
        "format binary_little_endian 1.0",
        *(f"comment {line}" for line in _comments(recipe)),
        f"element vertex {len(points)}",
        *(f"property double {axis}" for axis in "xyz"),
        f"element face {len(faces)}",
        "property list uchar int vertex_indices",
        "end_header\n",
    ]
    with whole_file(path) as file:
        file.write("\n".join(head).encode())
        file.write(points.tobytes())
        file.write(faces.tobytes())


def write_obj(mesh: Mesh, path: str | os.PathLike[str], recipe: Mapping[str, str] | None = None) -> None:
    """Write a triangle mesh as OBJ, positions to the last digit, the recipe as comments."""
    with whole_file(path) as file:
        for line in _comments(recipe):
            file.write(f"# {line}\n".encode())
        for x, y, z in mesh.points_3d().tolist():
            file.write(f"v {x!r} {y!r} {z!r}\n".encode())
        for a, b, c in (mesh.triangles() + 1).tolist():
            file.write(f"f {a} {b} {c}\n".encode())


def _comments(recipe: Mapping[str, str] | None) -> list[str]:
    """One line each: line breaks in a value are written as \\n."""
    lines = ["bcifs, lengths in millimetres"]
    for key in sorted(recipe or {}):
        value = f"{key}: {(recipe or {})[key]}".replace("\\", "\\\\")
        lines.append(value.replace("\r", "\\r").replace("\n", "\\n"))
    return lines


def _normals(corners: np.ndarray) -> np.ndarray:
    """Unit normals, zero for a triangle without area."""
    wide = corners.astype(np.float64)
    normals = np.cross(wide[:, 1] - wide[:, 0], wide[:, 2] - wide[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return normals / np.where(lengths > 0, lengths, 1)
