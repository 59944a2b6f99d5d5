"""Which way up a part wants the least support."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

STEEPEST = 45.0  # degrees from the vertical that print without support
PLATE = 1e-4  # of the height: triangles that low lie on the plate
DIRECTIONS = (("+z", 2, 1), ("-z", 2, -1), ("+x", 0, 1), ("-x", 0, -1), ("+y", 1, 1), ("-y", 1, -1))


@dataclass(frozen=True)
class Overhang:
    """With this axis upward: the share (0 to 1) of the area that hangs over, and mm² on the plate."""

    up: str
    share: float
    on_plate: float


def overhangs(
    corners: Float[np.ndarray, "t 3 3"], normals: Float[np.ndarray, "t 3"], steepest: float = STEEPEST
) -> tuple[Overhang, ...]:
    """The overhang of a part in six positions, the best first; `normals` are as long as twice the areas.

    A triangle hangs over when it looks down and is more than `steepest` degrees from the
    vertical (with a hundredth of a degree of room), and does not lie on the plate, that is, on the lowest
    ten-thousandth of the height. The best has the smallest share and, among equals, most on the plate.

    >>> corners = np.array([[[0.0, 0, 0], [0, 1, 0], [1, 0, 0]], [[0, 0, 2], [0, 1, 2], [1, 0, 2]]])
    >>> normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    >>> [(one.up, one.share) for one in overhangs(corners, normals)][-1]
    ('+z', 0.5)
    """
    doubled = np.sqrt(np.einsum("tx,tx->t", normals, normals))
    total = float(doubled.sum()) or 1.0
    limit = np.sin(np.radians(steepest + 0.01))
    found = []
    for up, axis, sign in DIRECTIONS:
        a, b, c = (sign * corners[:, k, axis] for k in range(3))
        top = np.maximum(np.maximum(a, b), c)
        low, high = min(float(x.min()) for x in (a, b, c)), float(top.max())
        plate = top <= low + PLATE * (high - low)
        down = -sign * normals[:, axis]
        hanging = (down > limit * doubled) & ~plate
        on_plate = float(doubled[plate & (down > 0)].sum()) / 2
        found.append(Overhang(up, float(doubled[hanging].sum()) / total, on_plate))
    return tuple(sorted(found, key=lambda one: (round(one.share, 9), -round(one.on_plate, 9))))
