"""The family of all operators that an automaton allows, and the choice of a member."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from automata import Automaton
from automata.document import suggestion
from subdivision.elimination import Inconsistent, LinearSystem
from subdivision.error import Undetermined, WrongValue
from subdivision.form import CONSTANT, Form
from subdivision.unknowns import Entry

Exact = tuple[tuple[Fraction, ...], ...]
Forms = tuple[tuple[Form, ...], ...]

_ENTRY = re.compile(r"(.+)\.([^.\[\]]+)\[(\d{1,9}),\s*(\d{1,9})\]")


@dataclass(frozen=True)
class Parameter:
    """A degree of freedom: the name it goes by, and the entry whose value it is."""

    name: str
    entry: Entry


@dataclass(frozen=True)
class Solution:
    """All operators that satisfy an automaton's constraints: an affine family.

    `operators[cell][label]` is the matrix by rows, each entry an affine form whose key i stands for
    `parameters[i]`. `fixed` holds the parameters that already have a value.
    """

    automaton: Automaton
    parameters: tuple[Parameter, ...]
    operators: Mapping[str, Mapping[str, Forms]]
    fixed: Mapping[int, Form]

    @property
    def free(self) -> tuple[Parameter, ...]:
        """The parameters that are still free."""
        return tuple(p for i, p in enumerate(self.parameters) if i not in self.fixed)

    @property
    def degrees_of_freedom(self) -> int:
        """How many numbers can be chosen independently.

        >>> import automata, subdivision
        >>> subdivision.solve(automata.read("corner-cutting")).degrees_of_freedom
        2
        """
        return len(self.free)

    def with_values(self, values: Mapping[str, Fraction]) -> "Solution":
        """The members of the family in which entries or parameters have the given values.

        A key is a parameter's name (`a`) or an entry (`edge.0[1,0]`). Raises `WrongValue` for a key that
        names nothing, or a value that the constraints or the earlier values exclude.
        """
        system = LinearSystem(len(self.parameters))
        system.require(_equals(i, form) for i, form in self.fixed.items())
        for key, value in values.items():
            form = system.reduce(self.form(key))
            if set(form) <= {CONSTANT} and form.get(CONSTANT, 0) != value:
                forced = form.get(CONSTANT, Fraction(0))
                why = "by the other values" if key in self._names() or self.form(key) != form else ""
                raise WrongValue(
                    f"{key} = {value} is impossible: it is {forced} {why or 'in every solution'}"
                )
            try:
                system.require([_equals_value(form, value)])
            except Inconsistent as error:  # pragma: no cover - excluded by the test above
                raise AssertionError from error
        fixed = {i: system.value(i) for i in range(len(self.parameters)) if i not in system.free([i])}
        operators = {
            cell: {
                label: tuple(tuple(system.reduce(form) for form in row) for row in rows)
                for label, rows in table.items()
            }
            for cell, table in self.operators.items()
        }
        return Solution(self.automaton, self.parameters, operators, fixed)

    def form(self, key: str) -> Form:
        """A parameter or an entry in terms of the free parameters. Raises `WrongValue` for an unknown key."""
        names = self._names()
        if key in names:
            return {names[key]: Fraction(1)}
        match = _ENTRY.fullmatch(key.strip())
        if match is None:
            raise WrongValue(f"{key!r} is neither a parameter nor an entry{suggestion(key, names)}")
        cell, label, row, column = match[1], match[2], int(match[3]), int(match[4])
        try:
            return self.operators[cell][label][row][column]
        except (KeyError, IndexError):
            raise WrongValue(f"there is no entry {key}: {self._known(cell, label)}") from None

    def numbers(self) -> Mapping[str, Mapping[str, Exact]]:
        """The operators as exact numbers, after the values that the description sets.

        Raises `Undetermined` when parameters remain free, `WrongValue` when a value is impossible.
        """
        chosen = self.with_values(self.automaton.values) if self.automaton.values else self
        if chosen.free:
            raise Undetermined(tuple(f"{p.name} ({p.entry})" for p in chosen.free))
        return {
            cell: {
                label: tuple(tuple(form.get(CONSTANT, Fraction(0)) for form in row) for row in rows)
                for label, rows in table.items()
            }
            for cell, table in chosen.operators.items()
        }

    def _names(self) -> dict[str, int]:
        return {parameter.name: i for i, parameter in enumerate(self.parameters)}

    def _known(self, cell: str, label: str) -> str:
        if cell not in self.operators:
            return f"no cell {cell!r}{suggestion(cell, self.operators)}"
        if label not in self.operators[cell]:
            return f"no sub-cell {label!r}{suggestion(label, self.operators[cell])}"
        rows = self.operators[cell][label]
        return f"the matrix is {len(rows)} by {len(rows[0])}, counted from 0"


def _equals(parameter: int, form: Form) -> Form:
    return {**{k: -v for k, v in form.items()}, parameter: Fraction(1)}


def _equals_value(form: Form, value: Fraction) -> Form:
    result = {**form, CONSTANT: form.get(CONSTANT, Fraction(0)) - value}
    return {key: coefficient for key, coefficient in result.items() if coefficient}
