"""Files that are written whole or not at all."""

import contextlib
import errno
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any


@contextlib.contextmanager
def written_whole(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A hidden file beside the path, to write; it takes the path's name when all is written, and on the disk.

    An older file of that name stays whole until then. Whatever ends the block early, Ctrl-C too,
    removes the new one. `OSError` where the folder is missing or cannot be written.

    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with written_whole(Path(folder) / "a") as part:
    ...         count = part.write_bytes(b"all")
    ...     (Path(folder) / "a").read_bytes()
    b'all'
    """
    target = Path(path)
    require_folder(target)
    handle, name = tempfile.mkstemp(**beside(target))
    os.close(handle)
    try:
        yield Path(name)
        with open(name, "rb") as file:
            os.fsync(file.fileno())
        os.chmod(name, 0o666 & ~umask())
        os.replace(name, target)
    except BaseException:
        with contextlib.suppress(FileNotFoundError):
            os.unlink(name)
        raise


def require_folder(target: Path) -> None:
    """`FileNotFoundError` where the folder of a path is missing."""
    if not target.parent.is_dir():
        raise FileNotFoundError(errno.ENOENT, "there is no such folder", str(target.parent))


def beside(target: Path) -> dict[str, Any]:
    """How `tempfile` names a hidden file or folder beside a path."""
    return {"prefix": f".{target.name[:60]}.", "suffix": ".part", "dir": target.parent}


def umask() -> int:
    """What new files are denied."""
    mask = os.umask(0)
    os.umask(mask)
    return mask
