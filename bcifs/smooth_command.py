"""The command that turns a control mesh into its limit surface."""

from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Literal

import typer

from bcifs.options import Depth, Tolerance
from bcifs.output import WrongOutput, check_output, writing
from bcifs.progress import reporting

ENDINGS = (".obj", ".ply", ".stl", ".3mf", ".step", ".png")

MeshIn = Annotated[str, typer.Argument(metavar="MESH", help="A control mesh: .obj .ply .stl, in mm.")]
Output = Annotated[
    str, typer.Option("--output", "-o", metavar="FILE", help="The surface: .obj .ply .stl .3mf .step .png.")
]


def smooth(
    mesh: MeshIn,
    output: Output,
    scheme: Annotated[
        Literal["catmull-clark", "doo-sabin", "doo-sabin-rational"], typer.Option(help="The scheme.")
    ] = "catmull-clark",
    depth: Depth = None,
    boundary: Annotated[
        Literal["smooth", "corners"] | None,
        typer.Option(
            help="For open meshes: the boundary is a smooth curve, or keeps the vertices of single faces."
        ),
    ] = None,
    crease_angle: Annotated[
        float | None,
        typer.Option(metavar="DEGREES", min=0, max=180, help="Edges sharper than that stay creases."),
    ] = None,
    sharpness: Annotated[
        float,
        typer.Option(metavar="S", min=0, help="How many subdivisions creases stay sharp; 10: for ever."),
    ] = 10.0,
    tolerance: Tolerance = 0.01,
) -> None:
    """Make the smooth limit surface of a control mesh, exact at every vertex.

    STEP holds exact B-spline faces, and fitted ones around extraordinary points.
    """
    check_output(output, ENDINGS)
    from export.control_files import read_control_mesh
    from ifs.surfaces.control_mesh import surface
    from ifs.surfaces.creases import creases_by_angle
    from ifs.surfaces.polygon_mesh import WrongMesh

    if Path(output).exists() and Path(output).samefile(mesh):
        raise WrongOutput(f"{output}: this is the control mesh itself; name another file")
    vertices, faces = read_control_mesh(mesh)
    creases = {}
    try:
        if crease_angle is not None:
            creases = dict.fromkeys(creases_by_angle(vertices, faces, crease_angle), sharpness)
        found = surface(vertices, faces, scheme, boundary=boundary, creases=creases)
    except WrongMesh as error:
        raise WrongMesh(f"{mesh} (vertices and faces counted from 0): {error}", None) from None
    recipe = {"Source": Path(mesh).name, "Scheme": scheme, "Boundary": boundary or "none"}
    if creases:
        recipe |= {"Creases": str(len(creases)), "Sharpness": str(sharpness)}
    if Path(output).suffix.lower() == ".step":
        from bcifs.step_file import write_step_file

        write_step_file(found, output, tolerance)
        return
    from bcifs.depth import drawn

    with reporting() as progress, writing(output):
        made = drawn(found.complex(), depth, progress)
        _write(
            made.mesh, output, recipe | {"Detail": made.detail, "Application": f"bcifs {version('bcifs')}"}
        )
    sizes = f"{len(made.mesh.vertices)} vertices, {len(made.mesh.faces)} {made.kind} {made.detail}"
    typer.echo(f"{output}: {sizes}")


def _require_outward(mesh, output: str) -> None:
    """A closed mesh is not written inside out."""
    if Path(output).suffix.lower() in (".png", ".obj"):
        return
    found = mesh.to_trimesh()
    if found.is_watertight and found.volume < 0:
        raise WrongOutput(f"{output}: the surface is inside out: turn the faces of the control mesh over")
    if not found.is_watertight:
        typer.echo(f"{output}: an open surface; to print it, give it a thickness", err=True)


def _write(mesh, output: str, recipe: dict[str, str]) -> None:
    match Path(output).suffix.lower():
        case ".png":
            from bcifs.picture import draw_mesh

            draw_mesh(mesh, output, recipe)
        case ".3mf":
            from export import write_part

            write_part(mesh, output, recipe, Path(output).stem)
        case _:
            from bcifs.polygon_file import write_polygons

            write_polygons(mesh, output, recipe)
