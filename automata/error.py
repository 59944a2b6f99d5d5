"""What can be wrong with a description, said with the place where it is wrong."""


class AutomatonError(ValueError):
    """A description that cannot be used: what is wrong, where, and what was expected.

    `path` is the chain of keys that leads to the fault, for example
    `("cells", "edge", "boundary", "left", "points", 1)`; `source`, `line` and `column`
    (both from 1) are known when the description came from a file.

    >>> str(AutomatonError("unknown cell 'egde'", source="curve.toml", line=7, column=3))
    "curve.toml:7:3: unknown cell 'egde'"
    """

    def __init__(
        self,
        message: str,
        *,
        path: tuple[str | int, ...] = (),
        source: str | None = None,
        line: int | None = None,
        column: int | None = None,
    ):
        self.message = message
        self.path = path
        self.source = source
        self.line = line
        self.column = column
        place = ":".join(str(part) for part in (source, line, column) if part is not None)
        if not place:
            place = ".".join(str(key) for key in path)
        super().__init__(f"{place}: {message}" if place else message)
