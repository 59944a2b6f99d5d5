"""The own file of a tree: whole, in parts, damaged, and hostile."""

import doctest
import importlib
import os
import pkgutil
import subprocess
import sys
from itertools import islice

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import trees.files
from trees import (
    Cube,
    DamagedFile,
    Misaligned,
    TreeError,
    empty,
    from_array,
    from_points,
    read_tree,
    to_array,
    unit_cube,
    write_tree,
)
from trees.files import from_bytes, map_tree, to_bytes
from trees.files.layout import CHUNK, HEAD, checksum, padded

SIZES = {1: 9, 2: 4, 3: 3, 4: 2}


def random_array(seed: int, dimension: int, bits: int) -> np.ndarray:
    """A random array with uniform regions of several sizes."""
    rng = np.random.default_rng(seed)
    array = np.zeros((1,) * dimension, dtype=bool)
    for _ in range(bits):
        for axis in range(dimension):
            array = array.repeat(2, axis=axis)
        array = array ^ (rng.random(array.shape) < rng.choice([0.02, 0.3]))
    return array


arrays = st.integers(1, 4).flatmap(
    lambda k: st.builds(random_array, st.integers(0, 2**32), st.just(k), st.integers(0, SIZES[k]))
)


@pytest.fixture(scope="module")
def large():
    """A tree of several chunks, whose last runs to the end of the cube."""
    cells = np.random.default_rng(1).integers(0, 2**20, (12000, 3))
    return from_points(cells, 20, Cube((-1.0, 0.5, 3.0), 3.0)) | from_points(
        [[1, 1, 1]], 1, Cube((-1.0, 0.5, 3.0), 3.0)
    )


@pytest.fixture(scope="module")
def stored(large, tmp_path_factory):
    path = tmp_path_factory.mktemp("files") / "large.tree"
    write_tree(large, path)
    return path


@settings(deadline=None, max_examples=40)
@given(arrays)
def test_bytes_there_and_back(array):
    tree = from_array(array)
    data = to_bytes(tree)
    assert from_bytes(data) == tree
    assert len(data) % 64 == 0
    assert to_bytes(~~tree) == data


def test_files(tmp_path, large, stored):
    assert read_tree(stored) == large
    assert stored.read_bytes() == to_bytes(large)
    assert to_bytes(large) == to_bytes((large | large) - empty(large.cube, 2))
    assert [path.name for path in stored.parent.iterdir()] == [stored.name]
    with pytest.raises(FileNotFoundError):
        write_tree(large, tmp_path / "none" / "a.tree")
    with pytest.raises(FileNotFoundError):
        map_tree(tmp_path / "none")


def test_the_arrays_can_be_mapped(large, stored):
    count = len(large.words)
    data = stored.read_bytes()
    tail = padded(large.starts.tobytes()), padded(large.words.tobytes())
    assert data.endswith(tail[0] + tail[1])
    assert (len(data) - len(tail[0]) - len(tail[1])) % 64 == 0
    offset = len(data) - len(tail[1])
    assert np.array_equal(np.memmap(stored, "<u8", "r", offset, (count,)), large.words)


def test_whole_cubes_of_64_bits(tmp_path):
    for dimension, bits in [(1, 64), (2, 32), (64, 1)]:
        whole = ~empty(unit_cube(dimension), bits)
        assert from_bytes(to_bytes(whole)) == whole
        assert from_bytes(to_bytes(whole)).count == 2**64
        write_tree(whole - from_points([[1] * dimension], bits, whole.cube), tmp_path / "a")
        with map_tree(tmp_path / "a") as mapped:
            assert mapped.count == 2**64 - 1
            assert mapped.count_in(bits, (2**bits - 1,) * dimension) == (dimension < 64)
            assert mapped.count_in(bits, (1,) * dimension) == 0
            assert (2**bits - 1,) * (dimension - 1) + (0,) in mapped


def test_a_mapped_tree_answers_as_the_tree_does(large, stored):
    rng = np.random.default_rng(2)
    with map_tree(stored) as mapped:
        assert (mapped.count, mapped.cube, mapped.bits) == (large.count, large.cube, large.bits)
        assert mapped.measure == large.measure
        assert mapped.whole() == large
        assert repr(mapped) == repr(large).replace("<Tree", "<MappedTree")
        cells = np.array(list(islice(large, 0, 9000, 7)))
        cells = np.concatenate([cells, rng.integers(-9, 2**20 + 9, (3000, 3))])
        assert np.array_equal(mapped.holds_cells(cells), large.holds_cells(cells))
        points = rng.uniform(-1, 6.5, (3000, 3))
        assert np.array_equal(mapped.holds(points), large.holds(points))
        assert tuple(cells[-3001].tolist()) in mapped
        assert (-1, 0, 0) not in mapped
        with pytest.raises(TreeError, match="3"):
            assert (1, 2) not in mapped
        with pytest.raises(TreeError, match="integer coordinates, not float64"):
            mapped.holds_cells(np.zeros((1, 3)))


@settings(deadline=None, max_examples=60)
@given(arrays, st.data())
def test_branches_and_their_counts(tmp_path_factory, array, data):
    tree = from_array(array, Cube((-2.0,) * array.ndim, 4.0))
    path = tmp_path_factory.getbasetemp() / "branch.tree"
    write_tree(tree, path)
    level = data.draw(st.integers(0, tree.bits))
    cell = tuple(data.draw(st.integers(0, 2**level - 1)) for _ in range(array.ndim))
    side = 2 ** (tree.bits - level)
    part = array[tuple(slice(i * side, (i + 1) * side) for i in cell)]
    with map_tree(path) as mapped:
        branch = mapped.branch(level, cell)
        assert np.array_equal(to_array(branch), part)
        assert branch.origin == tuple(-2 + 4 * i / 2**level for i in cell)
        assert mapped.count_in(level, cell) == part.sum()


def test_branches_across_chunks(large, stored):
    with map_tree(stored) as mapped:
        found = [mapped.count_in(2, cell) for cell in np.ndindex(4, 4, 4)]
        assert sum(found) == large.count
        for cell in np.ndindex(2, 2, 2):
            part = mapped.branch(1, cell)
            assert part.count == mapped.count_in(1, cell)
            assert (large & part).count == part.count
        last = mapped.branch(1, (1, 1, 1))
        assert last == ~empty(last.cube, 19)
        with pytest.raises(TreeError, match="level 21"):
            mapped.count_in(21, (0, 0, 0))
        with pytest.raises(TreeError, match="2 on axis 1 is no number from 0 to 1"):
            mapped.branch(1, (0, 2, 0))
        with pytest.raises(TreeError, match="dimension 3"):
            mapped.branch(1, (0, 1))
    with pytest.raises(TreeError, match="closed"):
        map_and_close(stored).count_in(20, (0, 0, 0))


def map_and_close(path):
    mapped = map_tree(path)
    mapped.close()
    return mapped


def test_branches_at_no_floating_point_number(tmp_path):
    write_tree(~empty(Cube((0.1,), 0.7), 4), tmp_path / "a")
    with map_tree(tmp_path / "a") as mapped, pytest.raises(Misaligned):
        mapped.branch(4, (3,))


def test_every_cut_and_every_changed_byte_is_found(tmp_path):
    good = to_bytes(from_points([[1, 5], [7, 7]], 4))
    (tmp_path / "a").write_bytes(good)
    for i in range(len(good)):
        with pytest.raises(DamagedFile):
            from_bytes(good[:i])
        for flip in (1, 4, 255):
            with pytest.raises(DamagedFile):
                from_bytes(good[:i] + bytes([good[i] ^ flip]) + good[i + 1 :])
    with pytest.raises(DamagedFile):
        from_bytes(good + b"\0")
    (tmp_path / "cut").write_bytes(good[:-1])
    for read in (read_tree, map_tree):
        with pytest.raises(DamagedFile, match="cut: "):
            read(tmp_path / "cut")


@settings(deadline=None, max_examples=100)
@given(st.data())
def test_random_damage_gives_the_same_tree_or_none(tmp_path_factory, data):
    tree = from_array(random_array(data.draw(st.integers(0, 99)), 2, 4))
    good = to_bytes(tree)
    bad = bytearray(good)
    for place, value in data.draw(st.lists(st.tuples(st.integers(0, len(good) - 1), st.integers(0, 255)))):
        bad[place] = value
    bad = bytes(bad)[: data.draw(st.sampled_from([None, len(good) - 64, len(good) // 2]))]
    path = tmp_path_factory.getbasetemp() / "damaged.tree"
    path.write_bytes(bad)
    try:
        assert from_bytes(bad) == tree
    except DamagedFile:
        assert bad != good
    try:
        with map_tree(path) as mapped:
            assert mapped.whole() == tree
    except DamagedFile:
        assert bad != good


def forged(tree, offset: int, value: bytes, table: bool = True) -> bytes:
    """A file with a change and right checksums, of the head and of its only chunk."""
    data = bytearray(to_bytes(tree))
    data[offset : offset + len(value)] = value
    frame = 64 + len(padded(bytes(8 * (tree.dimension + 1))))
    count = HEAD.unpack_from(to_bytes(tree))[6]
    first = frame + 128
    second = first + len(padded(bytes(8 * count)))
    if table:
        data[frame : frame + 32] = checksum(
            bytes(data[first : first + 8 * count]), bytes(data[second : second + 8 * count])
        )
    data[frame + 64 : frame + 96] = checksum(bytes(data[: frame + 64]))
    return bytes(data)


def number(value: int, width: int = 8) -> bytes:
    return value.to_bytes(width, "little")


HOSTILE = {
    "version": (6, number(1, 2)),
    "another kind": (8, number(2, 4)),
    "no kind": (8, number(9, 4)),
    "dimension": (12, number(3, 4)),
    "no dimension": (12, number(0, 4)),
    "dimensions": (12, number(2**32 - 1, 4)),
    "bits": (16, number(33, 4)),
    "many bits": (16, number(2**32 - 1, 4)),
    "other bits": (16, number(1, 4)),
    "chunk": (20, number(64, 4)),
    "entries": (24, number(2**60)),
    "no entries": (24, number(0)),
    "length": (32, number(2**60)),
    "root": (40, number(1)),
    "reserved": (50, b"x"),
    "origin": (64, np.float64(np.nan).tobytes()),
    "minus zero": (64, np.float64(-0.0).tobytes()),
    "size": (80, np.float64(-1).tobytes()),
    "endless": (80, np.float64(np.inf).tobytes()),
    "behind the frame": (90, b"x"),
    "first brick": (160, number(1)),
    "first word": (168, number(1)),
    "cells": (176, number(7)),
    "many cells": (184, number(1)),
    "behind the checksum": (230, b"x"),
    "start": (256, number(5)),
    "falling starts": (264, number(0)),
    "far start": (272, number(2**63)),
    "word": (320, number(5)),
    "repeated word": (336, number(0)),
    "behind the array": (310, b"x"),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_files_with_right_checksums(tmp_path, name):
    tree = from_points([[1, 5], [15, 15]], 4)
    assert forged(tree, 0, b"2KTREE") == to_bytes(tree)
    assert len(tree.words) == 3
    data = forged(tree, *HOSTILE[name])
    with pytest.raises(DamagedFile):
        from_bytes(data)
    (tmp_path / "a").write_bytes(data)
    with pytest.raises(DamagedFile, match="a: "), map_tree(tmp_path / "a") as mapped:
        mapped.whole()


def test_a_chunk_is_checked_when_it_is_read(large, stored, tmp_path):
    data = bytearray(stored.read_bytes())
    data[-100] ^= 1  # in the last chunk
    (tmp_path / "a").write_bytes(data)
    with pytest.raises(DamagedFile, match="a: chunk"):
        read_tree(tmp_path / "a")
    first = np.array(list(islice(large, 100)))
    with map_tree(tmp_path / "a") as mapped:
        assert mapped.count == large.count
        assert mapped.holds_cells(first).all()
        assert mapped.branch(10, (0, 0, 0)).count == mapped.count_in(10, (0, 0, 0))
        with pytest.raises(DamagedFile, match="a: chunk"):
            mapped.holds_cells(np.array([[2**20 - 1] * 3]))
        with pytest.raises(DamagedFile, match="a: chunk"):
            mapped.whole()


def test_a_file_cut_while_it_is_open(large, stored, tmp_path):
    (tmp_path / "a").write_bytes(stored.read_bytes())
    assert len(large.words) > 2 * CHUNK
    with map_tree(tmp_path / "a") as mapped:
        os.truncate(tmp_path / "a", 4096)
        with pytest.raises(DamagedFile, match="a: chunk"):
            mapped.holds_cells(np.array([[2**20 - 1] * 3]))
        assert mapped.count == large.count


def test_importing_files_loads_neither_numba_nor_vtk():
    asked = "import sys, trees.files; print(sorted({'numba', 'vtkmodules', 'scipy'} & set(sys.modules)))"
    answer = subprocess.run([sys.executable, "-c", asked], capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == "[]"


def test_the_examples_of_the_docstrings():
    results = [
        doctest.testmod(importlib.import_module(f"trees.files.{module.name}"))
        for module in pkgutil.iter_modules(trees.files.__path__)
    ]
    assert sum(result.failed for result in results) == 0
    assert sum(result.attempted for result in results) > 8
