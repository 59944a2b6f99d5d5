"""What `bcifs info` tells about a shape."""

from math import floor, log10
from typing import Any

import numpy as np

from ifs import Shape, bounding_box, convergence
from ifs.dimensions.affinity import affinity_bound
from ifs.dimensions.dimension import similarity_dimension


def facts(shape: Shape) -> dict[str, Any]:
    """Cells, values, convergence, bounds and dimension as plain data.

    `bounds_mm` (a box that contains the attractor) is left out for a system without a proof of convergence,
    `dimension` where the maps are no similarities: `dimension_at_most` then bounds it.

    >>> from ifs import shape
    >>> facts(shape("sierpinski-triangle"))["cells"]["triangle"]["points"]
    3
    """
    automaton = shape.automaton
    found = convergence(shape.system)
    result: dict[str, Any] = {
        "name": shape.name,
        "shape": automaton.shape,
        "cells": {
            name: {
                "points": cell.points,
                "subdivision": dict(cell.subdivision),
                "boundary": {label: b.cell for label, b in cell.boundary.items()},
            }
            for name, cell in automaton.cells.items()
        },
        "values": {key: str(value) for key, value in automaton.values.items()},
        "convergence": {
            "verdict": found.verdict,
            "lower": found.lower,
            "upper": found.upper,
            "cell": found.cell,
            "word": list(found.word),
        },
    }
    if found.verdict == "contracts":
        low, high = bounding_box(shape)
        result["bounds_mm"] = {"low": _plain(low), "high": _plain(high)}
        dimension = similarity_dimension(shape)
        if dimension is not None:
            result["dimension"] = dimension
        else:
            result["dimension_at_most"] = affinity_bound(shape)
    return result


def facts_text(found: dict[str, Any]) -> str:
    """The same as aligned text."""
    rows = [("name", found["name"]), ("shape", found["shape"])]
    for name, cell in found["cells"].items():
        parts = [f"{cell['points']} point{'' if cell['points'] == 1 else 's'}"]
        parts.append("subdivision " + _pairs(cell["subdivision"]))
        if cell["boundary"]:
            parts.append("boundary " + _pairs(cell["boundary"]))
        rows.append((f"cell {name}", "; ".join(parts)))
    if found["values"]:
        rows.append(("values", ", ".join(f"{key} = {value}" for key, value in found["values"].items())))
    rows += _convergence_rows(found["convergence"])
    if "bounds_mm" in found:
        rows.append(("bounds", _box(found["bounds_mm"]["low"], found["bounds_mm"]["high"]) + " mm"))
    if "dimension" in found:
        rows.append(("dimension", f"{found['dimension']:.12g} (similarity dimension)"))
    if "dimension_at_most" in found:
        rows.append(("dimension", f"at most {found['dimension_at_most']:.6g} (affinity dimension)"))
    width = max(len(title) for title, _ in rows)
    return "\n".join(f"{title:<{width}}  {text}" for title, text in rows)


def _convergence_rows(found: dict[str, Any]) -> list[tuple[str, str]]:
    radius = f"joint spectral radius in [{found['lower']:.9g}, {found['upper']:.9g}]"
    rows = [("convergence", f"{found['verdict']}: {radius}")]
    if found["word"]:
        rows.append(
            ("witness", f"the word {' '.join(found['word'])!r} at {found['cell']!r} attains the lower end")
        )
    return rows


def _box(low: list[float], high: list[float]) -> str:
    """The box of a part, to a millionth of its longest side: what is smaller is room for rounding."""
    longest = max(top - bottom for bottom, top in zip(low, high, strict=True))
    places = 6 - floor(log10(longest)) if longest > 0 else 6
    sides = ((round(v, places) + 0.0 for v in side) for side in zip(low, high, strict=True))
    return " x ".join("[{:.6g}, {:.6g}]".format(*side) for side in sides)


def _pairs(table: dict[str, str]) -> str:
    return ", ".join(f"{label} = {cell}" for label, cell in table.items())


def _plain(row: np.ndarray) -> list[float]:
    return [float(value) for value in row]
