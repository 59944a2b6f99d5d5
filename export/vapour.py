"""Vaporous shapes: from a few solid models to a density that lies between them."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool

from export.files import weld
from export.inside import EmptyModel, box_of, inside
from ifs.measures.grid import Density, Grid, TooManyCells, grid_around
from ifs.medians.condensation import coverage
from ifs.medians.perturbed import largest_move, perturbed
from ifs.mesh import Mesh

if TYPE_CHECKING:
    import trimesh
    from build123d.topology import Shape as Solid

    Model = Mesh | trimesh.Trimesh | Solid
else:
    Model = object

Progress = Callable[[str, float], None]

MOST_CELLS = 1 << 26  # about 70 bytes are needed for each
_ONE_MODEL = (2 / 3, 1 / 3)
_AMOUNT = 0.03  # of the longest side
_WAVE = 0.4
_FACETS = 0.25  # pitches: how far facets may lie from a curved solid


@dataclass(frozen=True, eq=False)
class Vapour:
    """A vaporous shape. `density.amounts / density.grid.cell` is its opacity, from 0 to 1, in each cell.

    The total of the density is the volume, in mm^3, that a set drawn from the measure has on average.
    `models` are the cells of the models, the perturbed one last; `change` says how much the last map applied
    mattered (`ifs.medians.condensation.Coverage`).
    """

    density: Density
    models: tuple[Bool[np.ndarray, "x y z"], ...]
    change: float
    recipe: Mapping[str, str]


def vapour(
    models: "Sequence[Model]",
    probabilities: Sequence[float] | None = None,
    *,
    resolution: int = 96,
    depth: int = 4,
    turning: float = 0.0,
    amount: float | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> Vapour:
    """The measure attractor of the maps that take sets half-way to each of the models.

    Models are closed meshes (`ifs.Mesh`, `trimesh.Trimesh`) or solids of build123d, in mm, in place: what
    lies in all of them becomes dense, what only some have becomes vapour. They are voxelised with
    `resolution` cells along the longest side of the box around them (`export.inside.inside`), and taken by
    `condensation.coverage` with `depth` and `turning` (degrees per mm). `probabilities` weigh the models;
    all alike by default.

    A single model is joined by one that `perturbed.perturbed` makes of it with the seed: `amount` mm of
    displacement in the mean square, by default 3 % of the longest side; the probabilities are 2/3 and 1/3 by
    default. `progress(message, share)` is told. The same arguments give the same density.

    Raises `EmptyModel`, `NotClosed`, `WrongProbabilities`, `TooManyCells` beyond 2^26 cells, `ValueError` for
    numbers out of range and for what is no model. Source: Gentil, §5.2.

    >>> import trimesh
    >>> ball = trimesh.creation.icosphere(3, radius=10)
    >>> box = trimesh.creation.box((14, 14, 14))
    >>> cloud = vapour([ball, box], [0.75, 0.25], resolution=20)
    >>> opacity = cloud.density.amounts / cloud.density.grid.cell
    >>> float(opacity[12, 12, 12].round(9)), bool(0 < opacity.min() < 1)
    (1.0, False)
    """
    tell = progress or (lambda message, share: None)
    if not 1 <= resolution <= 2000 or depth < 0:
        raise ValueError(
            f"the resolution lies in 1 … 2000, the depth is 0 or more; found {resolution}, {depth}"
        )
    if not len(models):
        raise EmptyModel("there is no model; give one at least")
    if not math.isfinite(turning):
        raise ValueError(f"the turning is a finite number of degrees per mm; found {turning}")
    alone = len(models) == 1
    chances = probabilities
    if chances is None:
        chances = _ONE_MODEL if alone else [1 / len(models)] * len(models)
    tell("models", 0.0)
    meshes = [_mesh(model, k, resolution) for k, model in enumerate(models)]
    low, high = box_of(meshes)
    pitch = float((high - low).max()) / resolution
    move = (_AMOUNT * resolution if amount is None else amount / pitch) if alone else 0.0
    wave = _WAVE * resolution
    margin = math.ceil(largest_move(seed, move, wave)) + 1 if alone else 1
    grid = grid_around(low, high, resolution, margin)
    if math.prod(grid.size) > MOST_CELLS:
        raise TooManyCells(math.prod(grid.size), MOST_CELLS)
    cells = []
    for k, mesh in enumerate(meshes):
        cells.append(_filled(mesh, grid, k))
        tell("models", (k + 1) / len(meshes))
    if alone:
        cells.append(perturbed(cells[0], seed, move, wave))
        if not cells[1].any():
            raise EmptyModel("the perturbed model fills no cell; take a smaller amount or a finer resolution")
    found = coverage(cells, chances, depth, turning * grid.pitch, progress)
    recipe = {
        "Models": str(len(models)),
        "Probabilities": ", ".join(f"{float(chance):.6g}" for chance in chances),
        "Resolution": str(resolution),
        "Depth": str(depth),
        "Turning": f"{turning:.6g} degrees per mm",
        **({"Perturbed by": f"{move * grid.pitch:.6g} mm", "Seed": str(seed)} if alone else {}),
        "Application": f"bcifs {version('bcifs')}",
    }
    return Vapour(Density(grid, found.chance * grid.cell), tuple(cells), found.change, recipe)


def _filled(mesh: Mesh, grid: Grid, k: int) -> Bool[np.ndarray, "x y z"]:
    cells = inside(mesh, grid, f"model {k}")
    if not cells.any():
        raise EmptyModel(
            f"model {k} has no centre of a cell inside: cells are {grid.pitch:.3g} mm; take a finer grid"
        )
    return cells


def _mesh(model: "Model", k: int, resolution: int) -> Mesh:
    """The model's triangles, equal positions as one vertex."""
    if isinstance(model, Mesh):
        points, triangles = model.points_3d(), model.triangles()
    elif hasattr(model, "tessellate"):
        box = model.bounding_box()  # pyright: ignore
        facets = _FACETS * max(box.size.X, box.size.Y, box.size.Z, 1e-9) / resolution
        corners, triangles = model.tessellate(facets)  # pyright: ignore
        points = np.array([tuple(corner) for corner in corners], dtype=np.float64).reshape(-1, 3)
    elif hasattr(model, "vertices") and hasattr(model, "faces"):
        points, triangles = np.asarray(model.vertices, dtype=np.float64), model.faces  # pyright: ignore
    else:
        raise ValueError(f"model {k} is a {type(model).__name__}; give a mesh or a solid of build123d")
    triangles = np.asarray(triangles, dtype=np.int64).reshape(-1, 3)
    if not len(triangles):
        raise EmptyModel(f"model {k} has no faces")
    if not np.isfinite(points).all():
        raise EmptyModel(f"model {k} has vertices that are not finite")
    return weld(Mesh(points, triangles))
