"""From the tables of a description to a checked `Automaton`."""

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from automata.automaton import (
    Automaton,
    Boundary,
    Cell,
    Equation,
    Rows,
    Symmetry,
    Word,
)
from automata.consistency import require_consistency
from automata.document import Field, suggestion, worked_out
from automata.expression import ExpressionError, Number, names, parse
from automata.maps import plain_ifs
from automata.parameters import parameter_names
from automata.sections import control_of, figure_of, names_of, parameters_of, values_of
from automata.sharing import with_shared

FORMAT = "bcifs/1"
MOST_CELLS = 500
MOST_POINTS = 256
MOST_LABELS = 4096
MOST_ENTRIES = 100_000
MOST_EQUATED = 500_000
LONGEST_PATH = 32

_TOP = ("format", "name", "shape", "cells", "maps", "figure", "set", "names", "control", "parameters")
_CELL = (
    "points",
    "subdivision",
    "boundary",
    "symmetry",
    "incidence",
    "adjacency",
    "coherence",
    "share",
    "matrices",
    "figure",
)


def describe(document: Mapping[str, Any]) -> Automaton:
    """The automaton that a parsed document states.

    Raises `AutomatonError` with the path of the first thing that is wrong: an unknown key or cell, a
    wrong size, a path that does not compose, a matrix whose columns cannot sum to 1.

    >>> describe({"format": "bcifs/1", "shape": "dust", "cells": {"dust": {
    ...     "points": 2, "subdivision": {"0": "dust", "1": "dust"}}}}).cells["dust"].points
    2
    """
    known = parameters_of(Field(dict(document)))
    top = Field(dict(document), known=known).table(_TOP, required=["format"])
    if top["format"].value != FORMAT:
        raise top["format"].error(f"expected format = {FORMAT!r}, found {top['format'].value!r}")
    name = top["name"].text() if "name" in top else "Untitled"
    if "maps" in top:
        return _from_maps(name, top)
    for key in ("shape", "cells"):
        if key not in top:
            raise Field(document).error(f"the key {key!r} is missing (or [[maps]] for a plain IFS)")
    if "figure" in top:
        raise top["figure"].error("figures belong to a cell: [cells.NAME] figure = …")
    cells = _cells(top["cells"])
    shape = top["shape"].choice(cells, "cell")
    figures = [table.get("figure") for table in top["cells"].value.values()]
    automaton = Automaton(
        name,
        shape,
        cells,
        values_of(top.get("set")),
        names_of(top.get("names")),
        control_of(top.get("control"), cells[shape].points),
        known,
        names_within([document.get("control"), figures]),
    )
    automaton = with_shared(automaton)
    taken = set(automaton.names) & set(parameter_names(automaton))
    if taken:
        raise top["names"].entries()[min(taken)].error(f"{min(taken)!r} is a parameter already")
    require_consistency(automaton)
    return automaton


def _from_maps(name: str, top: Mapping[str, Field]) -> Automaton:
    for key in ("cells", "shape", "set", "names"):
        if key in top:
            raise top[key].error(f"{key!r} and [[maps]] exclude each other")
    cell, frame = plain_ifs(top["maps"])
    figure = figure_of(top["figure"], cell.points) if "figure" in top else None
    cell = Cell(cell.name, cell.points, cell.subdivision, matrices=cell.matrices, figure=figure)
    control = control_of(top.get("control"), cell.points) or frame
    placing = names_within([field.value for field in top.values()])
    known = top["format"].known
    return Automaton(name, cell.name, {cell.name: cell}, control=control, parameters=known, placing=placing)


def names_within(value: Any) -> frozenset[str]:
    """The names in all expressions of some tables and lists."""
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        return frozenset(name for entry in value for name in names_within(entry))
    try:
        return names(parse(value)) if isinstance(value, str) else frozenset()
    except ExpressionError:
        return frozenset()


def _cells(tables: Field) -> dict[str, Cell]:
    fields = tables.table()
    if not 1 <= len(fields) <= MOST_CELLS:
        raise tables.error(f"expected 1 to {MOST_CELLS} cells, found {len(fields)}")
    keys = {name: field.table(_CELL, required=["points", "subdivision"]) for name, field in fields.items()}
    sizes = {name: cell["points"].count(1, MOST_POINTS) for name, cell in keys.items()}
    cells = {}
    entries = 0
    for name, cell in keys.items():
        cells[name] = _cell(name, cell, sizes)
        targets = [*cells[name].subdivision.values(), *(b.cell for b in cells[name].boundary.values())]
        entries += sum(sizes[name] * sizes[target] for target in targets)
        if entries > MOST_ENTRIES:
            raise tables.error(f"the operators have over {MOST_ENTRIES} entries")
    _check_borders(cells, keys)
    _check_words(cells)
    return cells


def _cell(name: str, fields: Mapping[str, Field], sizes: Mapping[str, int]) -> Cell:
    points = sizes[name]
    subdivision = {
        label: target.choice(sizes, "cell") for label, target in fields["subdivision"].table().items()
    }
    if not 1 <= len(subdivision) <= MOST_LABELS:
        raise fields["subdivision"].error(
            f"a cell is subdivided into 1 to {MOST_LABELS} cells (a vertex into itself)"
        )
    boundary: dict[str, Boundary] = {}
    for label, field in _optional(fields, "boundary").items():
        boundary[label] = _boundary(field, points, sizes)
        if points * sum(sizes[border.cell] for border in boundary.values()) > MOST_ENTRIES:
            raise field.error(f"the embeddings up to here have over {MOST_ENTRIES} entries")
    symmetry = {label: _symmetry(field, points) for label, field in _optional(fields, "symmetry").items()}
    _check_labels(fields, subdivision, boundary, symmetry)
    matrices = {}
    for label, rows in _optional(fields, "matrices").items():
        if label not in subdivision:
            raise rows.error(f"no sub-cell {label!r} here{suggestion(label, subdivision)}")
        matrices[label] = matrix(rows, points, sizes[subdivision[label]])
    return Cell(
        name,
        points,
        subdivision,
        boundary,
        symmetry,
        _equations(fields.get("incidence")),
        _equations(fields.get("adjacency")),
        matrices,
        figure_of(fields["figure"], points) if "figure" in fields else None,
        _equations(fields.get("coherence")),
        _equations(fields.get("share")),
    )


def _optional(fields: Mapping[str, Field], key: str) -> dict[str, Field]:
    return fields[key].table() if key in fields else {}


def _check_labels(fields: Mapping[str, Field], *tables: Mapping[str, Any]) -> None:
    seen: set[str] = set()
    for key, table in zip(("subdivision", "boundary", "symmetry"), tables, strict=True):
        for label in table:
            if label in seen:
                raise fields[key].error(f"the label {label!r} is used twice in this cell")
            seen.add(label)


def _boundary(field: Field, points: int, sizes: Mapping[str, int]) -> Boundary:
    fields = field.table(("cell", "points", "matrix"), required=["cell"])
    cell = fields["cell"].choice(sizes, "cell")
    if ("points" in fields) == ("matrix" in fields):
        raise field.error("an embedding has either 'points' or 'matrix'")
    if "matrix" in fields:
        return Boundary(cell, matrix(fields["matrix"], points, sizes[cell]))
    chosen = _selection(fields["points"], sizes[cell], points, f"cell {cell!r} has {sizes[cell]} points")
    return Boundary(cell, selection(chosen, points))


def _symmetry(field: Field, points: int) -> Symmetry:
    fields = field.table(("points", "subdivision", "boundary"), required=["points"])
    order = _selection(fields["points"], points, points, f"the cell has {points} points")
    if sorted(order) != list(range(points)):
        raise fields["points"].error(f"expected every number from 0 to {points - 1} once")
    return Symmetry(
        order,
        {label: word(entry) for label, entry in _optional(fields, "subdivision").items()},
        {label: word(entry) for label, entry in _optional(fields, "boundary").items()},
    )


def _selection(field: Field, length: int, points: int, why: str) -> tuple[int, ...]:
    entries = field.items("a list of point numbers")
    if len(entries) != length:
        raise field.error(f"expected {length} point numbers ({why}), found {len(entries)}")
    return tuple(entry.count(0, points - 1) for entry in entries)


def selection(chosen: tuple[int, ...], points: int) -> Rows:
    """The 0/1 matrix whose column j has its 1 in row `chosen[j]`."""
    zero, one = Number(Fraction(0)), Number(Fraction(1))
    return tuple(tuple(one if row == c else zero for c in chosen) for row in range(points))


def matrix(field: Field, rows: int, columns: int) -> Rows:
    """A matrix of the stated size; the entry "*" is left open, others may be expressions in parameters."""
    lines = field.items("a list of rows")
    if len(lines) != rows:
        raise field.error(f"expected {rows} rows, found {len(lines)}")
    result = []
    for line in lines:
        entries = line.items("a row")
        if len(entries) != columns:
            raise line.error(f"expected {columns} entries in this row, found {len(entries)}")
        result.append(tuple(None if e.value == "*" else e.expression() for e in entries))
    for column in range(columns):
        known = [worked_out(row[column], line) for row, line in zip(result, lines, strict=True)]
        if all(isinstance(entry, Number) for entry in known):
            total = sum(entry.value for entry in known if isinstance(entry, Number))
            if total != 1:
                raise field.error(f"column {column} sums to {total}; every column sums to 1")
    return tuple(result)


def _equations(field: Field | None) -> tuple[Equation, ...]:
    if field is None:
        return ()
    return tuple(_equation(entry) for entry in field.items("a list of equations"))


def _equation(field: Field) -> Equation:
    text = field.text('an equation such as "0 right = 1 left"')
    sides = text.split("=")
    if len(sides) != 2:
        raise field.error(f"expected one '=' between two paths in {text!r}")
    left, right = (tuple(side.split()) for side in sides)
    if not left or not right:
        raise field.error(f"expected a path on each side of '=' in {text!r}")
    if max(len(left), len(right)) > LONGEST_PATH:
        raise field.error(f"a path has at most {LONGEST_PATH} labels")
    return Equation(left, right, " ".join(text.split()), field.path)


def word(field: Field) -> Word:
    """A path of labels such as `"1 flip"`."""
    labels = tuple(field.text('a path of labels such as "1 flip"').split())
    if not labels:
        raise field.error("expected a path of labels, found an empty text")
    if len(labels) > LONGEST_PATH:
        raise field.error(f"a path has at most {LONGEST_PATH} labels")
    return labels


def _check_borders(cells: Mapping[str, Cell], keys: Mapping[str, Mapping[str, Field]]) -> None:
    """No cell is its own boundary, directly or through others."""
    rest = dict(cells)
    while rest:
        done = [
            name for name, cell in rest.items() if not any(b.cell in rest for b in cell.boundary.values())
        ]
        if not done:
            name = next(iter(rest))
            raise keys[name]["boundary"].error("boundaries form a cycle: " + ", ".join(rest))
        for name in done:
            del rest[name]


def _check_words(cells: Mapping[str, Cell]) -> None:
    """Every path composes, and the two sides of each equation lead to the same cell."""
    automaton = Automaton("", next(iter(cells)), cells)
    equated = 0
    for name, cell in cells.items():
        for equation in (*cell.equations, *cell.coherence, *cell.share, *cell.symmetry_equations()):
            place = Field(None, equation.path)
            ends = [_end(automaton, name, side, place) for side in (equation.left, equation.right)]
            if ends[0] != ends[1]:
                _check_sizes(cells, ends, equation, place)
            equated += cell.points * cells[ends[0]].points
            if equated > MOST_EQUATED:
                raise place.error(f"the equations up to here compare over {MOST_EQUATED} entries")


def _check_sizes(cells: Mapping[str, Cell], ends: list[str], equation: Equation, place: Field) -> None:
    """Different cells of one size become one; of different sizes they cannot."""
    first, second = (cells[end].points for end in ends)
    if first != second:
        raise place.error(
            f"the sides of {equation.text!r} lead to different cells: {ends[0]!r} and {ends[1]!r} "
            f"(of {first} and {second} points, which cannot be one)"
        )


def _end(automaton: Automaton, cell: str, path: Word, place: Field) -> str:
    for position, label in enumerate(path):
        target = automaton.target(cell, label)
        if target is None:
            here = automaton.cells[cell]
            known = [*here.subdivision, *here.boundary, *here.symmetry]
            before = f"after {' '.join(path[:position])!r}, in" if position else "in"
            raise place.error(
                f"the path {' '.join(path)!r} does not compose: "
                f"{before} cell {cell!r}, there is no {label!r}{suggestion(label, known)}"
            )
        cell = target
    return cell
