"""The automaton as a diagram: cells as boxes, subdivision as arrows, boundaries as dashed arrows."""

from collections.abc import Sequence

from automata import Automaton
from bcifs.diagram import Box, Diagram, Stroke, Words, curve
from bcifs.paint import width_of
from bcifs.palette import CLAY, INK, PAPER

BOUNDARY = "#8a8578"
ACROSS, DOWN = 330.0, 190.0
TALL = 64.0
LIFT = 34.0  # how much higher an arch rises for each place that it passes
SIDE = 90.0
MOST = 8

Place = tuple[float, float]
Part = Stroke | Words | Box


def graph_diagram(automaton: Automaton) -> Diagram:
    """The diagram of figures 4.9 and 4.23: cells in rows by how many boundaries lead to them.

    Arrows with the same ends are one, with all their labels. The shape's cell has a darker edge.
    """
    rows = layers(automaton)
    widest = max(len(row) for row in rows)
    arch = LIFT * max((_farthest(automaton, row) for row in rows), default=0)
    places = {
        name: (SIDE + ACROSS * (k + 0.5 + (widest - len(row)) / 2), 90 + arch + (DOWN + arch) * level)
        for level, row in enumerate(rows)
        for k, name in enumerate(row)
    }
    lines: list[Part] = []
    words: list[Part] = []
    for (start, end, kind), labels in _bundles(automaton, places).items():
        _arrow(lines, words, places, start, end, kind, bundle_words(labels))
    boxes = [part for name in places for part in _cell(automaton, name, places[name])]
    right = max((w.x + width_of(w.text, w.size) for w in words if isinstance(w, Words)), default=0.0)
    wide = max(ACROSS * widest + 2 * SIDE, right + SIDE)
    tall = 180 + arch + (DOWN + arch) * (len(rows) - 1)
    return Diagram(round(wide), round(tall), (*lines, *boxes, *words))


def _farthest(automaton: Automaton, row: Sequence[str]) -> int:
    """How many places along a row its longest subdivision goes."""
    places = {name: k for k, name in enumerate(row)}
    steps = (
        abs(places[target] - k)
        for name, k in places.items()
        for target in automaton.cells[name].subdivision.values()
        if target in places
    )
    return max(steps, default=0)


def layers(automaton: Automaton) -> list[list[str]]:
    """The cells that the shape needs, by the most boundaries that lead from the shape to them.

    Cells that subdivide into each other share a row.
    """
    names = automaton.reachable()
    depth = dict.fromkeys(names, 0)
    for _ in names:
        for name in names:
            cell = automaton.cells[name]
            for boundary in cell.boundary.values():
                depth[boundary.cell] = min(max(depth[boundary.cell], depth[name] + 1), len(names))
            for target in cell.subdivision.values():
                deepest = max(depth[target], depth[name])
                depth[target] = depth[name] = deepest
    found = sorted(set(depth.values()))
    return [[name for name in names if depth[name] == level] for level in found]


def bundle_words(labels: Sequence[str]) -> str:
    """The labels of arrows with the same ends.

    >>> bundle_words(["0", "1"]), bundle_words([str(k) for k in range(20)])
    ('0, 1', '0, 1, … 19 (20)')
    """
    if len(labels) <= MOST:
        return ", ".join(labels)
    return f"{labels[0]}, {labels[1]}, … {labels[-1]} ({len(labels)})"


def _bundles(automaton: Automaton, names) -> dict[tuple[str, str, str], list[str]]:
    found: dict[tuple[str, str, str], list[str]] = {}
    for name in names:
        cell = automaton.cells[name]
        for label, target in cell.subdivision.items():
            found.setdefault((name, target, "subdivision"), []).append(label)
        for label, boundary in cell.boundary.items():
            found.setdefault((name, boundary.cell, "boundary"), []).append(label)
    return found


def _cell(automaton: Automaton, name: str, place: Place) -> list[Part]:
    x, y = place
    count = automaton.cells[name].points
    points = f"{count} point{'' if count == 1 else 's'}"
    size, fill = _wide(name), CLAY if name == automaton.shape else PAPER
    return [
        Box(x, y, size, TALL, fill, INK),
        Words(x, y - 12, name, 21, INK),
        Words(x, y + 15, points, 15, INK),
    ]


def _wide(name: str) -> float:
    return max(110.0, width_of(name, 21) + 32)


def _arrow(
    lines: list[Part],
    words: list[Part],
    places: dict[str, Place],
    start: str,
    end: str,
    kind: str,
    text: str,
) -> None:
    """One arrow with its label: a loop, an arch along a row, or a line between rows."""
    (x0, y0), (x1, y1) = places[start], places[end]
    dashed, colour = kind == "boundary", BOUNDARY if kind == "boundary" else INK
    if start == end:
        edge = x0 + _wide(start) / 2
        line = curve((edge, y0 - 14), (edge + 70, y0 - 52), (edge + 70, y0 + 52), (edge, y0 + 14))
        lines.append(Stroke(line, colour, 2.0, dashed, True))
        words.append(Words(edge + 62, y0, text, 17, colour, "lm"))
        return
    if abs(y0 - y1) < 1:
        way = 1 if x1 > x0 else -1
        lift = way * (14 + LIFT * (abs(x1 - x0) / ACROSS))
        port = 40 - 12 * min(3, abs(x1 - x0) / ACROSS - 1)
        edges = x0 + way * port, x1 - way * port
        top = y0 - way * TALL / 2, y1 - way * TALL / 2
        high = top[0] - lift * 4 / 3
        line = curve((edges[0], top[0]), (edges[0], high), (edges[1], high), (edges[1], top[1]))
        lines.append(Stroke(line, colour, 2.0, dashed, True))
        words.append(Words((x0 + x1) / 2, top[0] - lift, text, 17, colour, "mm", True))
        return
    down = 1 if y1 > y0 else -1
    ends = (x0, y0 + down * TALL / 2), (x1, y1 - down * TALL / 2)
    line = curve(ends[0], ((x0 + x1) / 2, (y0 + y1) / 2), ends[1])
    lines.append(Stroke(line, colour, 2.0, dashed, True))
    t = 0.5 if abs(x1 - x0) < 1 else 0.36
    if abs(x1 - x0) < 1:
        words.append(Words(x0 + 14, (ends[0][1] + ends[1][1]) / 2, text, 17, colour, "lm"))
    else:
        x, y = (ends[0][k] + t * (ends[1][k] - ends[0][k]) for k in range(2))
        words.append(Words(x, y, text, 17, colour, "mm", True))
