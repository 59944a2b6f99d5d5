"""On which side of a hyperplane a part of a curve lies, with proof."""

import numpy as np

from fld.pieces import MOST, Pieces

_MARGIN = 1e-10
_LEVELS = 24


def side(pieces: Pieces) -> int | None:
    """The sign of the one coordinate of pieces, over all their points.

    1 or -1 when one strict sign is proven for all, 0 when there are proven points of both signs, None when it
    stays open: the value comes within 1e-10 (of the largest entry of a piece's row) to 0 without changing
    sign, or the refinement is not deep enough to tell. Raises what `ifs.bounds` raises.
    """
    sizes = np.abs(pieces.matrices).max(axis=(1, 2))
    if not (sizes > 0).all():
        return None
    pieces = Pieces(
        pieces.curve, pieces.parts, pieces.matrices / sizes[:, None, None], pieces.offsets, pieces.sizes
    )
    signs: set[int] = set()
    for _ in range(_LEVELS):
        lo, hi = (end[:, 0] for end in pieces.boxes())
        signs |= {1} if (lo > _MARGIN).any() else set()
        signs |= {-1} if (hi < -_MARGIN).any() else set()
        if len(signs) == 2:
            return 0
        pieces = pieces.chosen((lo <= _MARGIN) & (hi >= -_MARGIN))
        if len(pieces) == 0:
            return signs.pop()
        if len(pieces) * len(pieces.curve.labels) > MOST:
            return None
        pieces = pieces.divided()
    return None
