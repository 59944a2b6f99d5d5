"""Curves of many segments over common control points, open or closed: what `ifs.patchwork` needs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from automata import Automaton
from subdivision.schemes.building import Amount
from subdivision.schemes.knots import text
from subdivision.schemes.nonuniform import nonuniform_b_spline, pieces_of

if TYPE_CHECKING:
    import numpy


@dataclass(frozen=True)
class Segments:
    """An automaton and the pieces of a curve, each by the numbers of its control points.

    `patches[cell]` is `(pieces, points)`, counted from 0; `control_points` is how many the whole
    curve has.
    """

    automaton: Automaton
    patches: Mapping[str, "numpy.ndarray"]
    control_points: int


def chain(automaton: Automaton, control_points: int, closed: bool = False) -> Segments:
    """The segments of one kind along a polygon of control points, each sharing its end with the next.

    Neighbours share as many control points as a vertex depends on: a segment of p points whose vertices have
    v starts p - v points after the one before it, so that Bezier segments of degree d start every d points
    and those of B-splines at each. Raises `ValueError` for an automaton whose shape does not run from `left`
    to `right`, and for a number of control points that does not come out even.

    >>> from subdivision.schemes.curves import bezier, b_spline
    >>> chain(bezier(3), 7).patches["edge"].tolist()
    [[0, 1, 2, 3], [3, 4, 5, 6]]
    >>> chain(b_spline(2), 4, closed=True).patches["edge"].tolist()
    [[0, 1, 2], [1, 2, 3], [2, 3, 0], [3, 0, 1]]
    """
    cell = automaton.cells[automaton.shape]
    ends = [cell.boundary[label].cell for label in ("left", "right") if label in cell.boundary]
    if len(ends) != 2 or ends[0] != ends[1]:
        raise ValueError(f"segments of {automaton.name!r} cannot follow each other: cell {cell.name!r} needs "
                         "boundaries 'left' and 'right' of one kind")  # fmt: skip
    shared = automaton.cells[ends[0]].points
    step = cell.points - shared
    least = max(step, shared + 1) if closed else cell.points
    rest = control_points if closed else control_points - shared
    if control_points < least or rest % step:
        multiple = f"a multiple of {step}" if closed else f"{shared} and a multiple of {step}"
        raise ValueError(f"expected {least} or more control points, {multiple}, found {control_points}")
    starts = range(0, rest, step)
    rows = [[(start + i) % control_points for i in range(cell.points)] for start in starts]
    return Segments(automaton, _tables({cell.name: rows}), control_points)


def nonuniform(degree: int, intervals: Sequence[Amount], closed: bool = False) -> Segments:
    """The segments of a non-uniform B-spline of degree 2 or 3: one for each positive interval of the curve.

    Intervals are counted as in `nonuniform_b_spline`, which also names the errors. Pieces of the same ratios
    are of one cell. At a knot repeated more often than the degree, the curve breaks off and begins anew.

    >>> found = nonuniform(2, [1, 2, 2, 2, 2, 1])
    >>> {cell: rows.tolist() for cell, rows in found.patches.items()}
    {'1:2:2': [[0, 1, 2]], '1:1:1': [[1, 2, 3], [2, 3, 4]], '2:2:1': [[3, 4, 5]]}
    """
    automaton = nonuniform_b_spline(degree, intervals, closed)
    control_points = len(intervals) if closed else len(intervals) - degree + 2
    rows: dict[str, list[list[int]]] = {}
    for start, window in pieces_of(degree, intervals, closed):
        rows.setdefault(text(window), []).append([(start + i) % control_points for i in range(degree + 1)])
    return Segments(automaton, _tables(rows), control_points)


def _tables(rows: Mapping[str, Sequence[Sequence[int]]]) -> dict[str, "numpy.ndarray"]:
    import numpy as np  # the solver starts without it

    return {cell: np.array(found, dtype=np.int64) for cell, found in rows.items()}
