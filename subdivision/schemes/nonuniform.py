"""Non-uniform B-splines of degree 2 and 3 by knot doubling, with finitely many states.

Halving every knot interval and dropping the factor leaves the intervals of a piece the same in its middle and
nearer to uniform on both sides: after two steps only the two end pieces differ from the uniform one. The
states are ratios of intervals; pieces, segments and closed curves share them. Source: Gentil 2010, §4.3.2,
(4.11) and (4.12) for degree 2. The cubic formulas follow from the polar form f of the piece, whose control
points are f(t_1,t_2,t_3) … f(t_4,t_5,t_6): inserting the middles of all intervals gives E and V below.
"""

from collections.abc import Sequence
from fractions import Fraction

from automata import Automaton, Cell
from subdivision.schemes.building import Amount, coefficients, edge, scheme, vertex
from subdivision.schemes.knots import Joint, Window, exact_intervals, halves, joints, ratios, text

Column = tuple[Fraction, ...]


def nonuniform_b_spline(degree: int, intervals: Sequence[Amount], closed: bool = False) -> Automaton:
    """The automaton of a B-spline of degree 2 or 3 with the given knot intervals, 0 for repeated knots.

    An open curve of n control points has `n + degree - 2` intervals, those between its second and its last
    but one knot: for degree 2 interval i belongs to P_i, for degree 3 interval i ends, and i + 1 begins, at
    P_i. A closed curve has n; interval i belongs to P_i, or for degree 3 lies between P_i and P_{i+1}.
    A piece has `degree + 1` points, a joint `degree` and one less for each repetition of its knot.

    The shape is the first piece; `nonuniform` says which control points each piece of the curve draws on, for
    `ifs.patchwork`. Without repeated knots, degree 2 leaves 2 degrees of freedom for each kind of joint;
    degree 3 leaves 3 where all intervals are equal, and more otherwise. Raises `ValueError` for other
    degrees, too few intervals, a negative one, or none of positive length where the curve would be.

    >>> import subdivision
    >>> spline = nonuniform_b_spline(2, [1, 2, 4])
    >>> spline.reachable()
    ('1:2:4', '1:2:2', '1:1:2', '1|2', '1:1:1', '1|1')
    >>> [str(x) for x in subdivision.solve(spline).numbers()["1|2"]["s"][0]]
    ['5/6', '1/3']
    """
    windows = dict.fromkeys(window for _, window in pieces_of(degree, intervals, closed))
    cells, values = _cells(degree, list(windows))
    kind = "quadratic" if degree == 2 else "cubic"
    return scheme(f"Non-uniform {kind} B-spline", cells, values)


def pieces_of(degree: int, intervals: Sequence[Amount], closed: bool) -> list[tuple[int, Window]]:
    """The first control point and the window of each piece of positive length, along the curve."""
    if degree not in (2, 3):
        raise ValueError(f"non-uniform splines have degree 2 or 3, found {degree}")
    exact = exact_intervals(intervals)
    least = degree + 1 if closed else 2 * degree - 1
    if len(exact) < least:
        raise ValueError(f"expected {least} or more knot intervals for degree {degree}, found {len(exact)}")
    first = 2 - degree if closed else 0
    count = len(exact) if closed else len(exact) - 2 * degree + 2
    found = []
    for start in range(count):
        around = [exact[(first + start + i) % len(exact)] for i in range(2 * degree - 1)]
        if around[degree - 1]:
            found.append((start, ratios(around)))
    if not found:
        raise ValueError("the curve has no knot interval of positive length")
    return found


def _cells(degree: int, windows: list[Window]) -> tuple[list[Cell], dict[str, Fraction]]:
    """The cells of all windows that some windows lead to, and of their joints, with their coefficients."""
    edges: list[Cell] = []
    vertices: dict[str, Cell] = {}
    values: dict[str, Fraction] = {}
    known = list(windows)
    for window in known:
        parts = halves(window)
        known.extend(part for part in dict.fromkeys(parts) if part not in known)
        ends = joints(window)
        names = [text(part) for part in parts]
        left, right = ((joint.name, joint.points) for joint in ends)
        edges.append(edge(degree + 1, names, left, right, name=text(window)))
        for joint, after in zip(ends, (joints(parts[0])[0], joints(parts[1])[1]), strict=True):
            _add(vertices, joint, after)
        columns = (_quadratic if degree == 2 else _cubic)(window)
        values |= coefficients(text(window), "0", dict(enumerate(columns[:-1])))
        values |= coefficients(text(window), "1", {degree: columns[-1]})
    return [*edges, *vertices.values()], values


def _add(vertices: dict[str, Cell], joint: Joint, after: Joint) -> None:
    cell = vertex(joint.points, joint.name, after.name)
    assert vertices.setdefault(joint.name, cell) == cell


def _mix(*terms: tuple[Fraction | int, Column], over: int) -> Column:
    """The sum of multiples of columns, divided by a whole number."""
    return tuple(
        sum((Fraction(weight) * x for (weight, _), x in zip(terms, row, strict=True)), Fraction(0)) / over
        for row in zip(*(column for _, column in terms), strict=True)
    )


def _unit(points: int) -> list[Column]:
    return [tuple(Fraction(row == column) for row in range(points)) for column in range(points)]


def _quadratic(window: Window) -> list[Column]:
    """Q_{2i} = ((u+2v) P_i + u P_{i+1}) / 2(u+v), Q_{2i+1} = (v P_i + (2u+v) P_{i+1}) / 2(u+v)."""
    P = _unit(3)
    columns = []
    for i in range(2):
        u, v = window[i : i + 2]
        columns.append(_mix((u + 2 * v, P[i]), (u, P[i + 1]), over=2 * (u + v)))
        columns.append(_mix((v, P[i]), (2 * u + v, P[i + 1]), over=2 * (u + v)))
    return columns


def _cubic(window: Window) -> list[Column]:
    """E = ((v+2w) P_i + (v+2u) P_{i+1}) / 2(u+v+w), v being between P_i and P_{i+1};
    V = (v E_{i-1} + (u+v) P_i + u E_i) / 2(u+v), u before and v after P_i.
    """
    P = _unit(4)
    edge_points = []
    for i in range(3):
        u, v, w = window[i : i + 3]
        edge_points.append(_mix((v + 2 * w, P[i]), (v + 2 * u, P[i + 1]), over=2 * (u + v + w)))
    columns = [edge_points[0]]
    for i in (1, 2):
        u, v = window[i : i + 2]
        before, after = edge_points[i - 1 : i + 1]
        columns.append(_mix((v, before), (u + v, P[i]), (u, after), over=2 * (u + v)))
        columns.append(after)
    return columns
