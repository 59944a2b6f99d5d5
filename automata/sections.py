"""The sections of a description beside its cells: values, names, control points, figures."""

import math
import re
from fractions import Fraction

from automata.automaton import Figure
from automata.document import Field, worked_out
from automata.expression import Expression, Number

_DEPENDENT = re.compile(r"[A-Za-z_][A-Za-z_0-9]*(?:\([A-Za-z_][A-Za-z_0-9]*(?:,[A-Za-z_][A-Za-z_0-9]*)*\))?")
"""A name, or a name with the parameters that it depends on: `a(u,v)`, without spaces."""


def parameters_of(document: Field) -> dict[str, Fraction]:
    """The names with a value; one with "*" stays open."""
    tables = document.entries()
    if "parameters" not in tables:
        return {}
    known: dict[str, Fraction] = {}
    for name, entry in tables["parameters"].entries().items():
        if _DEPENDENT.fullmatch(name) is None:
            raise entry.error(f"expected a name such as u or a(u,v) for a parameter, found {name!r}")
        if entry.value != "*":
            known[name] = entry.number()
    return known


def values_of(field: Field | None) -> dict[str, Fraction | Expression]:
    if field is None:
        return {}
    return {key: _set_value(entry) for key, entry in field.entries().items()}


def _set_value(field: Field) -> Fraction | Expression:
    """A number, or an expression in parameters, which is worked out when a member is chosen."""
    expression = field.expression()
    worked_out(expression, field)
    return expression.value if isinstance(expression, Number) else expression


def names_of(field: Field | None) -> dict[str, str]:
    if field is None:
        return {}
    result: dict[str, str] = {}
    for key, entry in field.entries().items():
        text = "".join(entry.text('an entry such as "edge.0[1,0]"').split())
        name = "".join(key.split())
        if _DEPENDENT.fullmatch(name) is None:
            raise entry.error(f"expected a name of letters, digits and _ for an entry, found {key!r}")
        if name in result:
            raise entry.error(f"the name {name} is given twice")
        if text in result.values():
            raise entry.error(f"the entry {text} has a name already")
        result[name] = text
    return result


def control_of(field: Field | None, points: int) -> tuple[tuple[float, ...], ...] | None:
    if field is None:
        return None
    rows = field.table(["points"], required=["points"])["points"]
    lines = rows.items("a list of points")
    if len(lines) != points:
        raise rows.error(f"the shape has {points} control points, found {len(lines)}")
    result = [tuple(_coordinate(entry) for entry in line.items("a point")) for line in lines]
    dimension = len(result[0])
    for line, point in zip(lines, result, strict=True):
        if not 1 <= len(point) <= 6 or len(point) != dimension:
            raise line.error(f"expected {dimension} coordinates (1 to 6, the same for all points)")
    return tuple(result)


def _coordinate(field: Field) -> float:
    value = float(field.number())
    if not math.isfinite(value) or abs(value) > 1e9:
        raise field.error("coordinates are millimetres, at most 1e9 in size")
    return value


def figure_of(field: Field, points: int) -> Figure:
    if isinstance(field.value, str):
        return Figure(field.choice(("segment", "polygon", "box"), "figure"))
    fields = field.table(("points", "faces"))
    corners = []
    for line in fields["points"].items("a list of points") if "points" in fields else ():
        point = tuple(entry.number() for entry in line.items("a point"))
        if len(point) != points or sum(point) != 1:
            raise line.error(f"expected {points} barycentric coordinates that sum to 1")
        corners.append(point)
    most = len(corners) - 1 if corners else 10_000
    faces = tuple(
        tuple(corner.count(0, most) for corner in face.items("a face"))
        for face in (fields["faces"].items("a list of faces") if "faces" in fields else ())
    )
    if not faces or any(not 1 <= len(face) <= 64 for face in faces):
        raise field.error("expected 'faces', a list of lists of 1 to 64 point numbers")
    return Figure("faces", tuple(corners), faces)
