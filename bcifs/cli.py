"""The commands and their options; each does its work in the file that it names."""

from typing import Annotated

import typer

from bcifs import (
    answers,
    check_command,
    choose_command,
    graph_command,
    map_command,
    print_command,
    products,
    slices_command,
    smooth_command,
)
from bcifs.behaviours import command as behaviour_command
from bcifs.grouped_help import Grouped

app = typer.Typer(
    name="bcifs",
    help="Shapes that are built by iteration, from a text description to a part that prints.",
    epilog="Exit codes: 0 done, 2 wrong input, 3 constraints that contradict each other, "
    "4 a system that does not contract, 5 a mesh that fails the check, 130 interrupted.",
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


def _version(asked: bool) -> bool:
    if asked:
        from importlib.metadata import version

        typer.echo(f"bcifs {version('bcifs')}")
        raise typer.Exit
    return asked


@app.callback()
def _bcifs(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    pass


for name, command in (
    ("solve", answers.solve),
    ("choose", choose_command.choose),
    ("info", answers.info),
    ("render", products.render),
    ("mesh", products.mesh),
    ("print", print_command.print_part),
    ("slices", slices_command.slices),
    ("smooth", smooth_command.smooth),
    ("check", check_command.check),
    ("fld", behaviour_command.fld),
    ("map", map_command.map_behaviour),
    ("graph", graph_command.graph),
    ("list", answers.list_builtin),
):
    app.command(name, cls=Grouped)(command)
