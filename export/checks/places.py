"""Vertices at equal positions."""

import numpy as np
from jaxtyping import Float, Int

MIX = (0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9)


def representatives(
    points: Float[np.ndarray, "vertices 3"], triangles: Int[np.ndarray, "t 3"]
) -> Int[np.ndarray, "vertices"]:
    """For each used vertex the first used one at its position: where it is another one, sheets touch.

    >>> points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [-0.0, 0, 0]])
    >>> representatives(points, np.array([[0, 1, 2], [3, 2, 1]])).tolist()
    [0, 1, 2, 0]
    """
    used = np.zeros(len(points), dtype=bool)
    used[triangles.ravel()] = True
    number = np.flatnonzero(used)
    # equal positions have equal sums of mixed bits; only the few with equal sums are sorted as positions
    bits = (points[number] + 0.0).view(np.uint64)
    keys = np.zeros(len(number), dtype=np.uint64)
    for axis in range(3):
        keys ^= (bits[:, axis] ^ (bits[:, axis] >> np.uint64(29))) * np.uint64(MIX[axis])
        keys ^= keys >> np.uint64(31)
    values = np.sort(keys)
    again = values[1:][values[1:] == values[:-1]]
    result = np.arange(len(points))
    if not len(again):
        return result
    number = number[np.isin(keys, np.unique(again))]
    found = points[number] + 0.0
    order = np.lexsort((number, *found.T))
    new = np.concatenate([[True], (found[order[1:]] != found[order[:-1]]).any(axis=1)])
    first = number[order][new]
    result[number[order]] = first[np.cumsum(new) - 1]
    return result
