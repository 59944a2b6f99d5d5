"""Fractint's text files, cut into their entries `name { … }`; nothing in them is ever executed."""

from dataclasses import dataclass

from automata.error import AutomatonError

MOST_CHARACTERS = 1_000_000
MOST_ENTRIES = 10_000
LONGEST_NAME = 80


@dataclass(frozen=True)
class Line:
    """What a line says without its comment; `number` and `column` (from 1) are where it starts."""

    text: str
    number: int
    column: int


@dataclass(frozen=True)
class Entry:
    """One `name { … }`: the name as written, where it stands, and the lines between the braces."""

    name: str
    line: int
    column: int
    lines: tuple[Line, ...]


def entries(text: str, source: str | None = None) -> tuple[Entry, ...]:
    """The entries of a file, in order; those called `comment` are left out.

    A semicolon starts a comment. Raises `AutomatonError` with line and column for a text that is too long, a
    NUL, words outside of entries, and braces that do not match.

    >>> [entry.name for entry in entries("; two\\na { 1 }\\nb {\\n 2 ; more\\n}")]
    ['a', 'b']
    """
    if len(text) > MOST_CHARACTERS:
        raise AutomatonError(
            f"expected at most {MOST_CHARACTERS} characters, found {len(text)}", source=source
        )
    found: list[Entry] = []
    name: str | None = None
    place: tuple[int, int] = (0, 0)
    lines: list[Line] = []
    for number, whole in enumerate(text.split("\n"), start=1):
        if "\0" in whole:
            raise _wrong("a NUL character is no text", source, number, whole.index("\0") + 1)
        rest = whole.split(";")[0].rstrip() if not _commenting(name) else whole.rstrip()
        column = 1
        while rest.strip():
            if name is None:
                opening = rest.find("{")
                written = " ".join(rest[: max(opening, 0)].split())
                column += len(rest) - len(rest.lstrip())
                if opening < 0 or not written or "}" in written:
                    raise _wrong("expected an entry such as 'name {'", source, number, column)
                if len(written) > LONGEST_NAME:
                    message = f"a name has at most {LONGEST_NAME} characters, found {len(written)}"
                    raise _wrong(message, source, number, column)
                name, place, lines = written, (number, column), []
                column, rest = opening + 2, rest[opening + 1 :]
                continue
            closing = rest.find("}")
            part = rest if closing < 0 else rest[:closing]
            if "{" in part and not _commenting(name):
                message = f"'{{' inside the entry {name!r}, which has not been closed with '}}'"
                raise _wrong(message, source, number, column + part.index("{"))
            if part.strip():
                lines.append(Line(part, number, column))
            if closing < 0:
                break
            if not _commenting(name):
                found.append(Entry(name, *place, tuple(lines)))
                if len(found) > MOST_ENTRIES:
                    raise _wrong(f"a file has at most {MOST_ENTRIES} entries", source, number, column)
            column, rest, name = column + closing + 1, rest[closing + 1 :], None
    if name is not None:
        raise _wrong(f"the entry {name!r} is never closed with '}}'", source, *place)
    return tuple(found)


def chosen(text: str, name: str | None, source: str | None, kind: str) -> Entry:
    """The entry of that name, in any case of its letters; the only one when no name is given.

    Raises `AutomatonError` that lists the names there are.
    """
    found = entries(text, source)
    if not found:
        raise AutomatonError(f"there is no {kind}: expected 'name {{ … }}'", source=source)
    listed = ", ".join(entry.name for entry in found[:20])
    if name is None and len(found) > 1:
        raise AutomatonError(f"there are {len(found)} entries, name one of: {listed}", source=source)
    for entry in found:
        if name is None or plain_name(entry.name).lower() == plain_name(name).lower():
            return entry
    raise AutomatonError(f"there is no {kind} {name!r}; there are: {listed}", source=source)


def plain_name(written: str) -> str:
    """A name without what stands in parentheses after it, such as `(3D)`."""
    return written.split("(")[0].strip() or written


def _commenting(name: str | None) -> bool:
    return name is not None and name.lower() == "comment"


def _wrong(message: str, source: str | None, line: int, column: int) -> AutomatonError:
    return AutomatonError(message, source=source, line=line, column=column)
