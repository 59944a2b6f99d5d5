"""What ends a command early: the exit code and the message of every error."""

import sys

from subdivision import Contradiction

WRONG_INPUT = 2
CONTRADICTION = 3
NOT_CONTRACTING = 4
CHECK_FAILED = 5
INTERRUPTED = 130


class CheckFailed(Exception):
    """A mesh that is not printable; its faults are the message."""


def exit_code(error: BaseException) -> int | None:
    """The exit code that an error stands for, or None for one that no input should bring about.

    >>> exit_code(FileNotFoundError("no such file"))
    2
    >>> exit_code(AssertionError()) is None
    True
    """
    if isinstance(error, Contradiction):
        return CONTRADICTION
    if _is_not_contracting(error):
        return NOT_CONTRACTING
    if isinstance(error, CheckFailed):
        return CHECK_FAILED
    if isinstance(error, KeyboardInterrupt):
        return INTERRUPTED
    if isinstance(error, (ValueError, OSError, MemoryError)):
        return WRONG_INPUT
    return None


def explain(error: BaseException) -> str:
    """What the user is told: what is wrong and, where the error knows, what to do."""
    if isinstance(error, KeyboardInterrupt):
        return "interrupted; nothing was left half-written"
    if isinstance(error, MemoryError):
        return f"not enough memory ({error}): ask for a smaller --depth or --resolution, or use --coarsen"
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename}: {error.strerror}" if error.filename else error.strerror
    return str(error) or type(error).__name__


def _is_not_contracting(error: BaseException) -> bool:
    """Without importing the engine: an error of its kind exists only once the engine is loaded."""
    engine = sys.modules.get("ifs.error")
    return engine is not None and isinstance(error, (engine.NotContracting, engine.Undecided))
