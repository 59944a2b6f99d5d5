"""Pictures of densities: clouds in space with light and shadow, plane densities as shades."""

import os
from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from bcifs.palette import CLAY, INK, PAPER
from bcifs.png import write_png
from bcifs.view import Sheet, axes, seen, sheet
from ifs.measures.grid import Density

FINENESS = 1.4  # samples for each cell, across and in depth
SLANT = (-0.45, 0.35)  # how far light drifts along x and y while it falls by 1
DARK, THICK = 9.0, 14.0  # how strongly shadow and matter take light, over the size of the cloud
BRIGHT, GAMMA = "#dbe9f1", 0.5


def write_cloud(
    density: Density, path: str | os.PathLike[str], recipe: Mapping[str, str] | None = None
) -> None:
    """Draw a density (mm) as PNG: in space lit from above and seen as meshes are, in the plane as shades.

    Matter takes light in proportion to its density, relative to the largest one; what light is left where it
    stands is its brightness. `ValueError` for a density without mass or with negative amounts.

    >>> import pathlib, tempfile
    >>> from ifs import shape
    >>> from ifs.measures.density import density
    >>> place = pathlib.Path(tempfile.mkdtemp()) / "triangle.png"
    >>> write_cloud(density(shape("sierpinski-triangle"), 16), place)
    >>> place.stat().st_size > 1000
    True
    """
    from PIL import Image

    amounts = density.amounts
    if not np.isfinite(amounts).all() or amounts.min() < 0 or not amounts.max() > 0:
        raise ValueError("a picture needs amounts that are finite, 0 or more, and not all 0")
    shares = (amounts / amounts.max()).astype(np.float32)
    colours = _shades(density, shares) if amounts.ndim == 2 else _cloud(density, shares)
    pixels = np.rint(np.clip(colours, 0, 1) * 255).astype(np.uint8)
    page = _page(density)
    picture = Image.fromarray(pixels).resize((page.width, page.height), Image.Resampling.BICUBIC)
    write_png(picture, path, recipe or {})


def _page(density: Density) -> Sheet:
    if density.amounts.ndim == 2:
        return sheet(_corners(density))
    centres = density.grid.origin + density.grid.pitch * (np.argwhere(density.amounts > 0) + 0.5)
    right, up, _ = axes(_corners(density))
    return sheet(centres @ np.stack([right, up], axis=1))


def _corners(density: Density) -> Float[np.ndarray, "corners dim"]:
    """The corners of the box around all cells with mass."""
    sides = []
    for axis in range(density.amounts.ndim):
        others = tuple(other for other in range(density.amounts.ndim) if other != axis)
        there = np.flatnonzero(density.amounts.max(axis=others) > 0)
        ends = np.array([there[0], there[-1] + 1])
        sides.append(density.grid.origin[axis] + density.grid.pitch * ends)
    return np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1).reshape(-1, len(sides))


def _shades(density: Density, shares: Float[np.ndarray, "x y"]) -> Float[np.ndarray, "rows columns 3"]:
    """Each pixel has the shade of its cell: from paper through clay to ink, by the power 1/2 of the mass."""
    page = _page(density)
    x = page.centre[0] + (np.arange(page.width) + 0.5 - page.width / 2) / page.scale
    y = page.centre[1] - (np.arange(page.height) + 0.5 - page.height / 2) / page.scale
    places = [
        np.floor((along - low) / density.grid.pitch).astype(np.int64)
        for along, low in zip((x, y), density.grid.origin, strict=True)
    ]
    held = [(place >= 0) & (place < size) for place, size in zip(places, shares.shape, strict=True)]
    cells = np.ix_(*(np.clip(place, 0, size - 1) for place, size in zip(places, shares.shape, strict=True)))
    values = (shares[cells] * (held[0][:, None] & held[1])).T ** GAMMA
    return _ramp(values, (PAPER, CLAY, INK))


def _cloud(density: Density, shares: Float[np.ndarray, "x y z"]) -> Float[np.ndarray, "rows columns 3"]:
    """Slices across the direction of view, the farthest first, each laid over those behind it."""
    from scipy.ndimage import map_coordinates

    grid, corners, page = density.grid, _corners(density), _page(density)
    right, up, towards = axes(corners)
    size = float(np.ptp(corners, axis=0).max())
    step = grid.pitch / FINENESS
    width, height = (max(2, round(side / page.scale / step)) for side in (page.width, page.height))
    across = page.centre[0] + (np.arange(width) + 0.5 - width / 2) * step
    upwards = page.centre[1] - (np.arange(height) + 0.5 - height / 2) * step
    sheet_points = upwards[:, None, None] * up + across[None, :, None] * right
    light = _light(shares, grid.pitch / size)
    result = np.empty((height, width, 3))
    result[:] = _rgb(PAPER)
    depths = seen(corners)[:, 2]
    for depth in np.arange(depths.min(), depths.max(), step):
        places = np.moveaxis((sheet_points + depth * towards - grid.origin) / grid.pitch - 0.5, -1, 0)
        here = map_coordinates(shares, places, order=1)
        if not here.any():
            continue
        opacity = 1 - np.exp(-THICK * step / size * here)[..., None]
        colours = _ramp(map_coordinates(light, places, order=1, mode="nearest"), (INK, CLAY, BRIGHT))
        result += opacity * (colours - result)
    return result


def _light(shares: Float[np.ndarray, "x y z"], pitch: float) -> Float[np.ndarray, "x y z"]:
    """How much of the light that falls from above on a slant is left in each cell."""
    from scipy.ndimage import shift

    result = np.empty_like(shares)
    left = np.ones(shares.shape[:2], dtype=np.float32)
    for k in range(shares.shape[2] - 1, -1, -1):
        result[:, :, k] = left
        left = shift(left * np.exp(-DARK * pitch * shares[:, :, k]), SLANT, order=1, cval=1.0)
    return result


def _ramp(values: Float[np.ndarray, "rows columns"], colours: tuple[str, ...]) -> np.ndarray:
    stops = np.linspace(0, 1, len(colours))
    table = np.array([_rgb(colour) for colour in colours])
    return np.stack([np.interp(values, stops, channel) for channel in table.T], axis=-1)


def _rgb(colour: str) -> tuple[float, float, float]:
    red, green, blue = (int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return red, green, blue
