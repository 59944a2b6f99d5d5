"""Pieces of a system, walked depth first straight into the words of a tree."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float, UInt64

from export.voxels.forms import Form, affine_rules, forms_of
from export.voxels.frame import TOLERANCE, Frame, Subject, TooFine
from trees import Tree
from trees.bricks import bricks_of, form_of_bricks, form_of_words
from trees.errors import TooManyPieces
from trees.morton import keys_of_cells

FLAT = 30
"""A grid of up to 2^30 cells is filled in one go; a larger one in blocks of 2^BLOCK cells."""
BLOCK = 27
MOST_ENTRIES = 2**28
_STEPS = 1 << 21
_LEVELS = 64
_EPS = float(np.finfo(np.float64).eps)

WALKED = 58
"""Grids of over 2^58 cells are for the lattice alone: their blocks would be too many."""

LEFT_OUT = 1 / 64
"""How much of a voxel pieces may have beyond their slow coordinates to go on as these alone."""

Tell = Callable[[float, int], None]
Bits = tuple[int, int, int]
Root = tuple[
    int,
    Float[np.ndarray, "3"],
    Float[np.ndarray, "3 _coordinates"],
    Float[np.ndarray, "3"],
    Float[np.ndarray, "3"],
]


class GridTooLarge(MemoryError):
    """More cells than a walk goes through; `size` says how many along each axis."""

    def __init__(self, size: tuple[int, int, int]):
        self.size = size
        super().__init__(
            f"a grid of {size[0]} x {size[1]} x {size[2]} voxels is too large to be walked through, and the "
            f"shape keeps to no lattice of it: about {1 << WALKED // 3} voxels a side are possible in space"
        )


@dataclass(frozen=True, eq=False)
class Walked:
    """The tree, how many pieces were seen, and the longest diagonal of a filled box, in voxels."""

    tree: Tree
    pieces: int
    reach: float
    rounding: float


@dataclass(frozen=True, eq=False)
class Walker:
    """A system as arrays, the roots in its forms, in units of the grid, and what ends a walk.

    A root is its cell, where it begins, what it is made of, and half the sides of its box about that or, for
    a simplex, the ends.
    """

    tables: tuple[np.ndarray, ...]
    roots: tuple[Root, ...]
    widths: tuple[int, int, int]
    part: float
    depth: int


def walked(subject: Subject, frame: Frame, part: float, depth: int | None, snap: float, tell: Tell) -> Walked:
    """The voxels of a frame that the smallest pieces of a subject, in units of the grid, meet.

    Raises `TooFine`, and `trees.TooManyPieces` above 2^28 entries.
    """
    walker = walker_of(subject, part, -1 if depth is None else depth)
    rounding = rounding_of(subject, frame)
    if rounding > TOLERANCE / 2:
        raise TooFine(frame.pitch, frame.pitch * 2 * rounding / TOLERANCE)
    slack = snap if snap > 0 else -rounding
    found = np.zeros(2)
    if sum(_axis_bits(frame.size)) <= FLAT:
        words = _filled(walker, frame.size, slack, None, found, tell, (0.0, 1.0))
        form = _flat_form(words, frame)
    else:
        form = _in_blocks(walker, frame, slack, found, tell)
    return Walked(Tree(frame.cube, frame.bits, form), int(found[0]), math.sqrt(found[1]), rounding)


def walker_of(subject: Subject, part: float, depth: int) -> Walker:
    """The arrays of a system: labels of all cells in one row; kinds are labels alike but for their place.

    A cell with slow coordinates is there twice: whole, and as these alone.
    """
    forms = forms_of(subject.system, subject.boxes, subject.roots)
    rules = affine_rules(subject.system, forms)
    twins = [name for name, form in forms.items() if form.slow]
    number = {(name, 0): i for i, name in enumerate(forms)}
    number |= {(name, 1): len(forms) + i for i, name in enumerate(twins)}
    first, targets, kind, kinds, kind_cell, column, widths = [0], [], [], [0], [], [], []
    sizes = [forms[name].slow if twin else len(forms[name].centre) for name, twin in number]
    most = max(*sizes, 1)
    offsets, blocks = [], []
    for (name, twin), size in zip(number, sizes, strict=True):
        known: dict[tuple[str, bytes], int] = {}
        block: list[np.ndarray] = []
        width = 0
        for target, matrix, shift in rules[name]:
            below = forms[target].slow if twin else len(forms[target].centre)
            # The rows are those of the piece above: y = shift + y' matrix.
            made = matrix[:below, :size].T
            key = target, (np.round(made, 14) + 0.0).tobytes()
            if key not in known:
                known[key] = len(kind_cell)
                kind_cell.append(number[target, twin])
                column.append(width)
                width += below
                block.append(_padded(made, (most, below)))
            targets.append(number[target, twin])
            kind.append(known[key])
            offsets.append(_padded(shift[:size], (most,)))
        first.append(len(targets))
        kinds.append(len(kind_cell))
        widths.append(width)
        blocks.append(np.concatenate(block, axis=1))
    widest = max(*widths, 1)
    halves = [form.half for form in forms.values()] + [forms[name].half for name in twins]
    tables = (
        np.array(first),
        np.array(targets),
        np.array(kind),
        np.array(kinds),
        np.array(kind_cell),
        np.array(column),
        np.array(widths),
        np.array(sizes),
        np.array([half is None for half in halves]),
        np.array(
            [
                np.zeros(most) if half is None else _padded(half[:size], (most,))
                for half, size in zip(halves, sizes, strict=True)
            ]
        ),
        np.array([_padded(block, (most, widest)) for block in blocks]),
        np.array(offsets),
        np.array([number.get((name, 1), -1) for name in forms] + [-1] * len(twins)),
    )
    roots = tuple(
        _root(number[cell, 0], forms[cell], piece)
        for cell, pieces in subject.roots.items()
        for piece in pieces
    )
    return Walker(tables, roots, (widest, int(np.diff(kinds).max()), int(np.diff(first).max())), part, depth)


def _root(cell: int, form: Form, piece: Float[np.ndarray, "_points 3"]) -> Root:
    """A piece in the form of its cell, and the ends of its box relative to where it begins."""
    spread = (piece[:-1] - piece[-1]).T
    made = spread @ form.directions.T
    if form.half is None:
        low, high = made.min(axis=1, initial=0), made.max(axis=1, initial=0)
    else:
        high = np.abs(made) @ form.half
        low = -high
    return cell, piece[-1] + spread @ form.centre, made, low, high


def rounding_of(subject: Subject, frame: Frame) -> float:
    """An estimate of how far, in voxels, the boxes of the smallest pieces may be misplaced.

    `4 eps (points + 2)` of the coordinates, times the sums of the columns of an operator and of the weights
    within a box. Places are kept relative to the piece above, so that the errors of finer levels shrink with
    the pieces. An estimate, no interval arithmetic.
    """
    states = subject.system.states.values()
    columns = max(float(np.abs(o).sum(axis=0).max()) for state in states for o in state.operators)
    weights = max(float(np.maximum(np.abs(b.lo), np.abs(b.hi)).sum()) for b in subject.boxes.values())
    most = max(float(np.abs(points).max()) for points in subject.roots.values())
    width = max(state.points for state in states)
    return 4 * _EPS * (width + 2) * columns * (1 + min(weights, width * columns)) * (most + max(frame.size))


def _padded(array: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    return np.pad(array, [(0, n - m) for n, m in zip(shape, array.shape, strict=True)])


def _axis_bits(size: tuple[int, ...]) -> Bits:
    """Bits of the cells along each axis of a grid, at least the two of a brick."""
    x, y, z = (max((n - 1).bit_length(), 2) for n in size)
    return x, y, z


def _filled(
    walker: Walker,
    size: tuple[int, ...],
    slack: float,
    block: np.ndarray | None,
    found: np.ndarray,
    tell: Tell,
    share: tuple[float, float],
    scale: float = 1.0,
) -> UInt64[np.ndarray, " bricks"]:
    """The words of the bricks of a block of a grid; `block` is its first and last cell, all where None."""
    from export.voxels import kernels

    tops = np.array(size) - 1
    block = np.array([[0, 0, 0], tops]) if block is None else block
    shape = block[1] - block[0] + 1
    axes = np.argsort(shape, kind="stable")  # rows along the longest
    turned = shape[axes]
    rows = np.zeros((int(turned[0]), int(turned[1]), -(-int(turned[2]) // 64)), dtype=np.uint64)
    limits = walker.part, walker.depth, LEFT_OUT * walker.part if walker.depth < 0 else -1.0
    frame = np.ascontiguousarray(block[:, axes]), tops[axes], slack, limits, rows
    stack = _stack(walker, _LEVELS)
    before, behind = share
    for number, root in enumerate(walker.roots):
        level = _enter_root(walker, stack, _turned(root, axes, scale), frame, found)
        while level >= 0:
            level = kernels.walk(level, walker.tables, stack, *frame, _STEPS, found)
            if level < -1:
                level, stack = -2 - level, _deeper(stack)
            if level >= 0:
                inner = (number + _done(walker, stack, level)) / len(walker.roots)
                tell(before + (behind - before) * inner, int(found[0]))
    tell(behind, int(found[0]))
    bits = _axis_bits(tuple(shape.tolist()))
    words = np.zeros(2 ** (sum(bits) - 6), dtype=np.uint64)
    kernels.bricked(rows, axes, _places(bits), _spread(), words)
    return words


def _turned(root: Root, axes: np.ndarray, scale: float) -> Root:
    cell, base, made, low, high = root
    return cell, base[axes] * scale, made[axes] * scale, low[axes] * scale, high[axes] * scale


def _enter_root(walker: Walker, stack, root: Root, frame, found: np.ndarray) -> int:
    """Begin with a root; -1 where it ends at once."""
    from export.voxels import kernels

    block, tops, slack, limits, rows = frame
    cell, base, made, low, high = root
    start, end = base + low + slack, base + high - slack
    first = np.array([kernels.first_cell(x, top) for x, top in zip(start, tops, strict=True)])
    last = np.array([kernels.last_cell(x, a, top) for x, a, top in zip(end, first, tops, strict=True)])
    if (last < block[0]).any() or (first > block[1]).any():
        return -1
    small = walker.depth == 0 if walker.depth >= 0 else bool((high - low <= walker.part).all())
    if small or (first == last).all():
        a, b = np.maximum(first, block[0]) - block[0], np.minimum(last, block[1]) - block[0]
        kernels.fill(rows, a[0], b[0], a[1], b[1], a[2], b[2])
        found[0] += 1
        if not (first == last).all():
            found[1] = max(found[1], float(((high - low) ** 2).sum()))
        return -1
    stack[0][0], stack[1][0], stack[2][0], stack[3][0] = cell, 0, base, 0
    stack[4][0, :, : made.shape[1]] = made
    stack[13][0, 0] += 1
    stack[13][1, 0] = stack[13][0, 0]
    kernels.enter(0, cell, walker.tables, stack, slack, limits)
    return 0


def _stack(walker: Walker, levels: int) -> tuple[np.ndarray, ...]:
    width, kinds, labels = walker.widths
    width = max(width, walker.tables[9].shape[1])
    return (
        np.zeros(levels, dtype=np.int64),
        np.zeros(levels, dtype=np.int64),
        np.zeros((levels, 3)),
        np.zeros(levels, dtype=np.int64),
        np.zeros((levels + 1, 3, width)),
        np.zeros((levels, labels, 3)),
        np.zeros((levels, labels, 3)),
        np.zeros((levels, labels, 3)),
        np.zeros((levels, kinds), dtype=np.bool_),
        np.zeros((levels, kinds), dtype=np.int64),
        np.zeros((levels, kinds, 3)),
        np.zeros((levels, 3)),
        np.zeros((2, kinds, 3)),
        np.zeros((levels + 1, 3), dtype=np.int64),
        np.zeros(levels, dtype=np.bool_),
        np.zeros(levels),
        np.zeros((levels, labels, 3), dtype=np.int64),
        np.zeros((levels, 3), dtype=np.int64),
        np.zeros((levels, 3, labels), dtype=np.int64),
        np.zeros((3, labels, 2), dtype=np.int64),
        np.zeros(labels, dtype=np.uint64),
    )


def _deeper(stack: tuple[np.ndarray, ...]) -> tuple[np.ndarray, ...]:
    """The same stack with room for twice the levels."""
    levels = len(stack[0])
    kept = 12, 19, 20
    return tuple(
        array if i in kept else np.concatenate([array, np.zeros_like(array[:levels])])
        for i, array in enumerate(stack)
    )


def _done(walker: Walker, stack: tuple[np.ndarray, ...], level: int) -> float:
    """The share of the work behind: in each cell its pieces count alike."""
    first, share, done = walker.tables[0], 1.0, 0.0
    for i in range(level + 1):
        cell = int(stack[0][i])
        count = int(first[cell + 1] - first[cell])
        open_below = i < level
        done += share * (int(stack[1][i]) - int(open_below)) / count
        share /= count
    return done


def _places(bits: Bits) -> UInt64[np.ndarray, "3 bricks"]:
    """What each axis adds to the number of a brick, in Morton order without unused bits."""
    places = np.zeros((3, 2 ** (max(bits) - 2)), dtype=np.uint64)
    shift = 0
    for level in range(max(bits) - 2):
        for axis in (2, 1, 0):
            if level < bits[axis] - 2:
                digit = (np.arange(places.shape[1], dtype=np.uint64) >> np.uint64(level)) & np.uint64(1)
                places[axis] |= digit << np.uint64(shift)
                shift += 1
    return places


def _spread() -> UInt64[np.ndarray, "3 16"]:
    """`spread[axis, n]`: the cells of a brick that lie, along an axis, where n has bits."""
    cells = np.indices((4, 4, 4)).reshape(3, -1).T.astype(np.uint64)
    bit = np.uint64(1) << keys_of_cells(cells, 2)
    spread = np.zeros((3, 16), dtype=np.uint64)
    for axis in range(3):
        for n in range(16):
            inside = (np.uint64(n) >> cells[:, axis]) & np.uint64(1) == 1
            spread[axis, n] = np.bitwise_or.reduce(bit[inside], initial=np.uint64(0))
    return spread


def _used(bits: Bits) -> int:
    """The bits that the numbers of bricks of a grid have among those of a cube."""
    return sum(1 << 3 * level + 2 - axis for axis in range(3) for level in range(bits[axis] - 2))


def _flat_form(words: UInt64[np.ndarray, " bricks"], frame: Frame) -> Any:
    depth = 3 * frame.bits
    if words.size == 2 ** (depth - 6):
        return form_of_words(depth, words)
    return _form(depth, [_entries(words, _used(_axis_bits(frame.size)), 0)])


def _entries(words: UInt64[np.ndarray, " bricks"], used: int, begin: int):
    from export.voxels import kernels

    none = np.zeros(0, dtype=np.uint64)
    count = kernels.compacted(words, np.uint64(used), np.uint64(begin), none, none)
    starts, entries = np.empty(count, dtype=np.uint64), np.empty(count, dtype=np.uint64)
    kernels.compacted(words, np.uint64(used), np.uint64(begin), starts, entries)
    return starts, entries


def _form(depth: int, parts) -> Any:
    from export.voxels import kernels

    starts = np.concatenate([starts for starts, _ in parts]) if parts else np.zeros(0, dtype=np.uint64)
    words = np.concatenate([words for _, words in parts]) if parts else np.zeros(0, dtype=np.uint64)
    parts.clear()
    arrays = kernels.joined(starts, words, np.uint64(2 ** (depth - 6)))
    return form_of_bricks(bricks_of(depth, arrays))


def _in_blocks(walker: Walker, frame: Frame, slack: float, found: np.ndarray, tell: Tell) -> Any:
    """Block by block in Morton order, over the blocks that a coarser walk finds."""
    bits = _axis_bits(frame.size)
    if sum(bits) > WALKED:
        raise GridTooLarge(frame.size)
    side = max(e for e in range(2, max(bits) + 1) if sum(min(e, b) for b in bits) <= BLOCK)
    coarse = tuple(-(-n >> side) for n in frame.size)
    met = _cells_met(walker, coarse, slack, side)
    parts, held = [], 0
    for number, corner in enumerate(met):
        low = corner << side
        block = np.array([low, np.minimum(low + (1 << side), np.array(frame.size)) - 1])
        share = number / len(met), (number + 1) / len(met)
        words = _filled(walker, frame.size, slack, block, found, tell, share)
        begin = int(keys_of_cells(corner[None].astype(np.uint64), frame.bits)[0]) << 3 * side - 6
        part = _entries(words, _used(_axis_bits(tuple((block[1] - low + 1).tolist()))), begin)
        held += len(part[0])
        if held > MOST_ENTRIES:
            raise TooManyPieces(held, MOST_ENTRIES)
        parts.append(part)
    return _form(3 * frame.bits, parts)


def _cells_met(walker: Walker, size: tuple[int, ...], slack: float, side: int) -> np.ndarray:
    """The cells of a coarse grid, of 2^side voxels a side, that pieces meet, in Morton order."""
    from trees import to_points

    scale = 2.0**-side
    coarse = Walker(walker.tables, walker.roots, walker.widths, 1.0, walker.depth)
    bits = _axis_bits(size)
    words = _filled(coarse, size, slack * scale, None, np.zeros(2), lambda share, seen: None, (0, 1), scale)
    depth = 3 * max(bits)
    tree = Tree(_unit(), max(bits), _form(depth, [_entries(words, _used(bits), 0)]))
    return to_points(tree).astype(np.int64)


def _unit():
    from trees import unit_cube

    return unit_cube(3)
