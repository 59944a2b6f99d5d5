"""How long uniform refinement takes: stamping, beside OpenSubdiv and trimesh, on the same mesh and machine.

The mesh is the boundary of a ball of voxels, with vertices of valence 3 to 6. OpenSubdiv refines it level by
level and finds limit positions; all run on one thread. trimesh has triangles: it starts from the same
squares cut in two, and its results are control points, not limits. Each time is the least of several runs.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

SOURCE = Path(__file__).parent / "opensubdiv" / "refine.cpp"
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
MISSING = "OpenSubdiv left out: it needs g++ and its library (Debian: apt-get install g++ libosd-dev)"


def ball(radius: float) -> tuple[np.ndarray, np.ndarray]:
    """The boundary squares of the voxels whose centres lie within a radius of the origin, outwards.

    >>> vertices, squares = ball(1.5)
    >>> vertices.shape, squares.shape
    ((56, 3), (54, 4))
    """
    reach = int(radius) + 2
    along = np.arange(-reach, reach + 1)
    x, y, z = np.meshgrid(along, along, along, indexing="ij")
    solid = x**2 + y**2 + z**2 <= radius**2
    corners = []
    for axis in range(3):
        u, v = np.eye(3, dtype=int)[[(axis + 1) % 3, (axis + 2) % 3]]
        for side in (0, 1):
            cells = np.argwhere(solid & ~np.roll(solid, 1 - 2 * side, axis))
            cells[:, axis] += side
            ring = [0 * u, u, u + v, v]
            corners.append(np.stack([cells + step for step in (ring if side else ring[::-1])], axis=1))
    squares = np.concatenate(corners)
    vertices, numbers = np.unique(squares.reshape(-1, 3), axis=0, return_inverse=True)
    return (vertices - reach).astype(float), numbers.reshape(-1, 4)


def least(action: Callable[[], object], runs: int) -> float:
    """The least of the times that an action takes, in seconds."""
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        action()
        times.append(time.perf_counter() - start)
    return min(times)


def stamping(radius: float, depth: int, runs: int, save: str = "") -> None:
    """Prints what stamping a ball takes, as JSON; to be called in a process of its own."""
    from ifs.stamp import stamped
    from ifs.stencil import Stencils
    from ifs.surfaces.control_mesh import surface
    from ifs.template import Templates

    start = time.perf_counter()
    complex_ = surface(*ball(radius)).complex()
    found = time.perf_counter()
    stencils = Stencils(Templates(complex_.topology), complex_.system)
    before = _resident("VmRSS")
    mesh = stamped(complex_, depth, stencils).mesh
    first = time.perf_counter()
    peak = _resident("VmHWM")
    size = mesh.vertices.nbytes + mesh.faces.nbytes
    if save:
        np.savez(save, vertices=mesh.vertices, faces=mesh.faces)
    del mesh
    again = least(lambda: stamped(complex_, depth, stencils), runs)
    answer = {"patches": found - start, "first": first - found, "again": again}
    print(json.dumps(answer | {"before": before, "peak": peak, "size": size}))


def _resident(field: str) -> int:
    """The memory that this process has resident, now (VmRSS) or at most so far (VmHWM), in bytes.

    `resource.getrusage` would also count that of the process which started this one.
    """
    lines = Path("/proc/self/status").read_text().splitlines()
    return 1024 * next(int(line.split()[1]) for line in lines if line.startswith(field))


def _alone(radius: float, depth: int, runs: int, save: str = "") -> dict[str, float]:
    call = f"from bench.refine import stamping; stamping({radius}, {depth}, {runs}, {save!r})"
    done = subprocess.run(
        [sys.executable, "-c", call], check=True, stdout=subprocess.PIPE, env=os.environ | ONE_THREAD
    )
    return json.loads(done.stdout)


def opensubdiv(
    folder: Path, vertices: np.ndarray, squares: np.ndarray, depth: int, runs: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Limit positions, faces and the milliseconds of each run and stage; nothing without the library.

    The stages: topology, interpolation, limits, and copying the faces into one array.
    """
    program, mesh, out = folder / "refine", folder / "mesh", folder / "out"
    build = ["g++", "-O3", "-march=native", "-std=c++17", str(SOURCE), "-o", str(program), "-losdCPU"]
    try:
        subprocess.run(build, check=True, stderr=subprocess.DEVNULL)
    except (FileNotFoundError, subprocess.CalledProcessError):
        return None
    sized = np.pad(squares, ((0, 0), (1, 0)), constant_values=4)
    counts = np.array([len(vertices), len(squares)])
    mesh.write_bytes(counts.tobytes() + vertices.tobytes() + sized.astype(np.int64).tobytes())
    done = subprocess.run([program, mesh, out, str(depth), str(runs)], check=True, stdout=subprocess.PIPE)
    *times, last = [[float(word) for word in line.split()] for line in done.stdout.decode().splitlines()]
    count = 3 * int(last[0])
    points = np.fromfile(out, dtype=float, count=count).reshape(-1, 3)
    faces = np.fromfile(out, dtype=np.int64, offset=8 * count).reshape(-1, 4)
    return points, faces, np.array(times)


def difference(
    vertices: np.ndarray, faces: np.ndarray, others: np.ndarray, other_faces: np.ndarray
) -> float | None:
    """The greatest distance between vertices that answer to each other, in mm, when the faces do so too."""
    from scipy.spatial import KDTree

    distance, twin = map(np.asarray, KDTree(others).query(vertices))
    one, other = (np.sort(table, axis=1) for table in (twin[faces], other_faces))
    one, other = (table[np.lexsort(table.T)] for table in (one, other))
    same = len(vertices) == len(others) == len(np.unique(twin)) and np.array_equal(one, other)
    return float(distance.max()) if same else None


def report(radius: float = 7.3, depth: int = 5, runs: int = 7) -> Iterator[str]:
    """Lines for stamping, OpenSubdiv and trimesh, then one for a large mesh with its memory."""
    vertices, squares = ball(radius)
    yield f"refine: {len(squares)} squares, {depth} subdivisions, {len(squares) * 4**depth:,} faces"
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        found = _alone(radius, depth, runs, str(folder / "mesh.npz"))
        again = 1000 * found["again"]
        yield f"  {'stamping, templates ready':36} {again:8.0f} ms"
        first, patches = 1000 * found["first"], 1000 * found["patches"]
        yield f"  {'stamping and building its templates':36} {first:8.0f} ms   once a set of states"
        yield f"  {'finding patches and their operators':36} {patches:8.0f} ms   once a control mesh"
        known = opensubdiv(folder, vertices, squares, depth, runs)
        if known is None:
            yield f"  {MISSING}"
        else:
            yield from _compared(known, np.load(folder / "mesh.npz"), again)
    for label, seconds, count in _trimesh(vertices, squares, depth):
        ratio = 1000 * seconds / again
        yield f"  {label:36} {1000 * seconds:8.0f} ms   {ratio:5.1f} x stamping; {count:,} triangles"
    yield from large()


def _compared(known: tuple[np.ndarray, np.ndarray, np.ndarray], mesh, again: float) -> Iterator[str]:
    points, faces, times = known
    for label, stages in (("OpenSubdiv, vertices", 3), ("OpenSubdiv, vertices and faces", 4)):
        total = times[:, :stages].sum(axis=1).min()
        yield f"  {label:36} {total:8.0f} ms   {total / again:5.1f} x stamping"
    stages = times[times.sum(axis=1).argmin()]
    names = ("topology", "interpolation", "limits", "faces copied")
    parts = ", ".join(f"{name} {each:.0f}" for name, each in zip(names, stages, strict=True))
    yield f"    of which {parts} ms"
    apart = difference(mesh["vertices"], mesh["faces"], points, faces)
    same = "the meshes differ" if apart is None else f"the same faces, limits at most {apart:.1e} mm apart"
    yield f"    vertices: {len(mesh['vertices']):,} and {len(points):,}; {same}"


def _trimesh(vertices: np.ndarray, squares: np.ndarray, depth: int) -> Iterator[tuple[str, float, int]]:
    from trimesh.remesh import subdivide, subdivide_loop

    triangles = np.concatenate([squares[:, [0, 1, 2]], squares[:, [0, 2, 3]]])

    def midpoints():
        points, faces = vertices, triangles
        for _ in range(depth):
            points, faces, *_ = subdivide(points, faces)

    count = len(triangles) * 4**depth
    yield "trimesh subdivide (flat)", least(midpoints, 1), count
    seconds = least(lambda: subdivide_loop(vertices, triangles, iterations=depth), 1)
    yield "trimesh subdivide_loop", seconds, count


def large(radius: float = 73, depth: int = 3) -> Iterator[str]:
    """One line: a large mesh, its time and its memory."""
    count = len(ball(radius)[1])
    found = _alone(radius, depth, 2)
    size, more = found["size"] / 1e6, (found["peak"] - found["before"]) / 1e6
    seconds = f"{found['first']:.2f} s, {found['again']:.2f} s with templates ready"
    yield f"refine: {count} squares, {depth} subdivisions, {count * 4**depth:,} faces: {seconds}"
    yield f"  {size:.0f} MB of result; memory grew by {more:.0f} MB at the peak ({more / size:.2f} x)"


if __name__ == "__main__":
    for line in report():
        print(line, flush=True)
