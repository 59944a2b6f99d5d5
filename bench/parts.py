"""From an attractor to a file: voxels, meshes and formats, beside the peers.

`python -m bench.parts [SIDE]`, SIDE 256 unless given. VTK's flying edges and scikit-image's marching cubes
mesh the same voxels, lib3mf writes the same triangles from Python, and a frontier in NumPy voxelises the same
sponge. All on one thread; the least of two runs.
"""

import importlib
import importlib.util
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from bench.sets import least, menger, once, sphere


def report(side: int = 256) -> Iterator[str]:
    """The lines of the benchmark."""
    yield f"Parts on {side}^3 voxels, in seconds."
    yield from _voxels()
    for name, array in (("sphere", sphere(side)), ("Menger sponge", menger(side))):
        yield from _meshes(name, array)
    yield from _files(sphere(side))


def _voxels() -> Iterator[str]:
    import ifs
    from export import voxelise

    sponge = ifs.shape("menger-sponge")
    own = least(lambda: voxelise(sponge, 243), 2)
    yield f"sponge at 243: {own:.3f}, its cubes by a frontier in NumPy {once(lambda: _frontier(5)):.3f}"
    tetrahedron = ifs.shape("sierpinski-tetrahedron", control=np.vstack([np.zeros(3), np.eye(3)]) * 64)
    own = least(lambda: voxelise(tetrahedron, 2**18), 2)
    yield f"Sierpinski's tetrahedron of a lattice at 2^18 a side: {own:.3f}"


def _frontier(level: int) -> np.ndarray:
    """The corners of the cubes of a level of the sponge, all of a level at once."""
    offsets = np.array([c for c in np.ndindex(3, 3, 3) if sum(x == 1 for x in c) < 2])
    corners = np.zeros((1, 3), dtype=np.int64)
    for _ in range(level):
        corners = (3 * corners[:, None] + offsets).reshape(-1, 3)
    filled = np.zeros((3**level,) * 3, dtype=bool)
    filled[tuple(corners.T)] = True
    return filled


def _meshes(name: str, array: np.ndarray) -> Iterator[str]:
    from export import skin
    from trees import from_array

    tree = from_array(array)
    exact, smooth = least(lambda: skin(tree), 2), least(lambda: skin(tree, "smooth"), 2)
    line = f"{name}, {len(skin(tree).faces)} triangles: exact {exact:.3f}, smooth {smooth:.3f}"
    line += f", VTK's flying edges {_flying_edges(array):.3f}"
    if importlib.util.find_spec("skimage"):
        measure = importlib.import_module("skimage.measure")
        padded = np.pad(array, 1).astype(np.float32)
        line += f", scikit-image's marching cubes {once(lambda: measure.marching_cubes(padded, 0.5)):.3f}"
    yield line


def _flying_edges(array: np.ndarray) -> float:
    import vtk

    vtk.vtkSMPTools.Initialize(1)
    import pyvista

    grid = pyvista.ImageData(dimensions=np.array(array.shape) + 2)
    grid.point_data["black"] = np.pad(array, 1).astype(np.uint8).ravel(order="F")
    return least(lambda: grid.contour([0.5], scalars="black", method="flying_edges"), 1)


def _files(array: np.ndarray) -> Iterator[str]:
    from export import skin, write_part
    from trees import from_array

    mesh = skin(from_array(array), "smooth")
    with tempfile.TemporaryDirectory() as folder:
        yield f"files of {len(mesh.faces)} triangles:"
        for ending in ("3mf", "stl", "ply", "obj", "glb"):
            path = Path(folder) / f"part.{ending}"
            seconds = least(lambda path=path: write_part(mesh, path, {}, "part"), 1)
            size = path.stat().st_size
            raw = once(lambda size=size: (Path(folder) / "raw").write_bytes(bytes(size)))
            yield f"  {ending}: {seconds:.3f}, {size / 1e6:.1f} MB, as many zeros {raw:.3f}"
        yield f"  lib3mf: {once(lambda: _lib3mf(mesh, Path(folder) / 'peer.3mf')):.3f}"


def _lib3mf(mesh, path: Path) -> None:
    import lib3mf
    from lib3mf import get_wrapper

    wrapper = get_wrapper()
    model = wrapper.CreateModel()
    assert model is not None
    thing = model.AddMeshObject()
    assert thing is not None
    vertices = [lib3mf.Position(tuple(point)) for point in mesh.vertices.tolist()]
    triangles = [lib3mf.Triangle(tuple(face)) for face in mesh.faces.tolist()]
    thing.SetGeometry(vertices, triangles)
    model.AddBuildItem(thing, wrapper.GetIdentityTransform())
    writer = model.QueryWriter("3mf")
    assert writer is not None
    writer.WriteToFile(str(path))


if __name__ == "__main__":
    for text in report(int(sys.argv[1]) if len(sys.argv) > 1 else 256):
        print(text, flush=True)
