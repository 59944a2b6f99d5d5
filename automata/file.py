"""Automaton files: TOML text in, `Automaton` out, every fault with its line and column."""

import math
import os
import re
import tomllib
from fractions import Fraction
from importlib import resources
from pathlib import Path

from automata.automaton import Automaton
from automata.description import describe
from automata.document import suggestion
from automata.error import AutomatonError
from automata.location import locate

LARGEST_FILE = 1_000_000
LARGEST_EXPONENT = 300
LONGEST_NUMBER = 400
LONGEST_KEY = 32

_PART = r"(?:[A-Za-z0-9_-]++|\"[^\"\n]*+\"|'[^'\n]*+')[ \t]*+"
_LONG_KEY = re.compile(rf"(?<![A-Za-z0-9_-])(?:{_PART}\.[ \t]*+){{{LONGEST_KEY}}}")
"""Reading a dotted key takes the square of its length, so long ones are turned away first."""
_TOML_PLACE = re.compile(r"^(.*) \(at (?:line (\d+), column (\d+)|end of document)\)$", re.DOTALL)


def builtin_names() -> tuple[str, ...]:
    """The names of the automata that come with bcifs, in alphabetical order.

    >>> "corner-cutting" in builtin_names()
    True
    """
    folder = resources.files("automata") / "builtin"
    files = (entry.name for entry in folder.iterdir())
    return tuple(sorted(name.removesuffix(".toml") for name in files if name.endswith(".toml")))


def read(source: str | os.PathLike[str]) -> Automaton:
    """The automaton of a file, or the built-in one of that name.

    A name with a folder or the ending `.toml` is a file; any other is looked up among the built-in automata
    first. Raises `AutomatonError` with file, line and column for whatever is wrong with the file.

    >>> read("corner-cutting").shape
    'edge'
    """
    name = os.fspath(source)
    if name in builtin_names():
        text = (resources.files("automata") / "builtin" / f"{name}.toml").read_text("utf-8")
        return parse_text(text, name)
    return parse_text(_text(Path(name)), name)


def parse_text(text: str, source: str | None = None) -> Automaton:
    """The automaton that a TOML text describes; `source` names it in errors.

    Raises `AutomatonError` with line and column.
    """
    chain = _LONG_KEY.search(text)
    if chain:
        line, start = text.count("\n", 0, chain.start()) + 1, text.rfind("\n", 0, chain.start())
        message = f"a key has at most {LONGEST_KEY} parts between dots"
        raise AutomatonError(message, source=source, line=line, column=chain.start() - start)
    try:
        document = tomllib.loads(text, parse_float=_exact)
    except tomllib.TOMLDecodeError as error:
        raise _syntax_error(str(error), text, source) from None
    except (RecursionError, ValueError) as error:
        message = "nested too deeply" if isinstance(error, RecursionError) else str(error)
        raise AutomatonError(f"not a TOML text: {message}", source=source, line=1, column=1) from None
    try:
        return describe(document)
    except AutomatonError as error:
        line, column = locate(text, error.path)
        raise AutomatonError(
            error.message, path=error.path, source=source, line=line, column=column
        ) from None


def _text(path: Path) -> str:
    name = str(path)
    try:
        size = path.stat().st_size
        if not path.is_file():
            raise AutomatonError("expected a file", source=name)
        if size > LARGEST_FILE:
            raise AutomatonError(
                f"the file has {size} bytes; an automaton file has at most {LARGEST_FILE}",
                source=name,
            )
        return path.read_bytes().decode("utf-8")
    except FileNotFoundError:
        hint = suggestion(name, builtin_names()) if path.parent == Path() else ""
        raise AutomatonError(f"no such file or built-in automaton{hint}", source=name) from None
    except UnicodeDecodeError as error:
        message = f"not a text file in UTF-8 (byte {error.start} is no text)"
        raise AutomatonError(message, source=name) from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        if isinstance(error, AutomatonError):
            raise
        raise AutomatonError(f"cannot read the file: {reason}", source=name) from None


def _exact(digits: str) -> Fraction | float:
    """The exact number; `inf` for what is too long, too large or no number, which no field accepts."""
    exponent = digits.lower().partition("e")[2]
    if digits.endswith(("inf", "nan")) or len(digits) > LONGEST_NUMBER or len(exponent) > 5:
        return math.inf
    if exponent and abs(int(exponent)) > LARGEST_EXPONENT:
        return math.inf
    return Fraction(digits)


def _syntax_error(message: str, text: str, source: str | None) -> AutomatonError:
    match = _TOML_PLACE.match(message)
    if match is None:
        return AutomatonError(message, source=source, line=1, column=1)
    lines = text.split("\n")
    line, column = match[2] or len(lines), match[3] or len(lines[-1]) + 1
    return AutomatonError(match[1], source=source, line=int(line), column=int(column))
