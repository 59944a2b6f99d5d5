"""The automaton unfolded by one level, as a diagram: a tree of paths, and arcs between those that meet."""

from itertools import combinations

import numpy as np

from automata import Automaton
from automata.unfolding import Pair, Unfolding, unfolding
from bcifs.diagram import Box, Diagram, Stroke, Words, curve
from bcifs.graph_layout import BOUNDARY
from bcifs.paint import width_of
from bcifs.palette import CLAY, INK, PAPER

INCIDENCE = "#b8473a"
ADJACENCY = "#2f6fb0"
GAP, BETWEEN = 14.0, 34.0
TOP, MIDDLE, LOW = 70.0, 230.0, 390.0
TALL = 46.0
LEAST = 56.0
DEPTH = 26.0
SORTED = 24

Part = Stroke | Words | Box


def unfold_diagram(automaton: Automaton) -> Diagram:
    """The diagram of figure 4.10: the shape, its boundaries and sub-cells, and theirs.

    Arcs below join paths to the same cell: incidence in red, adjacency in blue.
    """
    found = unfolding(automaton)
    centre = _columns(found)
    width = max(x for x, _ in centre.values()) + max(w for _, w in centre.values()) / 2 + 60
    lines: list[Part] = []
    words: list[Part] = []
    for arrow in found.arrows:
        start, end = centre[arrow.start][0], centre[arrow.end][0]
        y0, y1 = (TOP, MIDDLE) if not arrow.start else (MIDDLE, LOW)
        dashed = arrow.kind == "boundary"
        colour = BOUNDARY if dashed else INK
        ends = ((start, y0 + TALL / 2), (end, y1 - TALL / 2))
        middle = ((start, y0 + 100), (end, y1 - 100))
        lines.append(Stroke(curve(ends[0], *middle, ends[1]), colour, 1.8, dashed, True))
        words.append(Words(end, y1 - TALL / 2 - 24, arrow.label, 15, colour, "mm", True))
    boxes: list[Part] = []
    for node in found.nodes:
        x, wide = centre[node.path]
        y = (TOP, MIDDLE, LOW)[len(node.path)]
        boxes += [
            Box(x, y, wide, TALL, CLAY if not node.path else PAPER, INK),
            Words(x, y, node.cell, 15 if node.path else 20, INK),
        ]
    deepest = _arcs(found, centre, lines, words)
    legend = _legend(found, deepest + 46, width / 2)
    return Diagram(round(width), round(deepest + (80 if legend else 50)), (*lines, *boxes, *words, *legend))


def _columns(found: Unfolding) -> dict[tuple[str, ...], tuple[float, float]]:
    """The middle and the width of every node's box."""
    groups = _ordered(found)
    leaves = {
        group: [n.path for n in found.nodes if n.path[:1] == group and len(n.path) == 2] for group in groups
    }
    cells = {node.path: node.cell for node in found.nodes}
    wide = {path: max(LEAST, width_of(cell, 20 if not path else 15) + 24) for path, cell in cells.items()}
    centre: dict[tuple[str, ...], tuple[float, float]] = {}
    x = 60.0
    for group in groups:
        members = leaves[group]
        total = sum(wide[path] for path in members) + GAP * max(len(members) - 1, 0)
        room = max(total, wide[group])
        place = x + (room - total) / 2
        for path in members:
            centre[path] = (place + wide[path] / 2, wide[path])
            place += wide[path] + GAP
        centre[group] = (x + room / 2, wide[group])
        x += room + BETWEEN
    ends = [centre[group][0] for group in groups] or [200.0]
    centre[()] = ((min(ends) + max(ends)) / 2, wide[()])
    return centre


def _ordered(found: Unfolding) -> list[tuple[str, ...]]:
    """Boundaries and sub-cells from left to right, changing places while that makes the arcs shorter."""
    first = [node.path for node in found.nodes if len(node.path) == 1]
    own = {arrow.end for arrow in found.arrows if arrow.kind == "boundary" and not arrow.start}
    borders = [path for path in first if path in own]
    half = (len(borders) + 1) // 2
    order = [*borders[:half], *(path for path in first if path not in own), *borders[half:]]
    if len(order) > SORTED:
        return order
    sizes = {g: max(1, sum(n.path[:1] == g and len(n.path) == 2 for n in found.nodes)) for g in order}
    best, improving = _length(found.pairs, order, sizes), True
    while improving:
        improving = False
        for i, j in combinations(range(len(order)), 2):
            tried = order.copy()
            tried[i], tried[j] = tried[j], tried[i]
            length = _length(found.pairs, tried, sizes)
            if length < best:
                order, best, improving = tried, length, True
    return order


def _length(
    pairs: tuple[Pair, ...], order: list[tuple[str, ...]], sizes: dict[tuple[str, ...], int]
) -> float:
    middles, x = {}, 0.0
    for group in order:
        middles[group] = x + sizes[group] / 2
        x += sizes[group]
    return sum(abs(middles[pair.left[:1]] - middles[pair.right[:1]]) for pair in pairs)


def _arcs(found: Unfolding, centre: dict, lines: list[Part], words: list[Part]) -> float:
    """The arcs, each below all that it spans; returns how low they reach."""
    foot = LOW + TALL / 2
    ports = _ports(found, centre)
    spans = sorted(
        ((sorted((ports[k, 0], ports[k, 1])), k) for k in range(len(found.pairs))),
        key=lambda item: (item[0][1] - item[0][0], item[0]),
    )
    levels: list[tuple[float, float, int]] = []
    deepest = foot if any(len(node.path) == 2 for node in found.nodes) else MIDDLE + TALL / 2
    for (left, right), k in spans:
        pair = found.pairs[k]
        level = 1 + max((other for a, b, other in levels if a < right + 6 and left < b + 6), default=0)
        levels.append((left, right, level))
        y = foot + DEPTH * level
        bend = min(10.0, (right - left) / 2)
        colour = INCIDENCE if pair.kind == "incidence" else ADJACENCY
        turns = (
            curve((left, y - bend), (left, y), (left + bend, y)),
            curve((right - bend, y), (right, y), (right, y - bend)),
        )
        lines.append(Stroke(np.vstack([[(left, foot)], *turns, [(right, foot)]]), colour, 2.0))
        if pair.symmetry:
            words.append(Words((left + right) / 2, y, " ".join(pair.symmetry), 13, colour, "mm", True))
        deepest = max(deepest, y)
    return deepest


def _ports(found: Unfolding, centre: dict) -> dict[tuple[int, int], float]:
    """Where each end of each arc leaves its box, spread when several do."""
    users: dict[tuple[str, ...], list[tuple[int, int]]] = {}
    for k, pair in enumerate(found.pairs):
        users.setdefault(pair.left, []).append((k, 0))
        users.setdefault(pair.right, []).append((k, 1))
    ports = {}
    for path, ends in users.items():
        x, wide = centre[path]

        def other(end: tuple[int, int]) -> float:
            pair = found.pairs[end[0]]
            return centre[pair.right if end[1] == 0 else pair.left][0]

        for place, end in enumerate(sorted(ends, key=other)):
            ports[end] = x + (place - (len(ends) - 1) / 2) * min(14.0, wide / (len(ends) + 1))
    return ports


def _legend(found: Unfolding, y: float, middle: float) -> list[Part]:
    entries = [
        (INCIDENCE, "incidence", "incidence"),
        (ADJACENCY, "adjacency", "adjacency"),
    ]
    shown = [(colour, text) for colour, kind, text in entries if any(p.kind == kind for p in found.pairs)]
    parts: list[Part] = []
    x = middle - 80.0 * len(shown)
    for colour, text in shown:
        parts += [
            Stroke(np.array([(x, y), (x + 34, y)]), colour, 2.5),
            Words(x + 44, y, text, 16, colour, "lm"),
        ]
        x += 160
    return parts
