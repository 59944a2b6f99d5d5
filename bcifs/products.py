"""The commands that write a drawing of a shape or its mesh: render, mesh."""

from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from bcifs.answers import load
from bcifs.options import Depth, File, Settings, Tolerance
from bcifs.output import check_output, writing
from bcifs.progress import reporting

Picture = Annotated[str, typer.Option("--output", "-o", metavar="PICTURE", help="The picture: .png or .svg.")]
ORDERS_DEPTH = 5
MeshFile = Annotated[
    str,
    typer.Option("--output", "-o", metavar="MESH", help="The mesh: .obj .ply .stl, or a surface as .step."),
]


def render(
    file: File,
    output: Picture,
    set_: Settings = None,
    depth: Depth = None,
    colour: Annotated[
        Literal["roughness"] | None,
        typer.Option(help="Colour curves and surfaces by their local order, with a scale."),
    ] = None,
) -> None:
    """Draw a picture: PNG for every shape, SVG for curves and plane shapes."""
    check_output(output, (".png", ".svg"))
    shape = load(file, set_)
    if colour == "roughness":
        _render_roughness(shape, output, ORDERS_DEPTH if depth is None else depth)
        return
    from bcifs.picture import draw_shape

    with reporting() as progress, writing(output):
        drawn = draw_shape(shape, output, depth=depth, progress=progress)
    typer.echo(f"{output}: {len(drawn.mesh.faces)} {drawn.kind} {drawn.detail}")


def _render_roughness(shape: Any, output: str, depth: int) -> None:
    from bcifs.behaviours.roughness import draw_roughness
    from bcifs.recipe import recipe
    from fld import roughness

    found = roughness(shape, depth)
    with writing(output):
        draw_roughness(found, output, recipe(shape, f"roughness at depth {depth}"))
    least, most = found.range
    typer.echo(f"{output}: {len(found.mesh.faces)} pieces of orders {least:.6g} to {most:.6g}")


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
