"""Files of Fractint, read as automata: `FILE.ifs` and `FILE.l`, with `:NAME` for one of several entries."""

import os
import re
from pathlib import Path

from automata.automaton import Automaton
from automata.fractint import fractint_ifs
from automata.include import file_text
from automata.turtle import lsystem_automaton

_PLACE = re.compile(r"(?P<path>.*\.(?P<kind>ifs|l))(:(?P<name>.*))?", re.IGNORECASE | re.DOTALL)


def read_foreign(source: str | os.PathLike[str]) -> Automaton | None:
    """The automaton of an entry of a Fractint file; nothing where the ending is another one.

    Raises `AutomatonError` as `automata.read` does.

    >>> read_foreign("corner-cutting") is None
    True
    """
    found = _PLACE.fullmatch(os.fspath(source))
    if not found:
        return None
    path = found["path"]
    text = file_text(Path(path), encoding="latin-1")  # comments of that time are in any code page
    if found["kind"].lower() == "ifs":
        return fractint_ifs(text, found["name"], path).automaton
    return lsystem_automaton(text, found["name"], path)
