"""The same sheet as `bcifs.paint` offers, as SVG text."""

import os
from collections.abc import Mapping
from xml.sax.saxutils import escape

import numpy as np
from jaxtyping import Float

from bcifs.palette import PAPER
from export.formats.atomic import whole_file

Positions = Float[np.ndarray, "n 2"]

_ANCHORS = {"l": "start", "m": "middle", "r": "end"}


class SvgSheet:
    """A drawing of `width` x `height` pixels, with those methods of `bcifs.paint.Sheet` that lines need."""

    def __init__(self, width: int, height: int):
        self.width = width
        self.height = height
        self._rows: list[str] = []

    def line(self, places: Positions, colour: str, width: float = 1.0) -> None:
        """A stroke through places, with round corners."""
        self._stroke(places, colour, width, "")

    def dashes(self, places: Positions, colour: str, width: float = 1.0, dash: float = 6.0) -> None:
        """A dashed stroke: dashes and gaps of `dash` pixels."""
        self._stroke(places, colour, width, f' stroke-dasharray="{dash:g}"')

    def polygon(self, places: Positions, colour: str) -> None:
        self._rows.append(f'<path fill="{colour}" d="{_path(places)}Z"/>')

    def disc(
        self, x: float, y: float, radius: float, colour: str, edge: str | None = None, width: float = 1.5
    ) -> None:
        """A filled disc, with an edge of `width` where asked."""
        stroke = f' stroke="{edge}" stroke-width="{width:g}"' if edge else ""
        self._rows.append(f'<circle cx="{x:.2f}" cy="{y:.2f}" r="{radius:g}" fill="{colour}"{stroke}/>')

    def box(
        self,
        low: tuple[float, float],
        high: tuple[float, float],
        colour: str | None,
        edge: str | None = None,
        radius: float = 0.0,
    ) -> None:
        """A rectangle between two corners, rounded by `radius`."""
        stroke = f' stroke="{edge}" stroke-width="1.5"' if edge else ""
        size = f'width="{high[0] - low[0]:.2f}" height="{high[1] - low[1]:.2f}" rx="{radius:g}"'
        self._rows.append(
            f'<rect x="{low[0]:.2f}" y="{low[1]:.2f}" {size} fill="{colour or "none"}"{stroke}/>'
        )

    def text(self, x: float, y: float, words: str, size: float, colour: str, anchor: str = "ls") -> None:
        """Words at a place; `anchor`: l, m or r, then s (baseline) or m (middle)."""
        middle = ' dominant-baseline="central"' if anchor[1] == "m" else ""
        self._rows.append(
            f'<text x="{x:.2f}" y="{y:.2f}" font-family="sans-serif" font-size="{size:g}" fill="{colour}" '
            f'text-anchor="{_ANCHORS[anchor[0]]}"{middle}>{escape(words)}</text>'
        )

    def write(self, path: str | os.PathLike[str], recipe: Mapping[str, str]) -> None:
        """Write the drawing, its recipe in the description. Whole or not at all."""
        notes = escape("\n".join(f"{key}: {value}" for key, value in recipe.items()))
        size = f'width="{self.width}" height="{self.height}" viewBox="0 0 {self.width} {self.height}"'
        rows = [
            f'<svg xmlns="http://www.w3.org/2000/svg" {size}>',
            f"<title>{escape(recipe.get('Name', ''))}</title>",
            f"<desc>{notes}</desc>",
            f'<rect width="100%" height="100%" fill="{PAPER}"/>',
            *self._rows,
            "</svg>\n",
        ]
        with whole_file(path) as file:
            file.write("\n".join(rows).encode())

    def _stroke(self, places: Positions, colour: str, width: float, more: str) -> None:
        style = f'fill="none" stroke="{colour}" stroke-width="{width:g}" stroke-linecap="round"'
        self._rows.append(f'<path {style} stroke-linejoin="round"{more} d="{_path(places)}"/>')


def _path(places: Positions) -> str:
    return "M" + "L".join(f"{x:.2f} {y:.2f}" for x, y in places)
