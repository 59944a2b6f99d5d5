"""The map of behaviours as a picture: the parameter plane in colours, a legend, a curve of each region."""

import math
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from bcifs.paint import Sheet, width_of
from bcifs.palette import INK, PAPER
from bcifs.samples import Sample, middles, plane, sample
from fld.classes import Region, named
from fld.regions import CONTRACTS, UNDECIDED, Map

COLOURS = (
    "#8dbad6",
    "#e09a66",
    "#a7c48a",
    "#ecd58a",
    "#bb94b8",
    "#7fb5aa",
    "#d59a94",
    "#9fa3cf",
    "#cdb79a",
)
OTHERS = "#c9c9c4"
NEVER = "#efece3"
ALONE = "#dcd6c8"
OPEN = "#4a4a4a"
GREY = "#6b6b66"
POLYGON = "#b9b4a6"

SIDE = 860  # pixels of the map
LEFT, TOP, BOTTOM = 96, 96, 84
LEGEND = 640
SMALL = 0.002  # share of the plane below which a region is not in the legend


def draw_map(found: Map, title: str):
    """The picture of a map, in Pillow."""
    regions = named(found)
    shown = [r for r in regions if _share(found, r) >= SMALL][: len(COLOURS)]
    sheet = Sheet(LEFT + SIDE + 60 + LEGEND, TOP + SIDE + BOTTOM)
    sheet.text(LEFT, TOP - 44, title, 30, INK)
    sheet.fields((LEFT, TOP), SIDE, colours(found, shown))
    _axes(sheet, found)
    for region in shown:
        for mask, prime in ((region.members, ""), (region.mirrored, "'")):
            for x, y in middles(found, mask):
                _label(sheet, _place(found, x, y), f"{region.number}{prime}")
    if found.family.here is not None:
        _marker(sheet, found, found.family.here)
    _legend(sheet, found, shown)
    return sheet.finished()


def colours(found: Map, shown: Sequence[Region]) -> np.ndarray:
    """The colour of each field, `(rows, columns, 3)` bytes."""
    facts = found.facts
    result = np.empty((len(facts.verdict), 3))
    result[:] = _rgb(NEVER)
    result[facts.alone] = _rgb(ALONE)
    result[facts.verdict == CONTRACTS] = _rgb(OTHERS)
    result[facts.verdict == UNDECIDED] = _rgb(OPEN)
    for region, colour in zip(shown, COLOURS, strict=False):
        result[region.members] = _rgb(colour)
        result[region.mirrored] = 0.55 * _rgb(colour) + 0.45 * _rgb(PAPER)
        mixed = (facts.start_flips | facts.end_flips) & (region.members | region.mirrored)
        if 0 < mixed.sum() < (region.members | region.mirrored).sum():
            result[mixed] *= 0.9
    return np.round(result).astype(np.uint8).reshape(len(found.y), len(found.x), 3)


def _axes(sheet: Sheet, found: Map) -> None:
    sheet.box((LEFT, TOP), (LEFT + SIDE, TOP + SIDE), None, edge=INK)
    for axis, (low, high) in enumerate(found.ranges):
        for value in ticks(low, high):
            x, y = _place(found, value, value)
            if value == 0:
                ends = [[x, TOP], [x, TOP + SIDE]] if axis == 0 else [[LEFT, y], [LEFT + SIDE, y]]
                sheet.line(np.array(ends, float), GREY, 0.8)
            text = f"{value:.6g}"
            if axis == 0:
                sheet.line(np.array([[x, TOP + SIDE], [x, TOP + SIDE + 7]]), INK, 1.5)
                sheet.text(x, TOP + SIDE + 28, text, 18, INK, "ms")
            else:
                sheet.line(np.array([[LEFT - 7, y], [LEFT, y]]), INK, 1.5)
                sheet.text(LEFT - 13, y, text, 18, INK, "rm")
    sheet.text(LEFT + SIDE / 2, TOP + SIDE + 62, found.family.names[0], 24, INK, "ms")
    name = found.family.names[1]
    if width_of(name, 24) < 30:
        sheet.text(LEFT - 66, TOP + SIDE / 2 - 24, name, 24, INK, "mm")
    else:
        sheet.text(LEFT, TOP - 9, name, 18, INK, "ls")


def ticks(low: float, high: float) -> list[float]:
    """About eight round values between two.

    >>> ticks(-1, 1)
    [-1.0, -0.75, -0.5, -0.25, 0.0, 0.25, 0.5, 0.75, 1.0]
    """
    rough = (high - low) / 8
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(power * k for k in (1, 2, 2.5, 5, 10) if power * k >= rough * (1 - 1e-9))
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return [round(k * step, 12) + 0.0 for k in range(first, last + 1)]


def _label(sheet: Sheet, place: tuple[float, float], text: str) -> None:
    sheet.text(place[0], place[1], text, 30, INK, "mm")


def _marker(sheet: Sheet, found: Map, here: tuple[float, float]) -> None:
    """The file's own values: a ring with a point, and a word beside it."""
    x, y = _place(found, *here)
    if not (LEFT <= x <= LEFT + SIDE and TOP <= y <= TOP + SIDE):
        return
    sheet.disc(x, y, 8, PAPER, INK, 2.0)
    sheet.disc(x, y, 3, INK)


def _legend(sheet: Sheet, found: Map, shown: Sequence[Region]) -> None:
    x, notes = LEFT + SIDE + 56, _notes(found, shown)
    room = SIDE - 30 * len(notes) - 16
    height = min(room / max(len(shown), 1), 150)
    for place, (region, colour) in enumerate(zip(shown, COLOURS, strict=False)):
        _row(sheet, found, region, colour, (x, TOP + place * height), height - 12)
    base = TOP + SIDE - 30 * len(notes) + 12
    for place, (colour, words) in enumerate(notes):
        y = base + 30 * place
        if colour is None:
            sheet.disc(x + 17, y, 8, PAPER, INK, 2.0)
            sheet.disc(x + 17, y, 3, INK)
        else:
            sheet.box((x, y - 9), (x + 34, y + 9), colour, radius=3)
        sheet.text(x + 48, y, words, 17, INK, "lm")


def _notes(found: Map, shown: Sequence[Region]) -> list[tuple[str | None, str]]:
    facts, names = found.facts, found.family.names
    rows: list[tuple[str | None, str]] = []
    if found.family.here is not None:
        values = ", ".join(f"{n} = {v:.4g}" for n, v in zip(names, found.family.here, strict=True))
        rows.append((None, f"the file's own values: {values}"))
    for region, colour in zip(shown, COLOURS, strict=False):
        both = region.members | region.mirrored
        if 0 < ((facts.start_flips | facts.end_flips) & both).sum() < both.sum():
            darker = "#" + "".join(f"{round(0.9 * v):02x}" for v in _rgb(colour))
            rows.append((darker, f"{region.number}, where one end has a negative eigenvalue"))
    if ((facts.verdict == 1) & facts.alone).any():
        rows.append((ALONE, "each operator alone contracts, but a product of them does not"))
    if ((facts.verdict == 1) & ~facts.alone).any():
        rows.append((NEVER, "does not converge: an operator has an eigenvalue of 1 or more"))
    if (facts.verdict == UNDECIDED).any():
        rows.append((OPEN, "undecided"))
    return rows


def _row(
    sheet: Sheet, found: Map, region: Region, colour: str, corner: tuple[float, float], height: float
) -> None:
    """One region of the legend: its number on its colour, its curve, its facts."""
    x, y = corner
    wide = min(1.5 * height, 200)
    sheet.box((x, y), (x + 46, y + height), colour, radius=6)
    sheet.text(x + 23, y + height / 2, str(region.number), 28, INK, "mm")
    made = sample(found, region)
    _curve(sheet, found, made, (x + 62, y + 4), (wide, height - 8))
    names = found.family.names
    phrases = [p[0].upper() + p[1:] if k == 0 else p for k, p in enumerate(region.words)]
    where = ", ".join(f"{n} = {v:.3g}" for n, v in zip(names, made.place, strict=True))
    step = min(24.0, height / (len(phrases) + 1.2))
    first = y + height / 2 - step * len(phrases) / 2
    for k, phrase in enumerate([*phrases, f"drawn: {where}"]):
        size = min(19 if k == 0 else 16, step * 0.8)
        while width_of(phrase, size) > LEGEND - wide - 100:
            size -= 0.5
        shade = INK if k < len(phrases) else GREY
        sheet.text(x + wide + 80, first + k * step, phrase, size, shade, "lm")


def _curve(
    sheet: Sheet, found: Map, made: Sample, corner: tuple[float, float], size: tuple[float, float]
) -> None:
    """A curve and its control polygon in a frame."""
    control = plane(found)
    whole = np.vstack([control, made.points])
    low, high = whole.min(axis=0), whole.max(axis=0)
    scale = float(min(size[k] / max(high[k] - low[k], 1e-300) for k in range(2)))
    middle = np.array([corner[0] + size[0] / 2, corner[1] + size[1] / 2])

    def placed(points: np.ndarray) -> np.ndarray:
        return middle + (points - (low + high) / 2) * scale * np.array([1.0, -1.0])

    sheet.line(placed(control), POLYGON, 1.2)
    for x, y in placed(control):
        sheet.disc(float(x), float(y), 3, POLYGON)
    sheet.line(placed(made.points), INK, 1.6)


def _place(found: Map, x: float, y: float) -> tuple[float, float]:
    (x0, x1), (y0, y1) = found.ranges
    return LEFT + SIDE * (x - x0) / (x1 - x0), TOP + SIDE * (y1 - y) / (y1 - y0)


def _share(found: Map, region: Region) -> float:
    return float((region.members | region.mirrored).mean())


def _rgb(colour: str) -> Float[np.ndarray, "3"]:
    return np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)], float)
