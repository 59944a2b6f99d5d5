"""Voxels to triangles, beside VTK, scikit-image, OpenVDB and isomesh.

The same set of voxels for all: as a tree here, as a dense array of bytes with a border of zeros for VTK, of
floats for scikit-image, as a grid of Booleans for OpenVDB. isomesh takes no voxels but a function: it has the
ball by its distance and gradient, and so have we there.
"""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np

from bench.contest import Action, Contest, Goal, Says, Way
from bench.sets import menger, takagi


def ball(side: int) -> np.ndarray:
    """The cells whose centres lie in a ball of 0.4 sides, layer by layer."""
    squares = (np.arange(side) - side / 2 + 0.5) ** 2
    disc = squares[:, None] + squares[None, :]
    return np.stack([disc < (0.4 * side) ** 2 - height for height in squares])


def sponge(side: int) -> np.ndarray:
    """A sponge of at most 256 cubes a side, each of them as many voxels as fit."""
    width = max(side // 256, 1)
    solid = menger(side // width)
    for axis in range(3):
        solid = np.repeat(solid, width, axis)
    return solid


SHAPES: dict[str, Callable[[int], np.ndarray]] = {
    "a ball": ball,
    "a Takagi surface": takagi,
    "a Menger sponge": sponge,
}


def contests(side: int) -> list[Contest]:
    """The three sets, and the ball by its distance."""
    goals = (
        Goal("time", "VTK's flying edges", "bcifs, exact", least=5),
        Goal("memory", "bcifs, exact", "VTK's flying edges", most=0.25),
    )
    whole = 2 ** math.ceil(math.log2(side))
    return [
        *(
            Contest(f"Mesh of {name} of {side}^3 voxels", side, WAYS, goals, voxels, (name,))
            for name in SHAPES
        ),
        Contest(
            f"Mesh of a ball by its distance, {whole}^3 voxels",
            whole,
            (Way("bcifs, smooth", of_distance), Way("isomesh", dual_contouring)),
        ),
    ]


def voxels(folder: Path, size: int, name: str) -> None:
    """The set as a tree, as bytes in an array with a border, and as a grid of OpenVDB."""
    from trees import from_array, write_tree, write_vdb

    cells = SHAPES[name](size)
    tree = from_array(cells)
    write_tree(tree, folder / "set.tree")
    write_vdb(tree, folder / "set.vdb")
    np.save(folder / "set.npy", np.pad(cells.view(np.uint8), 1))


def skinned(folder: Path, size: int, style: str) -> Action:
    """Our mesh of the tree."""
    from export import skin
    from trees import read_tree

    tree = read_tree(folder / "set.tree")

    def act() -> Says:
        mesh = skin(tree, style)
        return lambda: f"{len(mesh.faces)} triangles"

    return act


def from_dense(folder: Path, size: int) -> Action:
    """Our mesh, and the tree before it."""
    from export import skin
    from trees import from_array

    cells = np.load(folder / "set.npy").view(bool)[1:-1, 1:-1, 1:-1].copy()

    def act() -> Says:
        mesh = skin(from_array(cells))
        return lambda: f"{len(mesh.faces)} triangles"

    return act


def flying_edges(folder: Path, size: int) -> Action:
    """The surface at a half, without normals and scalars."""
    import vtk

    def made():
        edges = vtk.vtkFlyingEdges3D()
        edges.SetValue(0, 0.5)
        edges.ComputeNormalsOff()
        edges.ComputeGradientsOff()
        edges.ComputeScalarsOff()
        return edges

    return _filtered(folder, made)


def surface_nets(folder: Path, size: int) -> Action:
    """The surface of the label 1 as triangles, without smoothing."""
    import vtk

    def made():
        nets = vtk.vtkSurfaceNets3D()
        nets.SetValue(0, 1)
        nets.SmoothingOff()
        nets.SetOutputMeshTypeToTriangles()
        return nets

    return _filtered(folder, made)


def _filtered(folder: Path, made: Callable) -> Action:
    import vtk
    from vtkmodules.util.numpy_support import numpy_to_vtk

    vtk.vtkSMPTools.Initialize(1)
    cells = np.load(folder / "set.npy")
    image = vtk.vtkImageData()
    image.SetDimensions(*cells.shape)
    image.GetPointData().SetScalars(numpy_to_vtk(cells.ravel()))

    def act() -> Says:
        way = made()
        way.SetInputData(image)
        way.Update()
        mesh = way.GetOutput()
        return lambda: f"{mesh.GetNumberOfCells()} triangles"

    return act


def marching_cubes(folder: Path, size: int) -> Action:
    """The surface at a half; floats of 32 bits are what it works on."""
    from skimage.measure import marching_cubes as surface

    cells = np.load(folder / "set.npy").astype(np.float32)

    def act() -> Says:
        faces = surface(cells, 0.5)[1]
        return lambda: f"{len(faces)} triangles"

    return act


def of_distance(folder: Path, size: int) -> Action:
    """Our way from a function to a mesh: boxes that the surface misses are not divided."""
    from export import skin
    from trees import Cube, from_predicate

    centre, radius = size / 2, 0.4 * size

    def state(lows: np.ndarray, highs: np.ndarray) -> np.ndarray:
        middle, reach = (lows + highs) / 2, (highs - lows) / 2
        near = np.linalg.norm(middle - centre, axis=1) - radius
        about = np.where(reach.max(axis=1) > 0.5, np.linalg.norm(reach, axis=1), 0.0)
        return np.where(near > about, 0, np.where(near <= -about, 1, 2))

    def distance(points: np.ndarray) -> np.ndarray:
        return np.linalg.norm(points - centre, axis=1) - radius

    def act() -> Says:
        tree = from_predicate(state, Cube((0.0, 0.0, 0.0), float(size)), size.bit_length() - 1)
        mesh = skin(tree, "smooth", field=distance)
        return lambda: f"{len(mesh.faces)} triangles"

    return act


def dual_contouring(folder: Path, size: int) -> Action:
    """isomesh's octree and dual contouring, all leaves at the surface of one size, with exact gradients."""
    from isomesh import extract

    centre, radius = size / 2, 0.4 * size

    def distance(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        away = points - centre
        lengths = np.linalg.norm(away, axis=1)
        return lengths - radius, away / np.maximum(lengths, 1e-12)[:, None]

    def act() -> Says:
        far, depth = float(size), size.bit_length() - 1
        box = (0.0, 0.0, 0.0), (far, far, far)
        faces = extract(distance, bbox_min=box[0], bbox_max=box[1], min_depth=4, max_depth=depth)[1]
        return lambda: f"{len(faces)} triangles"

    return act


WAYS = (
    Way("bcifs, exact", skinned, ("exact",)),
    Way("bcifs, smooth", skinned, ("smooth",)),
    Way("bcifs, exact, from the dense array", from_dense),
    Way("VTK's flying edges", flying_edges),
    Way("VTK's surface nets", surface_nets),
    Way("scikit-image's marching cubes", marching_cubes),
    Way("OpenVDB's mesher", "mesh.cpp"),
)
