"""Fractint's `.ifs` files: affine maps of the plane or of space with their probabilities."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from automata.automaton import Automaton
from automata.error import AutomatonError
from automata.fractint_text import Entry, Line, chosen, entries, plain_name
from automata.plain import AffineMap, plain_automaton

SIZE = 20.0
MOST_MAPS = 1000

_NUMBER = re.compile(r"[+-]?(\d{1,40}\.?\d{0,40}|\.\d{1,40})([eE][+-]?\d{1,2})?")


@dataclass(frozen=True)
class FractintIfs:
    """A plain IFS of a `.ifs` file. `probabilities` sum to 1; the file's own summed to `total`."""

    automaton: Automaton
    probabilities: Mapping[str, Fraction]
    total: Fraction


def fractint_names(text: str, source: str | None = None) -> tuple[str, ...]:
    """The names of the entries of a Fractint file.

    >>> fractint_names("fern { 0 0 0 .16 0 0 1 }\\nbox (3D) { }")
    ('fern', 'box')
    """
    return tuple(plain_name(entry.name) for entry in entries(text, source))


def fractint_ifs(text: str, name: str | None = None, source: str | None = None) -> FractintIfs:
    """One entry of a Fractint `.ifs` text as a plain IFS with its probabilities.

    In the plane a line is a map `a b c d e f p`: `x' = a x + b y + e`, `y' = c x + d y + f`, chosen with
    probability p. In space, where `(3D)` follows the name, it has 13 numbers: the matrix by rows, the
    translation, p. Numbers are exact decimals. Files round, and theirs need not sum to 1: the probabilities
    are divided by their total. A unit of the file becomes 20 mm (the control points are the frame of 20 mm).

    Whether the maps contract is not looked at here: `ifs.require_contraction` does. Raises `AutomatonError`
    with file, line and column for a name that is missing, a line with the wrong number of numbers, what is no
    number, a negative probability, and probabilities that are all 0.

    >>> found = fractint_ifs("half { ; a segment\\n .5 0 0 .5 0 0 .3\\n .5 0 0 .5 .5 0 .6 }")
    >>> {label: str(p) for label, p in found.probabilities.items()}, str(found.total)
    ({'0': '1/3', '1': '2/3'}, '9/10')
    """
    entry = chosen(text, name, source, "IFS")
    dimension = 3 if re.search(r"\(\s*3d\s*\)", entry.name, re.IGNORECASE) else 2
    rows = [_numbers(line, dimension, source) for line in entry.lines]
    if not 1 <= len(rows) <= MOST_MAPS:
        message = f"the entry {entry.name!r} has {len(rows)} maps; expected 1 to {MOST_MAPS}"
        raise AutomatonError(message, source=source, line=entry.line, column=entry.column)
    total = sum((row[-1] for row in rows), Fraction(0))
    if total == 0:
        message = f"the probabilities of {entry.name!r} are all 0"
        raise AutomatonError(message, source=source, line=entry.line, column=entry.column)
    probabilities = {str(i): row[-1] / total for i, row in enumerate(rows)}
    return FractintIfs(_automaton(entry, rows, dimension), probabilities, total)


def _automaton(entry: Entry, rows: list[list[Fraction]], dimension: int) -> Automaton:
    maps: list[AffineMap] = []
    for row in rows:
        linear = [row[i * dimension : (i + 1) * dimension] for i in range(dimension)]
        maps.append((linear, row[dimension * dimension : -1]))
    axes = [[SIZE * (i == j) for j in range(dimension)] for i in range(dimension)]
    return plain_automaton(plain_name(entry.name), maps, [[0.0] * dimension, *axes])


def _numbers(line: Line, dimension: int, source: str | None) -> list[Fraction]:
    expected = dimension * (dimension + 1) + 1
    words = list(re.finditer(r"[^\s,]+", line.text))
    if len(words) != expected:
        where = line.column + len(line.text) - len(line.text.lstrip())
        what = f"a map of {'space' if dimension == 3 else 'the plane'} has {expected} numbers"
        raise _wrong(f"{what}, found {len(words)}", source, line, where)
    values = []
    for word in words:
        if _NUMBER.fullmatch(word[0]) is None:
            message = f"expected a number, found {word[0][:40]!r}"
            raise _wrong(message, source, line, line.column + word.start())
        values.append(Fraction(word[0]))
    if values[-1] < 0:
        message = f"a probability is not negative, found {words[-1][0]}"
        raise _wrong(message, source, line, line.column + words[-1].start())
    return values


def _wrong(message: str, source: str | None, line: Line, column: int) -> AutomatonError:
    return AutomatonError(message, source=source, line=line.number, column=column)
