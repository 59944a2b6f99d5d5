"""Pictures of plane meshes, painted here: PNG through Pillow, and SVG."""

import os
from collections.abc import Mapping
from pathlib import Path
from xml.sax.saxutils import escape

import numpy as np
from jaxtyping import Float

from bcifs.palette import INK, PAPER
from bcifs.png import write_png
from bcifs.strokes import strokes
from bcifs.view import Sheet, sheet
from export.formats.atomic import whole_file
from ifs import Mesh

STROKE = 3.2  # pixels
DOT = 1.6  # radius, pixels
FINER = 3  # each pixel is painted as 3 x 3

Positions = Float[np.ndarray, "n 2"]


def write_flat(mesh: Mesh, path: str | os.PathLike[str], recipe: Mapping[str, str]) -> None:
    """Draw a plane mesh (two coordinates): curves as strokes, faces filled, points as dots."""
    page = sheet(mesh.vertices)
    if Path(path).suffix.lower() == ".svg":
        with whole_file(path) as file:
            file.write(svg(mesh, page, recipe).encode())
    else:
        write_png(_painted(mesh, page), path, recipe)


def svg(mesh: Mesh, page: Sheet, recipe: Mapping[str, str]) -> str:
    """The SVG text: one path for all faces, one for all strokes, one for all dots."""
    places = page.place(mesh.vertices)
    polygons, lines, dots = parts(mesh)
    head = f'width="{page.width}" height="{page.height}" viewBox="0 0 {page.width} {page.height}"'
    rows = [f'<svg xmlns="http://www.w3.org/2000/svg" {head}>']
    if "Name" in recipe:
        rows.append(f"<title>{escape(recipe['Name'])}</title>")
    notes = escape("\n".join(f"{key}: {value}" for key, value in recipe.items()))
    rows.append(f"<desc>{notes}</desc>")
    rows.append(f'<rect width="100%" height="100%" fill="{PAPER}"/>')
    if polygons:
        rows.append(f'<path fill="{INK}" d="{"".join(_path(places[p], True) for p in polygons)}"/>')
    style = f'fill="none" stroke="{INK}" stroke-linecap="round" stroke-linejoin="round"'
    if lines:
        curve = "".join(_path(places[line], bool(line[0] == line[-1])) for line in lines)
        rows.append(f'<path {style} stroke-width="{STROKE:g}" d="{curve}"/>')
    if len(dots):
        spots = "".join(f"M{x:.2f} {y:.2f}h0" for x, y in places[dots])
        rows.append(f'<path {style} stroke-width="{2 * DOT:g}" d="{spots}"/>')
    return "\n".join([*rows, "</svg>\n"])


def parts(mesh: Mesh) -> tuple[list[np.ndarray], list[np.ndarray], np.ndarray]:
    """The vertex numbers of the polygons, of the strokes, and of the single points."""
    corners = (mesh.faces >= 0).sum(axis=1)
    polygons = [face[face >= 0] for face in mesh.faces[corners > 2]]
    segments = mesh.faces[corners == 2][:, :2]
    return polygons, strokes(segments), mesh.faces[corners == 1][:, 0]


def _path(places: Positions, closed: bool) -> str:
    end = len(places) - 1 if closed and (places[0] == places[-1]).all() else len(places)
    return "M" + "L".join(f"{x:.2f} {y:.2f}" for x, y in places[:end]) + ("Z" if closed else "")


def _painted(mesh: Mesh, page: Sheet):
    """The picture in Pillow: a mask painted finer, averaged down, between the colours of paper and ink."""
    from PIL import Image, ImageDraw

    mask = Image.new("L", (page.width * FINER, page.height * FINER), 0)
    brush = ImageDraw.Draw(mask)
    places = page.place(mesh.vertices) * FINER
    polygons, lines, dots = parts(mesh)
    for polygon in polygons:
        brush.polygon(_pairs(places[polygon]), fill=255)
    radius = STROKE * FINER / 2
    for line in lines:
        brush.line(_pairs(places[line]), fill=255, width=round(2 * radius), joint="curve")
        _discs(brush, places[line[[0, -1]]], radius)
    _discs(brush, places[dots], DOT * FINER)
    paper = Image.new("RGB", (page.width, page.height), PAPER)
    paper.paste(INK, (0, 0, page.width, page.height), mask.reduce(FINER))
    return paper


def _discs(brush, places: Positions, radius: float) -> None:
    for x, y in places:
        brush.ellipse((x - radius, y - radius, x + radius, y + radius), fill=255)


def _pairs(places: Positions) -> list[tuple[float, float]]:
    return [(float(x), float(y)) for x, y in places]
