"""A curve that turns from smooth to rough: a parabola blended into Takagi's curve, and both beside it."""

import numpy as np

import ifs
from gallery.arrange import row
from ifs.mixtures.mixing import mixed
from subdivision.schemes import bezier, takagi

DEPTH = 11
ARCH = np.array([[0.0, 0], [40, 60], [80, 0]])


def shapes() -> list[ifs.Shape]:
    """The smooth curve, the mixed one, the rough one."""
    smooth, rough = (ifs.shape(curve, control=ARCH) for curve in (bezier(2), takagi()))
    return [smooth, mixed([smooth, rough], bezier(1)), rough]


def build() -> ifs.Mesh:
    return row([ifs.mesh(shape, DEPTH) for shape in shapes()], 10.0)


if __name__ == "__main__":
    from gallery.picture import save

    save("mixed", build())
