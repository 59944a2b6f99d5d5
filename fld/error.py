"""Why a shape has no differential behaviour to report, with the numbers that show it."""

LEAST, MOST = 1e-100, 1e100


class NotACurve(ValueError):
    """The cell is no chain of copies of itself between two points; `reason` says what is missing."""

    def __init__(self, cell: str, reason: str):
        self.cell = cell
        self.reason = reason
        super().__init__(
            f"cell {cell!r} is no self-similar curve: {reason}. A curve has a boundary of two point cells, "
            f"and its sub-cells are that same cell, glued end to start along the curve."
        )


class OutOfScale(ValueError):
    """Control points whose squares or cubes leave the range of doubles; `size` is that of their differences.

    It is in mm, and lies outside `[LEAST, MOST]`.
    """

    def __init__(self, size: float):
        self.size = size
        super().__init__(
            f"control points of size {size:.3g} mm cannot be computed with: sizes lie between {LEAST:g} and "
            f"{MOST:g} mm. Give them in another unit: orders and directions do not depend on it."
        )


class Collapsed(ValueError):
    """A sub-cell has no size left: the linear part of its operator has the eigenvalue 0 alone.

    `label` names the sub-cell, None when the whole curve is one point; `modulus` is the largest modulus of
    an eigenvalue that was found, on differences that the control points show.
    """

    def __init__(self, cell: str, label: str | None, modulus: float):
        self.cell = cell
        self.label = label
        self.modulus = modulus
        if label is None:
            message = f"the curve {cell!r} is a single point: move its control points apart"
        else:
            message = (
                f"sub-cell {label!r} of {cell!r} shrinks to nothing: its largest eigenvalue is "
                f"{modulus:.3g}, and the equation of the critical order needs all of them above 0. "
                f"Change the parameters that enter its operator"
            )
        super().__init__(message + ".")
