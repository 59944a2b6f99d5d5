"""The two distances whose unit balls say which cells touch (Guye 1988, V.1)."""

from trees.errors import TreeError

D1, DINF = "d1", "d-infinity"
METRICS = (D1, DINF)


def is_box(metric: str) -> bool:
    """Whether cells that share no more than a corner touch: False for "d1", True for "d-infinity".

    A cell of a cube of dimension k has `2 k` neighbours for d1, those across its faces, and `3^k - 1` for
    d-infinity. Raises `TreeError` for any other word.

    >>> is_box("d1"), is_box("d-infinity")
    (False, True)
    """
    if metric not in METRICS:
        raise TreeError(f"metric {metric!r}: one of {', '.join(METRICS)} is needed")
    return metric == DINF


def dual_metric(metric: str) -> str:
    """The metric of the other colour: where black cells touch by d1, white ones do by d-infinity.

    With one metric for both colours a diagonal line of cells would neither join nor separate.

    >>> dual_metric("d1")
    'd-infinity'
    """
    return D1 if is_box(metric) else DINF
