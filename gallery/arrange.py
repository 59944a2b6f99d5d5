"""Several meshes in one picture."""

from collections.abc import Sequence

import numpy as np

from ifs import Mesh

_SAME = 6  # decimals of a millimetre to which vertices that are joined agree


def joined(meshes: Sequence[Mesh]) -> Mesh:
    """The meshes as one; vertices that lie in the same place, to a millionth of a millimetre, become one.

    >>> segment = Mesh(np.array([[0.0, 0], [1, 0]]), np.array([[0, 1]]))
    >>> joined([segment, Mesh(segment.vertices + [1, 0], segment.faces)]).vertices.shape
    (3, 2)
    """
    counts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    vertices = np.concatenate([mesh.vertices for mesh in meshes])
    faces = np.concatenate([mesh.faces + start for mesh, start in zip(meshes, counts, strict=False)])
    _, first, number = np.unique(
        np.round(vertices, _SAME) + 0.0, axis=0, return_index=True, return_inverse=True
    )
    return Mesh(vertices[first], number.reshape(-1)[faces])


def row(meshes: Sequence[Mesh], gap: float) -> Mesh:
    """The meshes side by side along the first axis, `gap` mm between their boxes."""
    moved, here = [], 0.0
    for mesh in meshes:
        left, right = mesh.vertices[:, 0].min(), mesh.vertices[:, 0].max()
        vertices = mesh.vertices.copy()
        vertices[:, 0] += here - left
        moved.append(Mesh(vertices, mesh.faces))
        here += right - left + gap
    return joined(moved)
