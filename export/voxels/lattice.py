"""Voxels of systems whose pieces keep to a lattice: each arrangement of pieces within a box is cut once."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from jaxtyping import Bool, Int

from export.voxels.frame import Frame, Subject, simple
from trees import Tree, from_substitution

MOST_SHAPES = 1000
MOST_STATES = 4096  # of one level
MOST_PIECES = 1 << 20  # of all states of one level
_WIDEST = 1 << 61
_FEW = 64  # states of a level, from which on a quarter or more must have been met before
_BOX = 1e-11

Corner = tuple[Fraction, ...]
Points = tuple[Corner, ...]
Rows = tuple[tuple[Fraction, ...], ...]


class NotOnLattice(ValueError):
    """Pieces that keep to no lattice of voxels, or to one with too many arrangements of them."""


@dataclass(frozen=True)
class _Cell:
    """A cell in fractions: a box around its attractor, and targets with the columns of their operators."""

    low: tuple[Fraction, ...]
    high: tuple[Fraction, ...]
    parts: tuple[tuple[str, Rows], ...]


@dataclass(frozen=True, eq=False)
class _Shapes:
    """Pieces up to translation, in units of `1 / scale` voxels: boxes relative to their last control point.

    The parts of shape s are `parts[s]`: their shapes, and where they stand. `depth` counts subdivisions.
    """

    scale: int
    low: Int[np.ndarray, "shapes 3"]
    high: Int[np.ndarray, "shapes 3"]
    depth: Int[np.ndarray, "shapes"]
    parts: tuple[tuple[Int[np.ndarray, "_parts"], Int[np.ndarray, "_parts 3"]], ...]


def lattice_tree(
    subject: Subject, frame: Frame, part: float = 1.0, depth: int | None = None, patient: bool = True
) -> tuple[Tree, float]:
    """The voxels of a frame that the smallest pieces meet, exactly as a walk finds them, in the shared form.

    With them the longest diagonal of the boxes of these pieces, in voxels.

    The state of a box of `2^m` voxels is the set of pieces that meet it, as large as the box or smaller,
    relative to its corner. Its eight octants have as states what is left of the pieces, those larger than an
    octant cut into theirs. Equal states of a level are worked out once, so that the time is that of the
    shared tree, not of the pieces. Everything is exact: operators as fractions with denominators up to 4096
    (the doubles nearest to which they are), control points and grid as the fractions that they are.

    Raises `NotOnLattice` where there are no such fractions or too many states, or, unless `patient`, where
    few states come again: then a walk is quicker.
    """
    cells = _exact_cells(subject)
    roots = _exact_roots(subject, frame)
    shapes, pieces = _shapes_of(cells, roots, frame, part, depth)
    rules, start = _rules(shapes, pieces, frame, part, depth, patient)
    last = np.array([not len(targets) for targets, _ in shapes.parts])
    sides = (shapes.high - shapes.low)[last] / shapes.scale
    tree = from_substitution(rules, start, frame.bits, frame.cube)
    return tree, float(np.sqrt((sides**2).sum(axis=1).max()))


def _exact_cells(subject: Subject) -> Mapping[str, _Cell]:
    system, boxes = subject.system, subject.boxes
    cells = {}
    for name, state in system.states.items():
        parts = []
        for target, operator in zip(state.targets, state.operators, strict=True):
            columns = tuple(
                tuple(simple(x) for x in column) for column in np.asarray(operator, dtype=float).T
            )
            if any(x.denominator > 4096 for column in columns for x in column) or any(
                sum(column) != 1 for column in columns
            ):
                raise NotOnLattice(f"an operator of cell {name!r} has entries that are no simple fractions")
            parts.append((target, columns))
        low, high = (tuple(_near(x) for x in side.tolist()) for side in (boxes[name].lo, boxes[name].hi))
        cells[name] = _Cell(low, high, tuple(parts))
    for name, cell in cells.items():
        for target, columns in cell.parts:
            other = cells[target]
            for axis in range(len(cell.low)):
                low, high = _extremes(other, [column[axis] for column in columns])
                if low < cell.low[axis] or high > cell.high[axis]:
                    raise NotOnLattice(f"the box around the attractor of cell {name!r} has no simple corners")
    return cells


def _near(x: float) -> Fraction:
    near = Fraction(x).limit_denominator(4096)
    if abs(near - Fraction(x)) > _BOX:
        raise NotOnLattice("the box around an attractor has no simple corners")
    return near


def _extremes(cell: _Cell, values: list[Fraction]) -> tuple[Fraction, Fraction]:
    """The least and the largest `sum_j p_j v_j` for p in the box of a cell."""
    order = sorted(range(len(values)), key=values.__getitem__)
    ends = []
    for along in (order, order[::-1]):
        rest = 1 - sum(cell.low, Fraction(0))
        total = sum((low * v for low, v in zip(cell.low, values, strict=True)), Fraction(0))
        for j in along:
            share = max(min(cell.high[j] - cell.low[j], rest), Fraction(0))
            total += share * values[j]
            rest -= share
        ends.append(total)
    return ends[0], ends[1]


def _exact_roots(subject: Subject, frame: Frame) -> list[tuple[str, Points]]:
    """Control points in voxels."""
    roots = []
    for cell, pieces in subject.roots.items():
        for piece in pieces.tolist():
            points = []
            for point in piece:
                placed = [
                    (Fraction(x) - low) / frame.exact_pitch if axis < subject.dimension else Fraction(1, 2)
                    for axis, (x, low) in enumerate(zip(point, frame.exact_origin, strict=True))
                ]
                if max(x.denominator for x in placed) > 1 << 24:
                    raise NotOnLattice("the control points lie on no lattice of voxels")
                points.append(tuple(placed))
            roots.append((cell, tuple(points)))
    return roots


def _moved(points: Points, column: tuple[Fraction, ...]) -> Corner:
    used = [(weight, point) for weight, point in zip(column, points, strict=True) if weight]
    x, y, z = (sum((weight * point[axis] for weight, point in used), Fraction(0)) for axis in range(3))
    return x, y, z


def _minus(a: Corner, b: Corner) -> Corner:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def _shapes_of(
    cells: Mapping[str, _Cell],
    roots: list[tuple[str, Points]],
    frame: Frame,
    part: float,
    depth: int | None,
) -> tuple[_Shapes, Int[np.ndarray, "pieces 4"]]:
    """All shapes of pieces that a walk meets, and the pieces that it begins with: shape and place."""
    numbers: dict[tuple[str, Points, int], int] = {}
    waiting: list[tuple[str, Points, int]] = []

    def number(cell: str, points: Points, level: int) -> int:
        key = cell, points, level if depth is not None else 0
        if key not in numbers:
            numbers[key] = len(waiting)
            waiting.append(key)
        return numbers[key]

    begun = []
    for cell, points in roots:
        base = points[-1]
        begun.append((number(cell, tuple(_minus(p, base) for p in points), 0), base))
    lows: list[Corner] = []
    highs: list[Corner] = []
    parts: list[list[tuple[int, Corner]]] = []
    at = 0
    while at < len(waiting):
        if len(waiting) > MOST_SHAPES:
            raise NotOnLattice(f"the pieces have more than {MOST_SHAPES} shapes")
        cell, points, level = waiting[at]
        at += 1
        ends = [_extremes(cells[cell], [point[axis] for point in points]) for axis in range(3)]
        lows.append((ends[0][0], ends[1][0], ends[2][0]))
        highs.append((ends[0][1], ends[1][1], ends[2][1]))
        small = level >= depth if depth is not None else all(high - low <= part for low, high in ends)
        mine: list[tuple[int, Corner]] = []
        known: dict[tuple[str, Rows], int] = {}
        for target, columns in () if small else cells[cell].parts:
            base = _moved(points, columns[-1])
            kind = target, tuple(_difference(column, columns[-1]) for column in columns)
            if kind not in known:
                moved = tuple(_minus(_moved(points, column), base) for column in columns)
                known[kind] = number(target, moved, level + 1)
            mine.append((known[kind], base))
        parts.append(mine)
    return _scaled(lows, highs, [level for _, _, level in waiting], parts, begun, frame)


def _difference(a: tuple[Fraction, ...], b: tuple[Fraction, ...]) -> tuple[Fraction, ...]:
    return tuple(x - y for x, y in zip(a, b, strict=True))


def _scaled(
    lows: list[Corner],
    highs: list[Corner],
    levels: list[int],
    parts: list[list[tuple[int, Corner]]],
    begun: list[tuple[int, Corner]],
    frame: Frame,
) -> tuple[_Shapes, Int[np.ndarray, "pieces 4"]]:
    """The same in whole numbers."""
    places = [*lows, *highs, *(base for mine in parts for _, base in mine), *(base for _, base in begun)]
    scale = math.lcm(*{x.denominator for place in places for x in place})
    reach = max(abs(x) for place in places for x in place) + (1 << frame.bits)
    if scale * reach * 4 > _WIDEST:
        raise NotOnLattice("the pieces lie on no lattice of voxels")

    def whole(corners: list[Corner]) -> Int[np.ndarray, "_corners 3"]:
        return np.array([[int(x * scale) for x in c] for c in corners], dtype=np.int64).reshape(-1, 3)

    low, high = whole(lows), whole(highs)
    table = tuple(
        (np.array([s for s, _ in mine], dtype=np.int64), whole([base for _, base in mine])) for mine in parts
    )
    pieces = np.column_stack([np.array([s for s, _ in begun], dtype=np.int64), whole([b for _, b in begun])])
    size = np.array(frame.size, dtype=np.int64) * scale
    ends_low, ends_high = pieces[:, 1:] + low[pieces[:, 0]], pieces[:, 1:] + high[pieces[:, 0]]
    flat = (low == high).any(axis=0) & (ends_high == size).any(axis=0)
    if (ends_low < 0).any() or (ends_high > size).any() or flat.any():
        raise NotOnLattice("pieces reach out of the grid, or are flat in its last face")
    return _Shapes(scale, low, high, np.array(levels, dtype=np.int64), table), pieces


def _rules(
    shapes: _Shapes,
    pieces: Int[np.ndarray, "pieces 4"],
    frame: Frame,
    part: float,
    depth: int | None,
    patient: bool,
):
    """The states of boxes, level by level, each with those of its octants, in Morton order."""
    rules: dict[tuple[int, int], list] = {}
    states = [_cut(shapes, pieces, _limit(shapes, frame.bits, part), depth, frame.bits)]
    for level in range(frame.bits, 0, -1):
        known: dict[bytes, int] = {}
        below: list[np.ndarray] = []
        met = 0
        half = shapes.scale << (level - 1)
        limit = _limit(shapes, level - 1, part)
        for number, state in enumerate(states):
            finer = _cut(shapes, state, limit, depth, level - 1)
            children: list[bool | tuple[int, int]] = []
            for octant in range(8):
                corner = np.array([octant >> 2 & 1, octant >> 1 & 1, octant & 1]) * half
                inside = _meeting(shapes, finer, corner, half)
                if not inside.any():
                    children.append(False)
                    continue
                met += 1
                if level == 1:
                    children.append(True)
                    continue
                rest = finer[inside]
                rest[:, 1:] -= corner
                key = rest.tobytes()
                if key not in known:
                    known[key] = len(below)
                    below.append(rest)
                children.append((level - 1, known[key]))
            rules[level, number] = children
        if level > 1 and len(below) >= _FEW and not patient and 4 * len(below) > 3 * met:
            raise NotOnLattice("few boxes are alike: a walk is quicker")
        if len(below) > MOST_STATES or sum(len(rest) for rest in below) > MOST_PIECES:
            raise NotOnLattice(f"{len(below)} boxes of {1 << level - 1} voxels a side are different")
        states = below
    return rules, (frame.bits, 0)


def _limit(shapes: _Shapes, level: int, part: float) -> float:
    """The largest side of a piece in a box of `2^level` voxels, in whole units."""
    return part * (shapes.scale << level)


def _cut(
    shapes: _Shapes, pieces: Int[np.ndarray, "pieces 4"], limit: float, depth: int | None, level: int
) -> Int[np.ndarray, "_pieces 4"]:
    """The pieces, those larger than the limit cut; sorted, each once. At last all that a walk would cut."""
    done = []
    while len(pieces):
        which = pieces[:, 0]
        large = (shapes.high[which] - shapes.low[which] > limit).any(axis=1)
        if depth is not None:
            large = (shapes.depth[which] < depth) & (large if level else True)
        done.append(pieces[~large])
        cut = pieces[large]
        if len(cut) > MOST_PIECES:
            raise NotOnLattice(f"more than {MOST_PIECES} pieces meet one box")
        found = []
        for shape in np.unique(cut[:, 0]):
            targets, places = shapes.parts[shape]
            bases = cut[cut[:, 0] == shape, 1:]
            moved = (bases[:, None] + places[None]).reshape(-1, 3)
            found.append(np.column_stack([np.tile(targets, len(bases)), moved]))
        pieces = np.concatenate(found) if found else pieces[:0]
    whole = np.concatenate(done) if done else pieces
    order = np.lexsort(whole.T)
    whole = whole[order]
    different = np.ones(len(whole), dtype=bool)
    different[1:] = (whole[1:] != whole[:-1]).any(axis=1)
    return whole[different]


def _meeting(
    shapes: _Shapes, pieces: Int[np.ndarray, "pieces 4"], corner: Int[np.ndarray, "3"], half: int
) -> Bool[np.ndarray, "pieces"]:
    """Which pieces' boxes meet the box: touching it with the high side alone does not count."""
    low = pieces[:, 1:] + shapes.low[pieces[:, 0]] - corner
    high = pieces[:, 1:] + shapes.high[pieces[:, 0]] - corner
    met = (low < half) & ((high > 0) | (low >= 0))
    return np.logical_and.reduce(met, axis=1)
