"""Meshes to files, beside lib3mf and the bytes of the same file written as they are.

Every way flushes its file to the disk (fsync) before the clock stops, and writes a new file each time.
"""

import itertools
import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from bench.contest import Action, Contest, Goal, Says, Way
from bench.parts_meshing import ball

ALL = os.cpu_count() or 1


def contests(side: int) -> list[Contest]:
    """The smooth mesh of a ball of voxels, as 3MF, STL and PLY."""
    ours, zip3mf = "bcifs", "lib3mf, from lists"
    ways = (
        Way(ours, part, ("3mf",)),
        Way(f"bcifs, on {ALL} processors", part, ("3mf",), processors=ALL),
        Way(zip3mf, lib3mf_lists),
        Way("lib3mf, from NumPy's buffers", lib3mf_buffers),
        Way("the same bytes", raw, ("3mf",)),
    )
    found = [Contest(_title("3MF", side), side, ways, (Goal("time", zip3mf, ours, least=5),), mesh_of_ball)]
    for ending, most in (("stl", 1.5), ("ply", 1.1)):
        ways = Way(ours, part, (ending,)), Way("the same bytes", raw, (ending,))
        goal = Goal("time", ours, "the same bytes", most=most)
        found.append(Contest(_title(ending.upper(), side), side, ways, (goal,), mesh_of_ball))
    return found


def _title(name: str, side: int) -> str:
    return f"{name} file of a ball of {side}^3 voxels"


def mesh_of_ball(folder: Path, size: int) -> None:
    """The smooth mesh, as two arrays."""
    from export import skin
    from trees import from_array

    mesh = skin(from_array(ball(size)), "smooth")
    np.save(folder / "vertices.npy", mesh.vertices)
    np.save(folder / "faces.npy", mesh.faces)


def part(folder: Path, size: int, ending: str) -> Action:
    """Our file."""
    from export import write_part

    mesh, names = _mesh(folder), _names(folder, ending)

    def act() -> Says:
        path = next(names)
        write_part(mesh, path, {}, "part")
        return lambda: _size(path, len(mesh.faces))

    return act


def raw(folder: Path, size: int, ending: str) -> Action:
    """The bytes of our file in one write."""
    from export import write_part

    mesh, names = _mesh(folder), _names(folder, ending)
    first = next(names)
    write_part(mesh, first, {}, "part")
    content = first.read_bytes()
    first.unlink()

    def act() -> Says:
        path = next(names)
        with open(path, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        return lambda: _size(path, len(mesh.faces))

    return act


def lib3mf_lists(folder: Path, size: int) -> Action:
    """As its wrapper has it: lists of its structures."""
    import lib3mf

    mesh, names = _mesh(folder), _names(folder, "3mf")

    def act() -> Says:
        vertices = [lib3mf.Position(tuple(point)) for point in mesh.vertices.tolist()]
        triangles = [lib3mf.Triangle(tuple(face)) for face in mesh.faces.tolist()]
        path = next(names)
        _write_lib3mf(path, lambda thing: thing.SetGeometry(vertices, triangles))
        return lambda: _size(path, len(mesh.faces))

    return act


def lib3mf_buffers(folder: Path, size: int) -> Action:
    """Past its wrapper: arrays in single precision straight to the library."""
    import ctypes

    import lib3mf

    mesh, names = _mesh(folder), _names(folder, "3mf")

    def act() -> Says:
        points, faces = mesh.vertices.astype(np.float32), mesh.faces.astype(np.uint32)

        def fill(thing) -> None:
            first = ctypes.cast(points.ctypes.data, ctypes.POINTER(lib3mf.Position))
            second = ctypes.cast(faces.ctypes.data, ctypes.POINTER(lib3mf.Triangle))
            counts = ctypes.c_uint64(len(points)), ctypes.c_uint64(len(faces))
            code = thing._wrapper.lib.lib3mf_meshobject_setgeometry(
                thing._handle, counts[0], first, counts[1], second
            )
            thing._wrapper.checkError(thing, code)

        path = next(names)
        _write_lib3mf(path, fill)
        return lambda: _size(path, len(mesh.faces))

    return act


def _write_lib3mf(path: Path, fill) -> None:
    from lib3mf import get_wrapper

    wrapper = get_wrapper()
    model = wrapper.CreateModel()
    assert model is not None
    thing = model.AddMeshObject()
    assert thing is not None
    fill(thing)
    model.AddBuildItem(thing, wrapper.GetIdentityTransform())
    writer = model.QueryWriter("3mf")
    assert writer is not None
    writer.WriteToFile(str(path))
    with open(path, "rb") as file:
        os.fsync(file.fileno())


def _mesh(folder: Path):
    from ifs.mesh import Mesh

    return Mesh(np.load(folder / "vertices.npy"), np.load(folder / "faces.npy"))


def _names(folder: Path, ending: str) -> Iterator[Path]:
    """Names of files that are not there yet."""
    return (folder / f"{os.getpid()}-{number}.{ending}" for number in itertools.count())


def _size(path: Path, triangles: int) -> str:
    return f"{path.stat().st_size / 1e6:.1f} MB, {triangles} triangles"
