"""The command that chooses values: `bcifs choose FILE --eigenvalue "edge.0=1/2" --smooth --near a=1/4`."""

from collections import Counter
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Annotated, Any

import typer

import automata
import subdivision
from automata.expression import ExpressionError, number
from automata.parameters import settled
from bcifs.answers import answer
from bcifs.options import AsJson, File, Settings
from bcifs.progress import reporting
from bcifs.values import parse_settings
from subdivision import WrongValue

if TYPE_CHECKING:
    from subdivision.choose import Choice
    from subdivision.requests import Eigenvalue, Nearest, Request

Values = Annotated[
    list[str] | None,
    typer.Option(
        "--eigenvalue",
        metavar="CELL.WORD=VALUES",
        help='Eigenvalues of a product that returns to its cell: "edge.0=1/2,1/4"; repeat one for a double.',
    ),
]
Dominant = Annotated[
    list[str] | None,
    typer.Option(metavar="CELL.WORD=VALUE", help="The same, and no other eigenvalue is larger."),
]
Smooth = Annotated[bool, typer.Option("--smooth", help="One tangent at the joints of every curve.")]
Positive = Annotated[bool, typer.Option("--positive", help="No entry of an operator is negative.")]
Contracts = Annotated[bool, typer.Option("--contracts", help="Short products have spectral radii below 1.")]
Near = Annotated[
    list[str] | None,
    typer.Option(
        metavar="NAME=VALUE …", help="Of all that fits, the nearest to these (default: the file's)."
    ),
]
Seed = Annotated[int, typer.Option(min=0, metavar="N", help="Seed of the start points.")]
Starts = Annotated[int, typer.Option(min=1, metavar="N", help="Number of start points.")]


def choose(
    file: File,
    eigenvalue: Values = None,
    dominant: Dominant = None,
    smooth: Smooth = False,
    positive: Positive = False,
    contracts: Contracts = False,
    near: Near = None,
    set_: Settings = None,
    seed: Seed = 0,
    starts: Starts = 16,
    as_json: AsJson = False,
) -> None:
    """Choose the free parameters by what the shape is to be like, and print a [set] table for the file.

    --set fixes parameters beforehand. JSON: name, ok, values (name to number), set (entry to exact text),
    requests (text, met, residual), degrees_of_freedom (what the requests that are met leave), distance (to
    --near, or null).
    """
    from subdivision.choose import NotMet
    from subdivision.choose import choose as chosen

    automaton = automata.read(file)
    settings = parse_settings(set_ or ())
    solution = subdivision.solve(automaton).with_values(settings)
    requests: list[Request | Nearest] = [
        *_eigenvalues(eigenvalue or (), dominant=False),
        *_eigenvalues(dominant or (), dominant=True),
    ]
    if smooth:
        from subdivision.joint import smooth_joints

        requests += smooth_joints(solution.automaton)
    if positive:
        from subdivision import requests as kinds

        requests.append(kinds.Positive())
    if contracts:
        from subdivision import requests as kinds

        requests.append(kinds.Contracts())
    wish = _near(near, settled(solution.automaton).values)
    with reporting() as report:
        choice = chosen(
            solution, [*requests, *wish], seed=seed, starts=starts, report=lambda done: report("search", done)
        )
    if as_json:
        answer(as_data(choice, settings))
    else:
        typer.echo(as_text(choice, settings), nl=False)
    if not choice.ok:
        raise NotMet(choice)


def as_data(choice: "Choice", settings: Mapping[str, Fraction]) -> dict[str, Any]:
    """A choice, and what --set gave beforehand, as plain data, ready for JSON."""
    return {
        "name": choice.solution.automaton.name,
        "ok": choice.ok,
        "values": dict(choice.values),
        "set": _settings(choice, settings),
        "requests": [{"text": o.request.text, "met": o.met, "residual": o.residual} for o in choice.outcomes],
        "degrees_of_freedom": choice.degrees_of_freedom,
        "distance": choice.distance,
    }


def as_text(choice: "Choice", settings: Mapping[str, Fraction]) -> str:
    """A choice as text: how each request fared, and the [set] table, which starts with what --set gave."""
    count = choice.degrees_of_freedom
    lines = [f"{choice.solution.automaton.name}: {count} degree{'' if count == 1 else 's'} of freedom left"]
    for outcome in choice.outcomes:
        lines.append(
            f"  {'met  ' if outcome.met else 'UNMET'}  {outcome.request.text}: {outcome.residual:.2g}"
        )
    if choice.distance is not None:
        lines.append(f"  distance to the values asked for: {choice.distance:.6g}")
    lines += [
        "",
        "[set]",
        *(f'"{entry}" = "{value}"' for entry, value in _settings(choice, settings).items()),
    ]
    return "\n".join(lines) + "\n"


def _settings(choice: "Choice", settings: Mapping[str, Fraction]) -> dict[str, str]:
    """The entries of the member with their exact values: fractions where small, otherwise decimals."""
    entries = {p.name: str(p.entry) for p in choice.solution.parameters}
    given = {entries.get(name, name): str(value) for name, value in settings.items()}
    return given | {entries[name]: _exact(value) for name, value in choice.exact.items()}


def _exact(value: Fraction) -> str:
    decimal = repr(float(value))
    return str(value) if value.denominator <= 1024 or Fraction(decimal) != value else decimal


def _eigenvalues(texts: Sequence[str], *, dominant: bool) -> list["Eigenvalue"]:
    from subdivision.requests import Eigenvalue

    result = []
    for text in texts:
        option = f"--{'dominant' if dominant else 'eigenvalue'} {text}"
        path, equals, values = text.partition("=")
        cell, dot, word = (part.strip() for part in path.partition("."))
        if not (cell and dot and word and equals):
            raise WrongValue(f"{option}: expected CELL.WORD=VALUE, for example edge.0=1/2")
        try:
            counted = Counter(number(value) for value in values.split(","))
        except ExpressionError as error:
            raise WrongValue(f"{option}: in {values!r}: {error}") from None
        result += [
            Eigenvalue(cell, tuple(word.split()), value, times, dominant) for value, times in counted.items()
        ]
    return result


def _near(texts: Sequence[str] | None, values: Any) -> list["Nearest"]:
    """The wish of --near, by default what the file sets, as far as that is numbers."""
    from subdivision.requests import Nearest

    if texts:
        try:
            return [Nearest(parse_settings(texts))]
        except WrongValue as error:
            raise WrongValue(str(error).replace("--set", "--near")) from None
    known = {key: value for key, value in values.items() if isinstance(value, Fraction)}
    return [Nearest(known)] if known else []
