"""OBJ: text, positions to the last digit."""

import os
from collections.abc import Mapping

from export.formats.atomic import whole_file
from export.formats.ply import comment_lines
from export.formats.scene import Scene, check_scene, placed, scene_of, triangles
from export.formats.text import number_rows
from ifs.mesh import Mesh

ROWS = 20_000  # turned into text at a time


def write_obj(
    shape: Mesh | Scene, path: str | os.PathLike[str], recipe: Mapping[str, str] | None = None
) -> None:
    """Write the triangles of a mesh or a scene as OBJ, the recipe as comments.

    Each body of a scene is an object with its name; colours are not kept. The file appears whole or not
    at all. Raises `WrongMesh`.

    >>> import numpy as np, pathlib, tempfile
    >>> place = pathlib.Path(tempfile.mkdtemp()) / "one.obj"
    >>> write_obj(Mesh(np.eye(3), np.array([[0, 1, 2]])), place)
    >>> place.read_text().splitlines()[1:]
    ['v 1.0 0.0 0.0', 'v 0.0 1.0 0.0', 'v 0.0 0.0 1.0', 'f 1 2 3']
    """
    scene = scene_of(shape)
    check_scene(scene)
    first = 1
    with whole_file(path) as file:
        for line in comment_lines(recipe):
            file.write(f"# {line}\n".encode())
        for number, body in enumerate(placed(scene)):
            if isinstance(shape, Scene):
                name = "_".join(body.name.split()) or f"body_{number}"
                file.write(f"o {name}\n".encode())
            points = body.mesh.points_3d() + 0.0
            for start in range(0, len(points), ROWS):
                some = points[start : start + ROWS].ravel().tolist()
                file.write(("v %r %r %r\n" * (len(some) // 3) % tuple(some)).encode())
            for piece in number_rows(("f ", " ", " ", "\n"), triangles(body.mesh) + first):
                file.write(piece)
            first += len(points)
