"""A polygon mesh in modelling space."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float, Int

if TYPE_CHECKING:
    import pyvista
    import trimesh


@dataclass(frozen=True)
class Mesh:
    """Vertices and the polygons between them: points (1 corner), segments (2) or faces (3 and more).

    `vertices` is `(vertices, dim)` in millimetres, `faces` is `(faces, corners)`; where polygons of
    different sizes meet in one mesh, the shorter ones end in -1.

    >>> import numpy as np
    >>> Mesh(np.array([[0.0, 0.0], [1.0, 0.0]]), np.array([[0, 1]])).faces.shape
    (1, 2)
    """

    vertices: Float[np.ndarray, "vertices dim"]
    faces: Int[np.ndarray, "faces corners"]

    def points_3d(self) -> Float[np.ndarray, "vertices 3"]:
        """The vertices in space: a plane shape lies at z = 0."""
        missing = 3 - self.vertices.shape[1]
        return np.pad(self.vertices, ((0, 0), (0, missing))) if missing > 0 else self.vertices

    def polygons(self) -> list[Int[np.ndarray, "corners"]]:
        """The faces one by one, without padding."""
        return [face[face >= 0] for face in self.faces]

    def triangles(self) -> Int[np.ndarray, "triangles 3"]:
        """The faces as triangles of 64-bit indices, each polygon fanned out from its first corner."""
        fans = []
        for corner in range(1, self.faces.shape[1] - 1):
            fan = self.faces[:, [0, corner, corner + 1]]
            fans.append(fan[fan[:, 2] >= 0])
        none = np.zeros((0, 3), dtype=np.int64)
        return np.concatenate([none, *fans]).astype(np.int64, copy=False)

    def to_trimesh(self) -> "trimesh.Trimesh":
        """The same faces as a `trimesh.Trimesh`, vertices in the same order."""
        import trimesh

        return trimesh.Trimesh(self.points_3d(), self.triangles(), process=False)

    def to_pyvista(self) -> "pyvista.PolyData":
        """The same polygons as `pyvista.PolyData`; segments become lines, points vertices."""
        import pyvista

        counts = (self.faces >= 0).sum(axis=1)
        cells = np.column_stack([counts, self.faces]).ravel()
        cells = cells[cells >= 0]
        match self.faces.shape[1]:
            case 1:
                return pyvista.PolyData(self.points_3d(), verts=cells)
            case 2:
                return pyvista.PolyData(self.points_3d(), lines=cells)
            case _:
                return pyvista.PolyData(self.points_3d(), faces=cells)
