"""Mesh files by their extension: writing parts, reading meshes."""

import os
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from export.formats.damage import AGAIN, Damaged
from export.formats.endings import UnsupportedFormat, ending_of
from export.formats.glb import write_glb
from export.formats.obj import write_obj
from export.formats.ply import write_ply
from export.formats.scene import Scene, check_recipe
from export.formats.stl import write_stl
from export.formats.threemf import write_3mf
from export.formats.welding import weld
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
    check_recipe(recipe or {}, title)
    _WRITERS[Path(path).suffix.lower()](shape, path, recipe, title)


def check_writable(path: str | os.PathLike[str]) -> None:
    """`UnsupportedFormat` unless `write_part` knows the extension: to ask before a long run."""
    if ending_of(path) not in WRITABLE:
        raise UnsupportedFormat(f"{path}: write {', '.join(WRITABLE)}")


def read_mesh(path: str | os.PathLike[str]) -> Mesh:
    """The triangles of a mesh file (.3mf, .stl, .ply, .obj, .off, .glb), in mm, as they are.

    Nothing is repaired. STL has no shared vertices: there equal positions become one vertex.
    A file of several objects comes as one mesh. A unit other than millimetres is converted where the file
    names one, and GLB is in metres with y upwards. `FileNotFoundError` for a missing file,
    `UnsupportedFormat` for another extension, `UnreadableMesh` for a file that is damaged or holds no
    triangles: it tells the line or the byte, what was expected, and what to do.
    """
    ending, place = ending_of(path), Path(path)
    if not place.exists():
        raise FileNotFoundError(f"{path}: there is no such file")
    if place.is_dir():
        raise UnreadableMesh(f"{path}: this is a folder; name a file in it")
    if ending not in READABLE:
        raise UnsupportedFormat(f"{path}: read {', '.join(READABLE)}")
    content = place.read_bytes()
    if not content:
        raise UnreadableMesh(f"{path}: the file is empty; {AGAIN}")
    try:
        found = _reader(ending)(content)
    except Damaged as error:
        raise UnreadableMesh(f"{path}: {error}") from error
    _check(path, found)
    return weld(found) if ending == ".stl" else found


def _reader(ending: str) -> Callable[[bytes], Mesh]:
    match ending:
        case ".3mf":
            from export.formats.threemf_reader import read_3mf as read
        case ".stl":
            from export.formats.stl_reader import read_stl as read
        case ".ply":
            from export.formats.ply_reader import read_ply as read
        case ".obj":
            from export.formats.obj_reader import read_obj as read
        case ".off":
            from export.formats.obj_reader import read_off as read
        case _:
            from export.formats.glb_reader import read_glb as read
    return read


def _check(path: str | os.PathLike[str], mesh: Mesh) -> None:
    """`UnreadableMesh` where triangles name vertices that are missing or not finite."""
    vertices, faces = mesh.vertices, mesh.faces
    if not len(faces):
        raise UnreadableMesh(f"{path}: the file holds no triangles; {AGAIN} as a mesh")
    if faces.min() < 0 or faces.max() >= len(vertices):
        wrong = ((faces < 0) | (faces >= len(vertices))).any(axis=1)
        row = int(np.argmax(wrong))
        raise UnreadableMesh(
            f"{path}: triangle {row} (counted from 0) is {faces[row].tolist()}: vertices from 0 to "
            f"{len(vertices) - 1} were expected; {AGAIN}"
        )
    if not np.isfinite(vertices).all():
        used = np.zeros(len(vertices), dtype=bool)
        used[faces.ravel()] = True
        wrong = used & ~np.isfinite(vertices).all(axis=1)
        if wrong.any():
            row = int(np.argmax(wrong))
            raise UnreadableMesh(
                f"{path}: vertex {row} (counted from 0) is {vertices[row].tolist()}: finite numbers were "
                f"expected; {AGAIN}"
            )
