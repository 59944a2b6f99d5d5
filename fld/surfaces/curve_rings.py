"""The ring on one side of a point of a curve, and the parameters of points."""

from collections.abc import Mapping, Sequence

import numpy as np

from fld.curve import fixed_point
from fld.surfaces.rings import Ground, Ring
from ifs.system import Operator


def curve_ring(
    ground: Ground,
    operators: Mapping[str, Operator],
    parts: Mapping[str, float],
    word: Sequence[str],
    repeat: Sequence[str],
    which: str,
) -> Ring | None:
    """The ring on one side ("left" or "right") of the point `word repeat repeat ...` of a curve.

    `operators` and `parts`, by label, come in the order along the curve. None where no piece lies on that
    side of the point within the piece `word`.
    """
    labels = list(operators)
    cell, place = ground.system.shape, parameter(parts, (), repeat)
    cycle, done, pieces, places = np.eye(ground.system.states[cell].points), [], [], []
    whole = 1 - place if which == "right" else place
    for label in repeat:
        here = labels.index(label)
        for other in labels[here + 1 :] if which == "right" else labels[:here]:
            offset, slope = _composed(parts, (*done, other))
            pieces.append((cycle @ operators[other], cell))
            ends = (offset - place, slope) if which == "right" else (place - offset, -slope)
            places.append((ends[0] / whole, ends[1] / whole))
        cycle, done = cycle @ operators[label], [*done, label]
    if not pieces:
        return None
    far = fixed_point(operators[labels[-1 if which == "right" else 0]])
    return Ring(
        ground,
        cell,
        tuple(operators[label] for label in word),
        cycle,
        tuple(pieces),
        fixed_point(cycle),
        far,
        whole * _composed(parts, word)[1],
        _composed(parts, repeat)[1],
        places=tuple(places),
    )


def parameter(parts: Mapping[str, float], word: Sequence[str], repeat: Sequence[str]) -> float:
    """The place in [0, 1] of `word repeat repeat ...` under `tau_i(t) = r_i t + sum of the r_j before i`."""
    if set(repeat) == {list(parts)[-1]}:
        place = 1.0
    else:
        offset, slope = _composed(parts, repeat)
        place = offset / (1 - slope)
    offset, slope = _composed(parts, word)
    return offset + slope * place


def _composed(parts: Mapping[str, float], labels: Sequence[str]) -> tuple[float, float]:
    """`tau_w1 ... tau_wp` as `offset + slope t`."""
    starts = {}
    start = 0.0
    for label, part in parts.items():
        starts[label] = start
        start += part
    offset, slope = 0.0, 1.0
    for label in labels:
        offset, slope = offset + slope * starts[label], slope * parts[label]
    return offset, slope
