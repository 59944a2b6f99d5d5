"""Tree codes and leaf codes: the linear lists of Guye 1988, II.2.

A tree code lists the colours of all nodes of the 2^k-tree, 0 white, 1 black, 2 grey, depth first or in
post-order. A leaf code is the path of digits from the root to a leaf, padded with X to `bits` digits.

Child j of a node is quadrant `quadrants[j]` in Morton order, which counts axis 0 highest; the figures of
the report go around the square instead, south-west, north-west, north-east, south-east: `AROUND`.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from trees.cube import Cube, unit_cube
from trees.doors import whole, wholes
from trees.errors import CodeError, TooManyPieces, TreeError
from trees.leaves import leaf_runs
from trees.morton import check_widths
from trees.runs import tree_of_runs
from trees.tree import Tree

AROUND = (0, 1, 3, 2)
DIGITS = "0123456789abcdefghijklmnopqrstuv"
MAX_NODES = 2**24
WHITE, BLACK, GREY = 0, 1, 2


def depth_first_code(tree: Tree, quadrants: Sequence[int] | None = None) -> str:
    """The colours of all nodes, each before its children.

    >>> from trees import from_points
    >>> figure_1 = from_points([[1, 0], [3, 2], [2, 0], [3, 0], [2, 1], [3, 1]], bits=2)
    >>> depth_first_code(figure_1, AROUND)
    '2 2 0 0 0 1 0 2 0 0 0 1 1'
    """
    return " ".join(map(str, _colours(tree, _order(tree.dimension, quadrants))))


def post_order_code(tree: Tree, quadrants: Sequence[int] | None = None) -> str:
    """The colours of all nodes, each after its children.

    >>> from trees import from_points
    >>> figure_1 = from_points([[1, 0], [3, 2], [2, 0], [3, 0], [2, 1], [3, 1]], bits=2)
    >>> post_order_code(figure_1, AROUND)
    '0 0 0 1 2 0 0 0 0 1 2 1 2'
    """
    mirrored = _order(tree.dimension, quadrants)[::-1]
    return " ".join(map(str, list(_colours(tree, mirrored))[::-1]))


def from_depth_first_code(
    code: str, dimension: int, bits: int, quadrants: Sequence[int] | None = None, cube: Cube | None = None
) -> Tree:
    """The tree of a depth-first code; white space between the colours may be left out.

    Children that are all of one colour are merged. Raises `CodeError` with the place of the symbol where
    one is no colour, is grey at the last level, follows the end, or is missing.

    >>> list(from_depth_first_code("2 0 0 1 0", dimension=2, bits=1))
    [(1, 0)]
    """
    symbols = _symbols(code)
    places = range(len(symbols))
    return _read(symbols, places, _order(dimension, quadrants), bits, cube or unit_cube(dimension))


def from_post_order_code(
    code: str, dimension: int, bits: int, quadrants: Sequence[int] | None = None, cube: Cube | None = None
) -> Tree:
    """The tree of a post-order code; it is read from its end, as errors are found.

    >>> list(from_post_order_code("0 0 1 0 2", dimension=2, bits=1))
    [(1, 0)]
    """
    symbols = _symbols(code)[::-1]
    places = range(len(symbols) - 1, -1, -1)
    return _read(symbols, places, _order(dimension, quadrants)[::-1], bits, cube or unit_cube(dimension))


def leaf_codes(tree: Tree, quadrants: Sequence[int] | None = None) -> list[str]:
    """The codes of the black leaves, sorted; those of the white ones are `leaf_codes(~tree)`.

    Digits are 0 to 9, then a to v: raises `TreeError` above five dimensions.

    >>> from trees import from_points
    >>> figure_1 = from_points([[1, 0], [3, 2], [2, 0], [3, 0], [2, 1], [3, 1]], bits=2)
    >>> leaf_codes(figure_1, AROUND)
    ['03', '23', '3X']
    """
    _check_digits(tree.dimension)
    order = _order(tree.dimension, quadrants)
    leaves = _ordered_leaves(tree, order)
    codes = []
    for key, level in leaves:
        shifts = range(
            tree.depth - tree.dimension, tree.depth - tree.dimension * (level + 1), -tree.dimension
        )
        digits = "".join(DIGITS[(key >> shift) & (2**tree.dimension - 1)] for shift in shifts)
        codes.append(digits + "X" * (tree.bits - level))
    return codes


def from_leaf_codes(
    codes: Sequence[str],
    dimension: int,
    bits: int,
    quadrants: Sequence[int] | None = None,
    cube: Cube | None = None,
) -> Tree:
    """The union of the leaves of these codes, in any order.

    Raises `CodeError` with the number of the code that has not `bits` digits, a digit that is no child,
    or a digit after an X.

    >>> len(from_leaf_codes(["03", "23", "3X"], dimension=2, bits=2))
    6
    """
    dimension, bits = whole(dimension, "dimension"), whole(bits, "bits")
    _check_digits(dimension)
    check_widths(dimension, bits)
    order = _order(dimension, quadrants)
    lows, highs = [], []
    for place, code in enumerate(codes):
        if not isinstance(code, str):
            raise CodeError(place, f"{code!r} is no leaf code: a string is needed")
        path = code.rstrip("X")
        if len(code) != bits:
            raise CodeError(place, f"{code!r} has {len(code)} digits, and {bits} are needed")
        key = 0
        for digit in path:
            child = DIGITS.find(digit)
            if not 0 <= child < 2**dimension:
                allowed = f"0 to {DIGITS[2**dimension - 1]}, then X only"
                raise CodeError(place, f"{code!r} has the digit {digit!r}; allowed are {allowed}")
            key = (key << dimension) | order[child]
        width = dimension * (bits - len(path))
        lows.append(key << width)
        highs.append((key + 1 << width) - 1)
    runs = sorted(zip(lows, highs, strict=True))
    joined: list[tuple[int, int]] = []
    for low, high in runs:
        if not joined or low > joined[-1][1]:
            joined.append((low, high))
        else:
            joined[-1] = joined[-1][0], max(high, joined[-1][1])
    low, high = (np.array([run[side] for run in joined], dtype=np.uint64) for side in (0, 1))
    return tree_of_runs((low, high), cube or unit_cube(dimension), bits)


def _order(dimension: int, quadrants: Sequence[int] | None) -> tuple[int, ...]:
    if not 1 <= whole(dimension, "dimension") <= 16:
        raise TreeError(f"codes of dimension {dimension}: 1 to 16 are possible")
    order = tuple(range(2**dimension) if quadrants is None else wholes(quadrants, "quadrants"))
    if sorted(order) != list(range(2**dimension)):
        raise TreeError(f"quadrants {order}: each of 0 to {2**dimension - 1} is needed once")
    return order


def _check_digits(dimension: int) -> None:
    if not 1 <= whole(dimension, "dimension") <= 5:
        raise TreeError(f"leaf codes of dimension {dimension}: there are digits for 1 to 5")


def _symbols(code: str) -> list[int]:
    symbols = []
    if not isinstance(code, str):
        raise TreeError(f"a code of {type(code).__name__}: a string is needed")
    for place, symbol in enumerate("".join(code.split())):
        if symbol not in "012":
            raise CodeError(place, f"{symbol!r} is no colour: 0 is white, 1 black, 2 grey")
        symbols.append(int(symbol))
    return symbols


def _ordered_leaves(tree: Tree, order: tuple[int, ...]) -> list[tuple[int, int]]:
    """(key in that order of children, level) of the black leaves, sorted."""
    k, bits = tree.dimension, tree.bits
    child = {quadrant: place for place, quadrant in enumerate(order)}
    first, last = leaf_runs(tree, k)
    if len(first) > MAX_NODES:
        raise TooManyPieces(len(first), MAX_NODES)
    leaves = []
    for low, high in zip(first.tolist(), last.tolist(), strict=True):
        level = bits - (high - low).bit_length() // k
        key = 0
        for i in range(level):
            key = (key << k) | child[(low >> (k * (bits - 1 - i))) & (2**k - 1)]
        leaves.append((key << (k * (bits - level)), level))
    return sorted(leaves)


def _colours(tree: Tree, order: tuple[int, ...]) -> Iterator[int]:
    """Depth first: a leaf is preceded by the grey nodes that begin with it."""
    black = [(*leaf, BLACK) for leaf in _ordered_leaves(tree, order)]
    white = [(*leaf, WHITE) for leaf in _ordered_leaves(~tree, order)]
    for key, level, colour in sorted(black + white):
        for _ in range(_top(key, tree.dimension, tree.bits), level):
            yield GREY
        yield colour


def _top(key: int, dimension: int, bits: int) -> int:
    """The level of the largest node that begins with this key."""
    zeros = (key & -key).bit_length() - 1 if key else dimension * bits
    return bits - zeros // dimension


def _read(symbols: list[int], places: range, order: tuple[int, ...], bits: int, cube: Cube) -> Tree:
    k, bits = cube.dimension, whole(bits, "bits")
    check_widths(k, bits)
    key, level, end = 0, 0, 2 ** (k * bits)
    blacks: list[tuple[int, int]] = []
    for place, colour in zip(places, symbols, strict=True):
        if key == end:
            raise CodeError(place, "the tree is complete without this colour")
        if colour == GREY:
            if level == bits:
                raise CodeError(place, f"a grey node at level {level}, the last for {bits} bits an axis")
            level += 1
            continue
        if colour == BLACK:
            blacks.append((_reordered(key, level, order, k, bits), k * (bits - level)))
        key += 2 ** (k * (bits - level))
        level = _top(key, k, bits) if key < end else 0
    if key != end:
        place = places[-1] + places.step if len(places) else 0
        raise CodeError(max(place, 0), f"the code ends where a node of level {level} is due")
    blacks.sort()
    low = np.array([key for key, _ in blacks], dtype=np.uint64)
    high = np.array([key + 2**width - 1 for key, width in blacks], dtype=np.uint64)
    return tree_of_runs((low, high), cube, bits)


def _reordered(key: int, level: int, order: tuple[int, ...], k: int, bits: int) -> int:
    result = 0
    for i in range(level):
        result = (result << k) | order[(key >> (k * (bits - 1 - i))) & (2**k - 1)]
    return result << (k * (bits - level))
