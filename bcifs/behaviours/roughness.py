"""Roughness maps as pictures: pieces coloured by their local order, with a scale."""

import itertools
import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from jaxtyping import Int

from bcifs.behaviours.svg import SvgSheet
from bcifs.paint import Sheet
from bcifs.palette import INK, PAPER
from bcifs.picture import WrongPicture
from bcifs.png import write_png
from bcifs.view import Sheet as Page
from bcifs.view import seen, sheet
from fld.roughness import Roughness

ROUGH_TO_SMOOTH = ("#8c1f3f", "#d4603a", "#f0b867", "#8fc1b5", "#2f6f9f", "#1d3f66")
MISSING = "#c9c9c4"
LEVELS = 48
STRIP, BAR = 96, 520
_ALIKE = 1e-6


def draw_roughness(
    found: Roughness, path: str | os.PathLike[str], recipe: Mapping[str, str] | None = None
) -> None:
    """Draw a map of local orders into a PNG file, that of a curve into an SVG file too.

    Colours run from dark red, the least order, to dark blue, the largest; pieces without an order are grey.
    Below stands the scale. Raises `WrongPicture` for another ending, for faces as SVG, and for more than
    three coordinates.

    >>> import pathlib, tempfile, ifs
    >>> from fld.roughness import roughness
    >>> place = pathlib.Path(tempfile.mkdtemp()) / "map.svg"
    >>> draw_roughness(roughness(ifs.shape("koch-curve"), 4), place)
    >>> place.read_text()[:4]
    '<svg'
    """
    ending = Path(path).suffix.lower()
    is_curve = found.mesh.faces.shape[1] == 2
    if ending not in ((".png", ".svg") if is_curve else (".png",)):
        raise WrongPicture(f"{path}: draw curves as .png or .svg, surfaces as .png")
    if found.mesh.vertices.shape[1] > 3:
        raise WrongPicture(f"a picture needs 1 to 3 coordinates; here are {found.mesh.vertices.shape[1]}")
    points = found.mesh.points_3d()
    flat = points[:, :2] if np.ptp(points[:, 2]) == 0 else seen(points)[:, :2]
    page = sheet(flat)
    levels = levels_of(found)
    notes = recipe or {}
    if not is_curve:
        whole = Sheet(page.width, page.height + STRIP)
        _scale(whole, page, found)
        picture = whole.finished()
        picture.paste(_rendered(found, page, levels), (0, 0))
        write_png(picture, path, notes)
        return
    drawing = (SvgSheet if ending == ".svg" else Sheet)(page.width, page.height + STRIP)
    places = page.place(flat)
    for start, end in _runs(levels):
        drawing.line(places[start : end + 1], colours()[levels[start]], 4.0)
    _scale(drawing, page, found)
    if isinstance(drawing, SvgSheet):
        drawing.write(path, notes)
    else:
        write_png(drawing.finished(), path, notes)


def colours() -> list[str]:
    """The colours of the levels, least order first, and that of a missing order last."""
    stops = np.array([[int(c[k : k + 2], 16) for k in (1, 3, 5)] for c in ROUGH_TO_SMOOTH], float)
    at = np.linspace(0, len(stops) - 1, LEVELS)
    mixed = np.column_stack([np.interp(at, np.arange(len(stops)), stops[:, k]) for k in range(3)])
    return ["#" + "".join(f"{round(v):02x}" for v in row) for row in mixed] + [MISSING]


def levels_of(found: Roughness) -> Int[np.ndarray, "pieces"]:
    """The number of each piece's colour; the largest one where all orders are alike.

    >>> import ifs
    >>> from fld.roughness import roughness
    >>> set(levels_of(roughness(ifs.shape("corner-cutting"), 3)).tolist())
    {47}
    """
    low, high = _range(found)
    if high - low <= _ALIKE:
        result = np.full(len(found.orders), LEVELS - 1)
    else:
        share = np.nan_to_num((found.orders - low) / (high - low))
        result = np.clip((share * LEVELS).astype(int), 0, LEVELS - 1)
    return np.where(np.isfinite(found.orders), result, LEVELS)


def _range(found: Roughness) -> tuple[float, float]:
    known = found.orders[np.isfinite(found.orders)]
    return (float(known.min()), float(known.max())) if len(known) else (1.0, 1.0)


def _runs(levels: Int[np.ndarray, "pieces"]) -> list[tuple[int, int]]:
    cuts = [0, *(np.flatnonzero(np.diff(levels)) + 1).tolist(), len(levels)]
    return list(itertools.pairwise(cuts))


def _scale(drawing: Sheet | SvgSheet, page: Page, found: Roughness) -> None:
    low, high = _range(found)
    x, y = page.width / 2 - BAR / 2, page.height + 18.0
    if high - low <= _ALIKE:
        drawing.text(page.width / 2, y + 12, f"local order {high:.6g} everywhere", 22, INK, "mm")
        return
    step = BAR / LEVELS
    for level, colour in enumerate(colours()[:LEVELS]):
        start = x + level * step
        drawing.box((start, y), (start + step + 0.5, y + 22), colour)
    drawing.text(x - 14, y + 11, f"rough {low:.4g}", 20, INK, "rm")
    drawing.text(x + BAR + 14, y + 11, f"{high:.4g} smooth", 20, INK, "lm")
    drawing.text(page.width / 2, y + 52, "local order", 18, INK, "mm")


def _rendered(found: Roughness, page: Page, levels: Int[np.ndarray, "pieces"]):
    """The surface in Pillow, shaded as other surfaces are, each face in its colour."""
    import pyvista
    from PIL import Image
    from vtkmodules.vtkCommonCore import vtkLogger

    from bcifs.scene import FINER, _aim, _light

    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_ERROR)
    points = found.mesh.points_3d()
    plotter = pyvista.Plotter(
        off_screen=True, window_size=[page.width * FINER, page.height * FINER], lighting="none"
    )
    try:
        plotter.renderer.set_background(PAPER)
        body = found.mesh.to_pyvista()
        body.cell_data["colour"] = _bytes(levels)
        plotter.add_mesh(body, scalars="colour", rgb=True, ambient=0.35, diffuse=0.75, specular=0.0)
        _light(plotter, points)
        _aim(plotter, points, page)
        pixels = np.asarray(plotter.screenshot(return_img=True))
    finally:
        plotter.close()
    return Image.fromarray(pixels).reduce(FINER)


def _bytes(levels: Int[np.ndarray, "pieces"]) -> np.ndarray:
    table = np.array([[int(c[k : k + 2], 16) for k in (1, 3, 5)] for c in colours()], np.uint8)
    return table[levels]
