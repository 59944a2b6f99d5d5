"""A plain IFS whose addresses are restricted to a regular language: a cell for each state of the language."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from automata.automaton import Automaton, Cell, Word
from automata.error import AutomatonError

MOST_STATES = 500
MOST_ENTRIES = 100_000
LONGEST_WORD = 200

Transitions = Mapping[str, Mapping[str, str]]
"""For each state the labels that may come next, and the state that each leads to."""


def restricted(automaton: Automaton, transitions: Transitions, start: str) -> Automaton:
    """The addresses of a plain IFS that a transition table can read for ever, as a graph-directed automaton.

    State q becomes a cell q; its sub-cell i is the cell `transitions[q][i]`, with the operator T_i of the
    plain IFS. States from which no infinite word starts, or that are not reached, are dropped. Control points
    are those of the plain IFS. Raises `AutomatonError` for an automaton
    that is no plain IFS, an unknown label or state, and an empty language.

    >>> from automata.plain import plain_automaton
    >>> halves = plain_automaton("Segment", [([[0.5]], [0]), ([[0.5]], [0.5])])
    >>> golden = restricted(halves, {"free": {"0": "free", "1": "rest"}, "rest": {"0": "free"}}, "free")
    >>> dict(golden.cells["rest"].subdivision)
    {'0': 'free'}
    """
    cell = _plain_cell(automaton)
    _check(cell, transitions, start)
    alive = _alive(transitions)
    if start not in alive:
        raise AutomatonError(
            f"the language is empty: no infinite address can be read from {start!r}. Allow a cycle of states"
        )
    kept = _reached(transitions, start, alive)
    if len(kept) > MOST_STATES or len(kept) * len(cell.subdivision) * cell.points**2 > MOST_ENTRIES:
        raise AutomatonError(
            f"the language needs {len(kept)} states; at most {MOST_STATES} states and {MOST_ENTRIES} "
            f"entries of operators can be handled"
        )
    cells = {}
    for state in kept:
        into = {label: target for label, target in transitions[state].items() if target in alive}
        matrices = {label: cell.matrices[label] for label in into}
        cells[state] = replace(cell, name=state, subdivision=into, matrices=matrices)
    return replace(automaton, shape=start, cells=cells)


def forbidding(automaton: Automaton, words: Iterable[str]) -> Automaton:
    """The addresses of a plain IFS in which none of the given words occurs, such as `"1 1"`.

    The states are the longest ends of what was read that may still grow into a forbidden word (the automaton
    of Aho and Corasick); cells are called `free` and `after 1 0`. Raises what `restricted` raises, and
    `AutomatonError` for an empty word.

    >>> from automata.plain import plain_automaton
    >>> halves = plain_automaton("Segment", [([[0.5]], [0]), ([[0.5]], [0.5])])
    >>> {name: dict(cell.subdivision) for name, cell in forbidding(halves, ["1 1"]).cells.items()}
    {'free': {'0': 'free', '1': 'after 1'}, 'after 1': {'0': 'free'}}
    """
    cell = _plain_cell(automaton)
    forbidden = {tuple(word.split()) for word in words}
    if () in forbidden:
        raise AutomatonError("a forbidden word has at least one label, found an empty one")
    for word in forbidden:
        for label in word:
            if label not in cell.subdivision:
                raise AutomatonError(_unknown(label, cell, f"the forbidden word {' '.join(word)!r}"))
    prefixes = {word[:end] for word in forbidden for end in range(len(word) + 1)} | {()}
    longest, most = max(map(len, prefixes)), MOST_ENTRIES // len(cell.subdivision)
    if len(prefixes) > most or longest > LONGEST_WORD:
        raise AutomatonError(
            f"the forbidden words have {len(prefixes)} beginnings, the longest of {longest} labels; at most "
            f"{most} and {LONGEST_WORD} can be handled"
        )
    table: dict[str, dict[str, str]] = {}
    for prefix in sorted(prefixes, key=lambda word: (len(word), word)):
        if _ends_in(prefix, forbidden):
            continue
        row = table.setdefault(_name(prefix), {})
        for label in cell.subdivision:
            read = (*prefix, label)
            if not _ends_in(read, forbidden):
                row[label] = _name(_longest(read, prefixes))
    return restricted(automaton, table, _name(()))


def _plain_cell(automaton: Automaton) -> Cell:
    cell = automaton.cells[automaton.shape]
    if len(automaton.cells) != 1 or cell.boundary or set(cell.matrices) != set(cell.subdivision):
        raise AutomatonError(
            f"{automaton.name!r} is no plain IFS: expected one cell without boundary and its operators"
        )
    return cell


def _check(cell: Cell, transitions: Transitions, start: str) -> None:
    if start not in transitions:
        raise AutomatonError(f"the start {start!r} is no state; there are {', '.join(transitions) or 'none'}")
    for state, row in transitions.items():
        for label, target in row.items():
            if label not in cell.subdivision:
                raise AutomatonError(_unknown(label, cell, f"state {state!r}"))
            if target not in transitions:
                raise AutomatonError(
                    f"state {state!r} leads by {label!r} to {target!r}, which is no state; there are "
                    f"{', '.join(list(transitions)[:12])}"
                )


def _unknown(label: str, cell: Cell, where: str) -> str:
    known = ", ".join(list(cell.subdivision)[:12])
    return f"unknown label {label!r} in {where}; the maps are {known}"


def _alive(transitions: Transitions) -> set[str]:
    """The states from which an infinite word can be read."""
    sources: dict[str, list[str]] = {state: [] for state in transitions}
    ways = {}
    for state, row in transitions.items():
        ways[state] = len(row)
        for target in row.values():
            sources[target].append(state)
    dead = [state for state, count in ways.items() if count == 0]
    for state in dead:
        for source in sources[state]:
            ways[source] -= 1
            if ways[source] == 0:
                dead.append(source)
    return set(transitions) - set(dead)


def _reached(transitions: Transitions, start: str, alive: set[str]) -> list[str]:
    found = [start]
    seen = {start}
    for state in found:
        new = [t for t in dict.fromkeys(transitions[state].values()) if t in alive and t not in seen]
        found += new
        seen.update(new)
    return found


def _ends_in(word: Word, forbidden: set[Word]) -> bool:
    return any(word[start:] in forbidden for start in range(len(word)))


def _longest(word: Word, prefixes: set[Word]) -> Word:
    return next(word[start:] for start in range(len(word) + 1) if word[start:] in prefixes)


def _name(prefix: Sequence[str]) -> str:
    return " ".join(("after", *prefix)) if prefix else "free"
