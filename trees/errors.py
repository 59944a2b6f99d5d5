"""What can be wrong with a tree or with what it is made from."""


class TreeError(ValueError):
    """Any wrong input of the package `trees`."""


class KeyTooWide(TreeError):
    """`dimension * bits` is more than the 64 bits of a key."""

    def __init__(self, dimension: int, bits: int):
        self.dimension, self.bits = dimension, bits
        super().__init__(
            f"{dimension} axes of {bits} bits need keys of {dimension * bits} bits, and a key has 64: "
            f"ask for at most {64 // dimension} bits an axis"
        )


class Misaligned(TreeError):
    """Two reference cubes whose grids do not meet: on which `axis`, or None where the sizes disagree."""

    def __init__(self, message: str, axis: int | None = None):
        self.axis = axis
        super().__init__(message)


class TooManyPieces(TreeError):
    """A result of more than `limit` pieces, `count` of them."""

    def __init__(self, count: int, limit: int):
        self.count, self.limit = count, limit
        super().__init__(f"{count} pieces, more than {limit}: ask for fewer bits an axis")


class CodeError(TreeError):
    """A tree or leaf code that cannot be read; `place` is the 0-based number of the symbol or leaf code."""

    def __init__(self, place: int, message: str):
        self.place = place
        super().__init__(f"place {place}: {message}")


class DamagedFile(TreeError):
    """A file that is no tree, or no longer one."""
