"""Voxels of attractors beside a frontier in NumPy, both with the same guarantee and on one thread.

`python -m bench.voxels [SIDE ...]`, 256 a side unless given. The frontier subdivides all pieces
of a generation together, as arrays; a piece whose certified box is no larger than a voxel, or lies in one,
fills the voxels that the box meets. It works by the chunk, in bounded memory, into a dense array of booleans.
Where it takes over 30 s it is stopped, and its time is that of the share of the shape that it did, measured
by the share of the pieces of each generation; the line says so.
"""

import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from export.voxels.frame import TOLERANCE, Frame, frame_around, in_grid
from export.voxels.voxelise import voxelise
from ifs import Shape, bounds, extent
from ifs.system import System

CHUNK = 1 << 15
PATIENCE = 30.0


@dataclass(frozen=True)
class Frontier:
    """What the peer found: the voxels, how many pieces it saw, and the share that it did in its time."""

    filled: Bool[np.ndarray, "x y z"]
    pieces: int
    seconds: float
    share: float


def report(sides: tuple[int, ...] = (256,)) -> Iterator[str]:
    """The lines of the benchmark."""
    yield "Seconds to voxelise, all set-up included, beside a frontier in NumPy."
    for name, made in shapes().items():
        shape = made()
        voxelise(shape, 16)
        for side in sides:
            yield line(name, shape, side)


def line(name: str, shape: Shape, side: int) -> str:
    start = time.perf_counter()
    found = voxelise(shape, side)
    own = time.perf_counter() - start
    peer = frontier(shape, frame_around(shape, side))
    whole = peer.seconds / peer.share
    told = f"{whole:.2f}" if peer.share == 1 else f"about {whole:.0f} ({100 * peer.share:.2g} % done)"
    grid = "x".join(map(str, found.size))
    return (
        f"{name}, {grid}, {found.tree.count} black: {own:.3f} ({found.way}), frontier {told}: "
        f"{whole / own:.0f} times"
    )


def shapes() -> dict[str, Callable[[], Shape]]:
    """The shapes that are compared."""
    import ifs
    from ifs.maps.maps import affine
    from ifs.maps.plain import from_maps
    from subdivision.schemes import bezier, tensor

    def turned() -> Shape:
        control = ifs.shape("sierpinski-tetrahedron").control
        c, s = np.cos(1.0), np.sin(1.0)
        turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
        return ifs.shape("sierpinski-tetrahedron", control=control @ turn.T)

    def random() -> Shape:
        rng = np.random.default_rng(3)
        maps = []
        for _ in range(8):
            linear = rng.normal(size=(3, 3))
            linear *= rng.uniform(0.4, 0.6) / np.linalg.norm(linear, 2)
            maps.append(affine(linear.round(6).tolist(), rng.normal(size=3).round(6).tolist()))
        return ifs.shape(from_maps(maps))

    def bicubic() -> Shape:
        x, y = np.meshgrid(np.linspace(0, 60, 4), np.linspace(0, 60, 4), indexing="ij")
        z = 20 * np.array([[0, 1, 0, 1], [1, 2, 3, 0], [0, 3, 2, 1], [1, 0, 1, 2]])
        control = np.stack([x, y, z], axis=-1).reshape(16, 3)
        return ifs.shape(tensor(bezier(3), bezier(3)), control=control)

    return {
        "Koch's curve": lambda: ifs.shape("koch-curve"),
        "fractal patch": lambda: ifs.shape("fractal-patch"),
        "Menger sponge": lambda: ifs.shape("menger-sponge"),
        "Sierpinski's tetrahedron, turned": turned,
        "Bezier patch, bicubic": bicubic,
        "Catmull-Clark patch": lambda: ifs.shape("catmull-clark-patch"),
        "8 random affine maps": random,
    }


def frontier(shape: Shape, frame: Frame, patience: float = PATIENCE) -> Frontier:
    """The voxels that the smallest pieces meet, generation by generation."""
    start = time.perf_counter()
    placed = in_grid(shape, frame)
    system, boxes = placed.system, bounds(placed.system)
    operators = {
        name: [(target, operator.T) for target, operator in zip(state.targets, state.operators, strict=True)]
        for name, state in system.states.items()
    }
    filled = np.zeros(frame.size, dtype=np.bool_)
    waiting = [(cell, control, 1.0) for cell, control in placed.roots.items()]
    seen, left = 0, 1.0
    while waiting and time.perf_counter() - start < patience:
        cell, control, share = waiting.pop()
        seen += len(control)
        low, high = extent(boxes[cell], control)
        first, last = cells_met(low, high, frame.size)
        done = (high - low <= 1).all(axis=1) | (first == last).all(axis=1)
        fill(filled, first[done], last[done])
        left -= share * done.mean()
        control = control[~done]
        if not len(control):
            continue
        share *= 1 - done.mean()
        waiting.extend(chunks(system, operators[cell], control, share))
    return Frontier(filled, seen, time.perf_counter() - start, 1.0 if not waiting else 1 - left)


def chunks(system: System, operators, control: Float[np.ndarray, "pieces points 3"], share: float):
    """The pieces of pieces, those of one cell together, by the chunk."""
    by_target: dict[str, list[np.ndarray]] = {}
    for target, operator in operators:
        by_target.setdefault(target, []).append(operator @ control)
    for target, found in by_target.items():
        pieces = np.concatenate(found)
        part = share * len(found) / len(operators)
        for begin in range(0, len(pieces), CHUNK):
            some = pieces[begin : begin + CHUNK]
            yield target, some, part * len(some) / len(pieces)


def cells_met(low, high, size: tuple[int, ...]):
    """The first and the last voxel of boxes, those that they touch within the tolerance left out."""
    top = np.array(size) - 1
    first = np.clip(np.floor(low + TOLERANCE).astype(np.int32), 0, top)
    last = np.ceil(high - TOLERANCE).astype(np.int32) - 1
    return first, np.clip(last, first, top)


def fill(filled: np.ndarray, first: np.ndarray, last: np.ndarray) -> None:
    """Blacken the voxels from first to last: boxes of at most a voxel meet two along an axis."""
    _, ny, nz = filled.shape
    flat = filled.reshape(-1)
    ends = [(first[:, axis], last[:, axis]) for axis in range(3)]
    keys = [(x.astype(np.int64) * ny + y) * nz + z for x in ends[0] for y in ends[1] for z in ends[2]]
    for key in keys:
        flat[key] = True


if __name__ == "__main__":
    for text in report(tuple(int(x) for x in sys.argv[1:]) or (256,)):
        print(text, flush=True)
