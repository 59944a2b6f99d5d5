"""Integrals of monomials over the cells of a tree, exactly, in units of cells."""

from fractions import Fraction
from functools import lru_cache
from itertools import product
from math import comb, factorial, lcm, prod

import numpy as np
from jaxtyping import Int, UInt64

from trees.errors import TreeError
from trees.measures.node_sums import node_integrals
from trees.shared import Shared
from trees.tree import Tree

Exponent = tuple[int, ...]

MAX_MOMENTS = 2**12
WORD_BITS = 34
FEW = 2**14


@lru_cache
def exponents(dimension: int, order: int) -> tuple[Exponent, ...]:
    """All exponents of total degree up to `order`, by degree.

    Raises `TreeError` above 4096 of them.

    >>> exponents(2, 1)
    ((0, 0), (1, 0), (0, 1))
    """
    if order >= MAX_MOMENTS:
        raise TreeError(f"moments up to order {order}: there would be more than {MAX_MOMENTS} of them")
    if comb(dimension + order, order) > MAX_MOMENTS:
        raise TreeError(
            f"{comb(dimension + order, order)} moments up to order {order}, more than {MAX_MOMENTS}: "
            "ask for a lower order"
        )
    found = [(0,) * dimension]
    for last in found:
        if sum(last) == order:
            break
        # Raising only the last axis used, or a later one, gives each exponent once.
        first = max((axis for axis in range(dimension) if last[axis]), default=0)
        found += [(*last[:axis], last[axis] + 1, *last[axis + 1 :]) for axis in range(first, dimension)]
    return tuple(found)


def cell_integrals(tree: Tree, order: int) -> dict[Exponent, Fraction]:
    """`integral of x^a` over the black cells, the cells being unit cubes, for all |a| up to `order`.

    A word repeated over an aligned block of `2^j` bricks is one piece. With X the corner of the block in
    blocks, t a brick of the block, l a cell of the brick and v in `[0, 1]^k`, a coordinate is
    `x = 2^c X + 2^d t + l + v`, so the integral over a piece is a sum of products of `X^n`, of sums of
    `l^m` over the word, and of integrals that depend on j alone. The first two are summed over all pieces of
    a level by machine integers in several digits, the rest is done once a level in Python's integers. (Guye
    1988, VI.1 and annex 10, carries the moments of each node down the tree instead; its printed formula
    for halves has a factor `(n_(j+1) - 1) / n_(j+1)` that is wrong.)
    """
    found = exponents(tree.dimension, order)
    if isinstance(tree.form, Shared) and (tree.depth > 64 or len(tree.form.lows) <= FEW):
        return node_integrals(tree.form, tree.dimension, found)
    if order > 0 and _word_bits(tree.dimension, order) > WORD_BITS:
        return _by_boxes(tree, order)
    sums, cuts = _pieces(tree, order)
    scale = lcm(*range(1, order + 2))
    total = [0] * len(found)
    for level, table in enumerate(sums):
        if table is not None:
            for a, value in enumerate(_expanded(table, cuts[level].tolist(), tree.dimension, order, scale)):
                total[a] += value
    return {a: Fraction(value, scale**tree.dimension) for a, value in zip(found, total, strict=True)}


def _pieces(tree: Tree, order: int) -> tuple[list[list[list[int]] | None], Int[np.ndarray, "levels dim"]]:
    """`sum of W_m X^n` over the pieces of each level, by n and m; None where the level has no piece."""
    from trees.measures import kernels

    k, found = tree.dimension, exponents(tree.dimension, order)
    levels = max(tree.depth - 6, 0) + 1
    cuts = np.array([[_bits_below(k, axis, 6 + level) for axis in range(k)] for level in range(levels)])
    radix = 42 - max(_word_bits(k, order), 12)
    wide = max(tree.bits - int(cuts[0].min()), 1)
    limbs = -(-order * wide // radix) or 1
    rooms = limbs + -(-(tree.depth + _word_bits(k, order)) // radix) + 1
    parents, axes = _parents(found)
    degrees = np.array([sum(a) for a in found])
    upto = np.searchsorted(degrees, np.arange(order + 1), side="right")
    near = _near(k)
    total = kernels.products(
        tree.starts, tree.words, np.uint64(tree.bricks), _octets(k, order), near, parents, axes, degrees,
        upto, cuts, radix, limbs, rooms,
    )  # fmt: skip
    used = [bool(table.any()) for table in total]
    return [_whole(table, radix) if some else None for table, some in zip(total, used, strict=True)], cuts


def _whole(digits: Int[np.ndarray, "rooms n m"], radix: int) -> list[list[int]]:
    values = digits[-1].astype(object)
    for digit in digits[-2::-1]:
        values = (values << radix) + digit.astype(object)
    return values.tolist()


def _bits_below(k: int, axis: int, depth: int) -> int:
    """How many of the lowest `depth` bits of a key belong to the axis."""
    return (depth + axis) // k


def _parents(found: tuple[Exponent, ...]) -> tuple[Int[np.ndarray, " n"], Int[np.ndarray, " n"]]:
    places = {a: n for n, a in enumerate(found)}
    parents, axes = np.zeros(len(found), np.int64), np.zeros(len(found), np.int64)
    for n, a in enumerate(found[1:], 1):
        axis = next(i for i, e in enumerate(a) if e)
        parents[n], axes[n] = places[(*a[:axis], a[axis] - 1, *a[axis + 1 :])], axis
    return parents, axes


@lru_cache
def _near(k: int) -> UInt64[np.ndarray, "4096 dim"]:
    """The coordinates of the first cells of the first 4096 bricks."""
    numbers = np.arange(4096, dtype=np.uint64)
    cells = np.zeros((len(numbers), k), np.uint64)
    for place in range(6, 18):
        bit = (numbers >> np.uint64(place - 6)) & np.uint64(1)
        cells[:, k - 1 - place % k] |= bit << np.uint64(place // k)
    return cells


def _locals(k: int) -> list[list[int]]:
    """The coordinates of the 64 cells of a word."""
    return [
        [
            sum((b >> place & 1) << (place // k) for place in range(6) if k - 1 - place % k == i)
            for i in range(k)
        ]
        for b in range(64)
    ]


@lru_cache
def _octets(k: int, order: int) -> Int[np.ndarray, "8 256 n"]:
    """`sum of l^m` over the cells of each value of each eight bits of a word."""
    single = np.array(
        [
            [prod(x**e for x, e in zip(cell, a, strict=True)) for a in exponents(k, order)]
            for cell in _locals(k)
        ]
    ).reshape(8, 8, -1)
    bits = (np.arange(256)[:, None] >> np.arange(8)) & 1
    kind = np.int32 if _word_bits(k, order) < 32 else np.int64
    return np.ascontiguousarray(np.einsum("vb,tbm->tvm", bits, single).astype(kind))


@lru_cache
def _word_bits(k: int, order: int) -> int:
    """How wide the largest sum of `l^m` over a word is: that of the axis with most bits."""
    return max(sum(x[-1] ** e for x in _locals(k)) for e in range(order + 1)).bit_length()


@lru_cache
def _terms(k: int, order: int) -> list[tuple[int, int, int]]:
    """The places `(a, n, m)` with `n + m <= a` on every axis."""
    found = exponents(k, order)
    places = {a: n for n, a in enumerate(found)}
    terms = []
    for a in found:
        for n in product(*(range(e + 1) for e in a)):
            for m in product(*(range(e - x + 1) for e, x in zip(a, n, strict=True))):
                terms.append((places[a], places[n], places[m]))
    return terms


def _expanded(table: list[list[int]], cuts: list[int], k: int, order: int, scale: int) -> list[int]:
    """The integrals over the pieces of one level, times `scale` to the power k."""
    found = exponents(k, order)
    factors = [
        _factors(cut, min(_bits_below(k, axis, 6), cut), order, scale) for axis, cut in enumerate(cuts)
    ]
    result = [0] * len(found)
    for a, n, m in _terms(k, order):
        value = table[n][m]
        if value:
            for factor, x, y, z in zip(factors, found[a], found[n], found[m], strict=True):
                value *= factor[x][y][z]
            result[a] += value
    return result


@lru_cache(maxsize=1024)
def _factors(cut: int, inside: int, order: int, scale: int) -> list[list[list[int]]]:
    """What `X^n l^m` is multiplied by in the integral of `x^a`, by a, n, m, times `scale`."""
    steps = _power_sums(2 ** (cut - inside), order)
    free = [
        sum(comb(s, i) * 2 ** (inside * i) * steps[i] * scale // (s - i + 1) for i in range(s + 1))
        for s in range(order + 1)
    ]
    return [
        [
            [
                factorial(a) // (factorial(n) * factorial(m) * factorial(a - n - m))
                * 2 ** (cut * n) * free[a - n - m]
                for m in range(a - n + 1)
            ]
            for n in range(a + 1)
        ]
        for a in range(order + 1)
    ]  # fmt: skip


def _power_sums(stop: int, order: int) -> list[int]:
    """`P_i = sum of t^i`, t from 0 to before `stop`: `(i + 1) P_i = stop^(i+1) - sum C(i+1, j) P_j`."""
    sums: list[int] = []
    for i in range(order + 1):
        sums.append((stop ** (i + 1) - sum(comb(i + 1, j) * sums[j] for j in range(i))) // (i + 1))
    return sums


def _by_boxes(tree: Tree, order: int) -> dict[Exponent, Fraction]:
    """The same box by box, in Python's integers: for orders whose sums over a word are too wide."""
    from trees.leaves import leaf_runs
    from trees.morton import cells_of_keys

    first, last = leaf_runs(tree, 1)
    lows = cells_of_keys(first, tree.dimension, tree.bits).astype(object)
    highs = cells_of_keys(last, tree.dimension, tree.bits).astype(object) + 1
    found = {}
    for a in exponents(tree.dimension, order):
        values = np.ones(len(lows), dtype=object)
        for axis, e in enumerate(a):
            values = values * (highs[:, axis] ** (e + 1) - lows[:, axis] ** (e + 1))
        found[a] = Fraction(int(values.sum()), prod(e + 1 for e in a))
    return found
