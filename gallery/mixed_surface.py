"""A surface between four curves: a parabola faces Takagi's curve, a straight line a rougher one."""

import numpy as np

import ifs
from ifs.mixtures.mixed_surface import between
from subdivision.schemes import bezier, takagi

DEPTH = 7
BORDERS = (
    (bezier(2), [[0, 0, 0], [40, 0, 40], [80, 0, 0]]),
    (takagi(), [[0, 80, 0], [40, 80, 30], [80, 80, 0]]),
    (bezier(1), [[0, 0, 0], [0, 80, 0]]),
    (takagi(0.625), [[80, 0, 0], [80, 40, 25], [80, 80, 0]]),
)


def build() -> ifs.Mesh:
    bottom, top, left, right = (ifs.shape(curve, control=np.array(points)) for curve, points in BORDERS)
    return ifs.mesh(between(bottom, top, left, right), DEPTH)


if __name__ == "__main__":
    from gallery.picture import save

    save("mixed_surface", build())
