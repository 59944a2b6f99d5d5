"""Trees as OpenVDB grids: there and back, and as OpenVDB itself reads and writes them."""

import subprocess
from pathlib import Path

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
    to_array,
    unit_cube,
)
from trees.files import openvdb, read_vdb, write_vdb
from trees.files.openvdb_nodes import SEAL, Nodes, write_nodes

SYSTEM_PYTHON = Path("/usr/bin/python3")


def system(code, folder):
    return subprocess.run([SYSTEM_PYTHON, "-c", code], cwd=folder, capture_output=True, text=True)


@pytest.fixture(scope="module")
def openvdb_itself():
    if not SYSTEM_PYTHON.exists() or system("import pyopenvdb, numpy", "/").returncode:
        pytest.skip("needs Debian's python3-openvdb")


def random_array(seed: int, bits: int) -> np.ndarray:
    """A random array with uniform regions of several sizes."""
    rng = np.random.default_rng(seed)
    array = np.zeros((1, 1, 1), dtype=bool)
    for _ in range(bits):
        for axis in range(3):
            array = array.repeat(2, axis=axis)
        array = array ^ (rng.random(array.shape) < rng.choice([0.02, 0.3]))
    return array


CUBE = Cube((0.1, -2.0, 3.0), 0.7)
arrays = st.builds(random_array, st.integers(0, 2**32), st.integers(0, 5))


def tiled():
    """A set with tiles of 8, 128 and 4096 cells and with leaves, in a cube of 2^14 cells a side."""
    found = from_points([[1, 2, 3]], 2, unit_cube(3)) | from_points(
        [[127, 3, 5], [64, 0, 0]], 7, unit_cube(3)
    )
    found |= from_points([[0, 0, 3], [1000, 5, 7]], 11, unit_cube(3))
    return found | from_points([[0, 0, 1], [2**14 - 1, 9, 1], [77, 78, 79]], 14, unit_cube(3))


@settings(deadline=None, max_examples=40)
@given(arrays)
def test_there_and_back(tmp_path_factory, array):
    tree = from_array(array, CUBE)
    path = tmp_path_factory.getbasetemp() / "a.vdb"
    write_vdb(tree, path)
    assert read_vdb(path) == tree
    first = path.read_bytes()
    write_vdb(~~tree, path)
    assert path.read_bytes() == first


def test_large_sets_are_tiles(tmp_path):
    tree = tiled()
    nodes = openvdb.nodes_of(tree)
    assert nodes.tiles_4096.tolist() == [[4096, 8192, 12288]]
    assert nodes.tiles_128.tolist() == [[127 * 128, 3 * 128, 5 * 128], [64 * 128, 0, 0]][::-1]
    assert nodes.tiles_8.tolist() == [[0, 0, 24], [8000, 40, 56]]
    assert sorted(nodes.leaves.tolist()) == [[0, 0, 0], [72, 72, 72], [2**14 - 8, 8, 0]]
    for found in (tree, ~tree, empty(tree.cube, 14), ~empty(tree.cube, 14), ~empty(tree.cube, 1)):
        write_vdb(found, tmp_path / "a.vdb")
        assert read_vdb(tmp_path / "a.vdb") == found
        assert (tmp_path / "a.vdb").stat().st_size < 40000


@pytest.mark.usefixtures("openvdb_itself")
def test_openvdb_reads_the_same_set(tmp_path):
    dense = [from_array(random_array(seed, bits), CUBE) for seed, bits in ((1, 5), (2, 5), (3, 1))]
    large = [tiled(), ~tiled()]
    for number, tree in enumerate([*dense, *large]):
        write_vdb(tree, tmp_path / f"{number}.vdb", name="part")
    code = f"""
import numpy, pyopenvdb
for number in range(5):
    grid = pyopenvdb.read(f"{{number}}.vdb", "part")
    print(grid.activeVoxelCount(), *map(float.hex, grid.transform.indexToWorld((-0.5, -0.5, -0.5))))
    if number < 3:
        values = numpy.full(({2**5},) * 3, -1, "f4")
        grid.copyToArray(values)
        numpy.save(f"{{number}}.npy", values)
    if number == 3:
        accessor = grid.getConstAccessor()
        for cell in ((4096, 8192, 12288), (8191, 12287, 16383), (8192, 8192, 12288), (8192, 5, 127),
                     (8192, 128, 5), (7, 7, 31), (0, 8, 31), (77, 78, 79), (77, 78, 78)):
            print(int(accessor.isValueOn(cell)), end="")
        print("", grid.leafCount())
"""
    answer = system(code, tmp_path)
    assert answer.returncode == 0, answer.stderr
    lines = answer.stdout.split("\n")
    for tree, line in zip([*dense, *large], [*lines[:4], lines[5]], strict=True):
        count, *corner = line.split()
        assert int(count) == tree.count
        assert [float.fromhex(x) for x in corner] == pytest.approx(tree.origin, abs=1e-15)
    assert lines[4] == "110101010"[:4] + "0" + "1010"[:4] + " 3"
    for number, tree in enumerate(dense):
        side = 2**tree.bits
        values = np.load(tmp_path / f"{number}.npy")
        assert np.array_equal(values[:side, :side, :side], to_array(tree).astype(np.float32))
        assert values.sum() == tree.count


@pytest.mark.usefixtures("openvdb_itself")
def test_files_that_openvdb_wrote(tmp_path):
    code = """
import numpy, pyopenvdb
random = numpy.random.default_rng(5)
values = random.random((40, 70, 9)) < 0.3
numpy.save("a.npy", values)
def filled(grid, value):
    grid.copyFromArray(values * value, ijk=(-20, 200, 3))
    grid.fill((4096, 0, 0), (8191, 4095, 4095), value, True)
    grid.fill((0, 128, 128), (127, 255, 255), value, True)
    grid.fill((-64, 0, 0), (-63, 1, 0), value * 3, True)
    grid.transform = pyopenvdb.createLinearTransform(0.25)
    grid.transform.translate((1, 2, 3))
    return grid
one, two = filled(pyopenvdb.FloatGrid(0), 2.5), filled(pyopenvdb.BoolGrid(False), True)
three = pyopenvdb.Vec3SGrid()
one.name, two.name, three.name = "one", "two", "three"
half = one.deepCopy()
half.name, half.saveFloatAsHalf = "half", True
pyopenvdb.write("a.vdb", [one, two, three, half])
print(one.activeVoxelCount(), two.activeVoxelCount())
"""
    answer = system(code, tmp_path)
    assert answer.returncode == 0, answer.stderr
    values = np.load(tmp_path / "a.npy")
    count = int(values.sum()) + 4096**3 + 128**3 + 4
    assert answer.stdout.split() == [str(count)] * 2
    found = read_vdb(tmp_path / "a.vdb")
    assert found.count == count
    assert found.cell_size == 0.25
    for name in ("one", "two", "half"):
        assert read_vdb(tmp_path / "a.vdb", name) == found
    places = np.stack(np.indices(values.shape), -1).reshape(-1, 3) + np.array([-20, 200, 3])
    assert np.array_equal(found.holds(places * 0.25 + [1, 2, 3]), values.ravel())
    inside = np.array(
        [[4096, 0, 0], [8191, 4095, 4095], [0, 128, 128], [127, 255, 255], [-63, 1, 0], [-62, 1, 0]]
    )
    assert found.holds(inside * 0.25 + [1, 2, 3]).tolist() == [True] * 5 + [False]
    with pytest.raises(TreeError, match="Tree_vec3s_5_4_3"):
        read_vdb(tmp_path / "a.vdb", "three")
    with pytest.raises(TreeError, match="no grid 'four': there are 'one', 'two'"):
        read_vdb(tmp_path / "a.vdb", "four")


@pytest.mark.usefixtures("openvdb_itself")
def test_values_of_leaves_are_kept_in_order(tmp_path):
    rng = np.random.default_rng(3)
    leaves = np.array([[8, 0, 0], [0, 0, 0], [136, 8, 0], [0, 128, 8]])
    masks = rng.random((4, 8, 8, 8)) < 0.4
    values = rng.random(masks.sum()).astype(np.float32)
    none = np.zeros((0, 3), dtype=np.int64)
    with open(tmp_path / "a.vdb", "wb+") as file:
        write_nodes(file, Nodes(leaves, masks, none, none, none, values), (0.0,) * 3, 1.0, {}, "a")
    code = (
        "import numpy, pyopenvdb; values = numpy.zeros((144, 136, 16), 'f4');"
        "pyopenvdb.read('a.vdb', 'a').copyToArray(values); numpy.save('a.npy', values)"
    )
    answer = system(code, tmp_path)
    assert answer.returncode == 0, answer.stderr
    expected = np.zeros((144, 136, 16), dtype=np.float32)
    parts = np.split(values, np.cumsum(masks.sum(axis=(1, 2, 3)))[:-1])
    for (x, y, z), mask, part in zip(leaves.tolist(), masks, parts, strict=True):
        expected[x : x + 8, y : y + 8, z : z + 8][mask] = part
    assert np.array_equal(np.load(tmp_path / "a.npy"), expected)


@settings(deadline=None, max_examples=60)
@given(st.data())
def test_damage_gives_the_same_tree_or_none(tmp_path_factory, data):
    tree = from_array(random_array(4, 4), CUBE)
    path = tmp_path_factory.getbasetemp() / "damaged.vdb"
    write_vdb(tree, path)
    good = path.read_bytes()
    bad = bytearray(good)
    places = st.integers(len(SEAL), 900) | st.integers(len(SEAL), len(good) - 1)
    for place, value in data.draw(st.lists(st.tuples(places, st.integers(0, 255)), max_size=3)):
        bad[place] = value
    bad = bad[: data.draw(st.integers(0, len(good)) | st.just(len(good)))]
    path.write_bytes(bad)
    try:
        assert read_vdb(path) == tree
    except DamagedFile:
        assert bad != good
    # Without the checksum, as others write them, damage may give another set, but no other error.
    path.write_bytes(bytes(bad).replace(b"SHA-256", b"nothing"))
    try:
        read_vdb(path)
    except TreeError:
        assert bad != good


def test_every_cut_is_found(tmp_path):
    write_vdb(from_points([[1, 2, 3], [9, 9, 9]], 4), tmp_path / "a.vdb")
    good = (tmp_path / "a.vdb").read_bytes()
    for end in range(0, len(good), 61):
        (tmp_path / "a.vdb").write_bytes(good[:end])
        with pytest.raises(DamagedFile, match=r"a\.vdb: "):
            read_vdb(tmp_path / "a.vdb")


def test_what_has_no_grid_is_refused(tmp_path, monkeypatch):
    with pytest.raises(TreeError, match="dimension 2"):
        write_vdb(empty(unit_cube(2), 2), tmp_path / "a.vdb")
    monkeypatch.setattr(openvdb, "MAX_NODES", 10)
    with pytest.raises(TooManyPieces) as caught:
        write_vdb(from_array(np.indices((32, 32, 32)).sum(axis=0) % 2 == 0), tmp_path / "a.vdb")
    assert (caught.value.count, caught.value.limit) == (64, 10)
    assert not list(tmp_path.iterdir())
