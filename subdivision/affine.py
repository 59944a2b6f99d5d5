"""From an automaton to the affine family of all its operators."""

import string
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain, count

from automata import Automaton, Cell
from automata.merging import Merged, merged
from automata.parameters import parameter_names, resolved, settled
from subdivision.coefficients import Scalar, exact
from subdivision.constraints import Constraint, Statement, constraints
from subdivision.elimination import Inconsistent, LinearSystem, minimal_subset
from subdivision.error import Contradiction, NotLinear, WrongValue
from subdivision.form import CONSTANT, Columns, Form
from subdivision.unknowns import Entry, Unknowns, unknowns

Forms = tuple[tuple[Form, ...], ...]


@dataclass(frozen=True)
class Parameter:
    """A degree of freedom: the name it goes by, and the entry whose value it is."""

    name: str
    entry: Entry


@dataclass(frozen=True)
class Affine:
    """The operators of a resolved automaton as affine forms in the parameters; fields as in `Solution`."""

    automaton: Automaton
    parameters: tuple[Parameter, ...]
    operators: Mapping[str, Mapping[str, Forms]]
    notes: tuple[str, ...]


def affine(automaton: Automaton) -> Affine:
    """What `subdivision.solve` finds; raises as it does."""
    automaton = resolved(automaton)
    merging = merged(settled(automaton))
    whole = merging.automaton
    table = unknowns(whole)
    named = _named(merging, table)
    linear, products = constraints(whole, table)
    try:
        system, rest = _solved(whole, table, linear, products, named)
    except Inconsistent:
        raise _contradiction(whole, table, linear, products) from None
    if rest:
        raise NotLinear(tuple(statement.text for statement in rest))
    free = system.free(range(len(table.entries)))
    numbered = {unknown: i for i, unknown in enumerate(free)}
    operators = {
        name: {label: _rows(table, system, numbered, name, label) for label in _unknown_labels(cell, table)}
        for name, cell in whole.cells.items()
    }
    parameters = tuple(_parameters(whole, table, system, free, named))
    return Affine(automaton, parameters, _all_names(merging, operators), merging.notes)


def _solved(
    automaton: Automaton,
    table: Unknowns,
    linear: Sequence[Constraint],
    products: Sequence[Statement],
    named: Iterable[int] = (),
) -> tuple[LinearSystem, list[Statement]]:
    """Solve the linear constraints, put the result into the others, and go on while any become linear."""
    system = LinearSystem(len(table.entries), lambda i: (table.diagonal(i), i), named)
    system.require(form for constraint in linear for form in constraint.forms)
    rest = list(products)
    while rest:
        known = replace(table, operators=_Reduced(table.operators, system))
        found = [(statement, statement.constraint(automaton, known)) for statement in rest]
        settled_now = [constraint for _, constraint in found if constraint is not None]
        if not settled_now:
            break
        system.require(form for constraint in settled_now for form in constraint.forms)
        rest = [statement for statement, constraint in found if constraint is None]
    return system, rest


class _Reduced(dict):
    """Operators in terms of what a system leaves free, each worked out when it is first asked for."""

    def __init__(self, operators: Mapping[tuple[str, str], Columns], system: LinearSystem):
        super().__init__()
        self.operators = operators
        self.system = system

    def __missing__(self, key: tuple[str, str]) -> Columns:
        columns: Columns = [
            {row: value for row, form in column.items() if (value := self.system.reduce(form))}
            for column in self.operators[key]
        ]
        self[key] = columns
        return columns


def _contradiction(
    automaton: Automaton, table: Unknowns, linear: Sequence[Constraint], products: Sequence[Statement]
) -> Contradiction:
    statements = [*linear, *products]

    def residual(chosen: Sequence[int]) -> Scalar | None:
        some = [statements[i] for i in chosen]
        try:
            _solved(
                automaton,
                table,
                [one for one in some if isinstance(one, Constraint)],
                [one for one in some if isinstance(one, Statement)],
            )
        except Inconsistent as error:
            return error.residual
        return None

    chosen, found = minimal_subset(len(statements), residual)
    return Contradiction(tuple(statements[i].text for i in chosen), found)


def _unknown_labels(cell: Cell, table: Unknowns) -> Iterator[str]:
    """The labels of the sub-cells, and of the embeddings that were not known."""
    yield from cell.subdivision
    sought = {(entry.cell, entry.label) for entry in table.entries}
    yield from (label for label in cell.boundary if (cell.name, label) in sought)


def _all_names(merging: Merged, operators: Mapping[str, Mapping[str, Forms]]) -> dict[str, dict[str, Forms]]:
    """The operators under the name of every cell, also of those that another one stands for."""
    result: dict[str, dict[str, Forms]] = {}
    for name, standing in merging.standing.items():
        back = {new: old for (cell, old), new in merging.renamed.items() if cell == name}
        result[name] = {back.get(label, label): rows for label, rows in operators[standing].items()}
    return result


def _rows(table: Unknowns, system: LinearSystem, numbered: Mapping[int, int], cell: str, label: str) -> Forms:
    columns = table.operators[cell, label]
    return tuple(
        tuple(_renamed(system.reduce(column.get(row, {})), numbered) for column in columns)
        for row in range(table.points[cell])
    )


def _renamed(form: Form, numbered: Mapping[int, int]) -> Form:
    return {key if key == CONSTANT else numbered[key]: exact(value) for key, value in form.items()}


def _named(merging: Merged, table: Unknowns) -> dict[int, str]:
    """The unknowns that the description names, which stay free if they can."""
    names = {merging.entry(text): name for name, text in merging.automaton.names.items()}
    found = {i: names.pop(str(entry)) for i, entry in enumerate(table.entries) if str(entry) in names}
    if names:
        raise WrongValue(f"[names] there is no entry {min(names)}")
    return found


def _parameters(
    automaton: Automaton, table: Unknowns, system: LinearSystem, free: Sequence[int], named: Mapping[int, str]
) -> Iterator[Parameter]:
    """The free unknowns under the user's names where given, else a, b, c … (p1, p2 … when over 26)."""
    by_root: dict[int, tuple[str, Entry]] = {}
    for unknown, name in named.items():
        root = system.root(unknown)
        if root not in free or root in by_root:
            why = f"it is {by_root[root][0]}" if root in by_root else "others determine it"
            listed = ", ".join(str(table.entries[i]) for i in free[:12])
            entry = table.entries[unknown]
            raise WrongValue(f"[names] {entry} is no free entry; the free ones are {listed} ({why})")
        by_root[root] = name, table.entries[unknown]
    taken = {*automaton.names, *parameter_names(automaton)}
    numbers = (f"p{i}" for i in count(1))
    letters = chain(string.ascii_lowercase, numbers) if len(free) <= 26 else numbers
    fresh = (name for name in letters if name not in taken)
    for unknown in free:
        name, entry = by_root.get(unknown) or (next(fresh), table.entries[unknown])
        yield Parameter(name, entry)
