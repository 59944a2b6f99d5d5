"""The ending of a path, by which formats are told apart."""

import os
from pathlib import Path


class UnsupportedFormat(ValueError):
    """The extension of a file names no format that can be written, or read."""


def ending_of(path: str | os.PathLike[str]) -> str:
    """The ending of a path in small letters. `UnsupportedFormat` for what is no path."""
    if not isinstance(path, (str, os.PathLike)):
        raise UnsupportedFormat(f"the path of a file was expected, found {path!r}")
    return Path(path).suffix.lower()
