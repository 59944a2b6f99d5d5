"""What cannot leave as STEP, said with its numbers and with what to do instead."""

ENDINGS = (".step", ".stp")


class WrongEnding(ValueError):
    """A file name that does not end as STEP files do."""

    def __init__(self, path: str):
        self.path = path
        super().__init__(
            f"{path}: STEP files end in .step or .stp. For 3MF, STL and others see export.write_part or "
            "bcifs mesh, which choose the format by the ending"
        )


class NotPolynomial(ValueError):
    """A cell whose limit is no polynomial surface, nor one away from finitely many points.

    `cell` is its name; `reason` says what was found.
    """

    def __init__(self, cell: str, reason: str):
        self.cell = cell
        self.reason = reason
        super().__init__(
            f"the cell {cell!r} has no B-spline faces: {reason}. Write 3MF or STL (bcifs mesh, bcifs print), "
            "or ask for planar facets (facets=True, --facets)"
        )


class TooManyFaces(ValueError):
    """More faces than a CAD system can be expected to take: `count` where `most` are allowed."""

    def __init__(self, count: int, most: int, remedy: str):
        self.count = count
        self.most = most
        super().__init__(f"the shape has {count} faces or more, at most {most} leave as STEP: {remedy}")


class WrongShell(ValueError):
    """Faces that do not form an oriented surface: `place` is the middle of the edge in question, in mm."""

    def __init__(self, reason: str, place: tuple[float, float, float]):
        self.reason = reason
        self.place = place
        x, y, z = place
        super().__init__(f"{reason} at ({x:.6g}, {y:.6g}, {z:.6g}) mm")


class InsideOut(ValueError):
    """A closed surface whose normals point inwards; `volume`, in mm^3, is negative."""

    def __init__(self, volume: float):
        self.volume = volume
        super().__init__(
            f"the solid has volume {volume:.6g} mm^3: its faces run clockwise seen from outside. List the "
            "corners of each face the other way round"
        )
