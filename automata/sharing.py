"""Incidence and adjacency equations from a smaller statement: which pieces share which of their boundaries.

`share = ["0 right = 1 left", …]` says that the pieces 0 and 1 have a boundary in common. What follows: an
adjacency through the symmetry that makes the ends of that boundary meet, and, for every boundary of
a piece that is shared with nobody, an incidence with a piece of the whole cell's boundary of the same name.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from automata.automaton import Automaton, Cell, Equation, Word
from automata.error import AutomatonError
from automata.symmetry import Permutation, compose
from automata.topology import Topology

Side = tuple[str, str]
"""A piece and one of its boundaries."""


def with_shared(automaton: Automaton) -> Automaton:
    """The automaton with the equations that its `share` statements bring.

    Raises `AutomatonError` with the path of a statement that leaves something open, saying what to write.
    """
    for name in _from_small_to_large(automaton):
        cell = automaton.cells[name]
        if cell.share:
            automaton = _replaced(automaton, _completed(automaton, cell))
    return automaton


def _replaced(automaton: Automaton, cell: Cell) -> Automaton:
    return replace(automaton, cells={**automaton.cells, cell.name: cell})


def _completed(automaton: Automaton, cell: Cell) -> Cell:
    if cell.incidence or cell.adjacency:
        raise _error(cell, "a cell has either 'share' or its own 'incidence' and 'adjacency'")
    shared = [_sides(cell, equation) for equation in cell.share]
    once = {side for pair in shared for side in pair}
    lone = [
        (label, border)
        for label, target in cell.subdivision.items()
        for border in automaton.cells[target].boundary
        if (label, border) not in once
    ]
    incidence = tuple(_incidences(automaton, cell, shared, lone))
    loose = replace(cell, incidence=incidence)
    topology = Topology(_replaced(automaton, loose))
    adjacency = tuple(_adjacency(topology, loose, equation) for equation in cell.share)
    return replace(loose, adjacency=adjacency)


def _sides(cell: Cell, equation: Equation) -> tuple[Side, Side]:
    for side in (equation.left, equation.right):
        if len(side) < 2 or side[0] not in cell.subdivision:
            message = f"each side of {equation.text!r} is a piece, then one of its boundaries"
            raise AutomatonError(message, path=equation.path)
    return (equation.left[0], equation.left[1]), (equation.right[0], equation.right[1])


def _incidences(
    automaton: Automaton, cell: Cell, shared: Sequence[tuple[Side, Side]], lone: Sequence[Side]
) -> Iterator[Equation]:
    for border, embedding in cell.boundary.items():
        whole = automaton.cells[embedding.cell]
        keepers = [label for label, own in lone if own == border]
        if len(keepers) != len(whole.subdivision):
            raise _error(
                cell,
                f"boundary {border!r} has {len(whole.subdivision)} pieces, but {len(keepers)} pieces of the "
                f"cell have a boundary {border!r} that is shared with nobody: write the incidences instead",
            )
        pieces = list(whole.subdivision)
        if len(pieces) > 1:
            keepers, pieces = _along(automaton, cell, border, shared, lone, keepers)
        for piece, keeper in zip(pieces, keepers, strict=True):
            text = f"{border} {piece} = {keeper} {border}"
            yield Equation((border, piece), (keeper, border), f"{text} (by share)", cell.share[0].path)
    strangers = [f"{label} {own}" for label, own in lone if own not in cell.boundary]
    if strangers:
        message = f"{strangers[0]!r} is shared with nobody, and no boundary of the cell is called so"
        raise _error(cell, message)


def _along(
    automaton: Automaton,
    cell: Cell,
    border: str,
    shared: Sequence[tuple[Side, Side]],
    lone: Sequence[Side],
    keepers: Sequence[str],
) -> tuple[list[str], list[str]]:
    """The sub-cells that keep a boundary, and the pieces of that boundary, both walked from one corner."""
    whole = automaton.cells[cell.boundary[border].cell]
    coincident = Topology(automaton).coincident(cell.name)
    for end in whole.boundary:
        first = [e.right[0] for e in whole.incidence if e.left[0] == end and e.right[0] in whole.subdivision]
        corner = coincident[(border, end)][0]
        others = {path[0] for path, (standing, _) in coincident.items() if standing == corner} - {border}
        at_corner = [k for k in keepers if any((k, other) in lone for other in others)]
        if len(first) == len(at_corner) == 1:
            links = [(e.left[0], e.right[0]) for e in whole.adjacency]
            pieces = _walk(first[0], links, list(whole.subdivision))
            steps = [(one[0], other[0]) for one, other in shared]
            found = _walk(at_corner[0], steps, keepers)
            if len(pieces) == len(whole.subdivision) and len(found) == len(keepers):
                return found, pieces
    raise _error(cell, f"the order of the pieces along {border!r} is open: write the incidences instead")


def _walk(start: str, links: Sequence[tuple[str, str]], allowed: Sequence[str]) -> list[str]:
    """The labels met from one end of a chain of links to the other."""
    walk = [start]
    while True:
        nearby = [b for a, b in links if a == walk[-1]] + [a for a, b in links if b == walk[-1]]
        onward = [label for label in nearby if label in allowed and label not in walk]
        if len(onward) != 1:
            return walk
        walk.append(onward[0])


def _adjacency(topology: Topology, cell: Cell, equation: Equation) -> Equation:
    """The shared boundary seen through the one symmetry that makes its ends meet."""
    if len(equation.right) > 2 or len(equation.left) > 2:
        return equation
    automaton = topology.automaton
    border = automaton.cells[automaton.end(cell.name, equation.left)]
    fitting = [word for element, word in _words(border).items() if _fits(topology, cell, equation, element)]
    if len(fitting) > 1 and len(topology.groups.elements[border.name]) > 1:
        names = ", ".join(border.symmetry)
        raise AutomatonError(
            f"{equation.text!r} leaves open through which symmetry of cell {border.name!r} the two see each "
            f"other: write it after the right side ({names})",
            path=equation.path,
        )
    if not fitting:
        raise AutomatonError(
            f"no declared symmetry of cell {border.name!r} makes the ends of {equation.text!r} meet: "
            "declare the one that turns it around",
            path=equation.path,
        )
    right = (*equation.right, *fitting[0])
    return replace(equation, right=right, text=f"{' '.join(equation.left)} = {' '.join(right)} (by share)")


def _fits(topology: Topology, cell: Cell, equation: Equation, element: Permutation) -> bool:
    """Whether the ends of a boundary that the incidences already identify are the ones that would meet."""
    border = topology.automaton.end(cell.name, equation.left)
    place: Mapping = topology.subdivided(cell.name).place
    ends = topology.automaton.cells[border].boundary
    for end in ends:
        here = place[(*equation.left, end)][0]
        meets = [other for other in ends if place[(*equation.right, other)][0] == here]
        if meets and topology.groups.elements[border][element][end][0] not in meets:
            return False
    return True


def _words(cell: Cell) -> dict[Permutation, Word]:
    """The shortest product of declared symmetries for each element of a cell's group."""
    identity: Permutation = tuple(range(cell.points))
    found: dict[Permutation, Word] = {identity: ()}
    queue = [identity]
    for element in queue:
        for name, symmetry in cell.symmetry.items():
            product = compose(element, symmetry.points)
            if product not in found:
                found[product] = (*found[element], name)
                queue.append(product)
    return found


def _from_small_to_large(automaton: Automaton) -> list[str]:
    """The cells, each after the cells of its boundaries."""
    order: list[str] = []
    rest = dict.fromkeys(automaton.cells)
    while rest:
        ready = [n for n in rest if not any(b.cell in rest for b in automaton.cells[n].boundary.values())]
        order += ready
        for name in ready:
            del rest[name]
    return order


def _error(cell: Cell, message: str) -> AutomatonError:
    return AutomatonError(message, path=cell.share[0].path[:-1])
