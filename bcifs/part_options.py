"""The options that print and slices share: how large and how fine a part is, and what makes it printable."""

import functools
import inspect
import re
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Annotated, Any, Literal, get_type_hints

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


MOST_TRIANGLES = 20_000_000
_STEPS = ("wall", "gap", "smallest", "islands", "strut", "hollow", "turn", "base", "margin", "drain")


class WrongVolume(ValueError):
    """A build volume that is not written as three lengths."""


@dataclass(frozen=True)
class PartOptions:
    """The options as they were given."""

    size: Size = None
    resolution: Resolution = None
    thickness: Thickness = 0.0
    thicken_by: ThickenBy = "ball"
    depth: PieceDepth = None
    triangles: Triangles = MOST_TRIANGLES
    coarsen: Coarsen = False
    wall: Wall = None
    gap: Gap = None
    smallest: Smallest = 0.0
    islands: Islands = "keep"
    strut: Strut = None
    hollow: Hollow = None
    turn: Turn = "keep"
    base: Base = None
    margin: Margin = 0.0
    drain: Drain = None
    fit: FitInto = None

    def printable(self) -> Any:
        """What is to be done to a part: `export.Printable` of the options."""
        from export import Printable

        volume = None if self.fit is None else build_volume(self.fit)
        return Printable(fit=volume, **{step: getattr(self, step) for step in _STEPS})

    def shaped(self) -> dict[str, Any]:
        """The arguments of `export.prepare` and `export.make_part` that say how large and how fine."""
        from dataclasses import replace

        from export.prepare import BUDGET

        exceeded = "coarsen" if self.coarsen else "refuse"
        return {
            "size": self.size,
            "resolution": self.resolution,
            "thickness": self.thickness,
            "thicken_by": self.thicken_by,
            "depth": self.depth,
            "budget": replace(BUDGET, triangles=self.triangles, exceeded=exceeded),
        }


def with_part_options(command: Callable[..., None]) -> Callable[..., None]:
    """A command whose argument `part` is made of the options above, which take its place."""
    own = inspect.signature(command, eval_str=True).parameters
    hints = get_type_hints(PartOptions, include_extras=True)
    shared = [
        inspect.Parameter(
            each.name, inspect.Parameter.KEYWORD_ONLY, default=each.default, annotation=hints[each.name]
        )
        for each in fields(PartOptions)
    ]
    every: list[inspect.Parameter] = []
    for name, one in own.items():
        every += shared if name == "part" else [one.replace(kind=inspect.Parameter.KEYWORD_ONLY)]

    @functools.wraps(command)
    def gathered(**given: Any) -> None:
        chosen = {one.name: given.pop(one.name) for one in shared}
        command(part=PartOptions(**chosen), **given)

    gathered.__signature__ = inspect.Signature(every)  # type: ignore[attr-defined]
    gathered.__annotations__ = {one.name: one.annotation for one in every}
    return gathered


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
