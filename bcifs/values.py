"""Values that are set on the command line: `--set a=1/4 "edge.0[1,0]=3/8"`."""

from collections.abc import Iterable, Sequence
from fractions import Fraction

from automata.expression import ExpressionError, number
from subdivision import WrongValue

_OF_VALUES = ("--set", "--near")  # options that take several NAME=VALUE


def spread(arguments: Sequence[str]) -> list[str]:
    """The arguments with `--set a=1 b=2` written as `--set a=1 --set b=2`; likewise `--near`.

    >>> spread(["solve", "--set", "a=1", "b=2", "file.toml"])
    ['solve', '--set', 'a=1', '--set', 'b=2', 'file.toml']
    """
    result: list[str] = []
    setting = ""
    fresh = False
    for place, argument in enumerate(arguments):
        if argument == "--":
            return [*result, *arguments[place:]]
        if setting and not fresh and "=" in argument and not argument.startswith("-"):
            result += [setting, argument]
            continue
        result.append(argument)
        was_fresh, fresh = fresh, argument in _OF_VALUES
        option = argument.partition("=")[0]
        if not was_fresh:
            setting = option if option in _OF_VALUES else ""
    return result


def parse_settings(texts: Iterable[str]) -> dict[str, Fraction]:
    """The exact values of `NAME=VALUE` texts. Raises `WrongValue` for one that is none.

    >>> parse_settings(["a=1/4", "edge.0[1, 0] = 1-1/4"])
    {'a': Fraction(1, 4), 'edge.0[1, 0]': Fraction(3, 4)}
    """
    values: dict[str, Fraction] = {}
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (name and equals and value):
            raise WrongValue(f"--set {text}: expected NAME=VALUE, for example a=1/4")
        if name in values:
            raise WrongValue(f"--set {text}: {name} is set twice")
        try:
            values[name] = number(value)
        except ExpressionError as error:
            raise WrongValue(f"--set {text}: in {value!r}, character {error.position + 1}: {error}") from None
    return values
