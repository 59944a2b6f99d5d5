"""A part of a complex: some of its pieces, with their boundaries of every dimension."""

from collections.abc import Mapping

import numpy as np
from jaxtyping import Int

from ifs.complex import Complex, Seen

Ids = Int[np.ndarray, "_cells"]


def subcomplex(complex_: Complex, pieces: Mapping[str, Ids]) -> tuple[Complex, dict[str, Ids]]:
    """The complex of the pieces with these numbers, and what the number of each of its cells was.

    Pieces keep the order in which they are given; boundary cells that they share stay shared.

    >>> import ifs
    >>> curve = ifs.shape("corner-cutting")
    >>> fine = ifs.refined(ifs.initial(curve.topology, curve.system, curve.control), 3)
    >>> half, was = subcomplex(fine, {"edge": np.arange(4)})
    >>> half.counts["edge"], half.counts["vertex"], len(was["vertex"])
    (4, 5, 5)
    """
    was = _with_boundaries(complex_, pieces)
    number = {cell: np.full(count, -1) for cell, count in complex_.counts.items()}
    for cell, ids in was.items():
        number[cell][ids] = np.arange(len(ids))
    cells = complex_.topology.automaton.cells
    boundary = {
        cell: {
            label: Seen(number[cells[cell].boundary[label].cell][seen.ids[ids]], seen.turn[ids])
            for label, seen in complex_.boundary.get(cell, {}).items()
        }
        for cell, ids in was.items()
    }
    control = {cell: complex_.control[cell][ids] for cell, ids in pieces.items() if len(ids)}
    counts = {cell: len(ids) for cell, ids in was.items()}
    return Complex(complex_.topology, complex_.system, counts, boundary, control), was


def _with_boundaries(complex_: Complex, pieces: Mapping[str, Ids]) -> dict[str, Ids]:
    """The cells among some pieces and their boundaries, the pieces first; none that are empty."""
    used = {cell: np.zeros(count, dtype=bool) for cell, count in complex_.counts.items()}
    waiting = list(pieces.items())
    while waiting:
        cell, ids = waiting.pop()
        ids = np.unique(ids[~used[cell][ids]])
        used[cell][ids] = True
        if len(ids):
            for label, border in complex_.topology.automaton.cells[cell].boundary.items():
                waiting.append((border.cell, complex_.boundary[cell][label].ids[ids]))
    found = {}
    for cell, flags in used.items():
        first = pieces.get(cell, np.arange(0))
        flags[first] = False
        found[cell] = np.concatenate([first, np.flatnonzero(flags)])
    return {cell: ids for cell, ids in found.items() if len(ids)}
