"""The field that the coefficients belong to: the rationals, or rational functions in named parameters.

A coefficient is a `Fraction` (or an integer), or an element of Q(u, v, …) as sympy's polynomial rings
compute it; sums and products of both kinds mix.
"""

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

from automata import Automaton
from automata.expression import Expression, Number, evaluate
from automata.parameters import parameter_names

Scalar = Any
"""A `Fraction`, an integer, or an element of a field of rational functions."""


def open_parameters(automaton: Automaton) -> tuple[str, ...]:
    """The parameters of a description that have no value."""
    return tuple(name for name in parameter_names(automaton) if name not in automaton.parameters)


def reader(names: Sequence[str]) -> Callable[[Expression], Scalar]:
    """The function that turns expressions in the given names into coefficients.

    It raises `ZeroDivisionError` where a denominator is zero whatever the names' values.

    >>> from automata.expression import parse
    >>> read = reader(["u", "v"])
    >>> str(read(parse("(u^2 - v^2)/(2(u + v))"))), read(parse("1/4"))
    ('(u - v)/2', Fraction(1, 4))
    """
    generators: dict[str, Scalar] = {}
    if names:
        from sympy import QQ, Symbol
        from sympy.polys.fields import FracField

        field = FracField([Symbol(name) for name in names], QQ)
        generators = dict(zip(names, field.gens, strict=True))

    def read(expression: Expression) -> Scalar:
        if isinstance(expression, Number):
            return expression.value
        return simple(evaluate(expression, generators))

    return read


def is_number(value: Scalar) -> bool:
    return isinstance(value, (int, Fraction))


def simple(value: Scalar) -> Scalar:
    """The same coefficient, as a `Fraction` where it depends on no parameter."""
    if is_number(value) or not (value.numer.is_ground and value.denom.is_ground):
        return value
    above, below = (Fraction(int(c.numerator), int(c.denominator)) for c in _grounds(value))
    return above / below


def exact(value: Scalar) -> Scalar:
    """The same coefficient, never an integer: a `Fraction` where it depends on no parameter."""
    return Fraction(value) if isinstance(value, int) else simple(value)


def _grounds(value: Scalar) -> tuple[Scalar, Scalar]:
    return value.numer.coeff(1), value.denom.coeff(1)


def names_of(value: Scalar) -> frozenset[str]:
    """The parameters on which a coefficient depends."""
    if is_number(value):
        return frozenset()
    symbols = value.field.symbols
    used = {
        i for part in (value.numer, value.denom) for powers in part for i, power in enumerate(powers) if power
    }
    return frozenset(str(symbols[i]) for i in used)


def text_of(value: Scalar) -> str:
    """A coefficient in the description's grammar: `u/(2*u + 2*v)`, `3/16`."""
    return str(value).replace("**", "^")
