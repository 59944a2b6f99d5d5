"""The command that tells whether a mesh is printable."""

from dataclasses import replace
from typing import Annotated

import typer

from bcifs.answers import answer
from bcifs.failure import CheckFailed
from bcifs.options import AsJson
from bcifs.output import check_output, writing

Width = Annotated[float | None, typer.Option(metavar="MM", help="The thinnest wall that will do.")]
Gap = Annotated[float | None, typer.Option(metavar="MM", help="The narrowest gap that will do.")]


def check(
    mesh: Annotated[str, typer.Argument(metavar="MESH", help="A mesh file: 3mf, stl, ply, obj, off, glb.")],
    as_json: AsJson = False,
    output: Annotated[
        str | None,
        typer.Option("--output", "-o", metavar="PNG", help="Draw the mesh with the faults marked."),
    ] = None,
    wall: Width = None,
    gap: Gap = None,
    tree: Annotated[
        str | None, typer.Option(metavar="FILE", help="The set of cells whose volume the mesh should have.")
    ] = None,
    slicer: Annotated[bool, typer.Option("--slicer", help="Ask PrusaSlicer for the print time.")] = False,
) -> None:
    """Tell whether a mesh is printable, and what is wrong where; thin walls, overhangs and print time too.

    Vertices at equal places count as one where the mesh would not be closed otherwise. JSON: ok, the measures
    and counts by name, faults and notes (kind, count, meaning, places in mm), walls and gaps (width, place),
    overhangs (up, share, on_plate), print_time in seconds.
    """
    if output:
        check_output(output, (".png",))
    import export
    from export.checks.sewing import sewn

    found, joined = sewn(export.read_mesh(mesh))
    cells = None
    if tree:
        import trees

        cells = trees.read_tree(tree)
    try:
        report = export.check(found, tree=cells, wall=wall, gap=gap)
    except ValueError as error:
        raise ValueError(f"{mesh}: {error}") from None
    if joined is not None:
        report = replace(report, notes=(joined, *report.notes))
    if slicer:
        from export.checks.slicer import print_time

        report = replace(report, print_time=print_time(found))
    if output:
        from bcifs.fault_picture import draw_faults

        with writing(output):
            draw_faults(found, report, output)
    if as_json:
        answer(report.to_dict())
    else:
        typer.echo(str(report))
    if not report.ok:
        raise CheckFailed(f"{mesh} fails the check: {'; '.join(report.faults)}")
