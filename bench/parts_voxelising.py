"""Attractors to voxels, beside frontiers in NumPy and trimesh.voxel.

A frontier has all pieces of one level at once, in arrays. One is of affine maps, for any system; the other
knows that the pieces are cubes of a grid, and which.
"""

import math
from pathlib import Path

import numpy as np

from bench.contest import Action, Contest, Goal, Says, Way

SPONGE = [cell for cell in np.ndindex(3, 3, 3) if sum(x == 1 for x in cell) < 2]
TETRAHEDRON = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
PIECES = {"sponge": (3, SPONGE), "tetrahedron": (2, TETRAHEDRON)}
SOLID = 2  # the level of the sponge that is voxelised as a solid


def contests(side: int) -> list[Contest]:
    """The limits of two systems, and a level of the sponge as a solid that trimesh has as a mesh."""
    sponge, half = 3 ** int(math.log(side + 0.5, 3)), 2 ** int(math.log2(side))
    solid = 3**SOLID * (side // 3**SOLID)
    return [
        *(
            Contest(
                f"Voxels of {title}, {size} a side",
                size,
                (
                    Way("bcifs", limit, (name,)),
                    Way("frontier of maps", frontier_of_maps, (name,)),
                    Way("frontier of cubes", frontier_of_cubes, (name,)),
                ),
                (Goal("time", "frontier of maps", "bcifs", least=100),),
                small=small,
            )
            for name, title, size, small in (
                ("sponge", "the Menger sponge", sponge, 27),
                ("tetrahedron", "Sierpinski's tetrahedron", half, 32),
            )
        ),
        Contest(
            f"Voxels of level {SOLID} of the sponge as a solid, {solid} a side",
            solid,
            (
                Way("bcifs", level),
                Way("trimesh, of its mesh, filled", trimesh_voxels),
            ),
            data=mesh_of_level,
            small=27,
        ),
    ]


def limit(folder: Path, size: int, name: str) -> Action:
    """Our cover of a shape that is read already; of its pieces nothing is known yet."""
    import ifs
    from export import voxelise

    corners = np.vstack([np.zeros(3), np.eye(3)]) * 64
    named = {"sponge": ("menger-sponge", None), "tetrahedron": ("sierpinski-tetrahedron", corners)}
    shape = ifs.shape(named[name][0], control=named[name][1])

    def act() -> Says:
        cover = voxelise(shape, size)
        return lambda: f"{cover.tree.count} voxels"

    return act


def frontier_of_maps(folder: Path, size: int, name: str) -> Action:
    """Pieces as affine maps of a cube until their boxes are no larger than a voxel; then a dense grid.

    Boxes that reach over the face of a voxel by at most a millionth of it do not fill the one behind.
    """
    scale, offsets = PIECES[name]
    linear, shift = np.array([np.eye(3) / scale] * len(offsets)), np.array(offsets) / scale

    def act() -> Says:
        lines, starts = np.eye(3)[None] * size, np.zeros((1, 3))
        while np.abs(lines[0]).sum(axis=1).max() > 1 + 1e-9:
            starts = (starts[:, None] + (lines[:, None] @ shift[..., None])[..., 0]).reshape(-1, 3)
            lines = (lines[:, None] @ linear).reshape(-1, 3, 3)
        middle, reach = starts + lines.sum(axis=2) / 2, np.abs(lines).sum(axis=2) / 2
        low = np.floor(middle - reach + 1e-6).astype(np.int32).clip(0, size - 1)
        high = np.floor(middle + reach - 1e-6).astype(np.int32).clip(0, size - 1)
        filled = np.zeros((size,) * 3, dtype=bool)
        for corner in np.ndindex(2, 2, 2):
            filled[tuple(np.where(corner, high, low).T)] = True
        return lambda: f"{np.count_nonzero(filled)} voxels"

    return act


def frontier_of_cubes(folder: Path, size: int, name: str) -> Action:
    """Corners of cubes as integers; then a dense grid."""
    scale, offsets = PIECES[name][0], np.array(PIECES[name][1])

    def act() -> Says:
        corners = np.zeros((1, 3), dtype=np.int64)
        width = size
        while width > 1:
            corners = (scale * corners[:, None] + offsets).reshape(-1, 3)
            width //= scale
        filled = np.zeros((size,) * 3, dtype=bool)
        filled[tuple(corners.T)] = True
        return lambda: f"{np.count_nonzero(filled)} voxels"

    return act


def mesh_of_level(folder: Path, size: int) -> None:
    """The boundary of the level of the sponge, for those who start from a mesh."""
    import ifs
    from export import skin, voxelise

    side = 3**SOLID
    mesh = skin(voxelise(ifs.shape("menger-sponge"), side, depth=SOLID).tree)
    low = mesh.vertices.min(axis=0)
    scale = side / (mesh.vertices.max(axis=0) - low)
    np.savez(folder / "mesh.npz", vertices=(mesh.vertices - low) * scale, faces=mesh.faces)


def level(folder: Path, size: int) -> Action:
    """Our cover of the pieces at the level."""
    import ifs
    from export import voxelise

    shape = ifs.shape("menger-sponge")

    def act() -> Says:
        cover = voxelise(shape, size, depth=SOLID)
        return lambda: f"{cover.tree.count} voxels"

    return act


def trimesh_voxels(folder: Path, size: int) -> Action:
    """The voxels that the surface meets, centred at multiples of their side, and the holes in them filled."""
    import trimesh

    data = np.load(folder / "mesh.npz")
    mesh = trimesh.Trimesh(data["vertices"], data["faces"], process=False)

    def act() -> Says:
        voxels = mesh.voxelized(3**SOLID / size)
        assert voxels is not None
        voxels.fill("holes")
        return lambda: f"{voxels.filled_count} voxels"

    return act
