"""TOML texts read with care, and the cells that one file includes from others.

`include = ["cells.toml"]` adds the cells and parameters of another file, looked for in the folder of the
file that includes it and never outside of it, or of a built-in automaton by its name.
"""

import math
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from importlib import resources
from os import PathLike, fspath
from pathlib import Path, PurePosixPath
from typing import Any

from automata.document import Field, suggestion
from automata.error import AutomatonError
from automata.location import locate

LARGEST_FILE = 1_000_000
LARGEST_EXPONENT = 300
LONGEST_NUMBER = 400
LONGEST_KEY = 32
MOST_INCLUDED = 32
DEEPEST_INCLUSION = 8

_PART = r"(?:[A-Za-z0-9_-]++|\"[^\"\n]*+\"|'[^'\n]*+')[ \t]*+"
_LONG_KEY = re.compile(rf"(?<![A-Za-z0-9_-])(?:{_PART}\.[ \t]*+){{{LONGEST_KEY}}}")
"""Reading a dotted key takes the square of its length, so long ones are turned away first."""
_TOML_PLACE = re.compile(r"^(.*) \(at (?:line (\d+), column (\d+)|end of document)\)$", re.DOTALL)


@dataclass(frozen=True)
class Source:
    """One text: its name in errors, what it says, and the folder that its inclusions may lie in."""

    name: str | None
    text: str
    document: Mapping[str, Any]
    folder: Path | None

    def placed(self, error: AutomatonError) -> AutomatonError:
        """The error with the line and column of its path in this text."""
        line, column = locate(self.text, error.path)
        return AutomatonError(error.message, path=error.path, source=self.name, line=line, column=column)


@dataclass(frozen=True)
class Whole:
    """A document with what it includes; `origin` says from which text a cell or parameter came."""

    main: Source
    document: dict[str, Any]
    origin: Mapping[tuple[str, str], Source] = field(default_factory=dict)

    def placed(self, error: AutomatonError) -> AutomatonError:
        """The error with its file, line and column."""
        key = error.path[:2]
        source = self.origin.get((str(key[0]), str(key[1])), self.main) if len(key) == 2 else self.main
        return source.placed(error)


def builtin_names() -> tuple[str, ...]:
    """The names of the automata that come with bcifs, in alphabetical order.

    >>> "corner-cutting" in builtin_names()
    True
    """
    folder = resources.files("automata") / "builtin"
    files = (entry.name for entry in folder.iterdir())
    return tuple(sorted(name.removesuffix(".toml") for name in files if name.endswith(".toml")))


def load(source: str | PathLike[str]) -> Whole:
    """The document of a file or a built-in automaton, with what it includes. Raises `AutomatonError`."""
    name = fspath(source)
    if name in builtin_names():
        return with_included(_builtin(name))
    return with_included(parsed(file_text(Path(name)), name, Path(name).parent))


def _builtin(name: str) -> Source:
    text = (resources.files("automata") / "builtin" / f"{name}.toml").read_text("utf-8")
    return parsed(text, name, None)


def parsed(text: str, source: str | None, folder: Path | None) -> Source:
    """A TOML text as a document of exact numbers. Raises `AutomatonError` with line and column."""
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
    return Source(source, text, document, folder)


def with_included(main: Source) -> Whole:
    """A document with the cells and parameters of all files that it includes, directly or through others.

    Its own parameters go before included ones; a cell has one definition. Raises `AutomatonError` with the
    place of the inclusion, or of the fault in the included file.
    """
    if "include" not in main.document:
        return Whole(main, dict(main.document))
    gathered = _Gathered()
    gathered.add(main, ())
    document = {key: value for key, value in main.document.items() if key != "include"}
    for key, table in gathered.tables.items():
        if table:
            document[key] = table
    return Whole(main, document, gathered.origin)


class _Gathered:
    """Cells and parameters from several texts, each text once however often it is included."""

    def __init__(self):
        self.tables: dict[str, dict[str, Any]] = {"cells": {}, "parameters": {}}
        self.origin: dict[tuple[str, str], Source] = {}
        self.seen: set[str] = set()

    def add(self, source: Source, chain: tuple[str, ...]) -> None:
        """Take over what a text includes, then what it says itself."""
        try:
            names = Field(source.document.get("include", []), ("include",))
            for entry in names.items('a list such as ["cells.toml"]'):
                self._include(entry, source, chain)
            self._take(source)
        except AutomatonError as error:
            raise error if error.line is not None or error.source else source.placed(error) from None

    def _include(self, entry: Field, source: Source, chain: tuple[str, ...]) -> None:
        name = entry.text('the name of a file such as "cells.toml"')
        place = name if name in builtin_names() else str(_within(entry, name, source.folder))
        if place in chain:
            raise entry.error(f"{name!r} includes itself: {' -> '.join((*chain, place))}")
        if place in self.seen:
            return
        if len(chain) >= DEEPEST_INCLUSION or len(self.seen) >= MOST_INCLUDED:
            limits = f"{DEEPEST_INCLUSION} deep, {MOST_INCLUDED} files in all"
            raise entry.error(f"too many files include each other (at most {limits})")
        self.seen.add(place)
        if name in builtin_names():
            found = _builtin(name)
        else:
            try:
                found = parsed(file_text(Path(place)), place, Path(place).parent)
            except AutomatonError as error:
                if error.line is not None:
                    raise
                raise entry.error(f"{place}: {error.message}") from None
        self.add(found, (*chain, place))

    def _take(self, source: Source) -> None:
        for key, table in self.tables.items():
            given = source.document.get(key, {})
            if not isinstance(given, dict):
                raise AutomatonError(f"expected a table of {key}", path=(key,))
            for name, value in given.items():
                before = self.origin.get((key, name))
                if before is not None and key == "cells":
                    message = f"the cell {name!r} is described in {before.name} already"
                    raise AutomatonError(message, path=(key, name))
                table[name] = value
                self.origin[key, name] = source


def _within(entry: Field, name: str, folder: Path | None) -> Path:
    """The file of an inclusion, which lies in the folder wherever its links lead."""
    if folder is None:
        raise entry.error(
            f"only built-in automata can be included here, not {name!r}{suggestion(name, builtin_names())}"
        )
    path = PurePosixPath(name)
    if (
        path.is_absolute()
        or ".." in path.parts
        or "\\" in name
        or "\0" in name
        or ":" in name
        or not path.parts
    ):
        raise entry.error(f"a file is included by its name in the folder of this one, not by {name!r}")
    try:
        found = (folder / path).resolve()
        inside = found.is_relative_to(folder.resolve())
    except (OSError, RuntimeError):
        raise entry.error(f"cannot follow the links of {name!r}") from None
    if not inside:
        raise entry.error(f"{name!r} leads out of the folder of this file")
    return folder / path


def file_text(path: Path, encoding: str = "utf-8") -> str:
    """The text of a file that is not too large; `AutomatonError` for whatever is wrong with it."""
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
        return path.read_bytes().decode(encoding)
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
