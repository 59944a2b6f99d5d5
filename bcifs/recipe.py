"""How a file was made, in words that are written into it."""

from collections.abc import Mapping
from importlib.metadata import version

from ifs import Shape


def recipe(shape: Shape, detail: str) -> dict[str, str]:
    """Name, detail, the values that were set, and the version; no dates, so that runs give equal bytes.

    >>> from ifs import shape
    >>> recipe(shape("corner-cutting"), "at depth 5")["Values"]
    'edge.0[1,0] = 1/4, edge.0[0,1] = 1/4'
    """
    values = values_text(shape)
    found = {"Name": shape.name, "Detail": detail, "Values": values}
    return {key: value for key, value in found.items() if value} | {
        "Application": f"bcifs {version('bcifs')}"
    }


def part_recipe(shape: Shape, made: Mapping[str, str]) -> dict[str, str]:
    """The recipe of a part of this shape, with the values of its parameters."""
    values = values_text(shape)
    return dict(made) | ({"Values": values} if values else {})


def values_text(shape: Shape) -> str:
    """The values that were set, in one line."""
    return ", ".join(f"{key} = {value}" for key, value in shape.automaton.values.items())
