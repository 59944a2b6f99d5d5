"""Diagrams of boxes, arrows and words, written as PNG or as SVG."""

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from xml.sax.saxutils import escape

import numpy as np
from jaxtyping import Float

from bcifs.paint import Sheet, width_of
from bcifs.palette import PAPER
from bcifs.png import write_png
from export.formats.atomic import whole_file

HEAD = 11.0  # length of an arrow's head, pixels

Positions = Float[np.ndarray, "n 2"]


@dataclass(frozen=True)
class Stroke:
    """A line through places, with a head at its end where asked."""

    places: Positions
    colour: str
    width: float = 2.0
    dashed: bool = False
    head: bool = False


@dataclass(frozen=True)
class Words:
    """A text whose middle, or left end, is at a place; it stands on a patch of paper."""

    x: float
    y: float
    text: str
    size: float
    colour: str
    anchor: str = "mm"
    patch: bool = False


@dataclass(frozen=True)
class Box:
    """A rounded rectangle round its middle."""

    x: float
    y: float
    width: float
    height: float
    fill: str
    edge: str


@dataclass(frozen=True)
class Diagram:
    """What is drawn, in this order, on `width` x `height` pixels."""

    width: int
    height: int
    parts: tuple[Stroke | Words | Box, ...]


def curve(*corners: tuple[float, float]) -> Positions:
    """A Bezier curve of these 3 or 4 control points, as a line through 33 places."""
    t = np.linspace(0, 1, 33)[:, None]
    degree = len(corners) - 1
    weights = [math.comb(degree, k) * t**k * (1 - t) ** (degree - k) for k in range(degree + 1)]
    return sum((w * np.array(c, float) for w, c in zip(weights, corners, strict=True)), np.zeros((33, 2)))


def write_diagram(diagram: Diagram, path: str | os.PathLike[str], recipe: Mapping[str, str]) -> None:
    """Write a diagram as .svg, or as .png for any other ending; the recipe goes into the file."""
    if Path(path).suffix.lower() == ".svg":
        with whole_file(path) as file:
            file.write(svg(diagram, recipe).encode())
    else:
        write_png(painted(diagram), path, recipe)


def painted(diagram: Diagram):
    """The picture in Pillow."""
    sheet = Sheet(diagram.width, diagram.height)
    for part in diagram.parts:
        match part:
            case Stroke(places, colour, width, dashed, head):
                line = _shortened(places) if head else places
                (sheet.dashes if dashed else sheet.line)(line, colour, width)
                if head:
                    sheet.polygon(_head(places), colour)
            case Words(x, y, text, size, colour, anchor, patch):
                if patch:
                    half = width_of(text, size) / 2 + 4
                    sheet.box((x - half, y - size * 0.62), (x + half, y + size * 0.62), PAPER)
                sheet.text(x, y, text, size, colour, anchor)
            case Box(x, y, width, height, fill, edge):
                low, high = (x - width / 2, y - height / 2), (x + width / 2, y + height / 2)
                sheet.box(low, high, fill, edge, 12)
    return sheet.finished()


def svg(diagram: Diagram, recipe: Mapping[str, str]) -> str:
    """The SVG text."""
    size = f'width="{diagram.width}" height="{diagram.height}" viewBox="0 0 {diagram.width} {diagram.height}"'
    rows = [f'<svg xmlns="http://www.w3.org/2000/svg" {size} font-family="sans-serif">']
    notes = escape("\n".join(f"{key}: {value}" for key, value in recipe.items()))
    rows += [f"<desc>{notes}</desc>", f'<rect width="100%" height="100%" fill="{PAPER}"/>']
    for part in diagram.parts:
        match part:
            case Stroke(places, colour, width, dashed, head):
                line = _shortened(places) if head else places
                dash = ' stroke-dasharray="6 6"' if dashed else ""
                rows.append(
                    f'<path fill="none" stroke="{colour}" stroke-width="{width:g}"{dash} d="{_path(line)}"/>'
                )
                if head:
                    rows.append(f'<path fill="{colour}" d="{_path(_head(places))}Z"/>')
            case Words(x, y, text, size_, colour, anchor, patch):
                align = {"l": "start", "m": "middle", "r": "end"}[anchor[0]]
                halo = f' stroke="{PAPER}" stroke-width="6" paint-order="stroke"' if patch else ""
                rows.append(
                    f'<text x="{x:.1f}" y="{y + 0.35 * size_:.1f}" font-size="{size_:g}" fill="{colour}" '
                    f'text-anchor="{align}"{halo}>{escape(text)}</text>'
                )
            case Box(x, y, width, height, fill, edge):
                rows.append(
                    f'<rect x="{x - width / 2:.1f}" y="{y - height / 2:.1f}" width="{width:.1f}" '
                    f'height="{height:.1f}" rx="12" fill="{fill}" stroke="{edge}" stroke-width="1.5"/>'
                )
    return "\n".join([*rows, "</svg>\n"])


def _shortened(places: Positions) -> Float[np.ndarray, "fewer 2"]:
    """The line without the part that its head covers."""
    gaps = np.linalg.norm(places - places[-1], axis=1)
    kept = places[gaps > HEAD * 0.8]
    last = places[-1] + HEAD * 0.8 * _backwards(places)
    return np.vstack([kept, last])


def _head(places: Positions) -> Float[np.ndarray, "3 2"]:
    back = _backwards(places)
    side = np.array([-back[1], back[0]])
    foot = places[-1] + HEAD * back
    return np.stack([places[-1], foot + 0.42 * HEAD * side, foot - 0.42 * HEAD * side])


def _backwards(places: Positions) -> Float[np.ndarray, "2"]:
    """The unit vector from the end towards where the line comes from."""
    gaps = np.linalg.norm(places - places[-1], axis=1)
    far = np.flatnonzero(gaps >= min(HEAD, gaps.max()))[-1]
    return (places[far] - places[-1]) / gaps[far]


def _path(places: Positions) -> str:
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in places)
