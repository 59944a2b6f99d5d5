"""Slices against dense arrays, and files that are interrupted or have no room."""

import contextlib
import json
import re
import resource
import zipfile
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

import trees
from export.files import WRITABLE, UnsupportedFormat, write_part
from export.formats import slices
from export.formats.layers import cell_box, layers
from export.formats.slices import WrongSlices, write_slices
from export.formats.tree_files import write_cells
from ifs.mesh import Mesh
from trees.files import read_hypertree_grid, read_vdb
from trees.tree import Tree

CUBE = trees.Cube((1.0, -2.0, 3.0), 8.0)


def random_set(bits: int, density: float) -> np.ndarray:
    cells = np.random.default_rng(bits).random((2**bits,) * 3) < density
    if bits > 3:
        cells[:, :3], cells[-2:], cells[4:8, 4:12, 5:] = False, False, True
    return cells


@pytest.mark.parametrize("bits", range(6))
@pytest.mark.parametrize("density", [0.02, 0.5, 0.9])
def test_layers_are_those_of_the_array(bits, density) -> None:
    cells = random_set(bits, density)
    tree = trees.from_array(cells, CUBE)
    if not cells.any():
        assert cell_box(tree) is None
        return
    where = np.argwhere(cells)
    low, high = where.min(axis=0), where.max(axis=0) + 1
    for form in (tree, Tree(tree.cube, bits, tree.as_shared)):
        box = cell_box(form)
        assert box is not None
        assert box.low.tolist() == low.tolist()
        assert box.high.tolist() == high.tolist()
        found = [picture.copy() for picture in layers(form, box, np.arange(2**bits))]
        window = cells[low[0] : high[0], low[1] : high[1]]
        assert np.array_equal(np.array(found), window.transpose(2, 1, 0))


def loops_of(svg: bytes) -> list[np.ndarray]:
    """The corners (x, y) of the closed loops of the one path."""
    path = ElementTree.fromstring(svg)[0]
    assert path.get("fill-rule") == "evenodd"
    found = []
    for loop in (path.get("d") or "").split("Z")[:-1]:
        place, corners = [0.0, 0.0], []
        for letter, text in re.findall(r"([MHV])([-0-9. ]+)", loop):
            numbers = [float(x) for x in text.split()]
            if letter == "M":
                place = numbers
            else:
                place["HV".index(letter)] = numbers[0]
            corners.append(tuple(place))
        found.append(np.array(corners))
    return found


def filled(loops: list[np.ndarray], columns: int, rows: int, pitch: float) -> np.ndarray:
    """Which cells an odd number of upright sides lie left of."""
    flips = np.zeros((rows, columns), dtype=int)
    for loop in loops:
        for (x, y), (_, end) in zip(loop, np.roll(loop, -1, axis=0), strict=True):
            top, bottom = sorted(round(value / pitch) for value in (y, end))
            flips[top:bottom, round(x / pitch) :] += 1
    return flips % 2 == 1


@pytest.mark.parametrize("format", ["png", "svg"])
@pytest.mark.parametrize("ending", ["", ".zip"])
def test_slices_show_the_set_from_above(tmp_path, format, ending) -> None:
    cells = random_set(5, 0.5)
    tree = trees.from_array(cells, CUBE)
    path = tmp_path / f"slices{ending}"
    assert write_slices(tree, path, format, recipe={"b": "2", "a": "1"}) == 32
    if ending:
        with zipfile.ZipFile(path) as archive:
            assert archive.testzip() is None
            content = {name: archive.read(name) for name in archive.namelist()}
    else:
        content = {file.name: file.read_bytes() for file in path.iterdir()}
    told = json.loads(content.pop("manifest.json"))
    assert told["layer_height"] == 0.25
    assert told["pixel_size"] == [0.25, 0.25]
    assert told["layers"] == len(content) == 32
    assert told["files"] == [f"000000.{format}", f"000031.{format}"]
    box = cell_box(tree)
    assert box is not None
    assert told["origin"] == [x + 0.25 * low for x, low in zip(CUBE.origin, box.low.tolist(), strict=True)]
    assert told["recipe"] == {"a": "1", "b": "2"}
    window = cells[box.low[0] : box.high[0], box.low[1] : box.high[1]]
    for number, name in enumerate(sorted(content)):
        above = window[:, ::-1, number].T
        if format == "png":
            (tmp_path / "one.png").write_bytes(content[name])
            with Image.open(tmp_path / "one.png") as picture:
                assert picture.mode == "1"
                assert picture.info["dpi"] == pytest.approx((101.6, 101.6))
                assert np.array_equal(np.asarray(picture), above)
        else:
            loops = loops_of(content[name])
            assert np.array_equal(filled(loops, *told["pixels"], 0.25), above)
            for loop in loops:  # sides along rows and columns in turn, none of length 0
                steps = np.roll(loop, -1, axis=0) - loop
                assert ((steps != 0).sum(axis=1) == 1).all()
                assert (steps[::2, 0] != 0).all()


def test_a_square_with_a_hole_and_cells_that_touch_at_a_corner() -> None:
    picture = np.zeros((4, 6), dtype=np.uint8)
    picture[:3, :3], picture[1, 1], picture[3, 3], picture[2, 4] = 1, 0, 1, 1
    loops = loops_of(slices._svg(picture[::-1], 2.0))
    sizes = sorted((len(loop), np.ptp(loop, axis=0).tolist()) for loop in loops)
    assert sizes == [(4, [2.0, 2.0]), (4, [2.0, 2.0]), (4, [2.0, 2.0]), (4, [6.0, 6.0])]


def test_layers_of_another_height_show_their_middle(tmp_path) -> None:
    tree = trees.from_points([[0, 0, z] for z in (1, 2, 5)], 3)  # cells of 1/8 mm, from 1/8 to 6/8
    for height, expected in (
        (1 / 16, [1, 1, 1, 1, 0, 0, 0, 0, 1, 1]),
        (1 / 8, [1, 1, 0, 0, 1]),
        (3 / 16, [1, 0, 0, 1]),
        (1 / 4, [1, 0, 1]),
        (9.0, [1]),
    ):
        path = tmp_path / f"{height}.zip"
        assert write_slices(tree, path, "png", height) == len(expected)
        with zipfile.ZipFile(path) as archive:
            assert json.loads(archive.read("manifest.json"))["layer_height"] == height
            found = []
            for number in range(len(expected)):
                with archive.open(f"{number:06d}.png") as file, Image.open(file) as picture:
                    found.append(int(np.asarray(picture).sum()))
        assert found == expected, height


def test_trees_too_deep_for_bricks_are_sliced(tmp_path) -> None:
    corner = trees.from_substitution(
        {"all": [False] * 7 + ["all"]}, "all", 40, trees.Cube((0.0,) * 3, 2.0**40)
    )
    box = cell_box(corner)
    assert box is not None
    assert box.low.tolist() == [2**40 - 1] * 3
    assert write_slices(corner, tmp_path / "a.zip") == 1
    with zipfile.ZipFile(tmp_path / "a.zip") as archive:
        told = json.loads(archive.read("manifest.json"))
    assert (told["origin"], told["pixels"]) == ([2.0**40 - 1] * 3, [1, 1])
    with pytest.raises(WrongSlices, match="61 bits"):
        write_slices(trees.from_substitution({"all": [False] * 7 + ["all"]}, "all", 61), tmp_path / "b.zip")


def test_what_cannot_be_sliced(tmp_path) -> None:
    tree = trees.full(CUBE, 3)
    with pytest.raises(UnsupportedFormat, match="'bmp': write png, svg"):
        write_slices(tree, tmp_path / "a.zip", "bmp")
    with pytest.raises(UnsupportedFormat, match=r"a\.rar: write \.zip, or a folder"):
        write_slices(tree, tmp_path / "a.rar")
    with pytest.raises(WrongSlices, match="empty"):
        write_slices(trees.empty(CUBE, 3), tmp_path / "a.zip")
    with pytest.raises(WrongSlices, match="dimension 2"):
        write_slices(trees.full(trees.unit_cube(2), 3), tmp_path / "a.zip")
    for height in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(WrongSlices, match="above 0 mm"):
            write_slices(tree, tmp_path / "a.zip", layer_height=height)
    with pytest.raises(WrongSlices, match="80000000 layers"):
        write_slices(tree, tmp_path / "a.zip", layer_height=1e-7)
    with pytest.raises(WrongSlices, match="4294967296 cells"):
        write_slices(trees.full(CUBE, 16), tmp_path / "a.zip")
    assert not list(tmp_path.iterdir())
    (tmp_path / "a").mkdir()
    assert write_slices(tree, tmp_path / "a") == 8
    with pytest.raises(FileExistsError, match="not an empty folder"):
        write_slices(tree, tmp_path / "a")
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


@pytest.mark.parametrize("name", ["a.zip", "a"])
def test_interrupted_slices_leave_nothing(tmp_path, name) -> None:
    def stop(_: str, share: float) -> None:
        if share > 0.5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_slices(trees.full(CUBE, 3), tmp_path / name, progress=stop)
    assert not list(tmp_path.iterdir())


@contextlib.contextmanager
def room_for(size: int):
    """No file can grow beyond this size, as on a full disk."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@pytest.mark.parametrize("extension", WRITABLE)
def test_without_room_nothing_is_left(tmp_path, extension) -> None:
    random = np.random.default_rng(0)
    mesh = Mesh(random.random((5000, 3)), random.integers(0, 5000, (20_000, 3)))
    path = tmp_path / f"a{extension}"
    path.write_bytes(b"before")
    with room_for(50_000), pytest.raises(OSError, match="large"):
        write_part(mesh, path)
    assert [found.name for found in tmp_path.iterdir()] == [path.name]
    assert path.read_bytes() == b"before"
    with pytest.raises(FileNotFoundError):
        write_part(mesh, tmp_path / "missing" / path.name)


def test_without_room_there_are_no_slices(tmp_path) -> None:
    tree = trees.from_array(random_set(5, 0.5))
    for name in ("a.zip", "a"):
        with room_for(400 if name == "a" else 5000), pytest.raises(OSError, match="large"):
            write_slices(tree, tmp_path / name, "svg")
        assert not list(tmp_path.iterdir())


def test_cells_as_volumes_read_back(tmp_path) -> None:
    tree = trees.from_array(random_set(4, 0.3), CUBE)
    write_cells(tree, tmp_path / "a.vdb")
    write_cells(tree, tmp_path / "a.HTG")
    assert read_vdb(tmp_path / "a.vdb") == tree == read_hypertree_grid(tmp_path / "a.HTG")
    with pytest.raises(UnsupportedFormat, match=r"write \.vdb, \.htg"):
        write_cells(tree, tmp_path / "a.vtk")
