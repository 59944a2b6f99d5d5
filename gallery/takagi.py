"""Takagi's curve and two relatives: heights shrink by 1/4 (a parabola), 1/2 (Takagi) and 2/3 (rougher)."""

from dataclasses import replace
from fractions import Fraction

import automata
import ifs
from gallery.arrange import row

FACTORS = ("1/4", "1/2", "2/3")


def build() -> ifs.Mesh:
    automaton = automata.read("takagi-curve")
    meshes = []
    for w in map(Fraction, FACTORS):
        values = {"edge.0[0,1]": (1 - w) / 2, "edge.0[1,1]": w + Fraction(1, 2)}
        meshes.append(ifs.mesh(ifs.shape(replace(automaton, values={**automaton.values, **values})), 11))
    return row(meshes, 10.0)


if __name__ == "__main__":
    from gallery.picture import save

    save("takagi", build())
