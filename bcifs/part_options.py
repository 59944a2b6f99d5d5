"""The options that print and slices share: how large and how fine a part is, and what makes it printable."""

import re
from typing import Annotated, Any, Literal

import typer

SHAPE, PRINTABLE = "Size and detail", "Made printable, in this order"

Size = Annotated[
    float | None,
    typer.Option(
        metavar="MM",
        help="The longest side, before thickening (default: as described).",
        rich_help_panel=SHAPE,
    ),
]
Resolution = Annotated[
    int | None,
    typer.Option(
        metavar="N",
        min=1,
        help="Voxels along the longest side (default: 200, or the grid of the pieces where they lie on "
        "one, or two voxels across a wall of the thickness).",
        rich_help_panel=SHAPE,
    ),
]
Thickness = Annotated[
    float,
    typer.Option(metavar="MM", min=0, help="The thickness of walls and wires.", rich_help_panel=SHAPE),
]
ThickenBy = Annotated[
    Literal["ball", "box"],
    typer.Option(help="What is swept over the shape to thicken it.", rich_help_panel=SHAPE),
]
PieceDepth = Annotated[
    int | None,
    typer.Option(
        min=0,
        metavar="N",
        help="Take the solid pieces of this level, not the limit.",
        rich_help_panel=SHAPE,
    ),
]
Coarsen = Annotated[
    bool,
    typer.Option(
        "--coarsen", help="Lower a resolution that is too fine to what fits.", rich_help_panel=SHAPE
    ),
]
Triangles = Annotated[
    int,
    typer.Option(
        metavar="N",
        min=1000,
        help="The most triangles, as predicted; what takes more is refused, or coarsened.",
        rich_help_panel=SHAPE,
    ),
]
Wall = Annotated[
    float | None,
    typer.Option(metavar="MM", help="Make thinner walls this thick.", rich_help_panel=PRINTABLE),
]
Gap = Annotated[
    float | None,
    typer.Option(metavar="MM", help="Fill gaps that are narrower.", rich_help_panel=PRINTABLE),
]
Smallest = Annotated[
    float,
    typer.Option(metavar="MM3", min=0, help="Drop islands of less volume.", rich_help_panel=PRINTABLE),
]
Islands = Annotated[
    Literal["keep", "drop", "link"],
    typer.Option(
        help="Pieces that hang free: kept, dropped but for the largest, or linked by struts.",
        rich_help_panel=PRINTABLE,
    ),
]
Strut = Annotated[
    float | None,
    typer.Option(
        metavar="MM",
        help="The diameter of struts (default: as thick as --wall, or two voxels).",
        rich_help_panel=PRINTABLE,
    ),
]
Hollow = Annotated[
    float | None,
    typer.Option(metavar="MM", help="Hollow it out, leaving walls this thick.", rich_help_panel=PRINTABLE),
]
Turn = Annotated[
    Literal["keep", "fit", "x", "-x", "y", "-y", "z", "-z"],
    typer.Option(help="The axis that will point up; fit: so that it fits --fit.", rich_help_panel=PRINTABLE),
]
Base = Annotated[
    float | None,
    typer.Option(metavar="MM", help="Put a flat base of this height under it.", rich_help_panel=PRINTABLE),
]
Margin = Annotated[
    float,
    typer.Option(
        metavar="MM", min=0, help="How far the base reaches beyond the part.", rich_help_panel=PRINTABLE
    ),
]
Drain = Annotated[
    float | None,
    typer.Option(
        metavar="MM", help="Bore a hole of this diameter out of each trapped void.", rich_help_panel=PRINTABLE
    ),
]
FitInto = Annotated[
    str | None,
    typer.Option(
        "--fit",
        metavar="XxYxZ",
        help="The build volume in mm, as in 200x200x180; what is larger is refused.",
        rich_help_panel=PRINTABLE,
    ),
]


class WrongVolume(ValueError):
    """A build volume that is not written as three lengths."""


def asked(fit: str | None, **options: Any) -> Any:
    """What is to be done to a part: `export.Printable` of the options."""
    from export import Printable

    return Printable(fit=None if fit is None else build_volume(fit), **options)


def build_volume(text: str) -> tuple[float, float, float]:
    """The sides of a build volume in mm.

    >>> build_volume("200x200x180.5")
    (200.0, 200.0, 180.5)
    """
    sides = re.split(r"\s*[xX*]\s*", text.strip())
    try:
        x, y, z = (float(side) for side in sides)
    except ValueError:
        raise WrongVolume(f"--fit {text}: expected three lengths in mm, as in 200x200x180") from None
    return x, y, z
