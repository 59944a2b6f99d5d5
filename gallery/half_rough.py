"""One control mesh, a ring, smooth on one side and rough on the other, without a gap between them."""

from fractions import Fraction

import numpy as np

import ifs

ROWS, COLUMNS, DEPTH = 24, 10, 5
WEIGHTS = [Fraction(weight, 20) for weight in (11, 12, -4, 1)]


def build() -> ifs.Mesh:
    u, v = np.meshgrid(*(2 * np.pi * np.arange(n) / n for n in (ROWS, COLUMNS)), indexing="ij")
    radius = 40 + 15 * np.cos(v)
    points = np.stack([radius * np.cos(u), radius * np.sin(u), 15 * np.sin(v)], -1).reshape(-1, 3)
    i, j = (index.ravel() for index in np.indices((ROWS, COLUMNS)))
    around = ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))
    faces = np.stack([p % ROWS * COLUMNS + q % COLUMNS for p, q in around], axis=1)
    half = [ifs.Region(range(len(faces) // 2), lambda n: WEIGHTS)]
    return ifs.smooth(points, faces, DEPTH, "doo-sabin", regions=half)


if __name__ == "__main__":
    from gallery.picture import save

    save("half_rough", build())
