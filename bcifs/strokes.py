"""Segments joined into strokes."""

from collections import defaultdict

import numpy as np
from jaxtyping import Int


def strokes(segments: Int[np.ndarray, "segments 2"]) -> list[Int[np.ndarray, "vertices"]]:
    """The segments (pairs of vertex numbers) as few long lines: each runs on while just two segments meet.

    A closed line ends where it begins. Every segment is in one stroke, once.

    >>> [stroke.tolist() for stroke in strokes(np.array([[2, 1], [0, 1], [2, 3]]))]
    [[0, 1, 2, 3]]
    """
    meeting: dict[int, list[int]] = defaultdict(list)
    ends = segments.tolist()
    for number, (first, last) in enumerate(ends):
        meeting[first].append(number)
        meeting[last].append(number)
    left = set(range(len(ends)))
    starts = [number for number, pair in enumerate(ends) if any(len(meeting[v]) != 2 for v in pair)]
    result = []
    for number in [*starts, *range(len(ends))]:
        if number not in left:
            continue
        first, last = ends[number]
        if len(meeting[first]) == 2 and len(meeting[last]) != 2:
            first, last = last, first
        result.append(np.array(_walk(ends, meeting, left, number, first, last)))
    return sorted(result, key=lambda stroke: stroke.tolist()[:2])


def _walk(
    ends: list[list[int]], meeting: dict[int, list[int]], left: set[int], number: int, first: int, last: int
) -> list[int]:
    """The vertices from `first` over `last` until a free end, a crossing, or a segment that was walked."""
    left.discard(number)
    stroke = [first, last]
    while len(meeting[stroke[-1]]) == 2:
        here = stroke[-1]
        ahead = next((n for n in meeting[here] if n in left), None)
        if ahead is None:
            break
        left.discard(ahead)
        one, other = ends[ahead]
        stroke.append(other if one == here else one)
    return stroke
