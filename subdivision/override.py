"""Other values than those that a description sets."""

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction

from automata import Automaton
from automata.expression import Expression
from subdivision.error import WrongValue
from subdivision.solution import Given, exact_values, solve


def overridden(automaton: Automaton, given: Mapping[str, Given]) -> Automaton:
    """The automaton with other values set; those of the file stay where they still are a choice.

    A value of the file gives way where the new ones say otherwise, be it through another entry of
    the same parameter. Raises `WrongValue` for a value that is impossible.
    """
    if not given:
        return automaton
    values = exact_values(given)
    family = solve(automaton)
    family.with_values(automaton.values)
    chosen = family.with_values(values)
    kept: dict[str, Fraction | Expression] = dict(values)
    for key, value in automaton.values.items():
        try:
            chosen = chosen.with_values({key: value})
        except WrongValue:
            continue
        kept[key] = value
    return replace(automaton, values=kept)
