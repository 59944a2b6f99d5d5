"""The Menger sponge after three subdivisions: 8000 cubes of 2 mm."""

import ifs

DEPTH = 3


def build() -> ifs.Mesh:
    return ifs.mesh(ifs.shape("menger-sponge"), DEPTH)


if __name__ == "__main__":
    from gallery.picture import save

    save("menger_sponge", build())
