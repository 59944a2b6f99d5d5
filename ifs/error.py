"""What can be wrong with a system of operators, with the numbers that show it."""


class NotContracting(ValueError):
    """Some cycle of operators does not shrink: the system has no attractor.

    `word` leads from `cell` back to `cell`; `radius` is the spectral radius of its product on the
    differences of points, and is not below 1.
    """

    def __init__(self, cell: str, word: tuple[str, ...], radius: float):
        self.cell = cell
        self.word = word
        self.radius = radius
        repeated = " ".join(word)
        super().__init__(
            f"cell {cell!r} does not contract: repeating the subdivision {repeated!r} multiplies "
            f"differences of points by {radius:.12g}, which must be below 1. Change the operators "
            f"along this word (or the free parameters in them)."
        )


class Undecided(RuntimeError):
    """The work allowed was spent before the joint spectral radius was placed on one side of 1.

    It lies in `[lower, upper]`; `word` from `cell` attains `lower`.
    """

    def __init__(self, cell: str | None, word: tuple[str, ...], lower: float, upper: float, budget: float):
        self.cell = cell
        self.word = word
        self.lower = lower
        self.upper = upper
        self.budget = budget
        super().__init__(
            f"contraction is undecided: the joint spectral radius lies in "
            f"[{lower:.9g}, {upper:.9g}]"
            + (f" (the lower end from {' '.join(word)!r} at cell {cell!r})" if word else "")
            + f". Allow more work than budget={budget:g}, or move the parameters away from the "
            f"limit of contraction."
        )


class EmptyAttractor(ValueError):
    """A cell without any subdivision: no infinite address starts there, so it has no points."""

    def __init__(self, cell: str):
        self.cell = cell
        super().__init__(
            f"cell {cell!r} has no subdivision, so its attractor is empty. Give it at least one "
            f"operator (a cell that is a point subdivides into itself)."
        )
