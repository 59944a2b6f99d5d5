"""A value of a parsed document together with the keys that lead to it, and the questions asked of it."""

import difflib
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from automata.error import AutomatonError
from automata.expression import Expression, ExpressionError, Number, names, parse, substitute, too_large

LONGEST_NAME = 100

_LABEL = re.compile(r"[^\s=\[\],]+")


@dataclass(frozen=True)
class Field:
    """A value and its path; each method answers what the value is, or says what was expected.

    `known` holds the values of the parameters that expressions may name.
    """

    value: Any
    path: tuple[str | int, ...] = ()
    known: Mapping[str, Fraction] = field(default_factory=dict)

    def error(self, message: str) -> AutomatonError:
        return AutomatonError(message, path=self.path)

    def expected(self, what: str) -> AutomatonError:
        return self.error(f"expected {what}, found {_describe(self.value)}")

    def table(self, allowed: Iterable[str] = (), required: Iterable[str] = ()) -> dict[str, "Field"]:
        """The fields of a table; with `allowed`, every other key is an error that names the nearest one."""
        if not isinstance(self.value, dict):
            raise self.expected("a table")
        fields = {key: self._inner(key, value) for key, value in self.value.items()}
        allowed = list(allowed)
        for key, entry in fields.items():
            if allowed and key not in allowed:
                raise entry.error(f"unknown key {key!r}{suggestion(key, allowed)}")
            if not _LABEL.fullmatch(key):
                raise entry.error(f"a name has no spaces and none of = [ ] , (found {key!r})")
            if len(key) > LONGEST_NAME:
                raise entry.error(f"a name has at most {LONGEST_NAME} characters, found {len(key)}")
        for key in required:
            if key not in fields:
                raise self.error(f"the key {key!r} is missing")
        return fields

    def items(self, what: str = "a list") -> list["Field"]:
        if not isinstance(self.value, list):
            raise self.expected(what)
        return [self._inner(place, value) for place, value in enumerate(self.value)]

    def entries(self) -> dict[str, "Field"]:
        """The fields of a table whose keys are no labels: entries of matrices, or names such as a(u,v)."""
        if not isinstance(self.value, dict):
            raise self.expected("a table")
        return {key: self._inner(key, value) for key, value in self.value.items()}

    def _inner(self, key: str | int, value: Any) -> "Field":
        return Field(value, (*self.path, key), self.known)

    def text(self, what: str = "a text in quotes") -> str:
        if not isinstance(self.value, str):
            raise self.expected(what)
        return self.value

    def count(self, least: int, most: int) -> int:
        value = self.value
        if not isinstance(value, int) or isinstance(value, bool) or not least <= value <= most:
            raise self.expected(f"a whole number from {least} to {most}")
        return value

    def expression(self) -> Expression:
        """A number, or a text with an expression."""
        if isinstance(self.value, (int, Fraction)) and not isinstance(self.value, bool):
            value = Fraction(self.value)
            if too_large(value):
                raise self.error("the number is out of range")
            return Number(value)
        text = self.text('a number or an expression such as "1/4"')
        try:
            return parse(text)
        except ExpressionError as error:
            raise self._in_text(text, error) from None

    def number(self) -> Fraction:
        """An exact number; a text may write it as an expression in parameters that have a value."""
        expression = self.expression()
        if isinstance(expression, Number):
            return expression.value
        try:
            found = substitute(expression, self.known)
        except ZeroDivisionError:
            raise self.error(f"division by zero in {self.text()!r}") from None
        except ExpressionError as error:
            raise self._in_text(self.text(), error) from None
        if isinstance(found, Number):
            return found.value
        name = min(names(found))
        raise self.error(f"expected a number, found the name {name!r} (give it a value under [parameters])")

    def _in_text(self, text: str, error: ExpressionError) -> AutomatonError:
        shown = text if len(text) <= 60 else text[:57] + "..."
        return self.error(f"in {shown!r}, character {error.position + 1}: {error}")

    def choice(self, allowed: Mapping[str, Any] | Iterable[str], what: str) -> str:
        """A text that is one of the allowed names."""
        text = self.text(f"the name of {what}")
        allowed = list(allowed)
        if text not in allowed:
            raise self.error(f"unknown {what} {text!r}{suggestion(text, allowed)}")
        return text


def suggestion(found: str, known: Iterable[str]) -> str:
    """`; did you mean 'edge'?` when a known name is near, else the list of what is known."""
    known = list(known)
    near = difflib.get_close_matches(found, known, n=1) if len(found) <= LONGEST_NAME else []
    if near:
        return f"; did you mean {near[0]!r}?"
    return f"; known here: {', '.join(known[:12])}" if known else ""


def _describe(value: Any) -> str:
    match value:
        case bool():
            return str(value).lower()
        case dict():
            return "a table"
        case list():
            return f"a list of {len(value)}"
        case str():
            return repr(value if len(value) <= 40 else value[:37] + "...")
        case int() | Fraction() if abs(value) >= 10**20:
            return "a very large number"
        case int():
            return str(value)
        case Fraction():
            return f"the number {float(value):g}"
        case float():
            return "a number out of range"
        case _:
            return f"a {type(value).__name__}"


def worked_out(entry: Expression | None, field: Field) -> Expression | None:
    """An entry with the parameters that have a value put in."""
    try:
        return substitute(entry, field.known) if entry is not None else None
    except ZeroDivisionError:
        raise field.error(f"division by zero in '{entry}'") from None
    except ExpressionError as error:
        raise field.error(f"in '{entry}': {error}") from None
