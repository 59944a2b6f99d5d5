"""From an automaton to the family of all its operators."""

import string
from collections.abc import Iterator, Mapping, Sequence
from itertools import count

from automata import Automaton
from subdivision.constraints import Constraint, constraints
from subdivision.elimination import Inconsistent, LinearSystem, minimal_conflict
from subdivision.error import Contradiction, NotLinear, WrongValue
from subdivision.form import CONSTANT, Form
from subdivision.solution import Forms, Parameter, Solution
from subdivision.unknowns import Entry, Unknowns, unknowns


def solve(automaton: Automaton) -> Solution:
    """All operators that satisfy the constraints, with free parameters that are entries of matrices.

    The unknowns are the entries of every subdivision operator; the equations are the stated incidences
    and adjacencies, those that the symmetries imply, the given entries, and `sum of each column = 1`.
    All are linear, so the solutions form an affine family, found in exact rational arithmetic.

    Raises `Contradiction` with an irreducible conflicting subset, and `NotLinear` where a path multiplies two
    unknown operators. Source: Gentil 2010, §4.3.1.

    >>> import automata
    >>> [str(p.entry) for p in solve(automata.read("corner-cutting")).parameters]
    ['edge.0[1,0]', 'edge.0[0,1]']
    """
    table = unknowns(automaton)
    linear, products = constraints(automaton, table)
    if products:
        raise NotLinear(tuple(products))
    system = LinearSystem(len(table.entries), lambda i: (table.diagonal(i), i))
    try:
        system.require(form for constraint in linear for form in constraint.forms)
    except Inconsistent:
        raise _contradiction(linear, len(table.entries)) from None
    free = system.free(range(len(table.entries)))
    numbered = {unknown: i for i, unknown in enumerate(free)}
    operators = {
        name: {label: _rows(table, system, numbered, name, label) for label in cell.subdivision}
        for name, cell in automaton.cells.items()
    }
    names = _names(automaton.names, [table.entries[unknown] for unknown in free])
    parameters = tuple(
        Parameter(name, table.entries[unknown]) for name, unknown in zip(names, free, strict=True)
    )
    return Solution(automaton, parameters, operators, {})


def _contradiction(linear: Sequence[Constraint], unknowns: int) -> Contradiction:
    chosen, residual = minimal_conflict([constraint.forms for constraint in linear], unknowns)
    return Contradiction(tuple(linear[i].text for i in chosen), residual)


def _rows(table: Unknowns, system: LinearSystem, numbered: Mapping[int, int], cell: str, label: str) -> Forms:
    columns = table.operators[cell, label]
    return tuple(
        tuple(_renamed(system.reduce(column[row]), numbered) for column in columns)
        for row in range(len(columns[0]))
    )


def _renamed(form: Form, numbered: Mapping[int, int]) -> Form:
    return {key if key == CONSTANT else numbered[key]: value for key, value in form.items()}


def _names(given: Mapping[str, str], entries: Sequence[Entry]) -> Iterator[str]:
    """The user's names where given, else a, b, c … (p1, p2 … when there are more than 26)."""
    by_entry = {text.replace(" ", ""): name for name, text in given.items()}
    unknown = set(by_entry) - {str(entry) for entry in entries}
    if unknown:
        listed = ", ".join(str(entry) for entry in entries[:12])
        raise WrongValue(f"[names] {min(unknown)} is no free entry; the free ones are {listed}")
    letters = iter(string.ascii_lowercase) if len(entries) <= 26 else (f"p{i}" for i in count(1))
    fresh = (name for name in letters if name not in given)
    for entry in entries:
        yield by_entry.get(str(entry)) or next(fresh)
