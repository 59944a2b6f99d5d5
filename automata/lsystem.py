"""Fractint's `.l` files: what an L-system rewrites, read into symbols."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from automata.error import AutomatonError
from automata.fractint_text import Entry, Line, chosen, plain_name

LONGEST = 4096
MOST_RULES = 36

DRAWING = frozenset("FD")
MOVING = frozenset("FDGM")
"""Letters that take the turtle one unit forward; those of DRAWING leave a trace."""

_REFUSED = {
    "[": "branches make a tree, and this importer makes curves",
    "]": "branches make a tree, and this importer makes curves",
    "@": "lengths follow here from how the letters grow, and are not multiplied",
    "\\": "turns by degrees are not read; give Angle and turn by + and -",
    "/": "turns by degrees are not read; give Angle and turn by + and -",
}
_ANGLE = re.compile(r"angle\s*=?\s*(\S+)", re.IGNORECASE)
_AXIOM = re.compile(r"axiom\s*=?\s*(.*)", re.IGNORECASE)
_RULE = re.compile(r"(\S)\s*=(.*)")
_TOKEN = re.compile(r"[<>]\d{1,3}|C\d{1,3}|.", re.DOTALL)


@dataclass(frozen=True)
class Symbol:
    """A letter, a turn by `amount` of the Angle's parts of 360 degrees, or a reversal of turns."""

    kind: Literal["letter", "turn", "reversal"]
    letter: str = ""
    amount: int = 0


Symbols = tuple[Symbol, ...]


@dataclass(frozen=True)
class LSystem:
    """An L-system whose turtle turns by 360 / `angle` degrees. Letters without a rule stay as they are."""

    name: str
    angle: int
    axiom: Symbols
    rules: Mapping[str, Symbols]

    def rule(self, letter: str) -> Symbols:
        return self.rules.get(letter, (Symbol("letter", letter),))


def lsystem(text: str, name: str | None = None, source: str | None = None) -> LSystem:
    """One entry of a Fractint `.l` text.

    `Angle n` (3 to 360), `Axiom …` and one line `letter=…` for each rule. Symbols: letters and digits
    (F and D draw, G and M move, others do nothing by themselves), `+` turns to the left, `-` to the right,
    `|` back (for an even Angle), `!` exchanges left and right from there on; `C`, `<` and `>` with a number
    are colours and are passed over. `[ ] @ \\ /` are refused. Raises `AutomatonError` with file, line and
    column.

    >>> koch = lsystem("Koch { Angle 6\\n Axiom F--F--F\\n F=F+F--F+F }")
    >>> koch.angle, len(koch.axiom), len(koch.rules["F"])
    (6, 7, 8)
    """
    entry = chosen(text, name, source, "L-system")
    angle, axiom, rules = None, None, {}
    found: list[tuple[str, Line, int, str]] = []
    for line in entry.lines:
        stripped = line.text.strip()
        column = line.column + len(line.text) - len(line.text.lstrip())
        if match := _ANGLE.fullmatch(stripped):
            angle = _angle(match[1], source, line, column)
        elif match := _AXIOM.fullmatch(stripped):
            found.append(("", line, column + match.start(1), match[1]))
        elif match := _RULE.fullmatch(stripped):
            found.append((match[1].upper(), line, column + match.start(2), match[2]))
        else:
            message = f"expected 'Angle n', 'Axiom …' or a rule 'F=…', found {stripped[:40]!r}"
            raise _wrong(message, source, line, column)
    if angle is None:
        raise _missing("Angle n", entry, source)
    for letter, line, column, written in found:
        start = line.column + len(line.text) - len(line.text.lstrip())
        if letter and not (letter.isascii() and letter.isalnum()):
            raise _wrong(f"a rule rewrites a letter, found {letter!r}", source, line, start)
        if letter in rules or (not letter and axiom is not None):
            raise _wrong(f"{letter or 'Axiom'} is given twice", source, line, start)
        symbols = _symbols(written, angle, source, line, column)
        if letter:
            rules[letter] = symbols
        else:
            axiom = symbols
    if axiom is None:
        raise _missing("Axiom …", entry, source)
    if len(rules) > MOST_RULES:
        raise AutomatonError(
            f"at most {MOST_RULES} rules are read", source=source, line=entry.line, column=entry.column
        )
    return LSystem(plain_name(entry.name), angle, axiom, rules)


def _angle(text: str, source: str | None, line: Line, column: int) -> int:
    if not re.fullmatch(r"\d{1,3}", text) or not 3 <= int(text) <= 360:
        message = f"Angle n divides 360 degrees by a whole number from 3 to 360, found {text[:40]!r}"
        raise _wrong(message, source, line, column)
    return int(text)


def _symbols(text: str, angle: int, source: str | None, line: Line, column: int) -> Symbols:
    if len(text) > LONGEST:
        message = f"a rule has at most {LONGEST} symbols, found {len(text)}"
        raise _wrong(message, source, line, column)
    result = []
    for match in _TOKEN.finditer(text.upper()):
        token = match[0]
        place = column + match.start()
        if token in _REFUSED:
            raise _wrong(f"{token!r} is refused: {_REFUSED[token]}", source, line, place)
        if token == "|" and angle % 2:
            message = f"'|' turns by half of 360 degrees, which Angle {angle} has no turns for"
            raise _wrong(message, source, line, place)
        if token in ("+", "-", "|"):
            result.append(Symbol("turn", amount={"+": 1, "-": -1, "|": angle // 2}[token]))
        elif token == "!":
            result.append(Symbol("reversal"))
        elif token.isascii() and token.isalnum() and len(token) == 1:
            result.append(Symbol("letter", token))
        elif len(token) == 1 and not token.isspace():
            raise _wrong(f"unknown symbol {token!r}", source, line, place)
    return tuple(result)


def _missing(what: str, entry: Entry, source: str | None) -> AutomatonError:
    message = f"the L-system {entry.name!r} has no {what!r}"
    return AutomatonError(message, source=source, line=entry.line, column=entry.column)


def _wrong(message: str, source: str | None, line: Line, column: int) -> AutomatonError:
    return AutomatonError(message, source=source, line=line.number, column=column)
