"""Sets of cells: building, Boolean operations, components, moments, dilation and memory, beside the peers.

`python -m bench.sets [SIDE]`, SIDE 512 unless given. Peers, each on one thread and on the same sets: OpenVDB
(a program of this folder; it works in place, so the time of a copy is told apart), dense bits in NumPy,
scipy.ndimage, cc3d and scikit-image, where they are installed. Times are the least of several runs, memory
is the largest resident size of a process of its own, less what it had with the set in its hands.
"""

import importlib
import importlib.util
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import numpy as np

SOURCE = Path(__file__).parent / "openvdb" / "sets.cpp"
NO_VDB = (
    "OpenVDB left out: it needs g++ and its library (Debian: apt-get install g++ libopenvdb-dev libboost-dev)"
)
RADIUS = 4


def menger(side: int) -> np.ndarray:
    """The corner of a sponge of 3^n cells a side that fills the array."""
    third = np.arange(side)
    solid = np.ones((side,) * 3, dtype=bool)
    while third.any():
        middle = third % 3 == 1
        x, y, z = middle[:, None, None], middle[None, :, None], middle[None, None, :]
        solid &= ~((x & y) | (y & z) | (x & z))
        third = third // 3
    return solid


def sphere(side: int) -> np.ndarray:
    """A ball of 0.4 sides."""
    squares = (np.arange(side) - side / 2 + 0.5) ** 2
    return squares[:, None, None] + squares[None, :, None] + squares[None, None, :] < (0.4 * side) ** 2


def takagi(side: int) -> np.ndarray:
    """The surface `z = (T(x) + T(y)) / 2` of two Takagi curves, one cell thick at least."""
    grid = np.arange(side + 1) / side
    steps = 2.0 ** np.arange(20)[:, None]
    curve = (np.abs(grid * steps - np.round(grid * steps)) / steps).sum(axis=0)
    height = (curve[:, None] + curve[None, :]) / 2 * (side - 1)
    corners = np.stack([height[:-1, :-1], height[1:, :-1], height[:-1, 1:], height[1:, 1:]])
    low, high = np.floor(corners.min(0)), np.ceil(corners.max(0))
    z = np.arange(side)
    return (z >= low[..., None]) & (z <= high[..., None])


def attractor(side: int) -> np.ndarray:
    """The cells of ten million points of a random system of six overlapping maps."""
    rng = np.random.default_rng(7)
    maps = [(0.55 * np.linalg.qr(rng.normal(size=(3, 3)))[0], rng.random(3)) for _ in range(6)]
    points = rng.random((100_000, 3))
    cells = np.zeros((side,) * 3, dtype=bool)
    centre, reach = np.array([0.5] * 3) * 2, 3.5
    for step in range(130):
        choice = rng.integers(0, 6, len(points))
        points = np.stack([matrix @ points.T for matrix, _ in maps])[choice, :, np.arange(len(points))]
        points = points + np.array([shift for _, shift in maps])[choice]
        if step >= 30:
            cells[tuple(np.clip(((points - centre) / reach + 0.5) * side, 0, side - 1).astype(int).T)] = True
    return cells


def noise(side: int) -> np.ndarray:
    """Cells taken at random, one in three."""
    return np.random.default_rng(5).random((side,) * 3, dtype=np.float32) < 1 / 3


SHAPES = {
    "Menger sponge": menger,
    "sphere": sphere,
    "Takagi surface": takagi,
    "random attractor": attractor,
    "noise": noise,
}


def least(action: Callable[[], object], runs: int = 3) -> float:
    """The least of the times that an action takes, in seconds, after one run that compiles."""
    action()
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        action()
        times.append(time.perf_counter() - start)
    return min(times)


def once(action: Callable[[], object]) -> float:
    """The time of one run, in seconds."""
    start = time.perf_counter()
    action()
    return time.perf_counter() - start


def report(side: int = 512) -> Iterator[str]:
    """The lines of the benchmark."""
    from trees import from_array
    from trees.geometry import homography, rotation

    yield f"Sets of {side}^3 cells; times in ms unless said, memory in MB."
    with tempfile.TemporaryDirectory() as folder:
        program = _compiled(Path(folder))
        if program is None:
            yield NO_VDB
        for name, build in SHAPES.items():
            array = build(side)
            yield from _shape(name, array, from_array(array), program, Path(folder))
            if name == "Menger sponge":
                small = from_array(array[: side // 2, : side // 2, : side // 2])
                turn = rotation(3, 0, 1, 0.4, about=(0.5, 0.5, 0.5))
                start = time.perf_counter()
                turned = homography(small, turn)
                yield f"  turned, at {side // 2}^3: {time.perf_counter() - start:.2f} s, {turned.count} cells"
        yield from _cloud(program, Path(folder))
    yield from _self_similar()


def _shape(name: str, array: np.ndarray, tree, program: Path | None, folder: Path) -> Iterator[str]:
    from trees import compact, from_array
    from trees.geometry import translate
    from trees.measures import moments
    from trees.morphology import Ball, dilation
    from trees.topology import components

    other = translate(tree, (5, 3, 1))
    yield f"{name}: {tree.count} cells"
    building = least(lambda: from_array(array), 1), least(lambda: np.packbits(array), 1)
    yield f"  from an array {1e3 * building[0]:.0f}, by NumPy's packbits {1e3 * building[1]:.0f}"
    peers = _openvdb(program, folder, tree, other)
    bits = [np.packbits(array).view(np.uint64), np.packbits(np.roll(array, 5, 0)).view(np.uint64)]
    dense = {
        "or": lambda: bits[0] | bits[1],
        "and": lambda: bits[0] & bits[1],
        "minus": lambda: bits[0] & ~bits[1],
    }
    yield from _boolean(tree, other, peers, dense)
    sizes = tree.nbytes / 1e6, compact(tree).nbytes / 1e6, array.size / 8e6
    memory = f"  memory: {sizes[0]:.2f}, in the smaller form {sizes[1]:.2f}, dense bits {sizes[2]:.1f}"
    yield memory + (f", OpenVDB {peers['bytes'] / 1e6:.2f}" if peers else "")
    yield f"  components: {1e3 * least(lambda: components(tree), 2):.0f}{_peer_components(array)}"
    yield f"    peak memory {_peak('own', array):.0f}{_peer_peak(array)}"
    yield _dilation(name, array, lambda: dilation(tree, Ball(RADIUS)), peers)
    yield _moments(name, array, lambda: moments(tree, 3))


def _boolean(
    tree, other, peers: dict[str, float], dense: Mapping[str, Callable[[], object]] | None = None
) -> Iterator[str]:
    for sign, own in (
        ("or", lambda: tree | other),
        ("and", lambda: tree & other),
        ("minus", lambda: tree - other),
    ):
        line = f"  {sign}: {1e3 * least(own, 5):.2f}"
        if dense:
            line += f", dense bits {1e3 * least(dense[sign], 5):.2f}"
        if peers:
            line += f", OpenVDB {1e3 * peers[sign]:.2f} in place + {1e3 * peers['copy']:.2f} to copy"
        yield line


def _dilation(name: str, array: np.ndarray, own: Callable[[], object], peers: dict[str, float]) -> str:
    line = f"  ball of {RADIUS} cells added: {1e3 * least(own, 2):.0f}"
    if peers:
        ball, faces = 1e3 * peers["dilate by a ball"], 1e3 * peers["dilate by faces"]
        line += f", OpenVDB {faces:.0f} by steps of faces"
        line += f", {ball:.0f} by a level set" if ball > 0 else ""
    if name == "sphere" and len(array) <= 512:
        from scipy.ndimage import distance_transform_edt

        transform = once(lambda: distance_transform_edt(~array))
        line += f", scipy's distance transform {1e3 * transform:.0f}"
    return line


def _moments(name: str, array: np.ndarray, own: Callable[[], object]) -> str:
    line = f"  moments to order 3, exact: {1e3 * least(own, 2):.1f}"
    if name == "sphere" and len(array) <= 512 and _there("skimage"):
        measure = importlib.import_module("skimage.measure")
        line += f", scikit-image {1e3 * once(lambda: measure.moments(array.astype(float), 3)):.0f}"
    return line


def _cloud(program: Path | None, folder: Path) -> Iterator[str]:
    """Ten million points of a cube of 2^20 cells a side, on a random surface."""
    from trees import from_points

    rng = np.random.default_rng(3)
    flat = rng.integers(0, 2**20, (10_000_000, 2))
    height = (2**19 + 2**17 * np.sin(flat[:, 0] / 2**17) * np.cos(flat[:, 1] / 2**17)).astype(int)
    points = np.column_stack([flat, height])
    seconds = least(lambda: from_points(points, 20), 1)
    tree = from_points(points, 20)
    other = from_points(points[::2] + np.array([0, 0, 1]), 20)
    peer = once(lambda: np.unique(points, axis=0))
    yield f"ten million points at 2^20 a side: {seconds:.2f} s, {tree.nbytes / 1e6:.0f} MB"
    yield f"  np.unique of their rows: {peer:.2f} s"
    yield f"  or: {1e3 * least(lambda: tree | other):.0f}, and: {1e3 * least(lambda: tree & other):.0f}"
    few, others = (from_points(points[: 10**6] + np.array([0, 0, step]), 20) for step in (0, 1))
    peers = _openvdb(program, folder, few, others)
    line = f"one million of them: {few.nbytes / 1e6:.0f} MB"
    yield line + (f", OpenVDB {peers['bytes'] / 1e6:.0f} MB" if peers else "")
    yield from _boolean(few, others, peers)


def _self_similar() -> Iterator[str]:
    """Sierpinski's tetrahedron with 2^20 cells a side."""
    from trees import from_substitution
    from trees.measures import moments
    from trees.topology import surface_area

    rules = {"t": ["t", False, False, "t", False, "t", "t", False]}
    mirror = {"t": rules["t"][::-1]}
    tree, other = (from_substitution(rule, "t", 20) for rule in (rules, mirror))
    yield f"Sierpinski's tetrahedron, 2^20 a side: {tree.count} cells, {tree.nbytes} bytes"
    for words, action in (
        ("built", lambda: from_substitution(rules, "t", 20)),
        ("volume", lambda: from_substitution(rules, "t", 20).count),
        ("moments to order 3", lambda: moments(tree, 3)),
        ("surface", lambda: surface_area(tree)),
        ("compared", lambda: (tree == other, tree & other)),
    ):
        yield f"  {words}: {1e3 * least(action):.2f}"


def _compiled(folder: Path) -> Path | None:
    program = folder / "sets"
    command = ["g++", "-O3", "-march=native", "-w", str(SOURCE), "-o", str(program), "-lopenvdb", "-ltbb"]
    try:
        subprocess.run(command, check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError):
        return None
    return program


def _openvdb(program: Path | None, folder: Path, tree, other) -> dict[str, float]:
    from trees.files import write_vdb

    if program is None:
        return {}
    paths = [str(folder / name) for name in ("a.vdb", "b.vdb")]
    for path, each in zip(paths, (tree, other), strict=True):
        write_vdb(each, path)
    answer = subprocess.run([program, *paths, str(RADIUS)], check=True, capture_output=True, text=True)
    return json.loads(answer.stdout)


def _there(module: str) -> bool:
    return importlib.util.find_spec(module) is not None


def _peer_components(array: np.ndarray) -> str:
    from scipy.ndimage import label

    line = f", scipy {1e3 * once(lambda: label(array)):.0f}"
    if _there("cc3d"):
        cc3d = importlib.import_module("cc3d")
        line += f", cc3d {1e3 * least(lambda: cc3d.connected_components(array, connectivity=6), 1):.0f}"
    return line


def _peer_peak(array: np.ndarray) -> str:
    return f", cc3d {_peak('cc3d', array):.0f}" if _there("cc3d") else ""


def _peak(which: str, array: np.ndarray) -> float:
    """The memory that components take, in MB, in a process of its own."""
    with tempfile.NamedTemporaryFile(suffix=".npy") as file:
        np.save(file, np.packbits(array))
        file.flush()
        command = [sys.executable, "-m", "bench.sets", which, file.name, str(array.shape[0])]
        answer = subprocess.run(command, check=True, capture_output=True, text=True, env=os.environ)
    return float(answer.stdout)


def _measure(which: str, path: str, side: int) -> None:
    """Prints by how much finding components raises the peak of memory, the set itself included."""
    array = np.unpackbits(np.load(path)).astype(bool).reshape((side,) * 3)
    if which == "own":
        from trees import from_array
        from trees.topology import components

        components(from_array(array[:64, :64, :64].copy()))
        tree = from_array(array)
        del array
        _reset_peak()
        held = _resident() - tree.nbytes
        components(tree)
    else:
        cc3d = importlib.import_module("cc3d")
        cc3d.connected_components(array[:64, :64, :64].copy(), connectivity=6)
        _reset_peak()
        held = _resident() - array.nbytes
        cc3d.connected_components(array, connectivity=6)
    print((_peak_resident() - held) / 1e6)


def _reset_peak() -> None:
    Path("/proc/self/clear_refs").write_text("5")


def _resident() -> int:
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize()


def _peak_resident() -> int:
    line = next(
        line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM")
    )
    return int(line.split()[1]) * 1024


if __name__ == "__main__":
    if sys.argv[1:2] in (["own"], ["cc3d"]):
        _measure(sys.argv[1], sys.argv[2], int(sys.argv[3]))
    else:
        for text in report(int(sys.argv[1]) if len(sys.argv) > 1 else 512):
            print(text, flush=True)
