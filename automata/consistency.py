"""What must hold of a description before its matrices are sought.

Cells that equations force to be one can be one; stated coherences of embeddings are true; the corners that
several boundaries share are seen through symmetries that are declared; and the gluing, carried on to the
corners, keeps apart those of each sub-cell, which it does not when an edge is glued the wrong way round.
Source: Gentil 2010, §4.4.1.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from fractions import Fraction

from automata.automaton import Automaton, Cell, Equation, Word
from automata.error import AutomatonError
from automata.expression import Number
from automata.merging import merged
from automata.parameters import settled
from automata.symmetry import Groups, Permutation, compose, inverse
from automata.topology import Topology, embedding

_ZERO = Number(Fraction(0))


def require_consistency(automaton: Automaton) -> None:
    """Raise `AutomatonError`, with the path of the statement, for what cannot hold together.

    >>> import automata
    >>> require_consistency(automata.read("doo-sabin-patch"))
    """
    whole = merged(settled(automaton)).automaton
    _require_ends(whole)
    _require_coherence(whole)
    deep = [cell for cell in whole.cells.values() if _has_corners(whole, cell)]
    if not deep:
        return
    topology = Topology(whole)
    for cell in deep:
        topology.boundaries(cell.name)  # too many are refused before anything is glued
    for cell in deep:
        _require_turns(topology, cell)
        if any(_has_corners(whole, whole.cells[target]) for target in cell.subdivision.values()):
            _require_gluing(topology, cell)


def _has_corners(automaton: Automaton, cell: Cell) -> bool:
    return any(automaton.cells[border.cell].boundary for border in cell.boundary.values())


def _require_ends(automaton: Automaton) -> None:
    """No cell is its own boundary once cells are merged."""
    rest = dict(automaton.cells)
    while rest:
        done = [n for n, cell in rest.items() if not any(b.cell in rest for b in cell.boundary.values())]
        if not done:
            name = next(iter(rest))
            message = "the equations make this cell its own boundary, with " + ", ".join(rest)
            raise AutomatonError(message, path=("cells", name, "boundary"))
        for name in done:
            del rest[name]


def _require_coherence(automaton: Automaton) -> None:
    """`B_1 B_0 = B_0 B_1 g` as matrices, where the description says so."""
    for cell in automaton.cells.values():
        for equation in cell.coherence:
            sides = [
                _columns(automaton, cell.name, side, equation) for side in (equation.left, equation.right)
            ]
            if sides[0] != sides[1]:
                shown = " and ".join(_shown(side) for side in sides)
                message = f"{equation.text!r} does not hold: its sides select {shown}"
                raise AutomatonError(message, path=equation.path)


def _columns(automaton: Automaton, cell: str, word: Word, equation: Equation) -> tuple:
    here, path, order = cell, [], None
    for label in word:
        known = automaton.cells[here]
        if label in known.symmetry and here == automaton.end(cell, word) and path:
            points = known.symmetry[label].points
            order = points if order is None else compose(order, points)
        elif label in known.boundary and order is None:
            path.append(label)
            here = known.boundary[label].cell
        else:
            message = f"a coherence has boundaries, then symmetries; {label!r} is in the way"
            raise AutomatonError(message, path=equation.path)
    columns = embedding(automaton, cell, tuple(path))
    return columns if order is None else tuple(columns[i] for i in order)


def _shown(columns: tuple) -> str:
    selected = _selected(columns)
    return f"points {list(selected)}" if selected else "mixtures of points"


def _selected(columns: tuple) -> tuple[int, ...] | None:
    """The points that an embedding selects, or None when it does not select."""
    if all(len(column) == 1 and column[0][1] == 1 for column in columns):
        return tuple(column[0][0] for column in columns)
    return None


def _require_turns(topology: Topology, cell: Cell) -> None:
    """Paths to a corner that select the same points in another order need a symmetry of the corner."""
    automaton = topology.automaton
    first: dict[tuple[str, frozenset[int]], tuple[Word, tuple[int, ...]]] = {}
    for path in topology.boundaries(cell.name):
        end = automaton.end(cell.name, path)
        points = _selected(embedding(automaton, cell.name, path))
        if points is None or not topology.is_point(end) or len(path) < 2:
            continue
        other, seen = first.setdefault((end, frozenset(points)), (path, points))
        turn: Permutation = tuple(seen.index(point) for point in points)
        if turn not in topology.groups.elements[end]:
            raise AutomatonError(
                f"{' '.join(other)!r} and {' '.join(path)!r} are one corner seen from two sides, its points "
                f"in another order: declare a symmetry of cell {end!r} with points {list(turn)}",
                path=("cells", cell.name, "boundary", path[0]),
            )


def _require_gluing(topology: Topology, cell: Cell) -> None:
    subdivided = topology.subdivided(cell.name)
    merged_corners = next(_merged_corners(topology, cell, subdivided.place), None)
    if merged_corners is None and not subdivided.folded:
        return
    _require_ways_round(topology, cell)
    if merged_corners is not None:
        label, one, other = merged_corners
        raise AutomatonError(
            f"the gluing makes {' '.join(one)!r} and {' '.join(other)!r} of sub-cell {label!r} one cell, "
            "which they are not: an equation glues the wrong boundaries, or lacks a symmetry",
            path=("cells", cell.name, "adjacency"),
        )
    word = subdivided.folded[0]
    raise AutomatonError(
        f"the gluing makes {' '.join(word)!r} equal to itself turned: an equation lacks a symmetry or has "
        "one too many",
        path=("cells", cell.name, "adjacency"),
    )


def _merged_corners(topology: Topology, cell: Cell, place: Mapping) -> Iterator[tuple[str, Word, Word]]:
    """Different corners of one sub-cell that the gluing makes one, where no equation glues it to itself."""
    glued = {e.left[0] for e in cell.equations if e.left[0] == e.right[0] and e.left[0] in cell.subdivision}
    for label, target in cell.subdivision.items():
        if label in glued:
            continue
        coincident = topology.coincident(target)
        met: dict[tuple[str, Word], Word] = {}
        for path in topology.boundaries(target):
            standing = coincident[path][0]
            if standing != path:
                continue
            end = topology.automaton.end(target, path)
            before = met.setdefault((end, place[(label, *path)][0]), path)
            if before != path:
                yield label, before, path


def _require_ways_round(topology: Topology, cell: Cell) -> None:
    """Each adjacency joins those ends of its boundary which the incidences say are one."""
    automaton = topology.automaton
    loose = replace(automaton, cells={**automaton.cells, cell.name: replace(cell, adjacency=())})
    place = Topology(loose).subdivided(cell.name).place
    for equation in cell.adjacency:
        left, p = topology.groups.normal(cell.name, equation.left)
        right, q = topology.groups.normal(cell.name, equation.right)
        border = automaton.cells[automaton.end(cell.name, left)]
        element = compose(q, inverse(p))
        for end in border.boundary:
            image = topology.groups.elements[border.name][element][end][0]
            meets = [
                other
                for other in border.boundary
                if (*left, end) in place
                and (*right, other) in place
                and place[(*left, end)][0] == place[(*right, other)][0]
            ]
            if meets and image not in meets:
                raise AutomatonError(
                    _wrong_way(topology.groups, border, equation, end, image, meets[0]), path=equation.path
                )


def _wrong_way(groups: Groups, border: Cell, equation: Equation, end: str, image: str, meets: str) -> str:
    text = (
        f"{equation.text!r} glues cell {border.name!r} the wrong way round: it joins {end!r} to {image!r}, "
        f"where the incidences join {end!r} to {meets!r}"
    )
    declared = [
        name
        for name, symmetry in border.symmetry.items()
        if groups.elements[border.name][symmetry.points][image][0] == meets
        or groups.elements[border.name][symmetry.points][meets][0] == image
    ]
    if declared:
        return f"{text}; write the symmetry {declared[0]!r} after it, or take it away"
    points = _reversal(border, image, meets)
    shown = f" with points {points}" if points else ""
    return f"{text}; declare a symmetry of cell {border.name!r}{shown} that exchanges them, and use it here"


def _reversal(border: Cell, one: str, other: str) -> list[int] | None:
    """The reversed order of a cell's points, where it exchanges the points of two boundaries."""
    chosen = [
        {i for i, row in enumerate(border.boundary[label].matrix) if any(entry != _ZERO for entry in row)}
        for label in (one, other)
    ]
    if {border.points - 1 - point for point in chosen[0]} == chosen[1]:
        return list(reversed(range(border.points)))
    return None
