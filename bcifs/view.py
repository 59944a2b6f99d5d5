"""From where a shape in space is seen, and the sheet that its picture fills."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

TOWARDS = (0.9, -1.75, 1.0)  # from the shape to the eye: right, front, above
TOWARDS_FLAT = (0.25, -0.75, 1.6)  # for what is low beside its length and breadth
LOW = 0.2
LONG = 1400  # pixels along the longer side
SHORT = 600  # at least along the other
MARGIN = 0.06


@dataclass(frozen=True)
class Sheet:
    """A picture of `width` x `height` pixels; `scale` pixels a millimetre, `centre` (mm) in its middle."""

    width: int
    height: int
    scale: float
    centre: Float[np.ndarray, "2"]

    def place(self, points: Float[np.ndarray, "n 2"]) -> Float[np.ndarray, "n 2"]:
        """Positions in pixels, from the upper left corner."""
        moved = (points - self.centre) * self.scale
        return np.column_stack([self.width / 2 + moved[:, 0], self.height / 2 - moved[:, 1]])


def sheet(points: Float[np.ndarray, "n 2"]) -> Sheet:
    """The sheet on which all points fit, with a margin.

    >>> made = sheet(np.array([[0.0, 0.0], [90.0, 30.0]]))
    >>> made.width, made.height, made.place(np.array([[45.0, 15.0]])).tolist()
    (1400, 600, [[700.0, 300.0]])
    """
    low, high = points.min(axis=0), points.max(axis=0)
    size = high - low
    longest = float(size.max())
    if longest == 0:
        return Sheet(SHORT, SHORT, 1.0, (low + high) / 2)
    room = LONG * (1 - 2 * MARGIN)
    scale = room / longest
    border = LONG - room
    width, height = (max(SHORT, 2 * round((float(side) * scale + border) / 2)) for side in size)
    return Sheet(width, height, scale, (low + high) / 2)


def axes(points: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "3 3"]:
    """The directions right, up and towards the eye, as rows: three-quarter, and steeper for flat things."""
    length, breadth, height = np.ptp(points, axis=0)
    eye = np.array(TOWARDS_FLAT if height < LOW * max(length, breadth) else TOWARDS)
    towards = eye / np.linalg.norm(eye)
    right = np.cross([0.0, 0.0, 1.0], towards)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(towards, right), towards])


def seen(points: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "n 3"]:
    """The points in the directions right, up and towards the eye, without perspective."""
    return points @ axes(points).T
