"""Trees of points in mm, in a reference cube that grows to hold them."""

from fractions import Fraction

import numpy as np
from jaxtyping import Float, UInt64

from trees.cells import from_points
from trees.cube import Cube, common_cube, log2_ratio, smallest_cube
from trees.doors import Rows, point_rows, whole
from trees.errors import TreeError
from trees.shared import check_depth
from trees.tree import Tree

MOST_BITS = 62


def from_reals(points: Rows, bits: int, cube: Cube | None = None) -> Tree:
    """The cells that hold these points, in mm (Guye 1988, III.5, "calculs en limite inductive").

    Without a cube the reference cube is `smallest_cube` of the points, cut into `2^bits` cells an axis.
    With one, the cells are those of that cube; where a point lies outside, the cube grows to the
    `common_cube` of itself and the cells of the points, and the bits grow with it.

    A cube grows only to corners that are floats: multiples of 1/1024 mm do, most decimal ones do not.

    Raises `TreeError` where a coordinate is not finite (with row and axis), where there is neither
    point nor cube, or above 62 bits an axis.

    >>> from_reals([[0.5, 0.5], [2.5, 0.5]], bits=1, cube=Cube((0.0, 0.0), 1.0))
    <Tree: dimension 2, 3 bits an axis, 2 cells, cube of 4.0 at (0.0, 0.0)>
    """
    rows, bits = point_rows(points, None if cube is None else cube.dimension), whole(bits, "bits")
    if not np.isfinite(rows).all():
        row, axis = np.argwhere(~np.isfinite(rows))[0].tolist()
        raise TreeError(f"point {row}: coordinate {rows[row, axis]} on axis {axis} is not finite")
    check_depth(rows.shape[1], bits)
    if cube is not None and cube.dimension != rows.shape[1]:
        raise TreeError(f"a cube of dimension {cube.dimension} for points of dimension {rows.shape[1]}")
    if len(rows) == 0 and cube is None:
        raise TreeError("no points, and no cube: give one of them")
    low, high = (tuple(f.tolist()) for f in (rows.min(0), rows.max(0))) if len(rows) else ((), ())
    outer = cube or smallest_cube(low, high)
    if cube is not None and len(rows):
        outer = _grown(cube, low, high)
        growth = log2_ratio(Fraction(outer.size), Fraction(cube.size))
        assert growth is not None
        bits += growth
    if bits > MOST_BITS:
        raise TreeError(f"{bits} bits an axis: points in mm have at most {MOST_BITS}")
    return from_points(cells_of_points(rows, outer, bits), bits, outer)


def cells_of_points(
    points: Float[np.ndarray, "points dim"], cube: Cube, bits: int
) -> UInt64[np.ndarray, "points dim"]:
    """The cells of points of the cube: `floor((x - origin) / cell)`, corrected where x - origin rounds."""
    origin, width = np.array(cube.origin), cube.size / 2**bits
    cells = np.clip(np.floor((points - origin) / width), 0, 2**bits - 1)
    cells -= origin + cells * width > points
    cells += origin + (cells + 1) * width <= points
    # 2^bits - 1 is no float above 53 bits: the minimum is taken among integers.
    return np.minimum(np.maximum(cells, 0).astype(np.uint64), np.uint64(2**bits - 1))


def exact_cells(points: Float[np.ndarray, "points dim"], cube: Cube, bits: int) -> list[tuple[int, ...]]:
    """The cells of points of the cube, in fractions: for cells of any number of bits.

    >>> exact_cells(np.array([[0.5, 0.25]]), Cube((0.0, 0.0), 1.0), 70) == [(2**69, 2**68)]
    True
    """
    width = Fraction(cube.size) / 2**bits
    return [
        tuple(int((Fraction(x) - Fraction(a)) // width) for x, a in zip(point, cube.origin, strict=True))
        for point in points.tolist()
    ]


def _grown(cube: Cube, low: tuple[float, ...], high: tuple[float, ...]) -> Cube:
    """The cube, or the common cube of it and the cubes of its size that hold the two corners."""
    whole = cube
    for corner in (low, high):
        origin = []
        for x, start in zip(corner, cube.origin, strict=True):
            size = Fraction(cube.size)
            origin.append(Fraction(start) + (Fraction(x) - Fraction(start)) // size * size)
        tile = Cube(tuple(float(x) for x in origin), cube.size)
        if [Fraction(x) for x in tile.origin] != origin:
            raise TreeError(
                f"the cube next to {cube} that holds {corner} has corners that are no floats: "
                "give a cube whose corners have few binary digits, such as multiples of 1/1024"
            )
        whole = common_cube(whole, tile)
    return whole
