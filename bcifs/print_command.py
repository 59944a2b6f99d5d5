"""The command that makes a part: from a description to a file that prints."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from bcifs.answers import load
from bcifs.failure import CheckFailed
from bcifs.options import File, Settings
from bcifs.output import check_output, writing
from bcifs.part_options import PartOptions, with_part_options
from bcifs.progress import reporting

SURFACE = "Surface"
PartFile = Annotated[
    str, typer.Option("--output", "-o", metavar="PART", help="The part: .3mf .stl .ply .obj .glb.")
]


@with_part_options
def print_part(
    file: File,
    output: PartFile,
    set_: Settings = None,
    picture: Annotated[str | None, typer.Option(metavar="PNG", help="Also draw the part.")] = None,
    *,
    part: PartOptions,
    surface: Annotated[
        Literal["smooth", "exact"] | None,
        typer.Option(
            help="The mesh: smooth (default where the part is thickened), or exact along the faces of the "
            "voxels.",
            rich_help_panel=SURFACE,
        ),
    ] = None,
    contacts: Annotated[
        Literal["join", "separate"],
        typer.Option(
            help="Voxels that touch at an edge or a corner only: joined, or each with a surface of its own.",
            rich_help_panel=SURFACE,
        ),
    ] = "join",
    merge: Annotated[
        bool,
        typer.Option(
            "--merge", help="Make rectangles of flat squares: fewer triangles.", rich_help_panel=SURFACE
        ),
    ] = False,
    features: Annotated[
        float | None,
        typer.Option(
            metavar="DEGREES",
            help="Keep edges and corners of the thickened shape that bend by more.",
            rich_help_panel=SURFACE,
        ),
    ] = None,
    block: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            help="Take blocks of 2, 4, 8, ... voxels a side, but in the boxes of --fine.",
            rich_help_panel=SURFACE,
        ),
    ] = None,
    fine: Annotated[
        list[str] | None,
        typer.Option(
            metavar="X,Y,Z,X,Y,Z",
            help="Two corners in mm of a box where voxels stay as they are; may be given again.",
            rich_help_panel=SURFACE,
        ),
    ] = None,
) -> None:
    """Make a printable part: voxels that cover the shape, thickened, meshed, checked and written.

    From 300 voxels a side on, or for fewer than 10 million triangles allowed, amounts are predicted first;
    beyond 20 million triangles or 8 GiB, unless told otherwise, it refuses.

    What was done to make the part printable is told line by line. A part that fails the check is not written.
    """
    from export.files import WRITABLE

    check_output(output, WRITABLE)
    if picture:
        check_output(picture, (".png",))
    printable = part.printable()
    grading = _grading(block, fine or [])
    shape = loaded(file, set_, part.depth)
    import export

    with reporting() as progress:
        made = export.make_part(
            shape,
            **part.shaped(),
            style=surface,
            contacts=contacts,
            merge=merge,
            features=features,
            grading=grading,
            printable=printable,
            predicted=lambda found: announce(found, part.resolution),
            progress=progress,
        )
    tell(made.steps)
    if not made.report.ok:
        raise CheckFailed(f"{output} is not written, it fails the check: {'; '.join(made.report.faults)}")
    from bcifs.recipe import part_recipe

    recipe = part_recipe(shape, made.recipe)
    with writing(output):
        export.write_part(made.mesh, output, recipe, shape.name)
    typer.echo(f"{output}: {Path(output).stat().st_size} bytes\n{made.report}")
    if picture:
        _draw(made.mesh, picture, recipe)


def loaded(file: str, settings: list[str] | None, depth: int | None) -> Any:
    """The shape of a file, at a depth that can be printed."""
    shape = load(file, settings)
    if depth is not None:
        from bcifs.depth import require_printable_depth

        require_printable_depth(shape, depth)
    return shape


class WrongBox(ValueError):
    """A box that is not written as two corners, or that has no use."""


def _grading(block: int | None, boxes: list[str]) -> Any:
    """Blocks outside of boxes: `export.Grading` of the options."""
    if block is None:
        if boxes:
            raise WrongBox(f"--fine {boxes[0]} has no use: --block says how coarse it is elsewhere")
        return None
    from export import Grading, Region

    return Grading(block, tuple(Region(*corners(text)) for text in boxes))


def corners(text: str) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Two corners of a box in mm, the lower one first.

    >>> corners("0,10,0, 20,5,8.5")
    ((0.0, 5.0, 0.0), (20.0, 10.0, 8.5))
    """
    try:
        a, b, c, x, y, z = (float(number) for number in text.split(","))
    except ValueError:
        raise WrongBox(f"--fine {text}: expected two corners of a box in mm, as in 0,0,0,20,20,8.5") from None
    return (min(a, x), min(b, y), min(c, z)), (max(a, x), max(b, y), max(c, z))


def announce(prediction: Any, resolution: int | None) -> None:
    """Tell what is predicted, and whether the resolution was lowered, on standard error."""
    typer.echo(str(prediction), err=True)
    if resolution is not None and prediction.resolution < resolution:
        typer.echo(f"the resolution is {prediction.resolution} instead of {resolution}, which fits", err=True)


def tell(steps: Iterable[Any]) -> None:
    """Tell what was done, a line a step."""
    for step in steps:
        typer.echo(str(step))


def _draw(mesh: Any, picture: str, recipe: Mapping[str, str]) -> None:
    from bcifs.picture import draw_mesh

    with writing(picture):
        draw_mesh(mesh, picture, recipe)
    typer.echo(f"{picture}: {Path(picture).stat().st_size} bytes")
