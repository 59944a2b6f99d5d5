"""Three Koch curves around a triangle of 90 mm: a closed curve whose length grows, not its area."""

import numpy as np

import ifs
from gallery.arrange import joined

DEPTH = 6


def build() -> ifs.Mesh:
    centre = np.array([45.0, -15 * np.sqrt(3)])
    turns = [
        np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]]) for a in 2 * np.pi * np.arange(3) / 3
    ]
    side = ifs.shape("koch-curve")
    around = [(side.control - centre) @ turn.T for turn in turns]
    return joined([ifs.mesh(ifs.shape("koch-curve", control=control), DEPTH) for control in around])


if __name__ == "__main__":
    from gallery.picture import save

    save("koch_snowflake", build())
