"""A sheet to draw charts on: strokes, words and discs, painted finer and averaged down."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from bcifs.palette import PAPER

FINER = 2

Positions = Float[np.ndarray, "n 2"]


class Sheet:
    """A picture of `width` x `height` pixels; all positions and sizes are in pixels of the result."""

    def __init__(self, width: int, height: int):
        from PIL import Image, ImageDraw

        self.width = width
        self.height = height
        self._image = Image.new("RGB", (width * FINER, height * FINER), PAPER)
        self._brush = ImageDraw.Draw(self._image)

    def line(self, places: Positions, colour: str, width: float = 1.0) -> None:
        """A stroke through places, with round corners."""
        self._brush.line(_flat(places), fill=colour, width=max(1, round(width * FINER)), joint="curve")

    def dashes(self, places: Positions, colour: str, width: float = 1.0, dash: float = 6.0) -> None:
        """A dashed stroke: dashes and gaps of `dash` pixels."""
        steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
        along = np.concatenate([[0.0], np.cumsum(steps)])
        for start in np.arange(0.0, along[-1], 2 * dash):
            ends = np.array([start, min(start + dash, along[-1])])
            at = np.concatenate([ends[:1], along[(along > ends[0]) & (along < ends[1])], ends[1:]])
            piece = np.column_stack([np.interp(at, along, places[:, k]) for k in range(2)])
            self.line(piece, colour, width)

    def polygon(self, places: Positions, colour: str) -> None:
        self._brush.polygon(_flat(places), fill=colour)

    def disc(
        self, x: float, y: float, radius: float, colour: str, edge: str | None = None, width: float = 1.5
    ) -> None:
        """A filled disc, with an edge of `width` where asked."""
        box = [FINER * v for v in (x - radius, y - radius, x + radius, y + radius)]
        self._brush.ellipse(box, fill=colour, outline=edge, width=round(width * FINER) if edge else 0)

    def box(
        self,
        low: tuple[float, float],
        high: tuple[float, float],
        colour: str | None,
        edge: str | None = None,
        radius: float = 0.0,
    ) -> None:
        """A rectangle between two corners, rounded by `radius`."""
        corners = [FINER * v for v in (*low, *high)]
        self._brush.rounded_rectangle(
            corners, radius * FINER, fill=colour, outline=edge, width=round(1.5 * FINER)
        )

    def text(self, x: float, y: float, words: str, size: float, colour: str, anchor: str = "ls") -> None:
        """Words at a place; `anchor` as in Pillow: l, m or r, then s (baseline) or m (middle)."""
        self._brush.text((x * FINER, y * FINER), words, fill=colour, font=_font(size), anchor=anchor)

    def fields(self, low: tuple[float, float], side: float, colours: np.ndarray) -> None:
        """A square of coloured fields, `(rows, columns, 3)` bytes, row 0 lowest."""
        from PIL import Image

        whole = round(side * FINER)
        tile = Image.fromarray(np.ascontiguousarray(colours[::-1])).resize(
            (whole, whole), Image.Resampling.NEAREST
        )
        self._image.paste(tile, (round(low[0] * FINER), round(low[1] * FINER)))

    def finished(self):
        """The picture in Pillow."""
        return self._image.reduce(FINER)


def width_of(words: str, size: float) -> float:
    """How wide words are, in pixels."""
    return _font(size).getlength(words) / FINER


def _font(size: float):
    from PIL import ImageFont

    return ImageFont.load_default(size * FINER)


def _flat(places: Positions) -> Sequence[tuple[float, float]]:
    return [(float(x) * FINER, float(y) * FINER) for x, y in places]
