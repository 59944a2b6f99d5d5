"""Writing a file, or a folder, whole or not at all."""

import contextlib
import errno
import os
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO


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
    target = Path(path)
    _require_folder(target)
    handle, name = tempfile.mkstemp(prefix=f".{target.name[:60]}.", suffix=".part", dir=target.parent)
    try:
        with os.fdopen(handle, "w+b") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        os.chmod(name, 0o666 & ~_umask())
        os.replace(name, target)
    except BaseException:
        with contextlib.suppress(FileNotFoundError):
            os.unlink(name)
        raise


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
    _require_folder(target)
    folder = Path(tempfile.mkdtemp(prefix=f".{target.name[:60]}.", suffix=".part", dir=target.parent))
    try:
        yield folder
        os.chmod(folder, 0o777 & ~_umask())
        os.replace(folder, target)
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise


def _require_folder(target: Path) -> None:
    if not target.parent.is_dir():
        raise FileNotFoundError(errno.ENOENT, "there is no such folder", str(target.parent))


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
