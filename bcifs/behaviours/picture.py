"""A point of a curve as a picture: the curve, two zooms, and how it leaves the point on either side."""

import math
import os
from pathlib import Path

import numpy as np

from bcifs.behaviours.glyphs import Panel, around, side_glyphs
from bcifs.behaviours.report import Report, exponent
from bcifs.behaviours.svg import SvgSheet
from bcifs.behaviours.window import clipped, lines, plane, windows
from bcifs.paint import Sheet, width_of
from bcifs.palette import INK, PAPER
from bcifs.png import write_png
from bcifs.recipe import recipe
from fld.wording import written
from ifs import Shape

ENDINGS = (".png", ".svg")
LEFT_COLOUR, RIGHT_COLOUR = "#c8643a", "#7a5ba8"
GREY, FRAME = "#6b6b66", "#c9c4b6"
SIDE, GAP, MARGIN, TOP = 560, 40, 56, 128
SIZE, STEP = 17, 25
FINE = 0.7  # pixels

Words = list[tuple[str, str]]


def draw_report(shape: Shape, found: Report, path: str | os.PathLike[str]) -> None:
    """Draw a report of `bcifs fld` into a PNG or SVG file, whole or not at all.

    Three squares: the whole curve, then two zooms about the point, each framed in the one before. Arrows and
    cones stand for the left and the right side, dashed lines for the next eigen-directions; below them
    are the numbers. Raises `WrongPicture` for more than three coordinates.

    >>> import pathlib, tempfile, ifs
    >>> from bcifs.behaviours.report import report
    >>> place = pathlib.Path(tempfile.mkdtemp()) / "cut.svg"
    >>> cutting = ifs.shape("corner-cutting")
    >>> draw_report(cutting, report(cutting, "1 0"), place)
    >>> place.read_text()[:4]
    '<svg'
    """
    columns = _columns(found)
    rows = max(len(column) for column in columns)
    width = 2 * MARGIN + 3 * SIDE + 2 * GAP
    height = TOP + SIDE + 84 + STEP * rows + 40
    sheet = SvgSheet(width, height) if Path(path).suffix.lower() == ".svg" else Sheet(width, height)
    sheet.text(MARGIN, 58, f"{found.behaviour.name} at {found.behaviour.address}", 32, INK)
    _panels(sheet, found)
    for place, column in enumerate(columns):
        x = MARGIN + place * (SIDE + GAP)
        for row, (words, colour) in enumerate(column):
            sheet.text(x, TOP + SIDE + 92 + STEP * row, words, SIZE, colour, "lm")
    made = recipe(shape, f"{found.behaviour.address}, two zooms")
    if isinstance(sheet, SvgSheet):
        sheet.write(path, made)
    else:
        write_png(sheet.finished(), path, made)


def _panels(sheet: Sheet | SvgSheet, found: Report) -> None:
    own, at = found.curve, found.behaviour
    seen = plane(own.control)
    control, point = own.control @ seen, at.point @ seen
    word = at.address.partition("(")[0].split()
    shown = windows(own, control, point, (at.left, at.right), word)
    panels = [
        Panel(window, (MARGIN + k * (SIDE + GAP), TOP), SIDE, seen, point) for k, window in enumerate(shown)
    ]
    for k, panel in enumerate(panels):
        low, high = np.array(panel.corner, float), np.array(panel.corner, float) + SIDE
        sheet.box((low[0], low[1]), (high[0], high[1]), "#ffffff", FRAME)
        _sides(sheet, panel, found, under=True)
        width = 2.4 if k == 0 else 2.0
        for line in lines(own, control, panel.window, FINE * panel.window.side / SIDE):
            for part in clipped(panel.placed(line), low, high):
                sheet.line(part, INK, width)
        _sides(sheet, panel, found, under=False)
        x, y = panel.place
        sheet.disc(x, y, 6.5, PAPER, INK, 2.2)
        if k < 2:
            _framed(sheet, panel, panels[k + 1].window.side)
        _heading(sheet, panel, shown[0].side / panel.window.side)
        _scale(sheet, panel)


def _sides(sheet: Sheet | SvgSheet, panel: Panel, found: Report, under: bool) -> None:
    """The signs of both sides; the left one, which is shorter, over the right one."""
    left, right = found.sides()
    for colour, (_, tangent, _, terms) in ((RIGHT_COLOUR, right), (LEFT_COLOUR, left)):
        if tangent is not None and terms is not None:
            side_glyphs(sheet, panel, tangent, terms, found.reach(terms), colour, under)


def _framed(sheet: Sheet | SvgSheet, panel: Panel, side: float) -> None:
    """The square that the next panel shows, or a ring where it is too small to be seen."""
    half = side / 2 * panel.scale
    x, y = panel.place
    if half < 9:
        sheet.line(around(panel.place, 16.0), GREY, 1.5)
        return
    low, high = np.array(panel.corner, float), np.array(panel.corner, float) + SIDE
    square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]]) * half + [x, y]
    for part in clipped(square, low, high):
        sheet.line(part, GREY, 1.5)


def _heading(sheet: Sheet | SvgSheet, panel: Panel, zoom: float) -> None:
    words = "the curve" if zoom < 1.5 else f"{zoom:.3g} times larger"
    sheet.text(panel.corner[0], TOP - 14, words, 20, INK)


def _scale(sheet: Sheet | SvgSheet, panel: Panel) -> None:
    """A bar of a round length, 1, 2 or 5 times a power of ten mm, below a panel."""
    wanted = panel.window.side / 4
    power = 10.0 ** math.floor(math.log10(wanted))
    length = next(power * k for k in (5, 2, 1) if power * k <= wanted * (1 + 1e-9))
    x, y = panel.corner[0], TOP + SIDE + 22
    end = x + length * panel.scale
    for ends in ([[x, y], [end, y]], [[x, y - 5], [x, y + 5]], [[end, y - 5], [end, y + 5]]):
        sheet.line(np.array(ends, float), INK, 2.0)
    sheet.text(end + 12, y, f"{length:.6g} mm", SIZE, INK, "lm")


def _columns(found: Report) -> list[Words]:
    """What stands below the panels: the point, its left side, its right side; lines with their colours."""
    at = found.behaviour
    parts = ", ".join(f"{ratio:.4g}" for ratio in at.ratios.values())
    facts = [
        f"point {written(at.point)} mm, parameter {at.parameter:.6g}",
        f"twin {found.twin}" if found.twin else "",
        f"critical order {at.critical_order:.9g}",
        f"local exponent {exponent(found.orders.holder)}",
        f"parts of [0, 1]: {parts}",
        f"joint: {at.joint}" if at.joint else "",
        f"derivatives: {found.derivatives.passage}" if found.derivatives.passage else "",
    ]
    columns = [[(line, INK) for fact in facts if fact for line in wrapped(fact)]]
    for colour, (side, tangent, slope, terms) in zip((LEFT_COLOUR, RIGHT_COLOUR), found.sides(), strict=True):
        if tangent is None or slope is None or terms is None:
            columns.append([(f"{side}: the curve {'starts' if side == 'left' else 'ends'} here", GREY)])
            continue
        order = "" if tangent.order is None else f", order {tangent.order:.9g}"
        rows: Words = [(f"{side}: {tangent.status}{order}", colour)]
        said = [tangent.words, slope.words.removesuffix(f": {tangent.words}")]
        if terms.terms[1:2] and _dashed(terms.terms[1].eigenvalue):
            said.append(f"dashed: the next eigen-direction, order {terms.terms[1].order:.6g}")
        rows += [(line, INK) for words in said for line in wrapped(words)]
        columns.append(rows)
    return columns


def _dashed(value: complex) -> bool:
    return value.imag == 0


def wrapped(words: str, width: float = SIDE, size: float = SIZE) -> list[str]:
    """Words in lines of at most `width` pixels.

    >>> wrapped("one two three", 75, 17)
    ['one two', 'three']
    """
    found: list[str] = []
    for word in words.split():
        longer = f"{found[-1]} {word}" if found else word
        if found and width_of(longer, size) <= width:
            found[-1] = longer
        else:
            found.append(word)
    return found
