"""Trees from a function that says of boxes whether they are in, out, or neither."""

from collections.abc import Callable

import numpy as np
from jaxtyping import Float, Integer, UInt64

from trees.cube import Cube
from trees.doors import whole
from trees.errors import TooManyPieces, TreeError
from trees.morton import cells_of_keys, check_widths
from trees.runs import tree_of_runs
from trees.tree import Tree

OUTSIDE, INSIDE, UNKNOWN = 0, 1, 2
MAX_BOXES = 2**26

Boxes = Float[np.ndarray, "boxes dim"]
Predicate = Callable[[Boxes, Boxes], Integer[np.ndarray, " boxes"]]


def from_predicate(function: Predicate, cube: Cube, bits: int) -> Tree:
    """The cells of a set known by a function on boxes: unknown boxes are halved, one axis after the other.

    `function(lows, highs)` takes the corners of n boxes, `(n, dimension)` each in mm, and returns n
    integers: 0 outside, 1 inside, 2 unknown. A cell still unknown becomes black: where the function
    is right about the boxes it decides, the tree covers the set (the upper envelope).

    Raises `TreeError` where the function returns something else, `TooManyPieces` where more than 2^26
    boxes of one level are unknown.

    >>> def disc(lows, highs):
    ...     near = np.clip(0.0, lows, highs)
    ...     far = np.maximum(abs(lows), abs(highs))
    ...     return np.where((far**2).sum(1) <= 1, 1, np.where((near**2).sum(1) > 1, 0, 2))
    >>> from_predicate(disc, Cube((-1.0, -1.0), 2.0), bits=3).count
    60
    """
    bits = whole(bits, "bits")
    check_widths(cube.dimension, bits)
    depth = cube.dimension * bits
    unknown = np.zeros(1, dtype=np.uint64)
    lows, highs = [], []
    for level in range(depth + 1):
        free = depth - level
        states = _states(function, *_corners(unknown, cube, bits, level))
        black = unknown[(states == INSIDE) | ((states == UNKNOWN) & (free == 0))]
        lows.append(black)
        highs.append(black | np.uint64(2**free - 1))
        grey = unknown[states == UNKNOWN]
        if free == 0 or len(grey) == 0:
            break
        if 2 * len(grey) > MAX_BOXES:
            raise TooManyPieces(2 * len(grey), MAX_BOXES)
        unknown = np.stack([grey, grey | np.uint64(2 ** (free - 1))], axis=1).ravel()
    low, high = np.concatenate(lows), np.concatenate(highs)
    order = np.argsort(low)
    return tree_of_runs((low[order], high[order]), cube, bits)


def _corners(keys: UInt64[np.ndarray, " boxes"], cube: Cube, bits: int, level: int) -> tuple[Boxes, Boxes]:
    cells = cells_of_keys(keys, cube.dimension, bits)
    halvings = [level // cube.dimension + (axis < level % cube.dimension) for axis in range(cube.dimension)]
    extents = np.array([2 ** (bits - n) for n in halvings], dtype=np.float64)
    width, origin = cube.size / 2**bits, np.array(cube.origin)
    corner = cells.astype(np.float64)
    return origin + corner * width, origin + (corner + extents) * width


def _states(function: Predicate, lows: Boxes, highs: Boxes) -> Integer[np.ndarray, " boxes"]:
    states = np.asarray(function(lows, highs))
    if states.shape != (len(lows),) or not np.issubdtype(states.dtype, np.integer):
        raise TreeError(
            f"the function returns {states.dtype} of shape {states.shape} for {len(lows)} boxes: "
            f"{len(lows)} integers are needed"
        )
    wrong = (states < OUTSIDE) | (states > UNKNOWN)
    if wrong.any():
        box = int(np.argmax(wrong))
        raise TreeError(
            f"the function returns {states[box]} for the box from {lows[box].tolist()} to "
            f"{highs[box].tolist()}: 0, 1 or 2 is needed"
        )
    return states
