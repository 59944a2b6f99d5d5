"""Mesh files by their extension: writing parts, reading meshes."""

import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from export.formats.glb import write_glb
from export.formats.obj import write_obj
from export.formats.ply import write_ply
from export.formats.scene import Scene
from export.formats.stl import write_stl
from export.formats.threemf import write_3mf
from ifs.mesh import Mesh

_WRITERS = {
    ".3mf": write_3mf,
    ".stl": lambda shape, path, recipe, title: write_stl(shape, path),
    ".ply": lambda shape, path, recipe, title: write_ply(shape, path, recipe),
    ".obj": lambda shape, path, recipe, title: write_obj(shape, path, recipe),
    ".glb": write_glb,
}
WRITABLE = tuple(_WRITERS)
READABLE = (*WRITABLE, ".off")


class UnsupportedFormat(ValueError):
    """The extension of a file names no format that can be written, or read."""


class UnreadableMesh(ValueError):
    """A file that holds no triangle mesh."""


def write_part(
    shape: Mesh | Scene,
    path: str | os.PathLike[str],
    recipe: Mapping[str, str] | None = None,
    title: str = "",
) -> None:
    """Write a mesh, or a scene of several (mm), in the format its extension names: .3mf .stl .ply .obj .glb.

    3MF and GLB keep unit, recipe, title, bodies, places and colours; PLY the recipe and the colours of
    faces, OBJ the recipe and the names of bodies, STL triangles only. Files appear whole or not at all; the
    same arguments give the same bytes. `UnsupportedFormat` for another extension, `WrongMesh` for a mesh
    without faces or with corners that are missing or not finite, `OSError` when the place cannot be written.

    >>> write_part(Mesh(np.eye(3), np.array([[0, 1, 2]])), "part.step")
    Traceback (most recent call last):
    ...
    export.files.UnsupportedFormat: part.step: write .3mf, .stl, .ply, .obj, .glb
    """
    check_writable(path)
    _WRITERS[Path(path).suffix.lower()](shape, path, recipe, title)


def check_writable(path: str | os.PathLike[str]) -> None:
    """`UnsupportedFormat` unless `write_part` knows the extension: to ask before a long run."""
    if Path(path).suffix.lower() not in WRITABLE:
        raise UnsupportedFormat(f"{path}: write {', '.join(WRITABLE)}")


def read_mesh(path: str | os.PathLike[str]) -> Mesh:
    """The triangles of a mesh file (.3mf, .stl, .ply, .obj, .off, .glb), in mm, as they are.

    Nothing is repaired. STL has no shared vertices: there equal positions become one vertex.
    A file of several objects comes as one mesh. A unit other than millimetres is converted where the file
    names one, and GLB is in metres with y upwards. `FileNotFoundError` for a missing file,
    `UnsupportedFormat` for another extension, `UnreadableMesh` for a file that is damaged or holds no
    triangles.
    """
    place = Path(path)
    if not place.exists():
        raise FileNotFoundError(f"{path}: there is no such file")
    if place.suffix.lower() not in READABLE:
        raise UnsupportedFormat(f"{path}: read {', '.join(READABLE)}")
    content = place.read_bytes()
    if not content:
        raise UnreadableMesh(f"{path}: the file is empty")
    try:
        found = _read(content, place.suffix.lower())
    except Exception as error:  # a foreign parser may raise anything on a damaged file
        reason = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
        raise UnreadableMesh(f"{path}: no mesh could be read ({reason})") from error
    vertices, faces = found.vertices, found.faces
    if not len(faces):
        raise UnreadableMesh(f"{path}: the file holds no triangles")
    if faces.min() < 0 or faces.max() >= len(vertices) or not np.isfinite(vertices[faces]).all():
        raise UnreadableMesh(f"{path}: triangles name vertices that are missing or not finite")
    if place.suffix.lower() == ".stl":
        return weld(found)
    return found


def _read(content: bytes, extension: str) -> Mesh:
    import trimesh

    from export.formats.glb_reader import read_glb

    if extension == ".glb":
        return read_glb(content)
    scene = trimesh.load_scene(trimesh.util.wrap_as_stream(content), file_type=extension[1:], process=False)
    loaded = scene.to_mesh()
    # a file without a unit is in millimetres
    if scene.units and scene.units not in ("mm", "millimeter", "millimeters"):
        loaded.units = scene.units
        loaded = loaded.convert_units("mm")
    vertices = np.asarray(loaded.vertices, dtype=np.float64).reshape(-1, 3)
    return Mesh(vertices, np.asarray(loaded.faces, dtype=np.int64).reshape(-1, 3))


def weld(mesh: Mesh) -> Mesh:
    """The same triangles with equal positions as one vertex, vertices sorted.

    >>> corners = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 0]])
    >>> weld(Mesh(corners, np.array([[0, 1, 2], [3, 2, 1]]))).vertices.shape
    (3, 3)
    """
    points = mesh.points_3d() + 0.0
    order = np.lexsort(points.T[::-1])
    new = np.ones(len(points), dtype=bool)
    new[1:] = (np.diff(points[order], axis=0) != 0).any(axis=1)
    number = np.empty(len(points), dtype=np.int64)
    number[order] = np.cumsum(new) - 1
    return Mesh(points[order][new], number[mesh.triangles()])
