"""What is asked for at the doors: whole numbers within their range, and shapes."""

import operator
from typing import Any

from ifs.shape import Shape


def require_whole(name: str, value: Any, least: int = 0, most: int | None = None) -> None:
    """Raise `ValueError` for a value that is no whole number within the range.

    >>> require_whole("depth", 2.5)
    Traceback (most recent call last):
    ValueError: the depth is a whole number, 0 or more, found 2.5
    """
    try:
        found = operator.index(value)
    except TypeError:
        found = None
    if found is None or found < least or (most is not None and found > most):
        allowed = f"{least} or more" if most is None else f"{least} to {most}"
        raise ValueError(f"the {name} is a whole number, {allowed}, found {value!r}")


def require_shape(value: Any) -> None:
    """Raise `TypeError` for what is no `ifs.Shape`.

    >>> require_shape("koch-curve")
    Traceback (most recent call last):
    TypeError: expected a shape, found 'koch-curve' (str): make one by ifs.shape("koch-curve")
    """
    if not isinstance(value, Shape):
        made = f'ifs.shape("{value}")' if isinstance(value, str) else 'ifs.shape("koch-curve"), for example'
        raise TypeError(f"expected a shape, found {shown(value)}: make one by {made}")


def shown(value: Any) -> str:
    """A value and its type, cut short, for a message."""
    text = repr(value)
    return f"{text if len(text) <= 60 else text[:57] + '...'} ({type(value).__name__})"
