"""VTK's HyperTreeGrid: a 2^k-tree, k from 1 to 3, as one tree of branch factor 2.

Child j of a node in VTK lies, on axis i, at bit i of j: axis 0 is lowest there, and highest in a Morton key.
VTK numbers the nodes level by level, the families in the order of their parents.
"""

import hashlib
import os
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool, UInt64

from trees.cube import Cube
from trees.errors import DamagedFile, TooManyPieces, TreeError
from trees.files.whole import written_whole
from trees.leaves import leaf_runs
from trees.morton import cells_of_keys, check_widths, keys_of_cells
from trees.runs import black_runs, tree_of_runs
from trees.tree import Tree

MAX_NODES = 2**25
NAME, PLACE = "black", "cube"
SEAL = b"<!-- SHA-256 of all below: "

# Of each level: the keys of its nodes in VTK's order of axes, which of them have children, which are black.
Levels = list[tuple[UInt64[np.ndarray, " _nodes"], Bool[np.ndarray, " _nodes"], Bool[np.ndarray, " _nodes"]]]


def write_hypertree_grid(tree: Tree, path: str | os.PathLike[str]) -> None:
    """Write a `.htg` file of VTK, whose cell array "black" is 1 where a node meets the set.

    Seen to some depth only, the array then shows the upper envelope, as `tree.at` does. The field data
    array "cube" keeps bits, size and origin exactly; the first line is a comment with the SHA-256 of
    the rest.

    Raises `TreeError` above dimension 3, `TooManyPieces` above 2^25 nodes.
    """
    from vtkmodules.vtkIOXML import vtkXMLHyperTreeGridWriter

    if tree.dimension > 3:
        raise TreeError(f"a HyperTreeGrid of dimension {tree.dimension}: VTK has 1 to 3")
    levels = _levels_of(tree)
    writer = vtkXMLHyperTreeGridWriter()
    writer.SetInputData(_grid(tree, levels))
    writer.SetDataModeToAppended()
    writer.EncodeAppendedDataOff()
    writer.SetHeaderTypeToUInt64()
    with written_whole(path) as unfinished:
        writer.SetFileName(os.fspath(unfinished))
        if writer.Write() != 1:
            raise OSError(f"VTK could not write {os.fspath(path)}")
        body = unfinished.read_bytes()
        unfinished.write_bytes(_seal(body) + body)


def read_hypertree_grid(path: str | os.PathLike[str]) -> Tree:
    """The set of a `.htg` file of one tree: its leaves where the cell array "black" is not 0.

    Without that array, the set is all leaves that are not masked. Where the file was not written here, the
    cube is that of the coordinates, and its bits are the levels of the tree.

    Raises `DamagedFile` where VTK cannot read the file, or where its checksum is wrong. Files that others
    wrote have no checksum: a damaged one may end the process, for VTK does not check it. Raises `TreeError`
    where a grid has several trees, another branch factor than 2, or unequal sides, and `TooManyPieces` above
    2^25 nodes.
    """
    data = Path(path).read_bytes()
    if not data.rstrip().endswith(b"</VTKFile>"):
        raise DamagedFile(f"{os.fspath(path)}: it does not end as files of VTK do")
    body = data[len(_seal(b"")) :]
    if data.startswith(SEAL) and data != _seal(body) + body:
        raise DamagedFile(f"{os.fspath(path)}: the checksum does not agree: the file was changed or cut")
    try:
        return _tree_of(_read(path))
    except DamagedFile as error:
        raise DamagedFile(f"{os.fspath(path)}: {error}") from error


def _seal(body: bytes) -> bytes:
    return SEAL + hashlib.sha256(body).hexdigest().encode() + b" -->\n"


def _read(path: str | os.PathLike[str]) -> Any:
    """The grid that VTK reads, where it reports no error."""
    from vtkmodules.vtkCommonCore import vtkCommand
    from vtkmodules.vtkIOXML import vtkXMLHyperTreeGridReader

    told: list[str] = []
    reader = vtkXMLHyperTreeGridReader()
    for source in (reader, reader.GetExecutive()):
        source.AddObserver(vtkCommand.ErrorEvent, lambda _, event: told.append(event))
    reader.SetFileName(os.fspath(path))
    reader.Update()
    grid = reader.GetOutput()
    if told or grid.GetMaxNumberOfTrees() < 1 or grid.GetTree(0) is None:
        raise DamagedFile(f"VTK reads no HyperTreeGrid here, and reports {len(told)} errors")
    return grid


def _tree_of(grid: Any) -> Tree:
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkBitArray, vtkIdList, vtkTypeInt64Array

    if grid.GetMaxNumberOfTrees() != 1 or grid.GetBranchFactor() != 2:
        raise TreeError(
            f"a grid of {grid.GetMaxNumberOfTrees()} trees of branch factor {grid.GetBranchFactor()}: "
            "one tree of factor 2 is needed"
        )
    k, held = grid.GetDimension(), grid.GetTree(0)
    nodes = held.GetNumberOfVertices()
    if nodes > MAX_NODES:
        raise TooManyPieces(nodes, MAX_NODES)
    per_level, descriptor, ids = vtkTypeInt64Array(), vtkBitArray(), vtkIdList()
    held.ComputeBreadthFirstOrderDescriptor(
        grid.GetDepthLimiter(), grid.GetMask(), per_level, descriptor, ids
    )
    local = np.array([ids.GetId(i) for i in range(ids.GetNumberOfIds())], dtype=np.int64)
    place = np.array([held.GetGlobalIndexFromLocal(i) for i in local.tolist()], dtype=np.int64)
    split = np.zeros(len(local), dtype=bool)
    inner = descriptor.GetNumberOfTuples()
    split[:inner] = vtk_to_numpy(descriptor)[:inner] != 0
    black = np.ones(len(local), dtype=bool)
    colours, mask = grid.GetCellData().GetArray(NAME), grid.GetMask()
    if colours is not None:
        black = vtk_to_numpy(colours)[place] != 0
    if mask is not None and mask.GetNumberOfTuples():
        black &= np.array([not mask.GetValue(i) for i in place.tolist()], dtype=bool)
    cube, bits = _place(grid, k, per_level.GetNumberOfTuples() - 1)
    counts = [per_level.GetValue(level) for level in range(per_level.GetNumberOfTuples())]
    return _tree_of_levels(counts, split, black, cube, bits)


def _tree_of_levels(
    counts: list[int],
    split: Bool[np.ndarray, " nodes"],
    black: Bool[np.ndarray, " nodes"],
    cube: Cube,
    bits: int,
) -> Tree:
    """The tree of nodes level by level, so many on each, in VTK's order."""
    k = cube.dimension
    check_widths(k, bits)
    keys, begin = np.zeros(1, dtype=np.uint64), 0
    first: list[np.ndarray] = []
    last: list[np.ndarray] = []
    for level, count in enumerate(counts):
        inside = slice(begin, begin + count)
        if count != len(keys) or len(split[inside]) != count:
            raise DamagedFile(f"{count} nodes at level {level}, where {len(keys)} are needed")
        ends = keys[~split[inside] & black[inside]]
        depth = k * (bits - level)
        cells = cells_of_keys(ends, k, level)[:, ::-1] if level else np.zeros((len(ends), k), np.uint64)
        low = keys_of_cells(cells << np.uint64(bits - level), bits) if bits else ends
        first.append(low)
        last.append(low | np.uint64(2**depth - 1))
        keys = (keys[split[inside]][:, None] << np.uint64(k)) | np.arange(2**k, dtype=np.uint64)
        keys, begin = keys.ravel(), begin + count
    low, high = np.concatenate(first), np.concatenate(last)
    order = np.argsort(low)
    return tree_of_runs((low[order], high[order]), cube, bits)


def _place(grid: Any, k: int, levels: int) -> tuple[Cube, int]:
    """The cube and the bits: those that were stored, or else of the coordinates and the levels."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    ends = [vtk_to_numpy(c) for c in (grid.GetXCoordinates(), grid.GetYCoordinates(), grid.GetZCoordinates())]
    if [len(pair) for pair in ends] != [2] * k + [1] * (3 - k):
        raise TreeError(
            f"coordinates {[len(pair) for pair in ends]}: those of one cube on the first axes are needed"
        )
    origin, sizes = [float(pair[0]) for pair in ends[:k]], [float(pair[1] - pair[0]) for pair in ends[:k]]
    stored = grid.GetFieldData().GetArray(PLACE)
    if stored is not None and stored.GetNumberOfValues() == k + 2:
        bits, size, *start = vtk_to_numpy(stored).ravel().tolist()
        if (
            start == origin
            and bits >= levels
            and all(x + size == pair[1] for x, pair in zip(start, ends, strict=False))
        ):
            return Cube(tuple(start), size), int(bits)
    if max(sizes) - min(sizes) > 1e-9 * max(sizes):
        raise TreeError(f"a grid of sides {sizes}: a cube is needed")
    return Cube(tuple(origin), sizes[0]), levels


def _levels_of(tree: Tree) -> Levels:
    """The nodes of each level, in VTK's order."""
    from trees import kernels

    k = tree.dimension
    total = sum(int(kernels.count_blocks(*black_runs(t), k, tree.depth)) for t in (tree, ~tree))
    nodes = total + (total - 1) // (2**k - 1)
    if nodes > MAX_NODES:
        raise TooManyPieces(nodes, MAX_NODES)
    blocks = [leaf_runs(t, k) for t in (tree, ~tree)]
    first, last = (np.concatenate(part) for part in zip(*blocks, strict=True))
    black = np.arange(total) < len(blocks[0][0])
    level = (tree.depth - np.bitwise_count(last - first).astype(np.int64)) // k
    keys = keys_of_cells(cells_of_keys(first, k, tree.bits)[:, ::-1], tree.bits)
    found: Levels = []
    families = np.zeros(0, dtype=np.uint64)
    for depth in range(int(level.max()), -1, -1):
        at, shift = level == depth, k * (tree.bits - depth)
        ends = keys[at] >> np.uint64(shift) if shift < 64 else np.zeros(1, np.uint64)
        all_keys = np.concatenate([ends, families])
        order = np.argsort(all_keys)
        split = order >= len(ends)
        found.append((all_keys[order], split, np.append(black[at], np.ones(len(families), bool))[order]))
        families = found[-1][0][:: 2**k] >> np.uint64(k)
    return found[::-1]


def _grid(tree: Tree, levels: Levels) -> Any:
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonCore import vtkBitArray
    from vtkmodules.vtkCommonDataModel import vtkHyperTreeGrid, vtkHyperTreeGridNonOrientedCursor

    grid = vtkHyperTreeGrid()
    grid.Initialize()
    grid.SetBranchFactor(2)
    grid.SetDimensions([2 if axis < tree.dimension else 1 for axis in range(3)])
    for axis, put in enumerate((grid.SetXCoordinates, grid.SetYCoordinates, grid.SetZCoordinates)):
        ends = [0.0]
        if axis < tree.dimension:
            ends = [tree.origin[axis], tree.origin[axis] + tree.size]
        put(numpy_to_vtk(np.array(ends), deep=True))
    cursor = vtkHyperTreeGridNonOrientedCursor()
    grid.InitializeNonOrientedCursor(cursor, 0, True)
    cursor.SetGlobalIndexStart(0)
    split = np.concatenate([split for _, split, _ in levels[:-1]] or [np.zeros(0, bool)])
    if len(split):
        packed = np.packbits(split)
        descriptor = vtkBitArray()
        descriptor.SetVoidArray(packed, len(split), 1)
        cursor.GetTree().BuildFromBreadthFirstOrderDescriptor(descriptor, len(split), 0)
    colours = numpy_to_vtk(np.concatenate([black for _, _, black in levels]).astype(np.uint8), deep=True)
    colours.SetName(NAME)
    grid.GetCellData().SetScalars(colours)
    place = numpy_to_vtk(np.array([tree.bits, tree.size, *tree.origin]), deep=True)
    place.SetName(PLACE)
    grid.GetFieldData().AddArray(place)
    return grid
