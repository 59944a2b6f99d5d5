"""Files that a command is to write: looked at before the work, and named when writing fails."""

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path


class WrongOutput(ValueError):
    """A place where the result cannot be written."""


def check_output(path: str, endings: Sequence[str]) -> None:
    """Raise `WrongOutput` for a wrong ending, a missing or closed folder, or a folder in the file's place.

    >>> check_output("part.doc", (".3mf", ".stl"))
    Traceback (most recent call last):
    ...
    bcifs.output.WrongOutput: part.doc: expected a file name that ends in .3mf or .stl
    """
    target = Path(path)
    if target.suffix.lower() not in endings:
        raise WrongOutput(f"{path}: expected a file name that ends in {_either(endings)}")
    if not target.parent.is_dir():
        raise WrongOutput(f"{path}: there is no folder {target.parent}")
    if target.is_dir():
        raise WrongOutput(f"{path}: is a folder")
    if not os.access(target.parent, os.W_OK):
        raise WrongOutput(f"{path}: the folder {target.parent} cannot be written")


@contextmanager
def writing(path: str) -> Iterator[None]:
    """Names the file that was asked for when the system refuses to write it."""
    try:
        yield
    except OSError as error:
        raise WrongOutput(f"{path}: cannot be written: {error.strerror or error}") from error


def _either(endings: Sequence[str]) -> str:
    return " or ".join(filter(None, [", ".join(endings[:-1]), endings[-1]]))
