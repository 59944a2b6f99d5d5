"""Integrals of monomials over the cells of a shared tree: one step for each node and level."""

from fractions import Fraction
from math import comb, lcm, prod

from trees.shared import BLACK, Shared

Exponent = tuple[int, ...]


def node_integrals(
    shared: Shared, dimension: int, exponents: tuple[Exponent, ...]
) -> dict[Exponent, Fraction]:
    """`integral of x^a` over the black cells, the cells being unit cubes, for these exponents.

    The integrals over a node are those over its low half, and those over its high half moved by s, the
    length of a half on the axis: `(x + s)^e = sum C(e, d) s^(e - d) x^d`. The exponents must hold with
    each one all those below it. Equal nodes at one level are worked out once. (Guye 1988, VI.1.)
    """
    order = max(sum(a) for a in exponents)
    scale = lcm(*range(1, order + 2))
    places = {a: n for n, a in enumerate(exponents)}
    levels = shared.levels()
    below: dict[int, list[int]] = {}
    for level in range(len(levels), -1, -1):
        extents = _extents(shared.depth - level, dimension)
        axis = level % dimension
        here = {0: [0] * len(exponents), BLACK: _box(extents, exponents, scale)}
        moves = _moves(exponents, places, axis, extents[axis] // 2)
        for node in levels[level].tolist() if level < len(levels) else ():
            low, high = below[int(shared.lows[node - 2])], below[int(shared.highs[node - 2])]
            here[node] = [
                own + sum(factor * high[n] for n, factor in terms)
                for own, terms in zip(low, moves, strict=True)
            ]
        below = here
    return {
        a: Fraction(value, scale**dimension) for a, value in zip(exponents, below[shared.root], strict=True)
    }


def _extents(height: int, dimension: int) -> list[int]:
    """The sides, in cells, of a box that is so many halvings above a cell."""
    return [2 ** ((height + axis) // dimension) for axis in range(dimension)]


def _box(extents: list[int], exponents: tuple[Exponent, ...], scale: int) -> list[int]:
    return [
        prod(side ** (e + 1) * scale // (e + 1) for side, e in zip(extents, a, strict=True))
        for a in exponents
    ]


def _moves(
    exponents: tuple[Exponent, ...], places: dict[Exponent, int], axis: int, step: int
) -> list[list[tuple[int, int]]]:
    """For each exponent, the places and factors of the integrals of which the moved one consists."""
    return [
        [
            (places[(*a[:axis], d, *a[axis + 1 :])], comb(a[axis], d) * step ** (a[axis] - d))
            for d in range(a[axis] + 1)
        ]
        for a in exponents
    ]
