"""A plain IFS as a list of maps, from and to its automaton."""

from collections.abc import Sequence
from fractions import Fraction

from automata import Automaton
from automata.plain import plain_automaton
from ifs.maps.exact import inverse, product
from ifs.maps.maps import Map
from ifs.measures.operators import operators
from ifs.shape import Shape


def maps_of(shape: Shape) -> list[Map]:
    """The affine maps of modelling space whose attractor a shape is, in the order of its labels.

    The shape has one cell, cut into copies of itself, and as many control points as span its space: d + 1 for
    R^d. With these as the columns of P over a row of ones, map i is `P T_i P^-1`, exact in terms of the
    control points and of the operators, where these are known exactly. Lengths in mm. Raises `ValueError` for
    other shapes.

    >>> from ifs.shape import shape
    >>> [f.ratio() for f in maps_of(shape("sierpinski-triangle"))]
    [0.5, 0.5, 0.5]
    """
    state = shape.system.states[shape.system.shape]
    foreign = [i for i, target in zip(state.labels, state.targets, strict=True) if target != state.name]
    if foreign:
        target = state.targets[state.labels.index(foreign[0])]
        raise ValueError(
            f"a plain IFS has one cell; sub-cell {foreign[0]!r} of {state.name!r} is a {target!r}"
        )
    points = [[Fraction(float(x)) for x in column] for column in shape.control.T]
    frame = [*points, [Fraction(1)] * state.points]
    back = inverse(frame) if len(frame) == state.points else None
    if back is None:
        raise ValueError(
            f"the {state.points} control points of cell {state.name!r} are no frame of R^{len(points)}: maps "
            f"need {len(frame)} that do not lie in one flat"
        )
    found = []
    for _, rows in operators(shape)[state.name].values():
        exact = [[Fraction(x) for x in row] for row in rows]
        found.append(Map(tuple(tuple(row) for row in product(product(frame, exact), back))))
    return found


def from_maps(
    maps: Sequence[Map], name: str = "Plain IFS", control: Sequence[Sequence[float]] | None = None
) -> Automaton:
    """The automaton of one cell whose attractor is that of some affine maps, exact.

    The control points are the origin and the ends of the axes' unit vectors (mm), for which the maps act as
    they stand; others, d + 1 rows, deform the attractor affinely. Labels count the maps from 0. Raises
    `ValueError` for a projective map and for maps of different spaces, naming the map.

    >>> import ifs
    >>> from ifs.maps.maps import affine
    >>> ternary = from_maps([affine([[Fraction(1, 3)]], [0]), affine([[Fraction(1, 3)]], [Fraction(2, 3)])])
    >>> [float(x) for x in ifs.bounds(ifs.shape(ternary).system)["attractor"].hi.round(9)]
    [1.0, 1.0]
    """
    for number, each in enumerate(maps):
        if not each.is_affine:
            raise ValueError(
                f"map {number} is projective; an automaton's operators are affine. Use ifs.projective"
            )
    pairs = [([row[:-1] for row in each.rows[:-1]], [row[-1] for row in each.rows[:-1]]) for each in maps]
    return plain_automaton(name, pairs, control)
