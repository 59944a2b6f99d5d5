"""On which side of a hyperplane a part of a curve lies, with proof."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from fld.curve import Curve
from ifs import extent

_MARGIN = 1e-10
_LEVELS = 24
_PIECES = 20_000

Row = Float[np.ndarray, "points"]


def side(curve: Curve, row: Row, pieces: Sequence[Float[np.ndarray, "points points"]]) -> int | None:
    """The sign of `row p` over all points p of the pieces `T A` of the attractor A, T in `pieces`.

    1 or -1 when one strict sign is proven for all, 0 when there are proven points of both signs, None when it
    stays open: the value comes within 1e-10 (of the largest entry of `row`) to 0 without changing sign, or
    the refinement is not deep enough to tell. Raises what `ifs.bounds` raises.
    """
    rows = np.array([row @ piece for piece in pieces]) / np.abs(row).max()
    steps = np.stack(curve.operators)
    signs: set[int] = set()
    for _ in range(_LEVELS):
        lo, hi = (end[:, 0] for end in extent(curve.box, rows[:, :, None]))
        signs |= {1} if (lo > _MARGIN).any() else set()
        signs |= {-1} if (hi < -_MARGIN).any() else set()
        if len(signs) == 2:
            return 0
        rows = rows[(lo <= _MARGIN) & (hi >= -_MARGIN)]
        if len(rows) == 0:
            return signs.pop()
        if len(rows) * len(steps) > _PIECES:
            return None
        rows = np.einsum("rj,ljk->rlk", rows, steps).reshape(-1, rows.shape[1])
    return None
