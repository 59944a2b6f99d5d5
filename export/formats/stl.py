"""Binary STL: triangles in single precision, and nothing else."""

import os

import numpy as np

from export.formats.atomic import whole_file
from export.formats.scene import Scene, check_scene, placed, scene_of, triangles
from ifs.mesh import Mesh

STL_HEADER = b"bcifs binary STL, lengths in millimetres".ljust(80)
ROW = np.dtype([("numbers", "<f4", 12), ("rest", "<u2")])  # a normal and three corners
ROWS = 1 << 16  # written at a time


def write_stl(shape: Mesh | Scene, path: str | os.PathLike[str]) -> None:
    """Write the triangles of a mesh or a scene as binary STL: 80 bytes of header, then single precision.

    STL names no unit: slicers take millimetres, which they are here; it keeps no recipe, no colours and no
    names either. The file appears whole or not at all. Raises `WrongMesh`.

    >>> import numpy as np, pathlib, tempfile
    >>> place = pathlib.Path(tempfile.mkdtemp()) / "one.stl"
    >>> write_stl(Mesh(np.eye(3), np.array([[0, 1, 2]])), place)
    >>> place.stat().st_size
    134
    """
    from export.formats.stl_kernels import fill

    scene = scene_of(shape)
    check_scene(scene)
    rows = np.zeros(ROWS, dtype=ROW)
    with whole_file(path) as file:
        file.write(STL_HEADER + bytes(4))
        count = 0
        for body in placed(scene):
            points, corners = body.mesh.points_3d().astype(np.float32), triangles(body.mesh)
            for start in range(0, len(corners), ROWS):
                some = corners[start : start + ROWS]
                fill(points, some, rows)
                file.write(rows[: len(some)].data)
            count += len(corners)
        file.seek(len(STL_HEADER))
        file.write(count.to_bytes(4, "little"))
