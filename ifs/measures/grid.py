"""A grid of equal cells in the plane or in space, and amounts of mass in its cells."""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Real

MOST_CELLS = 1 << 28


class WrongGrid(ValueError):
    """A grid that makes no sense, or that does not hold what is to be put into it."""


class TooManyCells(MemoryError):
    """The grid would not fit in memory; `cells` says how many there would be."""

    def __init__(self, cells: int, most: int = MOST_CELLS):
        self.cells = cells
        super().__init__(f"the grid has {cells:.3g} cells; the limit is {most:.3g}. Take a coarser one")


@dataclass(frozen=True, eq=False)
class Grid:
    """The cells `[origin + pitch i, origin + pitch (i + 1)]`, `i_k = 0 … size_k - 1`; lengths in mm.

    Two or three axes. Raises `WrongGrid`, and `TooManyCells` beyond 2^28 cells.

    >>> Grid(np.zeros(2), 0.5, (4, 2)).high
    array([2., 1.])
    """

    origin: Float[np.ndarray, "dim"]
    pitch: float
    size: tuple[int, ...]

    def __post_init__(self) -> None:
        origin = np.asarray(self.origin, dtype=np.float64)
        if len(self.size) not in (2, 3) or origin.shape != (len(self.size),):
            raise WrongGrid(
                f"a grid has 2 or 3 axes and an origin of as many coordinates; found {self.size}, {origin}"
            )
        if min(self.size) < 1:
            raise WrongGrid(f"each axis has 1 cell or more; found {self.size}")
        if not np.isfinite(origin).all() or not (math.isfinite(self.pitch) and self.pitch > 0):
            raise WrongGrid(
                f"origin and pitch are finite, the pitch above 0 mm; found {origin}, {self.pitch}"
            )
        if math.prod(self.size) > MOST_CELLS:
            raise TooManyCells(math.prod(self.size))
        object.__setattr__(self, "origin", origin)

    @property
    def high(self) -> Float[np.ndarray, "dim"]:
        """The corner opposite the origin, in mm."""
        return self.origin + self.pitch * np.array(self.size)

    @property
    def cell(self) -> float:
        """The area or the volume of a cell, in mm^2 or mm^3."""
        return self.pitch ** len(self.size)


def grid_around(
    low: Real[np.ndarray, "dim"], high: Real[np.ndarray, "dim"], resolution: int, margin: int = 0
) -> Grid:
    """The grid around a box, whose longest side is `resolution` cells, with `margin` cells on all sides.

    Raises `WrongGrid` for a box without extent and for counts out of range, `TooManyCells`.

    >>> grid_around(np.zeros(2), np.array([9, 4]), 9, margin=1).size
    (11, 6)
    """
    if resolution < 1 or margin < 0:
        raise WrongGrid(
            f"the resolution is 1 or more and the margin 0 or more; found {resolution} and {margin}"
        )
    sides = np.asarray(high, dtype=np.float64) - low
    longest = float(sides.max())
    if not (np.isfinite(sides).all() and longest > 0):
        raise WrongGrid(f"a grid needs a box with sides above 0 mm; found sides {sides.tolist()}")
    pitch = longest / resolution
    counts = np.maximum(np.ceil(sides / pitch - 1e-7), 1).astype(int) + 2 * margin
    return Grid((low + high - counts * pitch) / 2, pitch, tuple(counts.tolist()))


@dataclass(frozen=True, eq=False)
class Density:
    """Mass in each cell of a grid.

    `error` bounds (or, if it was sampled, estimates) its total variation distance from what it stands for: no
    set of cells has a mass that is wrong by more.

    `amounts` has the grid's size, `(x, y)` or `(x, y, z)`; mass by mm^2 or mm^3 is `amounts / grid.cell`.
    """

    grid: Grid
    amounts: Float[np.ndarray, "..."]
    error: float = 0.0

    def __post_init__(self) -> None:
        if self.amounts.shape != self.grid.size:
            raise WrongGrid(f"the grid has size {self.grid.size}, the amounts {self.amounts.shape}")

    @property
    def total(self) -> float:
        """All mass."""
        return float(self.amounts.sum(dtype=np.float64))

    @property
    def centroid(self) -> Float[np.ndarray, "dim"]:
        """The centre of mass, in mm, each cell's mass being at its centre. NaN without mass."""
        means = []
        for axis in range(self.amounts.ndim):
            others = tuple(other for other in range(self.amounts.ndim) if other != axis)
            along = self.amounts.sum(axis=others, dtype=np.float64)
            means.append(
                float(along @ (np.arange(len(along)) + 0.5)) / self.total if self.total else math.nan
            )
        return self.grid.origin + self.grid.pitch * np.array(means)
