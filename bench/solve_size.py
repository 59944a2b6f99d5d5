"""How long solving takes against the number of unknowns: B-spline curves, patches and volumes.

Each is a tensor power of the curve with d + 1 points an edge and d a vertex, d from 2, its pieces and
boundaries along the axes and glued without reversing any: a cell for each dimension, of (d+1)^k d^(n-k)
points. A boundary reached across two axes in either order is one cell, which makes exchanging the axes that
it lies across a symmetry.
"""

import time
from collections.abc import Iterator, Sequence
from itertools import product
from typing import Any

from automata import describe
from subdivision import solve
from subdivision.constraints import constraints
from subdivision.unknowns import unknowns

FAMILIES = (
    ("curve", 1, (2, 4, 8, 16, 32, 64)),
    ("patch", 2, (2, 3, 4, 5, 6)),
    ("volume", 3, (2, 3)),
)


def tensor(dimension: int, degree: int) -> dict[str, Any]:
    """The description of a tensor product of curves of one degree, cut in two along every axis.

    A cell `c<k>` spans k axes with degree + 1 points each, listed first, and lies across dimension - k axes
    with degree points each; the boundary `1+` of a cell is its upper end along its axis 1, and its
    symmetry `t1` exchanges the second and the third of the axes that it lies across.

    >>> [cell["points"] for cell in tensor(3, 3)["cells"].values()]
    [27, 36, 48, 64]
    """
    cells = {f"c{k}": _cell(k, dimension, degree) for k in range(dimension + 1)}
    return {"format": "bcifs/1", "shape": f"c{dimension}", "cells": cells}


def _cell(spanned: int, dimension: int, degree: int) -> dict[str, Any]:
    labels = ["".join(bits) for bits in product("01", repeat=spanned)] if spanned else ["s"]
    cell = {
        "points": (degree + 1) ** spanned * degree ** (dimension - spanned),
        "subdivision": dict.fromkeys(labels, f"c{spanned}"),
        "boundary": {
            f"{axis}{'-+'[end]}": {
                "cell": f"c{spanned - 1}",
                "points": _layer(spanned, axis, end, dimension, degree),
            }
            for axis in range(spanned)
            for end in (0, 1)
        },
    }
    incidence, adjacency = [], []
    for axis in range(spanned):
        for rest in product("01", repeat=spanned - 1):
            low, high = ("".join([*rest[:axis], end, *rest[axis:]]) for end in "01")
            piece = "".join(rest) or "s"
            incidence += [f"{axis}- {piece} = {low} {axis}-", f"{axis}+ {piece} = {high} {axis}+"]
            adjacency.append(f"{low} {axis}+ = {high} {axis}-")
    symmetry = {
        f"t{i}": _exchange(spanned, i, cell, dimension, degree) for i in range(dimension - spanned - 1)
    }
    return cell | {"incidence": incidence, "adjacency": adjacency, "symmetry": symmetry}


def _exchange(spanned: int, i: int, cell: dict[str, Any], dimension: int, degree: int) -> dict[str, Any]:
    """The symmetry that exchanges the axes i and i + 1 of those that a cell lies across."""
    sizes = [degree + 1] * spanned + [degree] * (dimension - spanned)
    order = list(range(dimension))
    order[spanned + i], order[spanned + i + 1] = order[spanned + i + 1], order[spanned + i]
    points = [
        _number([place[a] for a in order], sizes) for place in product(*(range(size) for size in sizes))
    ]
    return {
        "points": points,
        "subdivision": {label: f"{label} t{i}" for label in cell["subdivision"]},
        "boundary": {label: f"{label} t{i + 1}" for label in cell["boundary"]},
    }


def _number(place: Sequence[int], sizes: Sequence[int]) -> int:
    number = 0
    for index, size in zip(place, sizes, strict=True):
        number = number * size + index
    return number


def _layer(spanned: int, axis: int, end: int, dimension: int, degree: int) -> list[int]:
    """The points of a cell that its boundary across an axis depends on, in the boundary's own order:
    the other spanned axes, this one, then those that the cell lies across.
    """
    sizes = [degree + 1] * spanned + [degree] * (dimension - spanned)
    order = [*(a for a in range(spanned) if a != axis), axis, *range(spanned, dimension)]
    ranges = [range(end, end + degree) if a == axis else range(sizes[a]) for a in order]
    result = []
    for place in product(*ranges):
        index = dict(zip(order, place, strict=True))
        result.append(_number([index[a] for a in range(dimension)], sizes))
    return result


def measured(dimension: int, degree: int) -> tuple[int, int, int, float]:
    """Unknowns, scalar equations, degrees of freedom, and the seconds that solving takes."""
    automaton = describe(tensor(dimension, degree))
    table = unknowns(automaton)
    equations = sum(len(constraint.forms) for constraint in constraints(automaton, table)[0])
    start = time.perf_counter()
    freedom = solve(automaton).degrees_of_freedom
    return len(table.entries), equations, freedom, time.perf_counter() - start


def report(families: Sequence[tuple[str, int, Sequence[int]]] = FAMILIES) -> Iterator[str]:
    """A line for each size: unknowns, equations, degrees of freedom, seconds, microseconds an equation."""
    yield f"{'solve':12} {'unknowns':>9} {'equations':>9} {'freedom':>8} {'seconds':>8} {'us/equation':>11}"
    for name, dimension, degrees in families:
        for degree in degrees:
            count, equations, freedom, seconds = measured(dimension, degree)
            each = 1e6 * seconds / max(equations, 1)
            sizes = f"{count:9} {equations:9} {freedom:8}"
            yield f"{name} {degree:<{11 - len(name)}} {sizes} {seconds:8.3f} {each:11.1f}"
