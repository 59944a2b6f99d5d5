"""The commands that write a file: render, mesh, print."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Literal

import typer

from bcifs.answers import load
from bcifs.failure import CheckFailed
from bcifs.options import Depth, File, Settings, Tolerance
from bcifs.output import check_output, writing
from bcifs.progress import reporting

Picture = Annotated[str, typer.Option("--output", "-o", metavar="PICTURE", help="The picture: .png or .svg.")]
MeshFile = Annotated[
    str,
    typer.Option("--output", "-o", metavar="MESH", help="The mesh: .obj .ply .stl, or a surface as .step."),
]
PartFile = Annotated[
    str, typer.Option("--output", "-o", metavar="PART", help="The part: .3mf .stl .ply .obj .glb.")
]


def render(file: File, output: Picture, set_: Settings = None, depth: Depth = None) -> None:
    """Draw a picture: PNG for every shape, SVG for curves and plane shapes."""
    check_output(output, (".png", ".svg"))
    shape = load(file, set_)
    from bcifs.picture import draw_shape

    with reporting() as progress, writing(output):
        drawn = draw_shape(shape, output, depth=depth, progress=progress)
    typer.echo(f"{output}: {len(drawn.mesh.faces)} {drawn.kind} {drawn.detail}")


def mesh(
    file: File,
    output: MeshFile,
    set_: Settings = None,
    depth: Depth = None,
    tolerance: Tolerance = 0.01,
    facets: Annotated[bool, typer.Option("--facets", help="For STEP: plane faces, of any surface.")] = False,
) -> None:
    """Write the mesh of the shape, whose pieces share their vertices; curves become .obj lines.

    As .step, smooth surfaces leave as B-spline faces.
    """
    from bcifs.polygon_file import MESH_ENDINGS, write_polygons

    check_output(output, (*MESH_ENDINGS, ".step"))
    shape = load(file, set_)
    if Path(output).suffix.lower() == ".step":
        from bcifs.step_file import write_step_file

        write_step_file(shape, output, tolerance, facets, 3 if depth is None else depth)
        return
    from bcifs.depth import drawn
    from bcifs.recipe import recipe

    with reporting() as progress, writing(output):
        made = drawn(shape, depth, progress)
        write_polygons(made.mesh, output, recipe(shape, made.detail))
    typer.echo(f"{output}: {len(made.mesh.vertices)} vertices, {len(made.mesh.faces)} {made.kind}")


def print_part(
    file: File,
    output: PartFile,
    set_: Settings = None,
    size: Annotated[
        float | None,
        typer.Option(metavar="MM", help="The longest side, before thickening (default: as described)."),
    ] = None,
    resolution: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            min=1,
            help="Voxels along the longest side (default 200; with --depth the "
            "grid of the pieces where they lie on one).",
        ),
    ] = None,
    thickness: Annotated[
        float, typer.Option(metavar="MM", min=0, help="The thickness of walls and wires.")
    ] = 0.0,
    depth: Annotated[
        int | None,
        typer.Option(min=0, metavar="N", help="Print the solid pieces of this level, not the limit."),
    ] = None,
    surface: Annotated[
        Literal["smooth", "exact"] | None,
        typer.Option(help="The mesh: smooth, or exact along the faces of the voxels."),
    ] = None,
    coarsen: Annotated[
        bool, typer.Option("--coarsen", help="Lower a resolution that is too fine to what fits.")
    ] = False,
    picture: Annotated[str | None, typer.Option(metavar="PNG", help="Also draw the part.")] = None,
) -> None:
    """Make a printable part: voxels that cover the shape, thickened, meshed, checked and written.

    From 300 voxels a side on, amounts are predicted first; beyond 60 million triangles or 8 GiB it refuses.

    A part that fails the check is not written.
    """
    from export.files import WRITABLE

    check_output(output, WRITABLE)
    if picture:
        check_output(picture, (".png",))
    shape = load(file, set_)
    if depth is not None:
        from bcifs.depth import require_printable_depth

        require_printable_depth(shape, depth)
    import export
    from export.part import BUDGET, LARGE

    if resolution is not None and resolution >= LARGE:
        typer.echo(str(export.estimate(shape, resolution, depth=depth)), err=True)
    with reporting() as progress:
        part = export.make_part(
            shape,
            size=size,
            resolution=resolution,
            thickness=thickness,
            depth=depth,
            style=surface,
            budget=replace(BUDGET, exceeded="coarsen" if coarsen else "refuse"),
            progress=progress,
        )
    if not part.report.ok:
        raise CheckFailed(f"{output} is not written, it fails the check: {'; '.join(part.report.faults)}")
    from bcifs.recipe import part_recipe

    recipe = part_recipe(shape, part.recipe)
    with writing(output):
        export.write_part(part.mesh, output, recipe, shape.name)
    typer.echo(f"{output}: {Path(output).stat().st_size} bytes\n{part.report}")
    if picture:
        _draw(part.mesh, picture, recipe)


def _draw(mesh, picture: str, recipe: Mapping[str, str]) -> None:
    from bcifs.picture import draw_mesh

    with writing(picture):
        draw_mesh(mesh, picture, recipe)
    typer.echo(f"{picture}: {Path(picture).stat().st_size} bytes")
