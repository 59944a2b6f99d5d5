"""The command that maps behaviours over two parameters: map."""

from typing import Annotated

import typer

import automata
from bcifs.options import AsJson, File, Settings
from bcifs.output import check_output, writing
from bcifs.progress import reporting
from bcifs.values import parse_settings
from subdivision import WrongValue, overridden


def map_behaviour(
    file: File,
    x: Annotated[str, typer.Option("--x", metavar="NAME", help="The parameter or entry to the right.")],
    y: Annotated[str, typer.Option("--y", metavar="NAME", help="The parameter or entry upwards.")],
    output: Annotated[
        str | None, typer.Option("--output", "-o", metavar="PICTURE", help="The picture: .png.")
    ] = None,
    range_x: Annotated[
        tuple[float, float], typer.Option(metavar="LOW HIGH", help="From where to where x goes.")
    ] = (-1.0, 1.0),
    range_y: Annotated[
        tuple[float, float], typer.Option(metavar="LOW HIGH", help="From where to where y goes.")
    ] = (-1.0, 1.0),
    resolution: Annotated[
        int, typer.Option(min=2, max=2000, metavar="N", help="Fields along each side of the map.")
    ] = 400,
    set_: Settings = None,
    as_json: AsJson = False,
) -> None:
    """Map how the curves of a family converge, start, end and join, over two of its parameters.

    The other parameters keep the values of the file and of --set. JSON: x, y, x_range, y_range, resolution,
    here (the file's own place), shares (of the plane: contracts, does not contract, undecided),
    contracts_alone (each operator alone does), and regions (number, joints, dominant_eigenvalues,
    ends_on_own_points, alternates, share, mirrored_share, member).
    """
    if output is None and not as_json:
        raise typer.BadParameter("say where the map goes, -o MAP.png, or ask for --json")
    if output is not None:
        check_output(output, (".png",))
    settings = parse_settings(set_ or ())
    for name in (x, y):
        if name in settings:
            raise WrongValue(f"--set {name}: {name} varies over the map; leave it out, or map another")
    automaton = overridden(automata.read(file), settings)
    from bcifs.chart import draw_map
    from bcifs.map_words import map_data, map_recipe, map_text
    from bcifs.png import write_png
    from fld.regions import regions

    with reporting() as progress:
        found = regions(
            automaton,
            x,
            y,
            x_range=range_x,
            y_range=range_y,
            resolution=resolution,
            report=lambda done: progress("map", done),
        )
    if output is not None:
        picture = draw_map(found, f"{automaton.name}: behaviour over {x} and {y}")
        with writing(output):
            write_png(picture, output, map_recipe(automaton, found))
    if as_json:
        from bcifs.answers import answer

        answer(map_data(found))
    else:
        typer.echo(f"{output}: {resolution} x {resolution} fields\n{map_text(found)}")
