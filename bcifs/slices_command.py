"""The command that writes the layers of a part, for printers that harden layer after layer."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from bcifs.options import File, Settings
from bcifs.output import WrongOutput, check_output, writing
from bcifs.part_options import PartOptions, with_part_options
from bcifs.print_command import announce, loaded, tell
from bcifs.progress import reporting

LAYERS = "Layers"


@with_part_options
def slices(
    file: File,
    output: Annotated[
        str,
        typer.Option(
            "--output",
            "-o",
            metavar="SLICES",
            help="An archive, .zip, or a new folder (a name without ending).",
        ),
    ],
    set_: Settings = None,
    layer: Annotated[
        float | None,
        typer.Option(
            metavar="MM", help="The height of a layer (default: that of a voxel).", rich_help_panel=LAYERS
        ),
    ] = None,
    pixel: Annotated[
        float | None,
        typer.Option(
            metavar="MM", help="The side of a pixel, which is that of a voxel.", rich_help_panel=LAYERS
        ),
    ] = None,
    format: Annotated[
        Literal["png", "svg"],
        typer.Option(help="Pictures of a bit a pixel, or outlines in mm.", rich_help_panel=LAYERS),
    ] = "png",
    *,
    part: PartOptions,
) -> None:
    """Write the layers of a part as pictures or outlines, from the bottom up, with a manifest.

    Each layer shows the voxels at half its height; a pixel is a voxel. `manifest.json` names the height of
    a layer, the size of a pixel and the place of the first one. One layer is kept at a time.
    """
    _check_place(output)
    printable = part.printable()
    shape = loaded(file, set_, part.depth)
    import export
    from bcifs.recipe import part_recipe

    with reporting() as progress:
        prepared = export.prepare(
            shape,
            pitch=pixel,
            **part.shaped(),
            printable=printable,
            predicted=lambda found: announce(found, part.resolution),
            progress=progress,
        )
        with writing(output):
            count = export.write_slices(
                prepared.tree,
                output,
                format,
                layer_height=layer,
                recipe=part_recipe(shape, prepared.recipe),
                progress=progress,
            )
    tell(prepared.steps)
    pitch = prepared.tree.cell_size
    height = pitch if layer is None else layer
    typer.echo(f"{output}: {count} layers of {height:.4g} mm, pixels of {pitch:.4g} mm{_bytes(output)}")


def _check_place(output: str) -> None:
    target = Path(output)
    if target.suffix.lower() == ".zip":
        check_output(output, (".zip",))
    elif target.suffix:
        raise WrongOutput(f"{output}: expected an archive, .zip, or a folder whose name has no ending")
    elif not target.parent.is_dir():
        raise WrongOutput(f"{output}: there is no folder {target.parent}")
    elif target.exists() and not (target.is_dir() and not any(target.iterdir())):
        raise WrongOutput(f"{output}: is there already, and is no empty folder")


def _bytes(output: str) -> str:
    path = Path(output)
    return f", {path.stat().st_size} bytes" if path.is_file() else ""
