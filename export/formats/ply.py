"""Binary PLY: double precision, shared vertices, colours of faces."""

import os
from collections.abc import Mapping

import numpy as np

from export.formats.atomic import whole_file
from export.formats.scene import Body, Scene, check_scene, placed, scene_of, triangle_faces, triangles
from ifs.mesh import Mesh

FACE = [("count", "u1"), ("corners", "<i4", 3)]
COLOUR = [("colour", "u1", 4)]
WHITE = np.full((1, 4), 255, dtype=np.uint8)
ROWS = 1 << 16  # written at a time


def write_ply(
    shape: Mesh | Scene, path: str | os.PathLike[str], recipe: Mapping[str, str] | None = None
) -> None:
    """Write the triangles of a mesh or a scene as binary PLY in double precision, the recipe as comments.

    Where a body has colours, each face has its own (those of bodies without are white). The file appears
    whole or not at all. Raises `WrongMesh`.

    >>> import numpy as np, pathlib, tempfile
    >>> place = pathlib.Path(tempfile.mkdtemp()) / "one.ply"
    >>> write_ply(Mesh(np.eye(3), np.array([[0, 1, 2]])), place)
    >>> place.read_bytes().split()[:3]
    [b'ply', b'format', b'binary_little_endian']
    """
    scene = scene_of(shape)
    check_scene(scene)
    bodies = list(placed(scene))
    coloured = any(len(body.rgba()) for body in bodies)
    head = [
        "ply",
        "format binary_little_endian 1.0",
        *(f"comment {line}" for line in comment_lines(recipe)),
        f"element vertex {sum(len(body.mesh.vertices) for body in bodies)}",
        *(f"property double {axis}" for axis in "xyz"),
        f"element face {sum(len(triangle_faces(body.mesh)) for body in bodies)}",
        "property list uchar int vertex_indices",
        *(f"property uchar {part}" for part in ("red", "green", "blue", "alpha") if coloured),
        "end_header\n",
    ]
    table = np.zeros(ROWS, dtype=FACE + (COLOUR if coloured else []))
    table["count"] = 3
    with whole_file(path) as file:
        file.write("\n".join(head).encode())
        for body in bodies:
            file.write(np.ascontiguousarray(body.mesh.points_3d(), dtype="<f8").data)
        first = 0
        for body in bodies:
            corners, colours = triangles(body.mesh), _colours(body) if coloured else None
            for start in range(0, len(corners), ROWS):
                some = corners[start : start + ROWS]
                for k in range(3):
                    np.add(some[:, k], first, out=table["corners"][: len(some), k], casting="unsafe")
                if colours is not None:
                    table["colour"][: len(some)] = colours[start : start + ROWS]
                file.write(table[: len(some)].data)
            first += len(body.mesh.vertices)


def comment_lines(recipe: Mapping[str, str] | None) -> list[str]:
    """The recipe, one line each: line breaks in a value are written as \\n."""
    lines = ["bcifs, lengths in millimetres"]
    for key in sorted(recipe or {}):
        value = f"{key}: {(recipe or {})[key]}".replace("\\", "\\\\")
        lines.append(value.replace("\r", "\\r").replace("\n", "\\n"))
    return lines


def _colours(body: Body) -> np.ndarray:
    rgba, faces = body.rgba(), triangle_faces(body.mesh)
    if len(rgba) == len(body.mesh.faces):
        return rgba[faces]
    return np.broadcast_to(rgba if len(rgba) else WHITE, (len(faces), 4))
