"""Mesh files of shapes: polygons as they are in OBJ, triangles in the other formats."""

import os
from collections.abc import Mapping
from pathlib import Path

from export.formats.atomic import whole_file
from ifs import Mesh

MESH_ENDINGS = (".obj", ".ply", ".stl")
_ELEMENT = {1: "p", 2: "l"}


class WrongMeshFile(ValueError):
    """A mesh that the format cannot hold."""


def write_polygons(mesh: Mesh, path: str | os.PathLike[str], recipe: Mapping[str, str]) -> None:
    """Write a mesh (mm) as .obj (points, lines, polygons, shared vertices), .ply or .stl (triangles).

    The file appears whole or not at all; the same mesh gives the same bytes. Raises `WrongMeshFile`
    for curves and points in a format other than OBJ, and for more than three coordinates.
    """
    if mesh.vertices.shape[1] > 3:
        raise WrongMeshFile(f"{path}: mesh files hold up to 3 coordinates; here are {mesh.vertices.shape[1]}")
    if Path(path).suffix.lower() == ".obj":
        with whole_file(path) as file:
            file.write(obj(mesh, recipe).encode())
        return
    if mesh.faces.shape[1] < 3:
        raise WrongMeshFile(f"{path}: a curve or a set of points has no faces; write it as .obj")
    from export import write_part

    write_part(mesh, path, recipe)


def obj(mesh: Mesh, recipe: Mapping[str, str]) -> str:
    r"""The mesh as the text of an OBJ file, the recipe in comments.

    >>> import numpy as np
    >>> obj(Mesh(np.array([[0.0, 0.0], [1.5, 0.0]]), np.array([[0, 1]])), {"depth": "0"})
    '# bcifs, lengths in millimetres\n# depth: 0\nv 0.0 0.0 0.0\nv 1.5 0.0 0.0\nl 1 2\n'
    """
    lines = ["# bcifs, lengths in millimetres"]
    lines += [f"# {key}: {' '.join(value.split())}" for key, value in recipe.items()]
    lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in (mesh.points_3d() + 0.0).tolist()]
    for face in mesh.faces.tolist():
        corners = [str(corner + 1) for corner in face if corner >= 0]
        lines.append(" ".join([_ELEMENT.get(len(corners), "f"), *corners]))
    return "\n".join(lines) + "\n"
