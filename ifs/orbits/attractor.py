"""All pieces of an attractor to a depth or a size, and a point in each of them, in chunks of bounded size."""

from collections.abc import Iterator
from math import sqrt

import numpy as np
from jaxtyping import Float

from ifs.asked import require_shape
from ifs.certificates.bounds import sample
from ifs.pieces import Pieces, pieces
from ifs.shape import Shape

CHUNK = 1 << 14


def pieces_in_chunks(
    shape: Shape, depth: int | None = None, tolerance: float | None = None, most: int = CHUNK
) -> Iterator[Pieces]:
    """The pieces of a shape, at most `most` at a time, with boxes certain to contain them (mm).

    With `depth` each piece is subdivided that many times. With `tolerance` each is subdivided until its box
    has sides of at most `tolerance / sqrt(dim)`, so that its diameter is certain to be below the tolerance;
    the diameters may be smaller than need be, by that factor. Memory stays in proportion to `most`. Raises
    what `ifs.pieces` raises.

    >>> from ifs.shape import shape
    >>> sum(len(found.control) for found in pieces_in_chunks(shape("koch-curve"), depth=5, most=100))
    1024
    """
    require_shape(shape)
    if tolerance is not None and not tolerance > 0:
        raise ValueError(f"the tolerance is a length above 0 mm, found {tolerance}")
    size = None if tolerance is None else tolerance / sqrt(shape.control.shape[1])
    return _parted(pieces(shape.system, shape.control, size=size, depth=depth, chunk=most), most)


def points_in_chunks(
    shape: Shape, depth: int | None = None, tolerance: float | None = None, most: int = CHUNK
) -> Iterator[Float[np.ndarray, "_points dim"]]:
    """A point of the attractor in each of the pieces of `pieces_in_chunks`, in mm.

    It is that of the address which takes first labels for ever (`ifs.sample`), exact to rounding. With
    `tolerance`, every point of the attractor is within the tolerance of one of these.

    >>> from ifs.shape import shape
    >>> sum(len(found) for found in points_in_chunks(shape("sierpinski-triangle"), tolerance=10.0))
    81
    """
    columns = sample(shape.system)
    for found in pieces_in_chunks(shape, depth, tolerance, most):
        yield np.einsum("p,npd->nd", columns[found.cell], found.control)


def _parted(found: Iterator[Pieces], most: int) -> Iterator[Pieces]:
    for each in found:
        for start in range(0, len(each.control), most):
            part = slice(start, start + most)
            yield Pieces(each.cell, each.control[part], each.lo[part], each.hi[part], each.done)
