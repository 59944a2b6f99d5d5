"""Pieces of a system, walked depth first straight into the words of a tree."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float, UInt64

from export.voxels.frame import TOLERANCE, Frame, Subject, TooFine
from ifs import bounds
from trees import Tree
from trees.bricks import bricks_of, form_of_bricks, form_of_words
from trees.errors import TooManyPieces
from trees.morton import keys_of_cells

FLAT = 31
"""A grid of up to 2^31 cells is filled in one go; a larger one in blocks of 2^BLOCK cells."""
BLOCK = 27
MOST_ENTRIES = 2**28
_STEPS = 1 << 21
_LEVELS = 64
_EPS = float(np.finfo(np.float64).eps)

WALKED = 58
"""Grids of over 2^58 cells are for the lattice alone: their blocks would be too many."""

Tell = Callable[[float, int], None]
Bits = tuple[int, int, int]


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
    """A system as arrays, the roots in units of the grid, and what ends a walk.

    `slack` is by how much a box may reach over the face of a voxel without filling the next one.
    """

    tables: tuple[np.ndarray, ...]
    roots: tuple[tuple[int, Float[np.ndarray, "_points 3"]], ...]
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
    """The arrays of a system: labels of all cells in one row; kinds are labels alike but for their place."""
    system, boxes = subject.system, bounds(subject.system)
    names = list(system.states)
    number = {name: i for i, name in enumerate(names)}
    sizes = np.array([system.states[name].points for name in names])
    width = int(sizes.max())
    first, targets, kind, kinds, kind_cell = [0], [], [], [0], []
    weights, offsets = [], []
    for name in names:
        state = system.states[name]
        known: dict[tuple[str, bytes], int] = {}
        for target, operator in zip(state.targets, state.operators, strict=True):
            operator = np.asarray(operator, dtype=np.float64)
            linear = np.round((operator - operator[:, -1:]).T, 15) + 0.0
            key = target, linear.tobytes()
            if key not in known:
                known[key] = len(kind_cell)
                kind_cell.append(number[target])
                offsets.append(_padded((operator - operator[:, -1:]).T, (width, width)))
            targets.append(number[target])
            kind.append(known[key])
            weights.append(_padded(operator[:, -1], (width,)))
        first.append(len(targets))
        kinds.append(len(kind_cell))
    low = np.array([_padded(boxes[name].lo, (width,)) for name in names])
    high = np.array([_padded(boxes[name].hi, (width,)) for name in names])
    whole = np.array([bool((boxes[n].lo == 0).all() and (boxes[n].hi == 1).all()) for n in names])
    tables = (
        np.array(first),
        sizes,
        np.array(targets),
        np.array(kind),
        np.array(weights),
        np.array(kinds),
        np.array(kind_cell),
        *_sparse(np.array(offsets)),
        low,
        high,
        whole,
    )
    roots = tuple((number[cell], piece) for cell, pieces in subject.roots.items() for piece in pieces)
    return Walker(tables, roots, (width, int(np.diff(kinds).max()), int(np.diff(first).max())), part, depth)


def _sparse(matrices: Float[np.ndarray, "kinds rows columns"]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where the entries other than 0 of each row begin, their columns and values."""
    full = np.argwhere(matrices != 0)
    counts = (matrices != 0).sum(axis=2).ravel()
    ends = np.concatenate([[0], np.cumsum(counts)])
    rows = matrices.shape[1]
    begins = np.array([ends[q * rows : (q + 1) * rows + 1] for q in range(len(matrices))])
    return begins, np.ascontiguousarray(full[:, 2]), matrices[matrices != 0]


def rounding_of(subject: Subject, frame: Frame) -> float:
    """An estimate of how far, in voxels, the boxes of the smallest pieces may be misplaced.

    `4 eps (points + 2)` of the coordinates, times the sums of the columns of an operator and of the weights
    within a box. Places are kept relative to the piece above, so that the errors of finer levels shrink with
    the pieces. An estimate, no interval arithmetic.
    """
    states = subject.system.states.values()
    columns = max(float(np.abs(o).sum(axis=0).max()) for state in states for o in state.operators)
    weights = max(
        float(np.maximum(np.abs(b.lo), np.abs(b.hi)).sum()) for b in bounds(subject.system).values()
    )
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
    bits = _axis_bits(tuple((block[1] - block[0] + 1).tolist()))
    places, masks = _places(bits), _masks()
    words = np.zeros(2 ** (sum(bits) - 6), dtype=np.uint64)
    frame = (tops, slack, walker.part, walker.depth)
    before, behind = share
    for number, (cell, control) in enumerate(walker.roots):
        stack = _stack(walker, _LEVELS)
        # The root is met like any piece: as the only piece of a level above it.
        level = _enter_root(walker, stack, cell, control * scale, frame, block, words, places, masks, found)
        while level >= 0:
            level = kernels.walk(
                level, walker.tables, stack, block, frame, words, places, masks, _STEPS, found
            )
            if level < -1:
                level, stack = -2 - level, _deeper(stack)
            if level >= 0:
                inner = (number + _done(walker, stack, level)) / len(walker.roots)
                tell(before + (behind - before) * inner, int(found[0]))
    tell(behind, int(found[0]))
    return words


def _enter_root(walker, stack, cell, control, frame, block, words, places, masks, found) -> int:
    from export.voxels import kernels

    tables, (tops, slack, part, depth) = walker.tables, frame
    count = int(tables[1][cell])
    low, high = np.empty(3), np.empty(3)
    order = stack[9][cell]
    points = np.ascontiguousarray(control - control[-1])
    kernels.extremes(points, count, tables[10][cell], tables[11][cell], tables[12][cell], order, low, high)
    low, high = low + control[-1] + slack, high + control[-1] - slack
    first = np.array([kernels.first_cell(x, top) for x, top in zip(low, tops, strict=True)])
    last = np.array([kernels.last_cell(x, a, top) for x, a, top in zip(high, first, tops, strict=True)])
    if (last < block[0]).any() or (first > block[1]).any():
        return -1
    small = depth == 0 if depth >= 0 else bool((high - low + 2 * slack <= part).all())
    if small or (first == last).all():
        clipped = np.maximum(first, block[0]) - block[0], np.minimum(last, block[1]) - block[0]
        kernels.fill(words, places, masks, *clipped)
        found[0] += 1
        if not (first == last).all():
            found[1] = max(found[1], float(((high - low + 2 * slack) ** 2).sum()))
        return -1
    stack[0][0], stack[1][0] = cell, 0
    stack[2][0] = control[-1]
    stack[3][0, 0, :count] = points
    kernels.enter(0, cell, tables, stack, slack, part, depth)
    return 0


def _stack(walker: Walker, levels: int) -> tuple[np.ndarray, ...]:
    width, kinds, labels = walker.widths
    return (
        np.zeros(levels, dtype=np.int64),
        np.zeros(levels, dtype=np.int64),
        np.zeros((levels, 3)),
        np.zeros((levels, 1 + kinds, width, 3)),
        np.zeros((levels, labels, 3)),
        np.zeros((levels, labels, 3)),
        np.zeros((levels, labels, 3)),
        np.zeros((levels, kinds), dtype=np.bool_),
        np.zeros((levels + 1, 3), dtype=np.int64),
        _orders(walker),
        np.zeros((2, kinds, 3)),
    )


def _orders(walker: Walker) -> np.ndarray:
    """The numbers of control points, for each cell and axis."""
    return np.tile(np.arange(walker.widths[0]), (len(walker.tables[1]), 3, 1))


def _deeper(stack: tuple[np.ndarray, ...]) -> tuple[np.ndarray, ...]:
    """The same stack with room for twice the levels."""
    levels = len(stack[0])
    wider = [np.concatenate([array, np.zeros_like(array[:levels])]) for array in stack[:9]]
    return (*wider, *stack[9:])


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


def _masks() -> UInt64[np.ndarray, "3 4 4"]:
    """`masks[axis, f, l]`: the cells of a brick from f to l along an axis."""
    cells = np.indices((4, 4, 4)).reshape(3, -1).T.astype(np.uint64)
    bit = np.uint64(1) << keys_of_cells(cells, 2)
    masks = np.zeros((3, 4, 4), dtype=np.uint64)
    for axis in range(3):
        for f in range(4):
            for last in range(f, 4):
                inside = (cells[:, axis] >= f) & (cells[:, axis] <= last)
                masks[axis, f, last] = np.bitwise_or.reduce(bit[inside])
    return masks


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
