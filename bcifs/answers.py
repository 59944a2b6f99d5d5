"""The commands that answer on standard output: solve, info, list."""

import json
from typing import Any

import typer

import automata
import subdivision
from automata import Automaton
from bcifs.options import AsJson, AsLatex, File, Settings
from bcifs.values import parse_settings
from subdivision import overridden
from subdivision.display import as_data, as_text
from subdivision.latex import as_latex


def solve(file: File, set_: Settings = None, as_json: AsJson = False, latex: AsLatex = False) -> None:
    """Show the degrees of freedom, the free parameters and all matrices.

    Without --set the whole family is shown, whatever the file sets; with --set the family that these values
    leave. JSON: name, degrees_of_freedom, parameters (the free names), entries (name to entry), values (what
    --set gave), matrices (cell, label, rows of expressions or exact numbers, as texts).
    """
    if latex and as_json:
        raise typer.BadParameter("--json and --latex are two answers: ask for one of them")
    values = parse_settings(set_ or ())
    automaton = automata.read(file)
    solution = subdivision.solve(automaton)
    solution.with_values(automaton.values)  # a value of the file that is impossible is an error here too
    solution = solution.with_values(values)
    if latex:
        typer.echo(as_latex(solution), nl=False)
    elif as_json:
        answer(as_data(solution) | {"values": {key: str(value) for key, value in values.items()}})
    else:
        typer.echo(as_text(solution), nl=False)


def info(file: File, set_: Settings = None, as_json: AsJson = False) -> None:
    """Show cells, convergence with its proof, bounds in mm and the similarity dimension.

    JSON: name, shape, cells (name to points, subdivision, boundary), values, convergence (verdict, lower,
    upper, cell, word), bounds_mm (low, high), and dimension where all maps are similarities, otherwise
    dimension_at_most.
    """
    from bcifs.facts import facts, facts_text
    from ifs import require_contraction

    shape = load(file, set_, contracting=False)
    found = facts(shape)
    if as_json:
        answer(found)
    else:
        typer.echo(facts_text(found))
    require_contraction(shape.system)


def list_builtin() -> None:
    """List the built-in automata."""
    for name in automata.builtin_names():
        automaton = automata.read(name)
        free = subdivision.solve(automaton).degrees_of_freedom
        freedom = f"{free} degree{'' if free == 1 else 's'} of freedom" if free else "no freedom left"
        typer.echo(f"{name:<30}{automaton.name:<30}{_where(automaton):<14}{freedom}")


def load(file: str, settings: list[str] | None, *, contracting: bool = True):
    """The shape of a file with the values set on the command line, which contracts unless told otherwise."""
    import ifs

    values = parse_settings(settings or ())
    shape = ifs.shape(overridden(automata.read(file), values))
    if contracting:
        ifs.require_contraction(shape.system)
    return shape


def answer(data: Any) -> None:
    """Data as JSON on standard output."""
    typer.echo(json.dumps(data, indent=2, ensure_ascii=False))


def _where(automaton: Automaton) -> str:
    dimension = len(automaton.control[0]) if automaton.control else 0
    return {0: "no control", 1: "on a line", 2: "in the plane", 3: "in space"}.get(
        dimension, f"in {dimension}-space"
    )
