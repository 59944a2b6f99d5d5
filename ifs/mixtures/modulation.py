"""Mixtures of operators: one weight everywhere, or at each address the weights of that address.

With the same weights everywhere, `T_i = sum_k mu_k T_i^k` is a system again, and glued alike, since the
equations are linear where all embeddings are the same. Source: Gentil 2010, §5.1.2 and §5.1.3. The source
says that it is an IFS whenever all parts are; that holds for parts that contract in one norm. `[[0, 4], [0,
0]]` and its transpose have radius 0, their mean has 2. So certify the result: `ifs.convergence`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
from jaxtyping import Float, Int

from automata import Automaton, Cell
from automata.automaton import Rows, Word
from automata.expression import Number
from automata.topology import Topology, embedding
from ifs.asked import require_whole
from ifs.certificates.bounds import sample
from ifs.complex import Complex, initial, refined
from ifs.dimensions.alike import Cells, DifferentGluing, Factor, alike, factor
from ifs.drawing import corner_paths
from ifs.mesh import Mesh
from ifs.shape import Shape
from ifs.shape import shape as shape_of
from ifs.system import System

_SETTLED = 200  # steps after which a vertex of several control points has come to its limit
_CHUNK = 1 << 14

Words = Int[np.ndarray, "_pieces _depth"]


def combined(shapes: Sequence[Shape], weights: Sequence[float | Fraction]) -> Shape:
    """The shape with operators `sum_k mu_k T_i^k` and control points `sum_k mu_k P_k` (mm).

    The weights sum to 1; floats stand for the binary fractions that they are, and the last weight is taken as
    what is left. Symmetries are kept where all shapes have them. Raises `DifferentGluing` for shapes that are
    not glued alike or whose corresponding cells have different embeddings or numbers of points, and
    `ValueError` for weights that do not fit.

    >>> import ifs
    >>> from subdivision.schemes import bezier, takagi
    >>> half = combined([ifs.shape(bezier(2)), ifs.shape(takagi())], [0.5, 0.5])
    >>> half.system.states["edge"].operators[0][:, 1].tolist()
    [0.375, 0.75, -0.125]
    """
    mu = _weights(weights, len(shapes))
    factors = [factor(one.automaton) for one in shapes]
    _require_same_spaces(factors)
    first = factors[0].automaton
    cells = {name: _cell(factors, cell, mu) for name, cell in first.cells.items()}
    control = sum(float(m) * one.control for m, one in zip(mu, shapes, strict=True))
    name = " and ".join(dict.fromkeys(one.name for one in factors))
    return shape_of(Automaton(name, first.shape, cells), control=np.asarray(control))


def modulated(shapes: Sequence[Shape], blend: Shape, depth: int) -> Mesh:
    """The mesh of the source's mixed shape: at address s the point of `combined` with the weights mu(s).

        `p(s) = P^mu lim T_s1^mu T_s2^mu … T_sn^mu p`,    `mu = mu(s)`,

    mu(s) the point of `blend`, whose control points are `(points, shapes)`, rows that sum to 1. The weights
    of a point are frozen in all its operators; `mixing` blends the points instead. Both meet where a
    weight is 1. The mesh, in mm, shares the vertices of the gluing: two addresses of one vertex have the same
    weights, and the gluing holds for each choice of them.

    Raises what `combined` raises, and `ValueError` for a negative depth, a blend that does not fit, or cells
    that have no corners.

    >>> import ifs, numpy as np
    >>> from subdivision.schemes import bezier, takagi
    >>> blend = ifs.shape(bezier(1), control=np.eye(2))
    >>> modulated([ifs.shape(bezier(2)), ifs.shape(takagi())], blend, 3).vertices.shape
    (9, 2)
    """
    require_whole("depth", depth)
    factors = [factor(one.automaton) for one in shapes]
    _require_same_spaces(factors)
    _require_same_names([factors[0], factor(blend.automaton)])
    _require_blend(blend, len(shapes))
    complex_ = refined(initial(blend.topology, blend.system, blend.control), depth)
    return _drawn(complex_, shapes, depth)


def _weights(weights: Sequence[float | Fraction], count: int) -> list[Fraction]:
    mu = [Fraction(weight) for weight in weights]
    if len(mu) != count or not mu or abs(sum(mu) - 1) > Fraction(1, 10**9):
        raise ValueError(f"expected {count} weights that sum to 1, found {[float(m) for m in mu]}")
    return [*mu[:-1], 1 - sum(mu[:-1], Fraction(0))]


def _require_blend(blend: Shape, count: int) -> None:
    if blend.control.shape[1] != count:
        raise ValueError(f"the blend has {blend.control.shape[1]} weights for {count} shapes")
    off = abs(blend.control.sum(axis=1) - 1)
    if not (off <= 1e-9).all():
        row = int(np.argmax(off))
        raise ValueError(
            f"the weights at control point {row} of the blend sum to {1 + off[row]:g}, expected 1"
        )


def _require_same_names(factors: Sequence[Factor]) -> tuple[Cells, ...]:
    """The cells that correspond go by one name, and list their sub-cells in one order."""
    found = alike(factors)
    for cells in found:
        for one, cell in zip(factors, cells, strict=True):
            orders = [list(f.cell(c).subdivision) for f, c in ((factors[0], cells[0]), (one, cell))]
            if cell != cells[0] or orders[0] != orders[1]:
                what = f"names and order differ: sub-cells {orders[0]} and {orders[1]}"
                raise DifferentGluing((factors[0].name, one.name), (cells[0], cell), "", what)
    return found


def _require_same_spaces(factors: Sequence[Factor]) -> None:
    """Corresponding cells have as many points, and the same embeddings."""
    first = factors[0]
    for cells in _require_same_names(factors):
        for one, cell in zip(factors, cells, strict=True):
            mine, theirs = first.cell(cells[0]), one.cell(cell)
            label = next(
                (b for b in mine.boundary if mine.boundary[b].matrix != theirs.boundary[b].matrix), None
            )
            if mine.points != theirs.points:
                what = f"they have {mine.points} and {theirs.points} control points"
                raise DifferentGluing((first.name, one.name), (cells[0], cell), "", what)
            if label is not None:
                what = f"the embeddings {label!r} differ"
                raise DifferentGluing((first.name, one.name), (cells[0], cell), label, what)


def _cell(factors: Sequence[Factor], cell: Cell, mu: Sequence[Fraction]) -> Cell:
    shared = {
        name: symmetry
        for name, symmetry in cell.symmetry.items()
        if all(one.cell(cell.name).symmetry.get(name) == symmetry for one in factors)
    }
    matrices = {
        label: _mean([one.matrices[cell.name][label] for one in factors], mu) for label in cell.subdivision
    }
    return replace(cell, symmetry=shared, matrices=matrices)


def _mean(matrices: Sequence, mu: Sequence[Fraction]) -> Rows:
    return tuple(
        tuple(
            Number(sum((m * v for m, v in zip(mu, e, strict=True)), Fraction(0)))
            for e in zip(*rows, strict=True)
        )
        for rows in zip(*matrices, strict=True)
    )


@dataclass(frozen=True)
class _Operators:
    """All operators of each shape in matrices of one size; `number[cell][i]` is the place of one."""

    stack: Float[np.ndarray, "shapes operators size size"]
    number: Mapping[str, Sequence[int]]


def _operators(systems: Sequence[System]) -> _Operators:
    states = systems[0].states
    size = max(state.points for state in states.values())
    number, total = {}, 0
    for name, state in states.items():
        number[name] = range(total, total := total + len(state.operators))
    stack = np.zeros((len(systems), total, size, size))
    for k, system in enumerate(systems):
        for name, places in number.items():
            for place, operator in zip(places, system.states[name].operators, strict=True):
                stack[k, place, : operator.shape[0], : operator.shape[1]] = operator
    return _Operators(stack, number)


def _words(system: System, number: Mapping[str, Sequence[int]], depth: int) -> dict[str, Words]:
    """The operators that lead to each piece, in the order in which the engine keeps the pieces."""
    words = {system.shape: np.zeros((1, 0), dtype=np.int64)}
    for _ in range(depth):
        found: dict[str, list] = {}
        for cell, here in words.items():
            for place, target in zip(number[cell], system.states[cell].targets, strict=True):
                longer = np.pad(here, ((0, 0), (0, 1)), constant_values=place)
                found.setdefault(target, []).append(longer)
        words = {cell: np.concatenate(parts) for cell, parts in found.items()}
    return words


def _drawn(complex_: Complex, shapes: Sequence[Shape], depth: int) -> Mesh:
    """Every corner of every piece, its weights those of the blend there."""
    topology, total = complex_.topology, 0
    start: dict[str, int] = {}
    for cell, count in complex_.counts.items():
        if topology.is_point(cell):
            start[cell], total = total, total + count
    operators = _operators([one.system for one in shapes])
    control = np.stack([one.control for one in shapes])
    limits = sample(complex_.system)
    vertices = np.full((total, control.shape[2]), np.nan)
    tables = []
    for cell, words in _words(shapes[0].system, operators.number, depth).items():
        columns = []
        for path in corner_paths(topology, cell):
            end = topology.automaton.end(cell, path)
            at = start[end] + complex_.boundary_at(cell, path, np.arange(len(words))).ids
            share = _embedded(topology, cell, path) @ limits[end]
            mu = np.einsum("p,npk->nk", share, complex_.control[cell])
            into = _embedded(shapes[0].topology, cell, path)
            last = _ending(shapes[0].system, operators.number, end)
            for some in np.array_split(np.arange(len(words)), -(-len(words) // _CHUNK)):
                vertices[at[some]] = _points(operators, control, into, last, words[some], mu[some])
            columns.append(at)
        if len(columns) < 2:
            raise ValueError(f"cell {cell!r} has no corners to draw")
        tables.append(np.stack(columns, axis=1))
    width = max(table.shape[1] for table in tables)
    faces = np.concatenate([np.pad(t, ((0, 0), (0, width - t.shape[1])), constant_values=-1) for t in tables])
    used = np.unique(faces[faces >= 0])
    return Mesh(vertices[used], np.where(faces >= 0, np.searchsorted(used, faces), -1))


def _embedded(topology: Topology, cell: str, path: Word) -> Float[np.ndarray, "_points _vertex_points"]:
    """The embedding of the cell at the end of a boundary path."""
    columns = embedding(topology.automaton, cell, path)
    matrix = np.zeros((topology.automaton.cells[cell].points, len(columns)))
    for j, column in enumerate(columns):
        for row, value in column:
            matrix[row, j] = float(value)
    return matrix


def _ending(system: System, number: Mapping[str, Sequence[int]], vertex: str) -> list[int]:
    """The operators that a vertex repeats, as often as its limit needs."""
    steps = _SETTLED if system.states[vertex].points > 1 else 0
    found = []
    for _ in range(steps):
        found.append(number[vertex][0])
        vertex = system.states[vertex].targets[0]
    return found


def _points(
    operators: _Operators,
    control: Float[np.ndarray, "shapes points dim"],
    into: Float[np.ndarray, "cell_points vertex_points"],
    last: Sequence[int],
    words: Int[np.ndarray, "n depth"],
    mu: Float[np.ndarray, "n shapes"],
) -> Float[np.ndarray, "n dim"]:
    """`P^mu T_w^mu B x`, x the limit of the vertex that B embeds, each row with weights of its own."""
    count, size = len(words), operators.stack.shape[2]
    columns = np.zeros((count, size))
    columns[:, : into.shape[1]] = 1 / into.shape[1]
    for place in reversed(last):
        columns = np.einsum("nk,kij,nj->ni", mu, operators.stack[:, place], columns, optimize=True)
    columns = columns[:, : into.shape[1]] @ np.pad(into, ((0, size - len(into)), (0, 0))).T
    for step in reversed(range(words.shape[1])):
        each = np.einsum("nk,knij->nij", mu, operators.stack[:, words[:, step]])
        columns = np.einsum("nij,nj->ni", each, columns)
    return np.einsum("nk,kpd,np->nd", mu, control, columns[:, : control.shape[1]], optimize=True)
