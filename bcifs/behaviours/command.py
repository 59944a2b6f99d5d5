"""The command that tells how a curve or a surface leaves a point: fld."""

from typing import Annotated

import typer

from bcifs.answers import answer, load
from bcifs.options import AsJson, File, Settings
from bcifs.output import check_output, writing


class ForCurves(ValueError):
    """An option that says nothing about a surface was given for one."""


def fld(
    file: File,
    address: Annotated[
        str,
        typer.Argument(
            metavar="ADDRESS",
            help="Labels of sub-cells, as in '1 0' (the last one repeats for ever) or '2 (0 1)*'; of a patch "
            "a piece and its corner, as in '1 2 @ 3'.",
        ),
    ],
    output: Annotated[
        str | None, typer.Option("--output", "-o", metavar="PICTURE", help="Of a curve: .png or .svg.")
    ] = None,
    parametrisation: Annotated[
        str,
        typer.Option(
            metavar="PARTS", help="natural, uniform, or the part of each piece of a curve: 1/2,1/4,1/4."
        ),
    ] = "natural",
    order: Annotated[
        float | None,
        typer.Option(metavar="Q", help="The order of the derivatives (default: the local order)."),
    ] = None,
    times: Annotated[
        str | None,
        typer.Option(
            metavar="FILE", help="The tensor product with another curve; ADDRESS is then '1 0, 0 (1 0)*'."
        ),
    ] = None,
    set_: Settings = None,
    as_json: AsJson = False,
) -> None:
    """Show how a curve or a surface leaves a point: orders, derivatives, half-tangents, tangent planes.

    JSON of a curve: kind, name, address, twin, point, parameter, critical_order, ratios, left and right
    (half-tangents), joint, local_orders, holder, derivatives (left, right, passage), terms (left, right). Of
    a patch: kind, name, address, point, joint, normal, turn, corners, words. Of a product: kind, name,
    addresses, parameters, point, joint, angles, quarters, sections (u, v).
    """
    if output is not None:
        check_output(output, (".png", ".svg"))
    shape = load(file, set_)
    if times is not None:
        from bcifs.behaviours.surface import product_data, product_text

        _for_curves(output, parametrisation, order, "a tensor product")
        found = product_data(shape, load(times, None), address)
        if as_json:
            answer(found)
        else:
            typer.echo(product_text(found))
        return
    from bcifs.behaviours.surface import is_patch, patch_data, patch_text

    if is_patch(shape):
        _for_curves(output, parametrisation, order, "a patch")
        found = patch_data(shape, address)
        if as_json:
            answer(found)
        else:
            typer.echo(patch_text(found))
        return
    from bcifs.behaviours.report import report

    made = report(shape, address, order, parametrisation)
    if output is not None:
        from bcifs.behaviours.picture import draw_report

        with writing(output):
            draw_report(shape, made, output)
    if as_json:
        answer(made.as_data())
    else:
        typer.echo(made.as_text() + (f"\n{output}" if output else ""))


def _for_curves(output: str | None, parametrisation: str, order: float | None, what: str) -> None:
    """Options that say nothing about a surface are refused, not passed over."""
    given = {
        "--output": output is not None,
        "--parametrisation": parametrisation != "natural",
        "--order": order is not None,
    }
    for option, is_given in given.items():
        if is_given:
            raise ForCurves(f"{option} is for curves, and this is {what}: leave it out")
