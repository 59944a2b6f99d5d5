"""Where something is: the components of a set with their volumes and boxes in millimetres."""

from dataclasses import dataclass

import numpy as np

from export.printable.frame import mm_of
from trees import Tree
from trees.leaves import leaf_runs
from trees.morton import cells_of_keys
from trees.topology import Components, components


@dataclass(frozen=True)
class Region:
    """A connected set of cells: volume in mm^3; centre of gravity, and box from low to high, in mm."""

    volume: float
    centre: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]


def regions(found: Components) -> tuple[Region, ...]:
    """The components as regions, in their order: from the largest on.

    The centre of gravity need not lie in the region. Numbers are exact up to rounding of floats.

    >>> from trees import from_points
    >>> from trees.topology import components
    >>> regions(components(from_points([[0, 0, 0], [1, 0, 0]], bits=2)))[0].centre
    (0.25, 0.125, 0.125)
    """
    tree = found.tree
    if not len(found):
        return ()
    first, last = leaf_runs(tree, tree.dimension)
    labels = found.labels_of_leaves()
    order = np.argsort(labels, kind="stable")
    order = order[labels[order] >= 0]
    begins = np.searchsorted(labels[order], np.arange(len(found)))
    low = cells_of_keys(first[order], tree.dimension, tree.bits).astype(np.float64)
    high = cells_of_keys(last[order], tree.dimension, tree.bits).astype(np.float64) + 1
    counts = (high - low).prod(axis=1)
    moments = np.add.reduceat((low + high) / 2 * counts[:, None], begins)
    centres = mm_of(tree, moments / np.add.reduceat(counts, begins)[:, None])
    lows = mm_of(tree, np.minimum.reduceat(low, begins))
    highs = mm_of(tree, np.maximum.reduceat(high, begins))
    volumes = found.sizes.astype(np.float64) * tree.cell_size**tree.dimension
    rows = zip(volumes.tolist(), centres.tolist(), lows.tolist(), highs.tolist(), strict=True)
    return tuple(Region(volume, tuple(a), tuple(b), tuple(c)) for volume, a, b, c in rows)


def regions_of(tree: Tree) -> tuple[Region, ...]:
    """The regions of a set, whose cells touch where they share a corner."""
    return regions(components(tree, "d-infinity"))
