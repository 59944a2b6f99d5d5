"""Fewer triangles for the same part, within a tolerance."""

import math

import numpy as np

from ifs.mesh import Mesh

MAX_TRIANGLES = 2_000_000


def decimated(mesh: Mesh, tolerance_mm: float, limit: int = MAX_TRIANGLES) -> Mesh:
    """The mesh with fewer triangles, whose surface has moved by about `tolerance_mm` at most; closed,
    manifold, of the same genus (manifold3d's `simplify`).

    The mesh has to be closed, each edge in two triangles of opposite directions: where sheets touch, the
    library pairs edges anew and says nothing. Its result is checked in the same way. It takes seconds for
    each million triangles, which is why there is a limit.

    Raises `ValueError` for a tolerance that is no positive length, for a mesh that is not closed or has more
    triangles than the limit, and where the library fails.

    >>> from export.meshing.skin import skin
    >>> from trees import full, unit_cube
    >>> decimated(skin(full(unit_cube(3), bits=3)), 0.001).faces.shape
    (12, 3)
    """
    import manifold3d

    if not (math.isfinite(tolerance_mm) and tolerance_mm > 0):
        raise ValueError(f"the tolerance must be a positive length in mm, not {tolerance_mm}")
    if len(mesh.faces) > limit:
        raise ValueError(
            f"{len(mesh.faces)} triangles, more than {limit}: mesh at a lower resolution, or raise the limit"
        )
    check_closed(mesh)
    loaded = manifold3d.Manifold(
        manifold3d.Mesh64(np.ascontiguousarray(mesh.vertices, np.float64), mesh.faces.astype(np.uint64))
    )
    if loaded.status() != manifold3d.Error.NoError:
        raise ValueError(f"manifold3d cannot read the mesh: {loaded.status()}")
    simple = loaded.simplify(tolerance_mm)
    if simple.genus() != loaded.genus():
        raise ValueError(f"a tolerance of {tolerance_mm} mm closes tunnels: take a smaller one")
    found = simple.to_mesh64()
    vertices, faces = np.asarray(found.vert_properties)[:, :3], np.asarray(found.tri_verts).astype(np.int64)
    result = Mesh(np.ascontiguousarray(vertices), faces)
    check_closed(result)
    return result


def check_closed(mesh: Mesh) -> None:
    """Raises `ValueError` unless the triangles pair up: each directed edge once, and its reverse once."""
    if mesh.faces.shape[1] != 3:
        raise ValueError(f"faces of {mesh.faces.shape[1]} corners: triangles are needed")
    size = np.int64(len(mesh.vertices))
    start = mesh.faces.astype(np.int64)
    end = np.roll(start, -1, axis=1)
    there, back = np.sort((start * size + end).ravel()), np.sort((end * size + start).ravel())
    twice = there[:-1] == there[1:]
    if twice.any():
        edge = divmod(int(there[:-1][twice][0]), int(size))
        raise ValueError(f"the edge from vertex {edge[0]} to {edge[1]} is in two triangles the same way")
    if not np.array_equal(there, back):
        edge = divmod(int(np.setdiff1d(there, back)[0]), int(size))
        raise ValueError(f"the edge from vertex {edge[0]} to {edge[1]} is in one triangle only: an open mesh")
