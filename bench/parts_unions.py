"""The Menger sponge at a level, from voxels and as a union of its cubes in manifold3d."""

from pathlib import Path

import numpy as np

from bench.contest import Action, Contest, Goal, Says, Way

SPONGE = [cell for cell in np.ndindex(3, 3, 3) if sum(x == 1 for x in cell) < 2]
GENUS = {1: 5, 2: 81, 3: 1409, 4: 26433}


def contests(level: int) -> list[Contest]:
    """The mesh of the level; its genus is known."""
    ways = (
        Way("bcifs", from_voxels),
        Way("manifold3d, all cubes at once", all_cubes),
        Way("manifold3d, level by level", by_levels),
    )
    goal = Goal("time", "manifold3d, all cubes at once", "bcifs", least=100)
    title = f"Union: level {level} of the Menger sponge, {20**level} cubes, of genus {GENUS[level]}"
    return [Contest(title, level, ways, (goal,), small=1)]


def from_voxels(folder: Path, size: int) -> Action:
    """Our mesh, of the shape as a solid."""
    import ifs
    from export import skin, voxelise

    shape = ifs.shape("menger-sponge")

    def act() -> Says:
        mesh = skin(voxelise(shape, 3**size, depth=size).tree)
        return lambda: _genus(len(mesh.vertices), len(mesh.faces))

    return act


def all_cubes(folder: Path, size: int) -> Action:
    """One union of all cubes of the level."""
    from manifold3d import Manifold, OpType

    corners = np.zeros((1, 3), dtype=np.int64)
    for _ in range(size):
        corners = (3 * corners[:, None] + np.array(SPONGE)).reshape(-1, 3)
    corners = corners.astype(float)

    def act() -> Says:
        cube = Manifold.cube((1.0, 1.0, 1.0))
        whole = Manifold.batch_boolean([cube.translate(corner) for corner in corners], OpType.Add)
        triangles = whole.num_tri()
        return lambda: _genus(whole.num_vert(), triangles)

    return act


def by_levels(folder: Path, size: int) -> Action:
    """Each level as the union of twenty copies of the one before."""
    from manifold3d import Manifold, OpType

    def act() -> Says:
        whole = Manifold.cube((1.0, 1.0, 1.0))
        triangles = 12
        for level in range(size):
            copies = [whole.translate(3.0**level * np.array(cell, dtype=float)) for cell in SPONGE]
            whole = Manifold.batch_boolean(copies, OpType.Add)
            triangles = whole.num_tri()
        return lambda: _genus(whole.num_vert(), triangles)

    return act


def _genus(vertices: int, triangles: int) -> str:
    """Of one closed surface: V - F / 2 = 2 - 2 g."""
    genus = 1 - (vertices - triangles / 2) / 2
    return f"genus {genus:g}, {triangles} triangles"
