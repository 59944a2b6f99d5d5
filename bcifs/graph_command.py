"""The command that draws an automaton: graph."""

from importlib.metadata import version
from typing import Annotated

import typer

import automata
from bcifs.options import File
from bcifs.output import check_output, writing


def graph(
    file: File,
    output: Annotated[
        str, typer.Option("--output", "-o", metavar="PICTURE", help="The picture: .png or .svg.")
    ],
    unfold: Annotated[
        bool, typer.Option("--unfold", help="Draw one level of subdivision and what its pieces share.")
    ] = False,
) -> None:
    """Draw the automaton: cells, their subdivisions and boundaries; or what it unfolds to.

    Arrows in full lines are subdivisions, dashed ones boundaries. In the unfolding, arcs join two paths to
    the same cell: incidence in red, adjacency in blue, with the symmetry between them where there is one.
    """
    check_output(output, (".png", ".svg"))
    automaton = automata.read(file)
    from bcifs.diagram import write_diagram
    from bcifs.graph_layout import graph_diagram
    from bcifs.unfold_layout import unfold_diagram

    diagram = unfold_diagram(automaton) if unfold else graph_diagram(automaton)
    kind = "unfolding" if unfold else "automaton"
    recipe = {"Name": automaton.name, "Diagram": kind, "Application": f"bcifs {version('bcifs')}"}
    with writing(output):
        write_diagram(diagram, output, recipe)
    typer.echo(f"{output}: {kind} of {automaton.name}, {diagram.width} x {diagram.height}")
