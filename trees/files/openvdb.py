"""Trees of dimension 3 as OpenVDB grids: the set is what is active.

A black cube of 8, 128 or 4096 cells, where OpenVDB has a node for it, is one tile. Voxels are at whole
indices, so index (0, 0, 0) lies at the centre of the first cell.
"""

import hashlib
import os
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Int64, UInt64

from trees.cells import to_morton
from trees.cube import Cube, smallest_cube
from trees.errors import DamagedFile, TooManyPieces, TreeError
from trees.files.openvdb_nodes import SEAL, Nodes, write_nodes
from trees.files.openvdb_reader import Grid, read_grid
from trees.files.whole import written_whole
from trees.morton import cells_of_keys, check_widths, keys_of_cells
from trees.runs import Runs, embed, tree_of_runs
from trees.tree import Tree, empty

MAX_NODES = 2**25


def write_vdb(tree: Tree, path: str | os.PathLike[str], name: str = "black") -> None:
    """Write a fog volume of floats, 1 in the active voxels and tiles of the set, 0 elsewhere.

    The metadata entry "cube" keeps bits, size and origin exactly, that of the file the SHA-256 of
    all after it.

    Raises `TreeError` where the dimension is not 3, `TooManyPieces` above 2^25 nodes or tiles.
    """
    if tree.dimension != 3:
        raise TreeError(f"an OpenVDB grid of dimension {tree.dimension}: it has 3")
    if tree.depth > 63:
        raise TreeError(f"{tree.bits} bits an axis: an OpenVDB grid can have 21 here")
    facts = {"class": "fog volume", "name": name, "units": "mm", "cube": _place(tree.cube, tree.bits)}
    nodes = nodes_of(tree)
    place = tuple(x + tree.cell_size / 2 for x in tree.origin)
    with written_whole(path) as unfinished, open(unfinished, "wb+") as file:
        write_nodes(file, nodes, place, tree.cell_size, facts, name)


def read_vdb(path: str | os.PathLike[str], name: str | None = None) -> Tree:
    """The set of the active voxels and tiles of a grid of any file of format 222 to 224.

    The grid is that of this name, else the first. Grids of floats, integers and Booleans are read, with
    one scale for all axes. Where the file was not written here, the cube is the smallest one of size 2^n
    voxels at a multiple of its size (or centred at index 0) that holds all that is active.

    Raises `DamagedFile` where the file is no such file, or was written here and changed or cut; others'
    files have no checksum. Raises `TreeError` for other grids, `TooManyPieces` above 2^25 nodes or tiles.
    """
    data = Path(path).read_bytes()
    end = len(SEAL) + 64
    try:
        if data.startswith(SEAL) and data[len(SEAL) : end] != hashlib.sha256(data[end:]).hexdigest().encode():
            raise DamagedFile("the checksum does not agree: the file was changed or cut")
        return _tree_of(read_grid(data, name))
    except DamagedFile as error:
        raise DamagedFile(f"{os.fspath(path)}: {error}") from error


def nodes_of(tree: Tree) -> Nodes:
    """The leaves and tiles of the grid: cubes that meet the set without being full, and full ones."""
    if tree.bits < 3:
        tree = embed(tree, Cube(tree.origin, tree.size * 2 ** (3 - tree.bits)))
    eights = _full(tree, 3)
    blocks = _full(eights, 4)
    roots = _full(blocks, 5)
    kinds = [tree.at(tree.bits - 3) - eights, eights - blocks, blocks - roots, roots]
    count = sum(kind.count for kind in kinds)
    if count > MAX_NODES:
        raise TooManyPieces(count, MAX_NODES)
    keys = to_morton(kinds[0])
    corners = [_corners(kind, tree.bits) for kind in kinds]
    return Nodes(corners[0], _masks(tree, keys), *corners[1:])


def _full(tree: Tree, steps: int) -> Tree:
    """The cells of a grid `2^steps` times coarser that the set fills; none where there is no such grid."""
    if tree.bits < steps:
        return empty(tree.cube, 0)
    return ~(~tree).at(tree.bits - steps)


def _corners(tree: Tree, bits: int) -> Int64[np.ndarray, "cells 3"]:
    cells = (
        cells_of_keys(to_morton(tree), 3, tree.bits) if tree.bits else np.zeros((tree.count, 3), np.uint64)
    )
    return cells.astype(np.int64) << (bits - tree.bits)


def _masks(tree: Tree, keys: UInt64[np.ndarray, " leaves"]) -> Bool[np.ndarray, "leaves 8 8 8"]:
    """The cells of cubes of 8 cells a side, each of 8 bricks, as arrays."""
    found = np.zeros((len(keys), 512), dtype=bool)
    for begin in range(0, len(keys), 2**16):
        bricks = (keys[begin : begin + 2**16, None] << np.uint64(3)) | np.arange(8, dtype=np.uint64)
        entries = np.searchsorted(tree.starts, bricks, side="right") - 1
        octets = tree.words[entries].astype("<u8").view(np.uint8)
        found[begin : begin + 2**16, _places()] = np.unpackbits(octets, axis=1, bitorder="little")
    return found.reshape(-1, 8, 8, 8)


def _places() -> Int64[np.ndarray, "512"]:
    """Where the cell of each Morton key stands in an array [x, y, z] of 8^3."""
    cells = cells_of_keys(np.arange(512, dtype=np.uint64), 3, 3).astype(np.int64)
    return cells @ np.array([64, 8, 1])


def _place(cube: Cube, bits: int) -> str:
    return " ".join([str(bits), *(float.hex(x) for x in (cube.size, *cube.origin))])


def _tree_of(grid: Grid) -> Tree:
    used = grid.masks.any(axis=1)
    leaves, masks = grid.leaves[used], grid.masks[used]
    corners = [leaves, *grid.tiles.values()]
    sides = np.repeat([8, *grid.tiles], [len(c) for c in corners])
    every = np.concatenate(corners)
    if len(every) > MAX_NODES:
        raise TooManyPieces(len(every), MAX_NODES)
    if not len(every):
        cube, bits = _stored(grid) or (_moved(Cube((0.0,) * 3, 1.0), grid), 0)
        return empty(cube, bits)
    lows, highs = every.min(axis=0), (every + sides[:, None] - 1).max(axis=0)
    if (found := _stored(grid)) and lows.min() >= 0 and highs.max() < 2 ** max(found[1], 3):
        cube, bits = found
        base = np.zeros(3, dtype=np.int64)
    else:
        voxels = smallest_cube(tuple(lows.astype(float).tolist()), tuple(highs.astype(float).tolist()))
        base, bits = np.array(voxels.origin).astype(np.int64), int(voxels.size).bit_length() - 1
        cube = _moved(voxels, grid)
    check_widths(3, bits)
    keys = keys_of_cells(every - base, max(bits, 3))
    tiles, first = slice(len(leaves), None), _leaf_runs(keys[: len(leaves)], masks)
    wide = sides[tiles].astype(np.uint64) ** np.uint64(3) - np.uint64(1)
    low = np.concatenate([first[0], keys[tiles]])
    high = np.concatenate([first[1], keys[tiles] | wide])
    order = np.argsort(low)
    low, high = low[order], high[order]
    if (low[1:] <= high[:-1]).any() or int(high[-1]) >= 2 ** (3 * bits):
        raise DamagedFile("two nodes in one place, or voxels outside the cube")
    return tree_of_runs((low, high), cube, bits)


def _leaf_runs(keys: UInt64[np.ndarray, " leaves"], masks: Bool[np.ndarray, "leaves 512"]) -> Runs:
    """The runs of active voxels of leaves whose first Morton keys these are."""
    lows, highs = [np.zeros(0, dtype=np.uint64)], [np.zeros(0, dtype=np.uint64)]
    for begin in range(0, len(keys), 2**14):
        some = keys[begin : begin + 2**14]
        flags = np.zeros((len(some), 514), dtype=np.int8)
        flags[:, 1:-1] = masks[begin : begin + 2**14, _places()]
        change = np.diff(flags, axis=1)
        for found, sign in ((lows, 1), (highs, -1)):
            leaf, place = np.nonzero(change == sign)
            found.append(some[leaf] + (place - (sign < 0)).astype(np.uint64))
    return np.concatenate(lows), np.concatenate(highs)


def _stored(grid: Grid) -> tuple[Cube, int] | None:
    """The cube and the bits of the metadata, None where they are not, or where the grid was moved since."""
    try:
        first, *rest = grid.facts["cube"].split()
        size, *origin = map(float.fromhex, rest)
        cube, bits = Cube(tuple(origin), size), int(first)
    except (KeyError, ValueError, OverflowError):
        return None
    if cube.dimension != 3 or not 0 <= bits <= 21:
        return None
    pitch = cube.size / 2**bits
    here = pitch == grid.pitch and tuple(x + pitch / 2 for x in cube.origin) == grid.place
    return (cube, bits) if here else None


def _moved(voxels: Cube, grid: Grid) -> Cube:
    """A cube in mm, from one in voxels."""
    corner = tuple(x + grid.pitch * (a - 0.5) for x, a in zip(grid.place, voxels.origin, strict=True))
    return Cube(corner, grid.pitch * voxels.size)
