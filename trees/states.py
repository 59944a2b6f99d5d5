"""Trees from an automaton: states that say what their two halves are, each worked out once."""

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from trees.cube import Cube, unit_cube
from trees.doors import whole
from trees.errors import TooManyPieces, TreeError
from trees.shared import BLACK, MAX_NODES, WHITE, check_depth, renumbered
from trees.tree import Tree

State = Hashable
Place = tuple[State, int, bool]
Name = TypeVar("Name", bound=Hashable)
Halves = Callable[[State, int], "bool | tuple[State, State]"]


def from_states(halves: Halves, start: State, cube: Cube, bits: int) -> Tree:
    """The set of a deterministic automaton that reads paths of halvings.

    `halves(state, axis)` tells the state of a box that is next halved along `axis`: True where the box
    is black, False where it is white, else the states of its low and its high half. A state that is
    still neither at a cell makes it black: the upper envelope. Equal states at one level are worked
    out once, so a self-similar set takes a few steps a level, at any precision.

    States are hashable, and equal ones are the same; but 0 and 1 are not the colours False and True.

    Raises `TreeError` where the function returns something else or a state is not hashable, or above 512
    levels; `TooManyPieces` above 2^28 nodes.

    >>> def below_the_diagonal(state, axis):     # x + y < 1 in the unit square
    ...     if state == "square":
    ...         return "left", "right"
    ...     if state == "left":
    ...         return True, "square"
    ...     return ("square", False) if state == "right" else state
    >>> from_states(below_the_diagonal, "square", unit_cube(2), bits=20).measure
    0.5000004768371582
    """
    bits = whole(bits, "bits")
    check_depth(cube.dimension, bits)
    depth = cube.dimension * bits
    # A state is kept with the answer whether it is a colour: True and 1 are equal, and not the same state.
    made: dict[Place, int] = {}
    nodes: dict[tuple[int, int], int] = {}
    stack: list[Place] = [_place(start, 0)]
    children: dict[Place, tuple[Place, Place]] = {}
    while stack:
        here = stack[-1]
        state, level, colour = here
        if here in made:
            stack.pop()
            continue
        if here not in children:
            answer = state if colour else halves(state, level % cube.dimension)
            if isinstance(answer, bool | np.bool_) or level == depth:
                white = isinstance(answer, bool | np.bool_) and not answer
                made[here] = WHITE if white else BLACK
                stack.pop()
                continue
            if not isinstance(answer, tuple) or len(answer) != 2:
                raise TreeError(
                    f"state {state!r} at level {level} gives {answer!r}: True, False or two states are needed"
                )
            children[here] = _place(answer[0], level + 1), _place(answer[1], level + 1)
        due = [half for half in children[here] if half not in made]
        if due:
            stack.extend(reversed(due))
            continue
        low, high = (made[half] for half in children.pop(here))
        made[here] = low if low == high <= BLACK else nodes.setdefault((low, high), len(nodes) + 2)
        if len(nodes) > MAX_NODES:
            raise TooManyPieces(len(nodes), MAX_NODES)
        stack.pop()
    pairs = np.array(list(nodes), dtype=np.int64).reshape(-1, 2)
    return Tree(cube, bits, renumbered(depth, made[_place(start, 0)], pairs[:, 0], pairs[:, 1]))


def from_substitution(
    rules: Mapping[Name, Sequence[State]], start: Name, bits: int, cube: Cube | None = None
) -> Tree:
    """Cells cut into `2^k` cells by rules: `rules[state]` are the states of the children, Morton order.

    A child may be True (black) or False (white). Sierpinski's tetrahedron, lattice-aligned curves and
    other systems of ratio 1/2 are such rules. Cells left over at the last level are black.

    Raises `TreeError` where a rule has not `2^k` children for one k, or a child has no rule.

    >>> sierpinski = from_substitution({"t": ["t", "t", "t", False]}, "t", bits=20)
    >>> sierpinski.count == 3**20, len(sierpinski.form.lows)
    (True, 59)
    """
    table: dict[State, tuple[State, ...]] = {}
    for state, children in rules.items():
        if not isinstance(children, Sequence | np.ndarray):
            raise TreeError(f"the rule for {state!r} is {children!r}: a sequence of states is needed")
        table[state] = tuple(children)
    sizes = {len(children) for children in table.values()}
    dimension = min(sizes, default=0).bit_length() - 1
    if len(sizes) != 1 or dimension < 1 or sizes != {2**dimension}:
        raise TreeError(f"rules with {sorted(sizes)} children: 2^k of them are needed, the same k for all")
    for state in [start, *(child for children in table.values() for child in children)]:
        if not _is_colour(state) and (not _hashable(state) or state not in table):
            raise TreeError(f"there is no rule for {state!r}")

    def halves(state: State, axis: int) -> bool | tuple[State, State]:
        if _is_colour(state):
            return bool(state)
        rest = state.states if isinstance(state, _Part) else table[state]
        half = len(rest) // 2
        return _part(rest[:half]), _part(rest[half:])

    return from_states(halves, start, cube or unit_cube(dimension), bits)


def _is_colour(state: State) -> bool:
    return isinstance(state, bool | np.bool_)


def _hashable(state: object) -> bool:
    try:
        hash(state)
    except TypeError:
        return False
    return True


def _place(state: State, level: int) -> Place:
    """A state at a level, and whether it is a colour."""
    if not _hashable(state):
        raise TreeError(f"state {state!r} at level {level}: a hashable one, such as a tuple, is needed")
    return state, level, _is_colour(state)


@dataclass(frozen=True)
class _Part:
    """Some of the children of a cell, not yet apart; colours are told from numbers equal to them."""

    states: tuple[State, ...]
    colours: tuple[bool, ...]


def _part(states: tuple[State, ...]) -> State:
    return states[0] if len(states) == 1 else _Part(states, tuple(map(_is_colour, states)))
