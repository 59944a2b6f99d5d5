"""Writing a file, or a folder, whole or not at all."""

import contextlib
import os
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from trees.files.whole import beside, require_folder, umask, written_whole


@contextlib.contextmanager
def whole_file(path: str | os.PathLike[str]) -> Iterator[BinaryIO]:
    """A binary file that takes its place at `path` when the block ends well.

    Until then it is a hidden file in the same folder, and whatever ends the block early, Ctrl-C
    too, removes it and leaves what stood at `path` before. `OSError` when the folder is missing or
    cannot be written.

    >>> import pathlib, tempfile
    >>> place = pathlib.Path(tempfile.mkdtemp()) / "word.txt"
    >>> with whole_file(place) as file:
    ...     _ = file.write(b"done")
    >>> place.read_bytes()
    b'done'
    """
    with written_whole(path) as unfinished, open(unfinished, "w+b") as file:
        yield file


@contextlib.contextmanager
def whole_folder(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A folder to fill, which takes its place at `path` when the block ends well, as `whole_file` does.

    `FileExistsError` where there is a file, or a folder that is not empty: it is not written over.

    >>> place = Path(tempfile.mkdtemp()) / "words"
    >>> with whole_folder(place) as folder:
    ...     _ = (folder / "one.txt").write_bytes(b"1")
    >>> [found.name for found in place.iterdir()]
    ['one.txt']
    """
    target = Path(path)
    if target.exists() and not (target.is_dir() and not any(target.iterdir())):
        raise FileExistsError(f"{path}: is there already, and is not an empty folder")
    require_folder(target)
    folder = Path(tempfile.mkdtemp(**beside(target)))
    try:
        yield folder
        os.chmod(folder, 0o777 & ~umask())
        os.replace(folder, target)
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise
