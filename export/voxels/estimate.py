"""What a voxelisation will take, told before it is done, and budgets that refuse or coarsen it."""

import math
from dataclasses import dataclass, fields
from fractions import Fraction

import numpy as np

from export.voxels.frame import TOLERANCE, Frame, Model, Subject, frame_around, in_grid, subject
from export.voxels.level import at_depth
from export.voxels.piece_walk import BLOCK, FLAT, walked
from trees import Tree, to_array

COUNTED = 128
"""Voxels along the longest side, at most, of the grids in which a shape is counted."""

_COUNTED_SOLID = 256  # as above, for the figures of a level, which are quickly counted
_TOLD = 2  # voxels along a figure from which on its content and its border are told apart
_SOLID = 12  # voxels along a figure from which on nearly all of what it meets is its content
_ENTRY = 16  # bytes of an entry of a tree
_ENTRIES = 1.6  # entries for each brick that is met
_TRIANGLE = 32  # bytes of a mesh in memory, with half a vertex, and of what writing it takes
_FILES = {"stl": (84, 50.0), "ply": (300, 25.0), "obj": (0, 47.0), "3mf": (2000, 10.5), "glb": (1000, 18.0)}


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
class Terms:
    """A count of solid figures, by their content and by their border: `most r^power + less r^(power - 1)`."""

    power: int
    most: float
    less: float

    def at(self, resolution: float) -> float:
        return self.most * resolution**self.power + self.less * resolution ** (self.power - 1)


@dataclass(frozen=True)
class Law:
    """How counts grow with the resolution: as a power, and as that of a solid once pieces exceed voxels.

    `counted` voxels and `faces` at the resolution `base`, along the longest of sides in the proportions
    `sides`; from the resolution `solid` on volumes grow by `dimension`, faces by one less. `terms`, of voxels
    and of faces, take the place of the powers for the figures of a level that are two voxels or more.
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
    terms: tuple[Terms, Terms] | None = None

    def at(self, resolution: int) -> Prediction:
        """The estimates for a resolution."""
        voxels = self._voxels(resolution)
        faces = self._grown(self.faces, self.face_power, self.dimension - 1, resolution)
        if self.terms:
            faces = self.terms[1].at(resolution)
        if self.dimension < 3:  # the two large faces of one layer
            faces = max(faces, 2 * voxels)
        triangles = round(2 * faces)
        size = [max(math.ceil(side * resolution - TOLERANCE), 1) for side in self.sides]
        cube = 2 ** (3 * max((max(size) - 1).bit_length(), 2)) // 8
        bricks = self._voxels(max(resolution / 4, 1))
        kept = min(cube, round(_ENTRY * _ENTRIES * bricks) + 64)
        flat = _flat(size)
        files = {name: round(head + each * triangles) for name, (head, each) in _FILES.items()}
        return Prediction(
            resolution,
            self.longest / resolution,
            round(voxels),
            triangles,
            flat + 3 * kept if kept < cube else flat,
            round(triangles * _TRIANGLE),
            files,
        )

    def _voxels(self, resolution: float) -> float:
        if self.terms:
            return self.terms[0].at(resolution)
        return self._grown(self.counted, self.voxel_power, self.dimension, resolution)

    def _grown(self, count: int, power: float, solid_power: int, resolution: float) -> float:
        turn = max(self.solid, self.base)
        grown = count * (min(resolution, turn) / self.base) ** power
        return grown * (resolution / turn) ** solid_power if resolution > turn else grown


def _flat(size: list[int]) -> int:
    """Bytes of the rows and bricks that a walk fills."""
    bits = sum(max((n - 1).bit_length(), 2) for n in size)
    if bits > FLAT:
        return 2 << BLOCK - 3
    a, b, along = sorted(size)
    return 8 * a * b * -(-along // 64) + (1 << bits) // 8


def estimate(
    model: Model, resolution: int | None = None, *, pitch: float | None = None, depth: int | None = None
) -> Prediction:
    """What voxelising a shape at a resolution, or with a pitch in mm, will take.

    The voxels and their faces are counted in grids of up to 128 voxels along the longest side, in which
    pieces lie as they do in the grid that is asked for, and grow from there by the power between two of
    them; the voxels of a shape whose pieces are scaled copies grow by its similarity dimension. The boxes of
    the pieces of a `depth` are solids from voxels of their size on. Both numbers are right within a factor of
    1.5 for the built-in shapes; where the grid fits a fractal and the counted ones do not, the greater is
    told.

    Raises what `export.voxels.voxelise` raises.

    >>> import ifs
    >>> found = estimate(ifs.shape("menger-sponge"), 243)
    >>> 1e6 < found.voxels < 1e7
    True
    """
    found, depth = at_depth(subject(model), model, depth)
    frame = frame_around(found, resolution, pitch)
    return growth(found, frame, depth).at(max(frame.size))


def growth(model: Model | Subject, frame: Frame, depth: int | None = None) -> Law:
    """The law behind `estimate`, counted for a shape."""
    found = subject(model)
    resolution = max(frame.size)
    longest = frame.pitch * resolution
    finer = _coarser(resolution, _ratio(found), _COUNTED_SOLID if found.grain else COUNTED)
    counts = [_counted(found, base, depth) for base in finer]
    base, (voxels, faces, reach) = finer[0], counts[0]
    power, face_power = (_power(finer, counts, which, found.dimension) for which in (0, 1))
    known = _known(found)
    if depth is None and known is not None and known <= found.dimension:
        power = known
    face_power = min(face_power, power)
    for other, (more, more_faces, _) in zip(finer[2:], counts[2:], strict=True):
        voxels = max(voxels, round(more * (base / other) ** power))
        faces = max(faces, round(more_faces * (base / other) ** face_power))
    solid = math.inf if depth is None else base * math.sqrt(3) / max(reach, 1e-300)
    if found.grain:
        solid = _SOLID * longest / max(found.grain[0], 1e-300)
    sides = tuple(n / resolution for n in frame.size)
    return Law(
        base,
        voxels,
        faces,
        power,
        face_power,
        solid,
        found.dimension,
        longest,
        (sides[0], sides[1], sides[2]),
        _terms(found, finer[:2], counts, longest),
    )


def _terms(
    found: Subject, finer: list[int], counts: list[tuple[int, int, float]], longest: float
) -> tuple[Terms, Terms] | None:
    """The two terms of voxels and faces of a level's figures, where they are large enough to tell them."""
    if not found.grain or finer[0] == finer[1] or found.grain[0] * min(finer) < _TOLD * longest:
        return None
    power = found.grain[1]
    face_power = max(power - 1, 1) if power == found.dimension else power
    voxels, faces = [count[0] for count in counts[:2]], [count[1] for count in counts[:2]]
    return _two_terms(power, finer, voxels), _two_terms(face_power, finer, faces)


def _two_terms(power: int, sides: list[int], counts: list[int]) -> Terms:
    """The terms through two counts, neither below 0."""
    (r, s), (p, q) = sides, (n / side ** (power - 1) for n, side in zip(counts, sides, strict=True))
    most = min(max((p - q) / (r - s), 0.0), p / r)
    return Terms(power, most, p - most * r)


def _ratio(found: Subject) -> Fraction:
    """By how much pieces of a size keep their places in a grid: what pieces shrink by, else a half."""
    radii = set()
    for state in found.system.states.values():
        for target, operator in zip(state.targets, state.operators, strict=True):
            if target == state.name and state.points > 1:
                linear = (operator[:, :-1] - operator[:, -1:])[:-1]
                radii.add(round(float(np.abs(np.linalg.eigvals(linear)).max()), 6))
    ratio = Fraction(radii.pop() if len(radii) == 1 else 0.5).limit_denominator(16)
    return ratio if Fraction(1, 5) <= ratio <= Fraction(1, 2) else Fraction(1, 2)


def _coarser(resolution: int, ratio: Fraction, most: int = COUNTED) -> list[int]:
    """Resolutions to count at: one in which pieces lie as in the given one, one coarser, others.

    Where the first is no whole number those on both sides of it are counted.
    """
    steps = max(math.ceil(math.log(max(resolution, 1) / most) / -math.log(ratio) - 1e-9), 0)
    first = resolution * ratio**steps
    near = [max(round(first), 1), max(round(first * ratio), 1)]
    if first != near[0]:
        near += [each for each in {math.floor(first), math.ceil(first)} if each not in near]
    return near


def _counted(found: Subject, resolution: int, depth: int | None) -> tuple[int, int, float]:
    """Voxels, faces between black and white, and the longest diagonal of a filled box in voxels."""
    grid = frame_around(found, resolution)
    done = walked(in_grid(found, grid), grid, 1.0, depth, TOLERANCE, lambda share, seen: None)
    return done.tree.count, faces_of(done.tree), done.reach


def fitted(
    model: Model | Subject, frame: Frame, budget: Budget, depth: int | None = None
) -> tuple[Frame, Prediction]:
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


def _power(sides: list[int], counts: list[tuple[int, int, float]], which: int, dimension: int) -> float:
    """The power by which counts grow from the second resolution to the first."""
    if sides[0] == sides[1]:
        return float(dimension)
    power = math.log(counts[0][which] / counts[1][which]) / math.log(sides[0] / sides[1])
    return min(max(power, 0.0), float(dimension))


def _known(found: Subject) -> float | None:
    from ifs.dimensions.dimension import similarity_dimension

    return similarity_dimension(found.shape) if found.shape is not None else None


def _amount(name: str, amount: int) -> str:
    return _bytes(amount) if name in ("memory", "file") else f"{amount:.3g} {name}"


def _bytes(amount: int) -> str:
    for unit in ("B", "kB", "MB", "GB"):
        if amount < 1000:
            return f"{amount:.3g} {unit}"
        amount = round(amount / 1000) if amount >= 1_000_000 else amount / 1000  # type: ignore[assignment]
    return f"{amount:.3g} TB"
