"""How rough a fractal patch is, and where: every piece in the colour of its local order."""

import fld.roughness
import ifs

DEPTH, DETAIL = 3, 3


def build() -> fld.roughness.Roughness:
    return fld.roughness.roughness(ifs.shape("fractal-patch"), DEPTH, detail=DETAIL)


if __name__ == "__main__":
    from gallery.picture import save

    save("roughness", build())
