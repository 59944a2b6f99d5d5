"""Automaton files: TOML text in, `Automaton` out, every fault with its line and column."""

import os

from automata.automaton import Automaton
from automata.description import describe
from automata.error import AutomatonError
from automata.foreign import read_foreign
from automata.include import Whole, builtin_names, load, parsed, with_included

__all__ = ["builtin_names", "parse_text", "read"]


def read(source: str | os.PathLike[str]) -> Automaton:
    """The automaton of a file, or the built-in one of that name.

    A name with a folder or the ending `.toml` is a file; any other is looked up among the built-in automata
    first. A Fractint file gives one of its entries, `trees.ifs:fern` or `curves.l:koch`, or its only one.
    Raises `AutomatonError` with file, line and column for whatever is wrong with the file, or with one that
    it includes.

    >>> read("corner-cutting").shape
    'edge'
    """
    return read_foreign(source) or _described(load(source))


def parse_text(text: str, source: str | None = None) -> Automaton:
    """The automaton that a TOML text describes; `source` names it in errors.

    A text has no folder, so that it includes built-in automata only.
    Raises `AutomatonError` with line and column.
    """
    return _described(with_included(parsed(text, source, None)))


def _described(whole: Whole) -> Automaton:
    try:
        return describe(whole.document)
    except AutomatonError as error:
        raise whole.placed(error) from None
