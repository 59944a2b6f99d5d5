"""Mesh files by their extension: writing parts, reading meshes."""

import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from export.stl import write_obj, write_ply, write_stl
from export.threemf import write_3mf
from ifs.mesh import Mesh

WRITABLE = (".3mf", ".stl", ".ply", ".obj")
READABLE = (*WRITABLE, ".off", ".glb")


class UnsupportedFormat(ValueError):
    """The extension of a file names no format that can be written, or read."""


class UnreadableMesh(ValueError):
    """A file that holds no triangle mesh."""


def write_part(
    mesh: Mesh,
    path: str | os.PathLike[str],
    recipe: Mapping[str, str] | None = None,
    title: str = "",
) -> None:
    """Write a mesh (mm) in the format its extension names: .3mf, .stl, .ply or .obj.

    3MF keeps the unit and the recipe, PLY and OBJ keep the recipe in comments, STL keeps neither.
    Files appear whole or not at all; the same arguments give the same bytes. `UnsupportedFormat`
    for another extension, `OSError` when the place cannot be written.

    >>> write_part(Mesh(np.eye(3), np.array([[0, 1, 2]])), "part.step")
    Traceback (most recent call last):
    ...
    export.files.UnsupportedFormat: part.step: write .3mf, .stl, .ply, .obj
    """
    check_writable(path)
    match Path(path).suffix.lower():
        case ".3mf":
            write_3mf(mesh, path, recipe, title)
        case ".stl":
            write_stl(mesh, path)
        case ".ply":
            write_ply(mesh, path, recipe)
        case _:
            write_obj(mesh, path, recipe)


def check_writable(path: str | os.PathLike[str]) -> None:
    """`UnsupportedFormat` unless `write_part` knows the extension: to ask before a long run."""
    if Path(path).suffix.lower() not in WRITABLE:
        raise UnsupportedFormat(f"{path}: write {', '.join(WRITABLE)}")


def read_mesh(path: str | os.PathLike[str]) -> Mesh:
    """The triangles of a mesh file (.3mf, .stl, .ply, .obj, .off, .glb), in mm, as they are.

    Nothing is repaired. STL has no shared vertices: there equal positions become one vertex.
    A file of several objects comes as one mesh; a unit other than millimetres is converted where
    the file names one. `FileNotFoundError` for a missing file, `UnsupportedFormat` for another
    extension, `UnreadableMesh` for a file that is damaged or holds no triangles.
    """
    import trimesh

    place = Path(path)
    if not place.exists():
        raise FileNotFoundError(f"{path}: there is no such file")
    if place.suffix.lower() not in READABLE:
        raise UnsupportedFormat(f"{path}: read {', '.join(READABLE)}")
    content = place.read_bytes()
    if not content:
        raise UnreadableMesh(f"{path}: the file is empty")
    try:
        scene = trimesh.load_scene(
            trimesh.util.wrap_as_stream(content),
            file_type=place.suffix.lower()[1:],
            process=False,
        )
        loaded = scene.to_mesh()
        # a file without a unit is in millimetres
        if scene.units and scene.units not in ("mm", "millimeter", "millimeters"):
            loaded.units = scene.units
            loaded = loaded.convert_units("mm")
        vertices = np.asarray(loaded.vertices, dtype=np.float64).reshape(-1, 3)
        faces = np.asarray(loaded.faces, dtype=np.int64).reshape(-1, 3)
    except Exception as error:  # a foreign parser may raise anything on a damaged file
        reason = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
        raise UnreadableMesh(f"{path}: no mesh could be read ({reason})") from error
    if not len(faces):
        raise UnreadableMesh(f"{path}: the file holds no triangles")
    if faces.min() < 0 or faces.max() >= len(vertices) or not np.isfinite(vertices[faces]).all():
        raise UnreadableMesh(f"{path}: triangles name vertices that are missing or not finite")
    if place.suffix.lower() == ".stl":
        return weld(Mesh(vertices, faces))
    return Mesh(vertices, faces)


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
