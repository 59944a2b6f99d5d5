"""The Sierpinski tetrahedron after five subdivisions: 1024 tetrahedra that touch at their corners."""

import ifs

DEPTH = 5


def build() -> ifs.Mesh:
    return ifs.mesh(ifs.shape("sierpinski-tetrahedron"), DEPTH)


if __name__ == "__main__":
    from gallery.picture import save

    save("sierpinski_tetrahedron", build())
