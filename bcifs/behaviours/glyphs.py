"""Signs for how a curve leaves a point: arrows, lines, cones, spirals."""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from bcifs.behaviours.svg import SvgSheet
from bcifs.behaviours.window import Window, clipped
from bcifs.paint import Sheet
from fld.cone import Cone, Spiral
from fld.expansion import Expansion
from fld.tangent import HalfTangent

_SHARE = {"left": 0.30, "right": 0.36}  # of the side of a panel: arrows over each other stay two
_FAINT = 0.22
_SHOWN = 0.05

Direction = Float[np.ndarray, "dim"]
Places = Float[np.ndarray, "_n 2"]


@dataclass(frozen=True)
class Panel:
    """A square of the sheet, `side` pixels from its upper left `corner`, that shows a window of the plane."""

    window: Window
    corner: tuple[float, float]
    side: float
    plane: Float[np.ndarray, "dim 2"]
    point: Float[np.ndarray, "2"]

    @property
    def scale(self) -> float:
        """Pixels a millimetre."""
        return self.side / self.window.side

    def placed(self, points: Places) -> Places:
        """Points of the plane, in mm, as places on the sheet."""
        moved = (points - self.window.centre) * self.scale * [1.0, -1.0]
        return moved + np.array(self.corner, float) + self.side / 2

    @property
    def place(self) -> tuple[float, float]:
        """The point looked at, on the sheet."""
        x, y = self.placed(self.point[None])[0]
        return float(x), float(y)

    def towards(self, direction: Direction) -> Float[np.ndarray, "2"] | None:
        """A unit vector on the sheet; None for a direction that is seen from its end."""
        seen = direction @ self.plane * [1.0, -1.0]
        size = float(np.linalg.norm(seen))
        return seen / size if size > _SHOWN * np.linalg.norm(direction) else None


def side_glyphs(
    sheet: Sheet | SvgSheet,
    panel: Panel,
    tangent: HalfTangent,
    terms: Expansion,
    distance: float,
    colour: str,
    under: bool,
) -> None:
    """What stands for one side of the point: `under` the curve the faint sectors, over it the strokes.

    `distance` is that in parameter to the end of the piece which the terms are about.
    """
    reach = _SHARE[tangent.side] * panel.side
    if under:
        _next_direction(sheet, panel, terms, colour)
        if tangent.cone is not None and _is_sector(tangent.cone, panel):
            _sector(sheet, panel, tangent.cone, reach, colour)
        return
    if tangent.spiral is not None:
        _spiral(sheet, panel, tangent.spiral, terms, distance, colour)
    elif tangent.cone is not None:
        dashed = tangent.cone.angle is None
        whole = _is_sector(tangent.cone, panel) and (tangent.cone.angle or 0) >= 359
        for direction in tangent.cone.directions[: 0 if whole else 12]:
            _arrow(sheet, panel, direction, reach, colour, dashed)
    elif tangent.direction is not None:
        _arrow(sheet, panel, tangent.direction, reach, colour, tangent.status == "undecided")


def around(
    place: tuple[float, float], radius: float, start: float = 0.0, turn: float = 2 * math.pi
) -> Places:
    """Places on an arc, from the angle `start`, by `turn`, counter-clockwise on the sheet."""
    angles = start + np.linspace(0, turn, max(8, round(abs(turn) / 0.05)))
    return np.array(place) + radius * np.column_stack([np.cos(angles), -np.sin(angles)])


def faint(colour: str) -> str:
    """A colour thinned with white."""
    parts = [int(colour[k : k + 2], 16) for k in (1, 3, 5)]
    return "#" + "".join(f"{round(_FAINT * part + (1 - _FAINT) * 255):02x}" for part in parts)


def _is_sector(cone: Cone, panel: Panel) -> bool:
    return panel.plane.shape[0] == 2 and cone.axis is None and cone.angle is not None and cone.angle > 0


def _sector(sheet: Sheet | SvgSheet, panel: Panel, cone: Cone, reach: float, colour: str) -> None:
    """All directions from the first of a cone, turning counter-clockwise by its angle."""
    first = panel.towards(cone.directions[0])
    if first is None or cone.angle is None:
        return
    start = math.atan2(-first[1], first[0])
    arc = _within(panel, around(panel.place, reach, start, math.radians(cone.angle)))
    sheet.polygon(np.vstack([[panel.place], arc]) if cone.angle < 359 else arc, faint(colour))


def _arrow(
    sheet: Sheet | SvgSheet, panel: Panel, direction: Direction, reach: float, colour: str, dashed: bool
) -> None:
    way = panel.towards(direction)
    if way is None:
        return
    start = np.array(panel.place)
    free = _room(panel, start, way)
    tip = start + way * min(reach, free)
    across = np.array([-way[1], way[0]])
    neck = tip - 13 * way
    shaft = np.array([start, neck])
    if dashed:
        sheet.dashes(shaft, colour, 3.2, 7.0)
    else:
        sheet.line(shaft, colour, 3.6)
    sheet.polygon(np.array([tip, neck - 7 * across, neck + 7 * across]), colour)


def _next_direction(sheet: Sheet | SvgSheet, panel: Panel, terms: Expansion, colour: str) -> None:
    """The direction of the second term, as a dashed line to both sides."""
    if len(terms.terms) < 2 or terms.terms[1].eigenvalue.imag:
        return
    way = panel.towards(np.real(terms.terms[1].vector))
    if way is None:
        return
    ends = np.array([[-1.0], [1.0]]) * way * 0.42 * panel.side + panel.place
    low = np.array(panel.corner, float)
    for part in clipped(ends, low, low + panel.side):
        sheet.dashes(part, colour, 1.6, 4.0)


def _spiral(
    sheet: Sheet | SvgSheet, panel: Panel, spiral: Spiral, terms: Expansion, distance: float, colour: str
) -> None:
    """The spiral `Re(vector lambda^k) distance^order` of the leading term, k running on between the steps.

    At whole k it passes through the ends of the pieces, up to the terms that follow.
    """
    term = terms.terms[0]
    vector = term.vector @ panel.plane * [1.0, -1.0] * distance**term.order * panel.scale
    least = math.atan2(term.eigenvalue.imag, term.eigenvalue.real)
    turns = least + 2 * math.pi * np.arange(-4, 5)
    turn = turns[np.abs(np.abs(turns) - math.radians(abs(spiral.turn))).argmin()]
    size = float(np.linalg.norm(vector))
    if size == 0:
        return
    steps = [math.log(pixels / size) / math.log(spiral.ratio) for pixels in (0.7 * panel.side, 1.0)]
    along = np.linspace(steps[0], steps[1], 600)
    places = np.real(vector * np.exp(1j * turn * along)[:, None]) * spiral.ratio ** along[:, None]
    low = np.array(panel.corner, float)
    for part in clipped(places + panel.place, low, low + panel.side):
        sheet.dashes(part, colour, 2.4, 7.0)


def _room(panel: Panel, start: Places | np.ndarray, way: Float[np.ndarray, "2"]) -> float:
    """How far an arrow can go before it leaves the panel."""
    low = np.array(panel.corner, float)
    ends = [
        ((low[k] + panel.side if way[k] > 0 else low[k]) - start[k]) / way[k]
        for k in range(2)
        if abs(way[k]) > 1e-12
    ]
    return max(min(ends) - 4, 16.0)


def _within(panel: Panel, places: Places) -> Places:
    low = np.array(panel.corner, float)
    return np.clip(places, low, low + panel.side)
