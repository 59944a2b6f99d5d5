"""The family of all operators that an automaton allows, and the choice of a member."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction

from automata import Automaton, AutomatonError
from automata.document import suggestion
from automata.expression import Expression, substitute
from automata.parameters import parameter_names
from subdivision.affine import Forms, Parameter, affine
from subdivision.coefficients import Scalar, exact, names_of, open_parameters, reader, simple, text_of
from subdivision.elimination import Inconsistent, LinearSystem
from subdivision.error import Undetermined, WrongValue
from subdivision.form import CONSTANT, Form

Exact = tuple[tuple[Fraction, ...], ...]

_ENTRY = re.compile(r"(.+)\.([^.\[\]]+)\[(\d{1,9}),\s*(\d{1,9})\]")

Given = Fraction | int | float | str | Expression
"""A value as users give it."""


@dataclass(frozen=True)
class Solution:
    """All operators that satisfy an automaton's constraints: an affine family.

    `operators[cell][label]` is the matrix by rows, each entry an affine form whose key i stands for
    `parameters[i]`. `fixed` holds the parameters that already have a value. Coefficients are Fractions, or
    rational functions in `open_parameters` where the description has parameters without a value. `notes`
    says which cells were found to be one, and why; operators are listed under the names of all cells.
    """

    automaton: Automaton
    parameters: tuple[Parameter, ...]
    operators: Mapping[str, Mapping[str, Forms]]
    fixed: Mapping[int, Form]
    notes: tuple[str, ...] = ()
    chosen: Mapping[str, Fraction | Expression] = field(default_factory=dict)

    @property
    def open_parameters(self) -> tuple[str, ...]:
        """The description's own parameters, such as u and v, that have no value."""
        return open_parameters(self.automaton)

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

    def with_values(self, given: Mapping[str, Given]) -> "Solution":
        """The members of the family in which entries or parameters have the given values.

        A key is a parameter's name (`a`), an entry (`edge.0[1,0]`) or a parameter of the description (`u`);
        the family is solved again for the latter, so that special values may leave more freedom than others.
        A value may be an expression in the description's parameters. Raises `WrongValue` for a key that
        names nothing, or a value that the constraints or the earlier values exclude.
        """
        values = exact_values(given)
        described = set(parameter_names(self.automaton))
        named = {key: value for key, value in values.items() if key in described}
        rest = {key: value for key, value in values.items() if key not in described}
        if any(self.automaton.parameters.get(key) != value for key, value in named.items()):
            return self._described(named).with_values({**self.chosen, **rest})
        system = LinearSystem(len(self.parameters))
        system.require(_equals(i, form) for i, form in self.fixed.items())
        for key, chosen in rest.items():
            value = self._value(key, chosen)
            form = system.reduce(self.form(key))
            if set(form) <= {CONSTANT} and form.get(CONSTANT, 0) != value:
                forced = text_of(simple(form.get(CONSTANT, Fraction(0))))
                why = "by the other values" if key in self._names() or self.form(key) != form else ""
                raise WrongValue(
                    f"{key} = {text_of(value)} is impossible: it is {forced} {why or 'in every solution'}"
                )
            try:
                system.require([_equals_value(form, value)])
            except Inconsistent as error:  # pragma: no cover - excluded by the test above
                raise AssertionError from error
        fixed = {i: _exact(system.value(i)) for i in range(len(self.parameters)) if i not in system.free([i])}
        operators = {
            cell: {
                label: tuple(tuple(_exact(system.reduce(form)) for form in row) for row in rows)
                for label, rows in table.items()
            }
            for cell, table in self.operators.items()
        }
        return replace(self, operators=operators, fixed=fixed, chosen={**self.chosen, **rest})

    def _described(self, named: Mapping[str, Fraction | Expression]) -> "Solution":
        """The family of the description with other values of its own parameters."""
        numbers = {}
        for key, value in named.items():
            if not isinstance(value, Fraction):
                raise WrongValue(f"{key} = {value}: a parameter of the description is set to a number")
            if key in self.automaton.placing:
                raise WrongValue(f"{key} also places control points: change it under [parameters]")
            numbers[key] = value
        parameters = {**self.automaton.parameters, **numbers}
        values = {key: numbers.get(key, value) for key, value in self.automaton.values.items()}
        try:
            return solve(replace(self.automaton, parameters=parameters, values=values))
        except AutomatonError as error:
            raise WrongValue(str(error)) from None

    def _value(self, key: str, given: Fraction | Expression) -> Scalar:
        if isinstance(given, Fraction):
            return given
        try:
            found = substitute(given, self.automaton.parameters)
            return reader(self.open_parameters)(found)
        except ZeroDivisionError:
            raise WrongValue(f"{key} = {given}: division by zero") from None

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
        missing = tuple(f"{p.name} ({p.entry})" for p in chosen.free)
        if missing or chosen.open_parameters:
            forms = (
                form
                for table in chosen.operators.values()
                for rows in table.values()
                for r in rows
                for form in r
            )
            used = {name for form in forms for value in form.values() for name in names_of(value)}
            missing = (*(name for name in chosen.open_parameters if name in used), *missing)
        if missing:
            raise Undetermined(missing)
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


def solve(automaton: Automaton) -> Solution:
    """All operators that satisfy the constraints, with free parameters that are entries of matrices.

    The unknowns are the entries of every subdivision operator; the equations are the stated incidences
    and adjacencies, those that the symmetries imply, the given entries, and `sum of each column = 1`.
    All are linear, so the solutions form an affine family, found in exact arithmetic: over the rationals, or
    over rational functions in the parameters that have no value. Embeddings may be unknown as well: equations
    that multiply unknowns wait until the linear ones have settled enough of them. Cells that gluing forces
    to be one are one; `Solution.notes` says so, and the operators are listed under all names.

    Raises `Contradiction` with a least conflicting subset, `NotLinear` where products of unknowns stay,
    `TooMuchWork` for a system too dense to solve, and `AutomatonError` for cells that cannot be one.
    Source: Gentil 2010, §4.3.1.

    >>> import automata
    >>> [str(p.entry) for p in solve(automata.read("corner-cutting")).parameters]
    ['edge.0[1,0]', 'edge.0[0,1]']
    """
    found = affine(automaton)
    return Solution(found.automaton, found.parameters, found.operators, {}, found.notes)


def exact_values(given: Mapping[str, Given]) -> dict[str, Fraction | Expression]:
    """The values as exact numbers; a float stands for the binary fraction that it is.

    Raises `WrongValue` for a text that is no number, and for infinity and NaN.
    """
    values: dict[str, Fraction | Expression] = {}
    for key, value in given.items():
        if not isinstance(value, int | float | str | Fraction):
            values[key] = value
            continue
        try:
            values[key] = Fraction(value)
        except (ValueError, OverflowError, ZeroDivisionError):
            raise WrongValue(f"{key} = {value!r}: expected a finite number such as 1/4") from None
    return values


def _exact(form: Form) -> Form:
    return {key: exact(value) for key, value in form.items()}


def _equals(parameter: int, form: Form) -> Form:
    return {**{k: -v for k, v in form.items()}, parameter: Fraction(1)}


def _equals_value(form: Form, value: Scalar) -> Form:
    result = {**form, CONSTANT: form.get(CONSTANT, Fraction(0)) - value}
    return {key: coefficient for key, coefficient in result.items() if coefficient}
