"""Five curves by corner cutting, one from each region of figure 4.14 (Gentil 2010), smooth to rough."""

from dataclasses import replace
from fractions import Fraction

import automata
import ifs
from gallery.arrange import row

REGIONS = (("1/4", "1/4"), ("-1/10", "2/5"), ("1/5", "1/2"), ("2/5", "2/5"), ("7/10", "7/10"))


def shapes() -> list[ifs.Shape]:
    """The five curves, by the coefficients a and b of their regions."""
    automaton = automata.read("corner-cutting")
    keys = ("edge.0[1,0]", "edge.0[0,1]")
    values = [dict(zip(keys, map(Fraction, pair), strict=True)) for pair in REGIONS]
    return [ifs.shape(replace(automaton, values=chosen)) for chosen in values]


def build() -> ifs.Mesh:
    return row([ifs.mesh(shape, 10) for shape in shapes()], 10.0)


if __name__ == "__main__":
    from gallery.picture import save

    save("corner_cutting", build())
