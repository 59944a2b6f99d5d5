"""One control grid, two surfaces: Catmull and Clark's smooth patch, and a fractal one beside it."""

import ifs
from gallery.arrange import row

DEPTH = 6


def build() -> ifs.Mesh:
    return row([ifs.mesh(ifs.shape(name), DEPTH) for name in ("catmull-clark-patch", "fractal-patch")], 10.0)


if __name__ == "__main__":
    from gallery.picture import save

    save("patches", build())
