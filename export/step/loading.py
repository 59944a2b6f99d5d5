"""OpenCASCADE, loaded without being disturbed: an interrupt in the middle of that leaves no usable module."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


def load() -> None:
    """Load OpenCASCADE and build123d, which takes seconds. Ctrl-C waits until they are there.

    Their C++ modules turn an interrupt into an `ImportError` of their own.
    """
    with undisturbed():
        import build123d  # noqa: F401
        import OCP  # noqa: F401


@contextmanager
def undisturbed() -> Iterator[None]:
    """Ctrl-C waits until the end of the block, and is raised there as `KeyboardInterrupt`.

    Only the main thread hears of interrupts: in others, and where the caller has replaced Python's own
    handler, nothing changes.
    """
    usual = signal.default_int_handler
    if threading.current_thread() is not threading.main_thread() or signal.getsignal(signal.SIGINT) != usual:
        yield
        return
    heard: list[int] = []
    signal.signal(signal.SIGINT, lambda number, frame: heard.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, usual)
    if heard:
        raise KeyboardInterrupt
