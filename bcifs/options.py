"""Arguments and options that several commands share."""

from typing import Annotated

import typer

File = Annotated[str, typer.Argument(metavar="FILE", help="An automaton file, or a built-in name.")]
Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="NAME=VALUE …", help="Set free parameters or entries, as in --set a=1/4 b=1/4."
    ),
]
AsJson = Annotated[bool, typer.Option("--json", help="Answer as JSON.")]
AsLatex = Annotated[bool, typer.Option("--latex", help="Answer as LaTeX (amsmath): a block of matrices.")]
Tolerance = Annotated[
    float, typer.Option(metavar="MM", help="For STEP: how far fitted patches may be off, in mm.")
]
Depth = Annotated[
    int | None,
    typer.Option(min=0, metavar="N", help="Number of subdivisions (default: until the detail is fine)."),
]
