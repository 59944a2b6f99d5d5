"""Tensor-product surfaces of any two curves.

A cell of the surface is a product of a cell of either curve: the face is edge * edge, its sides are
edge * vertex and vertex * edge, its corners vertex * vertex. Control point (i, j) has the number
`i n + j`, n the points of the second factor, and operators and embeddings are Kronecker products.
"""

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import NamedTuple

import subdivision
from automata import Automaton, Boundary, Cell, Equation, Symmetry
from automata.automaton import Rows, Word
from automata.expression import Number
from automata.parameters import settled

MOST_POINTS = 400
GAP = 30.0

Matrix = Sequence[Sequence[Fraction]]

_ZERO = Number(Fraction(0))


class _Factor(NamedTuple):
    """A curve, its operators and embeddings by cell and label, and what its labels become in a product."""

    curve: Automaton
    matrices: Mapping[str, Mapping[str, Matrix]]
    sides: Mapping[str, str]
    prefix: str
    first: bool

    def product(self, own: str, still: str) -> str:
        """The name of the product of a name of this factor and one of the other."""
        return f"{own}*{still}" if self.first else f"{still}*{own}"


def tensor(first: Automaton, second: Automaton) -> Automaton:
    """The surface `S(u,v) = sum P_ij f_i(u) g_j(v)` of two curves `sum P_i f_i(u)` and `sum P_j g_j(v)`.

    `control.reshape(m, n, dim)[i, j]` is `P_ij` for m and n control points. The curves may have several
    kinds of edges and vertices and different numbers of pieces. Sub-cell `s*t` is piece s of the first and t
    of the second; `left` and `right` are the ends of u, `bottom` and `top` those of v. Operators are given
    exactly, `T_s` times `T_t` after Kronecker, and the equations of both curves are stated, so that
    `subdivision.solve` proves them and leaves 0 degrees of freedom.

    Every symmetry g of the first curve is declared as `u-g` for all products with its cell, of the second
    as `v-g`. So `ifs.patchwork` glues patches into tubes and tori, and into Moebius bands where the curve
    across has a mirror. A side at an end of u is glued to such sides only, never to one at an end of v.

    The control points are in millimetres. For plane curves `(x_i, y_i)` and `(x_j, y_j)` point (i, j) is
    `(x_i, x_j, y_i + y_j)`, so that one curve is moved along the other; otherwise they stand over a grid.

    Raises `ValueError` for an automaton that is no curve between two vertices, for more than 400 control
    points, and for labels that hold `*`; `subdivision.Undetermined` for parameters without a value.

    >>> import subdivision
    >>> from subdivision.schemes.curves import bezier, b_spline
    >>> patch = tensor(bezier(2), b_spline(3))
    >>> patch.reachable()
    ('edge*edge', 'edge*vertex', 'vertex*edge', 'vertex*vertex')
    >>> subdivision.solve(patch).degrees_of_freedom
    0
    """
    across, along = (curve.cells[curve.shape].points for curve in (first, second))
    if across * along > MOST_POINTS:
        raise ValueError(f"a surface has at most {MOST_POINTS} control points, found {across} by {along}")
    one = _factor(first, {"left": "left", "right": "right"}, "u-", True)
    other = _factor(second, {"left": "bottom", "right": "top"}, "v-", False)
    cells: dict[str, Cell] = {}
    waiting = [(first.shape, second.shape)]
    for a, b in waiting:
        if one.product(a, b) not in cells:
            p, q = one.curve.cells[a], other.curve.cells[b]
            cells[one.product(a, b)] = _product(one, p, other, q)
            waiting.extend((x, y) for x in p.subdivision.values() for y in q.subdivision.values())
            waiting.extend((end.cell, b) for end in p.boundary.values())
            waiting.extend((a, end.cell) for end in q.boundary.values())
    control = tuple((x, y, z + h) for x, z in _profile(one.curve) for y, h in _profile(other.curve))
    shape = one.product(first.shape, second.shape)
    return Automaton(f"{first.name} by {second.name}", shape, cells, control=control)


def _factor(curve: Automaton, sides: Mapping[str, str], prefix: str, first: bool) -> _Factor:
    curve = settled(curve)
    reachable = curve.reachable()
    for name in reachable:
        _check(curve, curve.cells[name])
    solved = subdivision.solve(curve).numbers()
    matrices = {}
    for name in reachable:
        known = {
            label: [[entry.value for entry in row if isinstance(entry, Number)] for row in end.matrix]
            for label, end in curve.cells[name].boundary.items()
        }
        matrices[name] = {**known, **solved[name]}
    return _Factor(curve, matrices, sides, prefix, first)


def _check(curve: Automaton, cell: Cell) -> None:
    """A cell of a curve is an edge between two vertices, or a vertex; the shape is an edge."""
    if any("*" in label for label in (cell.name, *cell.subdivision, *cell.symmetry)):
        raise ValueError(f"{curve.name!r}: names and labels of cell {cell.name!r} may not hold '*'")
    if set(cell.boundary) == {"left", "right"}:
        fits = not any(curve.cells[border.cell].boundary for border in cell.boundary.values())
    else:
        fits = not cell.boundary and len(cell.subdivision) == 1 and cell.name != curve.shape
    if not fits:
        found = f"{len(cell.subdivision)} pieces and the boundaries {', '.join(cell.boundary) or 'none'}"
        raise ValueError(f"{curve.name!r} is no curve: its cells are edges between the vertices 'left' and "
                         f"'right', and vertices of one piece; cell {cell.name!r} has {found}")  # fmt: skip


def _product(one: _Factor, p: Cell, other: _Factor, q: Cell) -> Cell:
    name = one.product(p.name, q.name)
    pieces = {
        one.product(s, t): one.product(x, y)
        for s, x in p.subdivision.items()
        for t, y in q.subdivision.items()
    }
    matrices = {
        one.product(s, t): _kronecker(one.matrices[p.name][s], other.matrices[q.name][t])
        for s in p.subdivision
        for t in q.subdivision
    }
    sides = _sides(one, p, other, q) | _sides(other, q, one, p)
    stated = {
        kind: tuple(
            Equation(left, right, f"{' '.join(left)} = {' '.join(right)}", ("cells", name, kind, i))
            for i, (left, right) in enumerate(
                [
                    *_equations(one, p, getattr(p, kind), other, q),
                    *_equations(other, q, getattr(q, kind), one, p),
                ]
            )
        )
        for kind in ("incidence", "adjacency")
    }
    return Cell(
        name,
        p.points * q.points,
        pieces,
        # Sides are listed as they follow each other counterclockwise around a face.
        {side: sides[side] for side in ("bottom", "right", "top", "left") if side in sides},
        _symmetries(one, p, other, q) | _symmetries(other, q, one, p),
        stated["incidence"],
        stated["adjacency"],
        matrices,
    )


def _sides(factor: _Factor, cell: Cell, other: _Factor, still: Cell) -> dict[str, Boundary]:
    """The boundaries of a product at the ends of one factor, all of the other one being kept."""
    kept = [[Fraction(i == j) for j in range(still.points)] for i in range(still.points)]
    found = {}
    for label, end in cell.boundary.items():
        own = factor.matrices[cell.name][label]
        matrix = _kronecker(own, kept) if factor.first else _kronecker(kept, own)
        found[factor.sides[label]] = Boundary(factor.product(end.cell, still.name), matrix)
    return found


def _symmetries(factor: _Factor, cell: Cell, other: _Factor, still: Cell) -> dict[str, Symmetry]:
    """The symmetries of one factor, as those of a product; they leave the other factor as it is."""
    return {
        factor.prefix + name: Symmetry(
            _permuted(symmetry.points, still.points, factor.first),
            {
                factor.product(s, t): (factor.product(image[0], t), *_prefixed(factor, image[1:]))
                for s, image in symmetry.subdivision.items()
                for t in still.subdivision
            },
            {
                factor.sides[label]: (factor.sides[image[0]], *_prefixed(factor, image[1:]))
                for label, image in symmetry.boundary.items()
            }
            | {other.sides[label]: (other.sides[label], factor.prefix + name) for label in still.boundary},
        )
        for name, symmetry in cell.symmetry.items()
    }


def _permuted(points: Sequence[int], still: int, first: bool) -> tuple[int, ...]:
    if first:
        return tuple(image * still + j for image in points for j in range(still))
    return tuple(i * len(points) + image for i in range(still) for image in points)


def _prefixed(factor: _Factor, symmetries: Word) -> Word:
    return tuple(factor.prefix + name for name in symmetries)


def _equations(
    factor: _Factor, cell: Cell, stated: Sequence[Equation], other: _Factor, still: Cell
) -> Iterator[tuple[Word, Word]]:
    """The equations of one factor, along every path of as many sub-cells of the other."""
    for equation in stated:
        steps, others = (_steps(factor.curve, cell, side) for side in (equation.left, equation.right))
        if steps != others:
            raise ValueError(
                f"{factor.curve.name!r}: the sides of {equation.text!r} are subdivided {steps} and {others} "
                "times; a product needs equations between equal levels"
            )
        for path in _paths(other.curve, still.name, steps):
            yield (
                _word(factor, cell.name, equation.left, path),
                _word(factor, cell.name, equation.right, path),
            )


def _steps(curve: Automaton, cell: Cell, word: Word) -> int:
    """How many labels of a word are those of sub-cells."""
    ends = [curve.cells[curve.end(cell.name, word[:i])] for i in range(len(word))]
    return sum(label in end.subdivision for label, end in zip(word, ends, strict=True))


def _paths(curve: Automaton, cell: str, length: int) -> Iterator[Word]:
    if not length:
        yield ()
        return
    for label, target in curve.cells[cell].subdivision.items():
        yield from ((label, *rest) for rest in _paths(curve, target, length - 1))


def _word(factor: _Factor, cell: str, word: Word, path: Word) -> Word:
    """A word of one factor as one of the product: the other factor goes along a path of sub-cells."""
    rest = iter(path)
    found = []
    for label in word:
        here = factor.curve.cells[cell]
        if label in here.subdivision:
            found.append(factor.product(label, next(rest)))
        else:
            found.append(factor.sides[label] if label in here.boundary else factor.prefix + label)
        cell = factor.curve.end(cell, (label,))
    return tuple(found)


def _kronecker(one: Matrix, other: Matrix) -> Rows:
    return tuple(
        tuple(Number(a * b) if a and b else _ZERO for a in row for b in line) for row in one for line in other
    )


def _profile(curve: Automaton) -> list[tuple[float, float]]:
    """Where the control points of a curve stand over the axis of the surface, and how high."""
    if curve.control is not None and all(len(point) == 2 for point in curve.control):
        return [(point[0], point[1]) for point in curve.control]
    return [(GAP * i, GAP * (i % 2)) for i in range(curve.cells[curve.shape].points)]
