"""A cloud between two solids: the Menger sponge after two subdivisions, and a rounded cube around it."""

import numpy as np

import ifs
from export.vapour import Vapour, vapour

RESOLUTION = 108
CUBE = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]


def build() -> Vapour:
    sponge = ifs.mesh(ifs.shape("menger-sponge"), 2)
    corners = np.array([[x, y, z] for x in (-9, 63) for y in (-9, 63) for z in (-9, 63)])
    pebble = ifs.smooth(corners, CUBE, depth=5)
    return vapour([sponge, pebble], [2 / 3, 1 / 3], resolution=RESOLUTION)


if __name__ == "__main__":
    from gallery.picture import save

    save("vapour", build())
