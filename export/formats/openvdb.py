"""OpenVDB fog volumes of dense grids: the nodes of `trees.files`, with values."""

from collections.abc import Mapping
from typing import BinaryIO

import numpy as np
from jaxtyping import Float

from trees.files.openvdb_nodes import Nodes, write_nodes

LEAF = 8


def write_grid(
    file: BinaryIO,
    values: Float[np.ndarray, "x y z"],
    origin: Float[np.ndarray, "3"],
    pitch: float,
    recipe: Mapping[str, str],
    name: str,
) -> None:
    """Write a fog volume. Voxels that hold 0 are left out: 0 is the background, the others are active.

    OpenVDB's samples lie at whole indices, so index (0, 0, 0) is placed at the centre of the first cell.
    `file` can be read and sought.
    """
    nodes = _nodes(np.asarray(values, dtype=np.float32))
    facts = {"class": "fog volume", "name": name, "units": "mm"}
    facts |= {f"bcifs:{key}": value for key, value in recipe.items()}
    write_nodes(file, nodes, tuple((origin + pitch / 2).tolist()), pitch, facts, name)


def _nodes(values: Float[np.ndarray, "x y z"]) -> Nodes:
    """Leaves alone: the blocks of 8 voxels a side that hold something."""
    padded = np.pad(values, [(0, -size % LEAF) for size in values.shape])
    x, y, z = (size // LEAF for size in padded.shape)
    blocks = padded.reshape(x, LEAF, y, LEAF, z, LEAF).transpose(0, 2, 4, 1, 3, 5)
    corners = np.argwhere(blocks.any(axis=(3, 4, 5)))
    leaves = blocks[tuple(corners.T)]
    masks = leaves != 0
    none = np.zeros((0, 3), dtype=np.int64)
    return Nodes(corners.astype(np.int64) * LEAF, masks, none, none, none, leaves[masks])
