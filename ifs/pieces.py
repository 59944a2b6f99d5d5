"""The pieces of a shape, down to a size or a depth, a bounded number at a time."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from ifs.asked import require_whole
from ifs.certificates.bounds import Box, bounds, extent
from ifs.certificates.convergence import require_contraction
from ifs.system import System

Control = Float[np.ndarray, "_count _points _dim"]
Corners = Float[np.ndarray, "_count _dim"]
Skip = Callable[[Corners, Corners], Bool[np.ndarray, "count"]]

_FINEST = 1e-12  # the smallest size asked for, relative to the coordinates of the control points

_Batch = list[tuple[str, Control]]


@dataclass(frozen=True)
class Pieces:
    """Pieces of one cell: their control points and boxes certain to contain them, in mm.

    `done` estimates which share of the whole work lies behind them, from 0 to 1.
    """

    cell: str
    control: Control
    lo: Corners
    hi: Corners
    done: float


def pieces(
    system: System,
    control: Float[np.ndarray, "points dim"],
    size: float | None = None,
    depth: int | None = None,
    chunk: int = 1 << 14,
    skip: Skip | None = None,
) -> Iterator[Pieces]:
    """Subdivide the shape with the given control points (mm) and yield its pieces by the chunk.

    With `size`, each piece is subdivided until its box has all sides at most `size` mm; with
    `depth`, exactly that many times. The boxes of the pieces together cover the attractor.
    `skip(lo, hi)` is asked about the boxes of every generation, and the pieces where it answers
    True are dropped with all that is in them (what they would cover is covered already).

    At most `chunk` pieces are subdivided together, the last made first, so that memory stays in
    proportion to `chunk * labels * generations` whatever the number of pieces. The order depends
    only on the arguments. Control points of the piece behind label i: `T_i^T control`.

    Raises at the call: ValueError for control points that do not fit the shape, for neither or
    both of size and depth, for a size below 1e-12 of the coordinates; and, where a size is asked
    for, `NotContracting` or `Undecided`.

    >>> import numpy as np
    >>> from ifs.system import State, System
    >>> halves = (np.array([[1, 0.5], [0, 0.5]]), np.array([[0.5, 0], [0.5, 1]]))
    >>> segment = State("segment", 2, ("0", "1"), ("segment", "segment"), halves)
    >>> line = System("segment", {"segment": segment})
    >>> found = next(pieces(line, np.array([[0.0, 0.0], [8.0, 4.0]]), size=2.5))
    >>> found.hi[:, 0]
    array([2., 4., 6., 8.])
    """
    control = np.asarray(control, dtype=np.float64)
    expected = system.states[system.shape].points
    if control.ndim != 2 or len(control) != expected or control.shape[1] == 0:
        raise ValueError(
            f"cell {system.shape!r} takes {expected} control points, one row each; "
            f"got an array of shape {control.shape}"
        )
    if not np.isfinite(control).all():
        raise ValueError("control points must be finite numbers of millimetres")
    if (size is None) == (depth is None):
        raise ValueError("give either a size in millimetres or a depth")
    if depth is not None:
        require_whole("depth", depth)
    require_whole("chunk", chunk, 1)
    if size is not None:
        least = _FINEST * float(np.abs(control).max())
        if not (np.isfinite(size) and size > 0 and size >= least):
            raise ValueError(
                f"the size must be above 0, and at least {least:.3g} mm for coordinates as large "
                f"as these; got {size}"
            )
        require_contraction(system)
    return _subdivided(system, bounds(system), control, size, depth, chunk, skip)


def _subdivided(
    system: System,
    boxes: Mapping[str, Box],
    control: Float[np.ndarray, "points dim"],
    size: float | None,
    depth: int | None,
    chunk: int,
    skip: Skip | None,
) -> Iterator[Pieces]:
    operators = {name: _stacked(system, name) for name in system.states}
    waiting: list[tuple[int, float, _Batch]] = [(0, 1.0, [(system.shape, control[None])])]
    while waiting:
        level, share, batch = waiting.pop()
        done_before = 1.0 - share - sum(other for _, other, _ in waiting)
        number = sum(len(controls) for _, controls in batch)
        ended = 0
        children: dict[str, list[Control]] = {}
        for cell, controls in batch:
            last = level == depth
            if size is not None or last or skip is not None:
                lo, hi = extent(boxes[cell], controls)
                if skip is not None:
                    kept = ~skip(lo, hi)
                    ended += int((~kept).sum())
                    controls, lo, hi = controls[kept], lo[kept], hi[kept]
                done = np.full(len(controls), last)
                if size is not None:
                    done = (hi - lo <= size).all(axis=1)
                if done.any():
                    ended += int(done.sum())
                    behind = done_before + share * ended / number
                    yield Pieces(cell, controls[done], lo[done], hi[done], behind)
                controls = controls[~done]
            if len(controls) == 0:
                continue
            for target, stack in operators[cell]:
                moved = stack @ controls[:, None]
                children.setdefault(target, []).append(moved.reshape(-1, *moved.shape[2:]))
        parts = _batches(children, chunk)
        sizes = [sum(len(controls) for _, controls in part) for part in parts]
        rest = share * (1 - ended / number)
        waiting.extend(
            (level + 1, rest * size / sum(sizes), part)
            for part, size in zip(reversed(parts), reversed(sizes), strict=True)
        )


def _stacked(
    system: System, name: str
) -> list[tuple[str, Float[np.ndarray, "_labels _target_points _points"]]]:
    """The transposed operators of a cell, those to the same target together."""
    state = system.states[name]
    return [
        (
            target,
            np.stack(
                [
                    operator.T
                    for operator, other in zip(state.operators, state.targets, strict=True)
                    if other == target
                ]
            ),
        )
        for target in dict.fromkeys(state.targets)
    ]


def _batches(children: Mapping[str, list[Control]], chunk: int) -> list[_Batch]:
    """The pieces of a generation in batches of `chunk`, in order, the last one smaller."""
    batches: list[_Batch] = []
    room = 0
    for cell, found in children.items():
        controls = np.concatenate(found)
        start = 0
        while start < len(controls):
            if room == 0:
                batches.append([])
                room = chunk
            part = controls[start : start + room]
            batches[-1].append((cell, part))
            start += len(part)
            room -= len(part)
    return batches
