"""Trees as VTK's HyperTreeGrids: there and back, and as VTK itself reads them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from trees import (
    Cube,
    DamagedFile,
    TooManyPieces,
    TreeError,
    empty,
    from_array,
    from_points,
    leaves,
    unit_cube,
)
from trees.files import hypertree, read_hypertree_grid, write_hypertree_grid

SIZES = {1: 6, 2: 4, 3: 3}
CUBE = {k: Cube((0.5, -2.0, 3.0)[:k], 1.5) for k in SIZES}


def random_array(seed: int, dimension: int, bits: int) -> np.ndarray:
    """A random array with uniform regions of several sizes."""
    rng = np.random.default_rng(seed)
    array = np.zeros((1,) * dimension, dtype=bool)
    for _ in range(bits):
        for axis in range(dimension):
            array = array.repeat(2, axis=axis)
        array = array ^ (rng.random(array.shape) < rng.choice([0.02, 0.3]))
    return array


arrays = st.integers(1, 3).flatmap(
    lambda k: st.builds(random_array, st.integers(0, 2**32), st.just(k), st.integers(0, SIZES[k]))
)


def read_by_vtk(path):
    from vtkmodules.vtkIOXML import vtkXMLHyperTreeGridReader

    reader = vtkXMLHyperTreeGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    return reader.GetOutput()


def leaves_by_vtk(grid):
    """Bounds and colour of each leaf, and colour of each inner node, by walking VTK's cursor."""
    from vtkmodules.vtkCommonDataModel import vtkHyperTreeGridNonOrientedGeometryCursor

    cursor = vtkHyperTreeGridNonOrientedGeometryCursor()
    grid.InitializeNonOrientedGeometryCursor(cursor, 0)
    colours, ends, inner = grid.GetCellData().GetArray("black"), set(), []

    def walk():
        colour = colours.GetValue(cursor.GetGlobalNodeIndex())
        if cursor.IsLeaf():
            bounds = [0.0] * 6
            cursor.GetBounds(bounds)
            ends.add((*bounds, colour))
            return
        inner.append(colour)
        for child in range(cursor.GetNumberOfChildren()):
            cursor.ToChild(child)
            walk()
            cursor.ToParent()

    walk()
    return ends, inner


@settings(deadline=None, max_examples=40)
@given(arrays)
def test_vtk_reads_the_same_leaves(tmp_path_factory, array):
    tree = from_array(array, CUBE[array.ndim])
    path = tmp_path_factory.getbasetemp() / "a.htg"
    write_hypertree_grid(tree, path)
    grid = read_by_vtk(path)
    assert grid.GetDimension() == tree.dimension
    expected = set()
    for colour, part in ((1, leaves(tree)), (0, leaves(~tree))):
        for low, high in zip(part.lows.tolist(), part.highs.tolist(), strict=True):
            bounds = [x for pair in zip(low, high, strict=True) for x in pair]
            expected.add((*bounds, *[0.0] * (6 - len(bounds)), colour))
    found, inner = leaves_by_vtk(grid)
    assert found == expected
    assert set(inner) <= {1}
    assert grid.GetNumberOfCells() == len(expected) + len(inner)
    assert read_hypertree_grid(path) == tree


def test_the_cube_and_the_bits_are_exact(tmp_path):
    cube = Cube((0.1, 1e9), 0.3)
    for tree in (from_points([[1, 5], [6, 6]], 20, cube), empty(cube, 7), ~empty(cube, 32)):
        write_hypertree_grid(tree, tmp_path / "a.htg")
        assert read_hypertree_grid(tmp_path / "a.htg") == tree
        first = (tmp_path / "a.htg").read_bytes()
        write_hypertree_grid(tree, tmp_path / "a.htg")
        assert (tmp_path / "a.htg").read_bytes() == first


def write_by_vtk(grid, path):
    from vtkmodules.vtkIOXML import vtkXMLHyperTreeGridWriter

    writer = vtkXMLHyperTreeGridWriter()
    writer.SetInputData(grid)
    writer.SetFileName(str(path))
    assert writer.Write() == 1


def source(descriptor, mask=None, grid=(2, 2, 1), factor=2):
    from vtkmodules.vtkFiltersSources import vtkHyperTreeGridSource

    made = vtkHyperTreeGridSource()
    made.SetDimensions(grid)
    made.SetMaxDepth(descriptor.count("|") + 1)
    made.SetGridScale(2.0, 2.0, 2.0)
    made.SetBranchFactor(factor)
    made.SetDescriptor(descriptor)
    made.SetUseMask(mask is not None)
    if mask is not None:
        made.SetMask(mask)
    made.Update()
    return made.GetOutput()


def test_a_grid_that_vtk_made(tmp_path):
    # Children in VTK's order: south-west, south-east, north-west, north-east.
    write_by_vtk(source("R|.R..|....", "1|1101|0111"), tmp_path / "a.htg")
    tree = read_hypertree_grid(tmp_path / "a.htg")
    assert (tree.cube, tree.bits) == (Cube((0.0, 0.0), 2.0), 2)
    assert set(tree) == {(x, y) for x in range(4) for y in range(4)} - {(2, 0)} - {
        (x, y) for x in (0, 1) for y in (2, 3)
    }


def test_grids_of_other_kinds(tmp_path):
    write_by_vtk(source("..", grid=(3, 2, 1)), tmp_path / "a.htg")
    with pytest.raises(TreeError, match="2 trees of branch factor 2"):
        read_hypertree_grid(tmp_path / "a.htg")
    write_by_vtk(source(".", factor=3), tmp_path / "a.htg")
    with pytest.raises(TreeError, match="1 trees of branch factor 3"):
        read_hypertree_grid(tmp_path / "a.htg")
    write_by_vtk(source(".", grid=(2, 1, 2)), tmp_path / "a.htg")
    with pytest.raises(TreeError, match="first axes"):
        read_hypertree_grid(tmp_path / "a.htg")


def test_what_is_too_large_is_refused(tmp_path, monkeypatch):
    with pytest.raises(TreeError, match="dimension 4"):
        write_hypertree_grid(empty(unit_cube(4), 1), tmp_path / "a.htg")
    tree = from_array(np.indices((8, 8)).sum(axis=0) % 2 == 0)
    write_hypertree_grid(tree, tmp_path / "a.htg")
    monkeypatch.setattr(hypertree, "MAX_NODES", 84)
    for action in (
        lambda: write_hypertree_grid(tree, tmp_path / "b.htg"),
        lambda: read_hypertree_grid(tmp_path / "a.htg"),
    ):
        with pytest.raises(TooManyPieces) as caught:
            action()
        assert (caught.value.count, caught.value.limit) == (85, 84)
    assert [path.name for path in tmp_path.iterdir()] == ["a.htg"]
    with pytest.raises(FileNotFoundError):
        read_hypertree_grid(tmp_path / "none")


@settings(deadline=None, max_examples=60)
@given(st.data())
def test_damage_gives_the_same_tree_or_none(tmp_path_factory, data):
    tree = from_points([[1, 5], [7, 6]], 3)
    path = tmp_path_factory.getbasetemp() / "damaged.htg"
    write_hypertree_grid(tree, path)
    good = path.read_bytes()
    bad = bytearray(good)
    places = st.integers(good.index(b"\n"), len(good) - 1)  # in what the checksum covers
    for place, value in data.draw(st.lists(st.tuples(places, st.integers(0, 255)), max_size=3)):
        bad[place] = value
    path.write_bytes(bad)
    try:
        assert read_hypertree_grid(path) == tree
    except DamagedFile:
        assert bad != good


def test_every_cut_is_found(tmp_path, capfd):
    tree = from_points([[1, 5], [7, 6]], 3)
    write_hypertree_grid(tree, tmp_path / "a.htg")
    good = (tmp_path / "a.htg").read_bytes()
    for end in range(0, len(good) - 1, 7):
        (tmp_path / "a.htg").write_bytes(good[:end])
        with pytest.raises(DamagedFile, match=r"a\.htg: "):
            read_hypertree_grid(tmp_path / "a.htg")
    (tmp_path / "a.htg").write_bytes(b"<VTKFile></VTKFile>")
    with pytest.raises(DamagedFile, match="VTK reads no"):
        read_hypertree_grid(tmp_path / "a.htg")
    assert capfd.readouterr() == ("", "")
