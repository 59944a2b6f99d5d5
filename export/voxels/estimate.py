"""What a voxelisation will take, told before it is done, and budgets that refuse or coarsen it."""

import math
from dataclasses import dataclass, fields

import numpy as np

from export.voxels.frame import TOLERANCE, Frame, Model, frame_around, in_grid
from export.voxels.piece_walk import walked
from ifs import Shape
from trees import Tree, to_array

COUNTED = 64
"""Voxels along the longest side of the finer of the two grids in which a shape is counted."""
LATTICE_COUNTED = 1 << 20

_ENTRY = 16  # bytes of an entry of a tree
_ENTRIES = 1.6  # entries for each brick that is met
_VERTEX, _TRIANGLE = 24, 24  # bytes of a mesh in memory
_FILES = {"stl": (84, 50.0), "ply": (300, 19.0), "obj": (0, 34.0), "3mf": (2000, 11.0)}


@dataclass(frozen=True)
class Prediction:
    """Estimates for a resolution, in voxels along the longest side.

    `voxels` are black, `triangles` bound them exactly. `memory` is the most that voxelising takes,
    `mesh_memory` what the mesh takes besides, and `files` the sizes of the mesh by format, all in bytes.
    """

    resolution: int
    pitch: float
    voxels: int
    triangles: int
    memory: int
    mesh_memory: int
    files: dict[str, int]

    def __str__(self) -> str:
        sizes = ", ".join(f"{name} {_bytes(size)}" for name, size in self.files.items())
        return (
            f"about {self.voxels:.2g} voxels of {self.pitch:.3g} mm and {self.triangles:.2g} triangles; "
            f"memory {_bytes(self.memory)} and {_bytes(self.mesh_memory)} for the mesh; files: {sizes}"
        )


@dataclass(frozen=True)
class Budget:
    """The most that may be predicted (None: any amount): numbers, and bytes for memory and for the STL file.

    `exceeded` says what happens beyond: "refuse" raises `OverBudget`, "coarsen" lowers the resolution to the
    largest that fits.

    >>> Budget(voxels=10**6, exceeded="coarsen").voxels
    1000000
    """

    voxels: int | None = None
    triangles: int | None = None
    memory: int | None = None
    file: int | None = None
    exceeded: str = "refuse"

    def __post_init__(self):
        if self.exceeded not in ("refuse", "coarsen"):
            raise ValueError(f"a budget that is exceeded can refuse or coarsen, not {self.exceeded!r}")
        for each in ("voxels", "triangles", "memory", "file"):
            most = getattr(self, each)
            if most is not None and not most > 0:
                raise ValueError(f"a budget of {most} {each}: a number above 0 is needed")

    def broken(self, prediction: Prediction) -> dict[str, tuple[int, int]]:
        """What is over the budget: the amount that is predicted, and the most."""
        amounts = {
            "voxels": prediction.voxels,
            "triangles": prediction.triangles,
            "memory": prediction.memory,
            "file": prediction.files["stl"],
        }
        most = {each.name: getattr(self, each.name) for each in fields(self) if each.name in amounts}
        return {
            name: (amount, most[name])
            for name, amount in amounts.items()
            if most[name] is not None and amount > most[name]
        }


class OverBudget(MemoryError):
    """More is predicted than a budget allows; `prediction` and `budget` say how much, `fits` what would do.

    `fits` is the largest resolution within the budget, None where none is.
    """

    def __init__(self, prediction: Prediction, budget: Budget, fits: int | None):
        self.prediction, self.budget, self.fits = prediction, budget, fits
        over = ", ".join(
            f"{_amount(name, amount)} where {_amount(name, most)} are allowed"
            for name, (amount, most) in budget.broken(prediction).items()
        )
        way_out = f"a resolution of {fits} fits" if fits else "no resolution fits: allow more"
        super().__init__(f"a resolution of {prediction.resolution} takes about {over}; {way_out}")


@dataclass(frozen=True)
class Law:
    """How counts grow with the resolution: as a power, and as that of a solid once pieces exceed voxels.

    `counted` voxels and `faces` at the resolution `base`, along the longest of sides in the proportions
    `sides`; from the resolution `solid` on volumes grow by `dimension`, faces by one less.
    """

    base: int
    counted: int
    faces: int
    voxel_power: float
    face_power: float
    solid: float
    dimension: int
    longest: float
    sides: tuple[float, float, float]

    def at(self, resolution: int) -> Prediction:
        """The estimates for a resolution."""
        voxels = self._grown(self.counted, self.voxel_power, self.dimension, resolution)
        faces = self._grown(self.faces, self.face_power, self.dimension - 1, resolution)
        if self.dimension < 3:  # the two large faces of one layer
            faces = max(faces, 2 * voxels)
        triangles = round(2 * faces)
        size = [max(math.ceil(side * resolution - TOLERANCE), 1) for side in self.sides]
        grid = math.prod(1 << max((n - 1).bit_length(), 2) for n in size) // 8
        cube = 2 ** (3 * max((max(size) - 1).bit_length(), 2)) // 8
        bricks = self._grown(self.counted, self.voxel_power, self.dimension, max(resolution / 4, 1))
        kept = min(cube, round(_ENTRY * _ENTRIES * bricks) + 64)
        flat = grid if grid <= 1 << 28 else 1 << 25
        files = {name: round(head + each * triangles) for name, (head, each) in _FILES.items()}
        return Prediction(
            resolution,
            self.longest / resolution,
            round(voxels),
            triangles,
            flat + 3 * kept if kept < cube else flat,
            round(triangles * (_TRIANGLE + _VERTEX / 2)),
            files,
        )

    def _grown(self, count: int, power: float, solid_power: int, resolution: float) -> float:
        turn = max(self.solid, self.base)
        grown = count * (min(resolution, turn) / self.base) ** power
        return grown * (resolution / turn) ** solid_power if resolution > turn else grown


def estimate(
    model: Model, resolution: int | None = None, *, pitch: float | None = None, depth: int | None = None
) -> Prediction:
    """What voxelising a shape at a resolution, or with a pitch in mm, will take.

    The voxels and their faces are counted in grids of 32 and 64 voxels along the longest side, and grow from
    there by the power between the two; the voxels of a shape whose pieces are scaled copies grow by its
    similarity dimension. The boxes of the pieces of a `depth` are solids from voxels of their size on. Counts
    of grids that a lattice fractal does not fit differ by a factor of up to about 2.

    Raises what `export.voxels.voxelise` raises.

    >>> import ifs
    >>> found = estimate(ifs.shape("menger-sponge"), 243)
    >>> 1e6 < found.voxels < 1e7
    True
    """
    frame = frame_around(model, resolution, pitch)
    return growth(model, frame, depth).at(max(frame.size))


def growth(model: Model, frame: Frame, depth: int | None = None) -> Law:
    """The law behind `estimate`, counted for a shape."""
    longest = frame.pitch * max(frame.size)
    counts, reach = [], 0.0
    for resolution in (COUNTED // 2, COUNTED):
        grid = frame_around(model, resolution)
        subject = in_grid(model, grid)
        found = walked(subject, grid, 1.0, depth, TOLERANCE, lambda share, seen: None)
        counts.append((found.tree.count, faces_of(found.tree)))
        reach, dimension = found.reach, subject.dimension
    (fewer, fewer_faces), (voxels, faces) = counts
    solid = math.inf if depth is None else COUNTED * math.sqrt(3) / max(reach, 1e-300)
    power = _power(fewer, voxels, dimension)
    known = _known(model)
    if depth is None and known is not None and known <= dimension:
        power = known
    sides = tuple(n / max(frame.size) for n in frame.size)
    return Law(
        COUNTED,
        voxels,
        faces,
        power,
        min(_power(fewer_faces, faces, dimension), power),
        solid,
        dimension,
        longest,
        (sides[0], sides[1], sides[2]),
    )


def fitted(model: Model, frame: Frame, budget: Budget, depth: int | None = None) -> tuple[Frame, Prediction]:
    """The frame, or the finest coarser one that a budget allows, and its prediction. Raises `OverBudget`."""
    law = growth(model, frame, depth)
    resolution = max(frame.size)
    prediction = law.at(resolution)
    if not budget.broken(prediction):
        return frame, prediction
    low, high = 0, resolution
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if budget.broken(law.at(middle)) else (middle, high)
    if budget.exceeded == "refuse" or not low:
        raise OverBudget(prediction, budget, low or None)
    return frame_around(model, low), law.at(low)


def faces_of(tree: Tree) -> int:
    """How many faces of black voxels have white on the other side."""
    padded = np.pad(to_array(tree), 1)
    return sum(int(np.count_nonzero(np.diff(padded.view(np.int8), axis=axis))) for axis in range(3))


def _power(fewer: int, more: int, dimension: int) -> float:
    return min(max(math.log2(more / fewer), 0.0), float(dimension))


def _known(model: Model) -> float | None:
    from ifs.dimensions.dimension import similarity_dimension

    return similarity_dimension(model) if isinstance(model, Shape) else None


def _amount(name: str, amount: int) -> str:
    return _bytes(amount) if name in ("memory", "file") else f"{amount:.3g} {name}"


def _bytes(amount: int) -> str:
    for unit in ("B", "kB", "MB", "GB"):
        if amount < 1000:
            return f"{amount:.3g} {unit}"
        amount = round(amount / 1000) if amount >= 1_000_000 else amount / 1000  # type: ignore[assignment]
    return f"{amount:.3g} TB"
