"""Exact maps, sections and projections against dense arrays."""

import doctest
import importlib
import itertools
import pkgutil

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import trees.geometry
from trees import Cube, KeyTooWide, TreeError, empty, from_array, from_points, to_array, unit_cube
from trees.geometry import (
    branch,
    depth_map,
    insert,
    permute,
    project,
    quarter_turn,
    reflect,
    scale,
    section,
    translate,
    visible,
    window,
)

SIZES = {1: 8, 2: 4, 3: 3, 4: 2}


def blocky(seed: int, dimension: int, bits: int) -> np.ndarray:
    """A random array with uniform regions of several sizes."""
    rng = np.random.default_rng(seed)
    array = np.zeros((1,) * dimension, dtype=bool)
    for _ in range(bits):
        for axis in range(dimension):
            array = array.repeat(2, axis=axis)
        array = array ^ (rng.random(array.shape) < rng.choice([0.02, 0.3]))
    return array


@st.composite
def arrays(draw, least: int = 1, bits: int = 0):
    dimension = draw(st.integers(least, 4))
    return blocky(draw(st.integers(0, 2**32)), dimension, draw(st.integers(bits, SIZES[dimension])))


def moved(array: np.ndarray, vector) -> np.ndarray:
    """The array shifted, with white coming in."""
    found = np.zeros_like(array)
    ends = [(max(v, 0), min(n + v, n)) for v, n in zip(vector, array.shape, strict=True)]
    if all(a < b for a, b in ends):
        into = tuple(slice(a, b) for a, b in ends)
        out = tuple(slice(a - v, b - v) for (a, b), v in zip(ends, vector, strict=True))
        found[into] = array[out]
    return found


@settings(deadline=None, max_examples=80)
@given(arrays(), st.data())
def test_shifts(array, data):
    side = array.shape[0]
    vector = [data.draw(st.integers(-side - 1, side + 1)) for _ in array.shape]
    tree = from_array(array)
    assert np.array_equal(to_array(translate(tree, vector)), moved(array, vector))
    grown = translate(tree, vector, grow=True)
    assert grown.count == tree.count
    assert grown.cell_size == tree.cell_size
    offset = (np.array(tree.origin) - np.array(grown.origin)) / tree.cell_size
    assert set(grown) == {tuple((np.array(cell) + offset + vector).tolist()) for cell in tree}
    assert not translate(grown, [-v for v in vector], grow=True) ^ tree


@settings(deadline=None, max_examples=60)
@given(arrays(), st.data())
def test_mirrors_and_exchanges(array, data):
    tree = from_array(array, Cube(tuple(range(array.ndim)), 2.0))
    axes = data.draw(st.permutations(range(array.ndim)))
    turned = permute(tree, axes)
    assert np.array_equal(to_array(turned), array.transpose(axes))
    assert turned.origin == tuple(float(axis) for axis in axes)
    some = axes[: data.draw(st.integers(0, array.ndim))]
    assert np.array_equal(to_array(reflect(tree, some)), np.flip(array, some))
    assert reflect(reflect(tree, some), some) == tree
    if array.ndim > 1:
        quarter = quarter_turn(tree, axes[0], axes[1])
        assert np.array_equal(to_array(quarter), np.rot90(array, 1, (axes[0], axes[1])))
        assert quarter.cube == tree.cube
        assert quarter_turn(quarter, axes[1], axes[0]) == tree


@settings(deadline=None, max_examples=60)
@given(arrays(), st.integers(-2, 3))
def test_powers_of_two(array, power):
    tree = from_array(array)
    wide = scale(tree, power, grow=True)
    assert wide.size == 2.0**power
    assert np.array_equal(to_array(wide), array)
    if power > tree.bits:
        with pytest.raises(TreeError, match="wider than the cube"):
            scale(tree, power)
        return
    side = array.shape[0]
    if power >= 0:
        expected = array[(slice(side >> power),) * array.ndim]
    else:
        expected = np.pad(array, [(0, (side << -power) - side)] * array.ndim)
    assert np.array_equal(to_array(scale(tree, power)), expected)
    assert scale(tree, power).cube == tree.cube


@settings(deadline=None, max_examples=80)
@given(arrays(least=2), st.data())
def test_sections_and_projections(array, data):
    axis = data.draw(st.integers(0, array.ndim - 1))
    index = data.draw(st.integers(0, array.shape[0] - 1))
    tree = from_array(array, Cube(tuple(range(array.ndim)), 2.0))
    cut, shadow = section(tree, axis, index), project(tree, axis)
    assert np.array_equal(to_array(cut), array.take(index, axis))
    assert np.array_equal(to_array(shadow), array.any(axis))
    assert cut.origin == shadow.origin == tuple(float(i) for i in range(array.ndim) if i != axis)
    none = ~array.any(axis)
    first = np.where(none, -1, array.argmax(axis))
    last = np.where(none, -1, array.shape[0] - 1 - np.flip(array, axis).argmax(axis))
    assert np.array_equal(depth_map(tree, axis), first)
    assert np.array_equal(depth_map(tree, axis, rising=False), last)
    places = np.arange(array.shape[0]).reshape([-1 if i == axis else 1 for i in range(array.ndim)])
    for seen, heights in ((visible(tree, axis), first), (visible(tree, axis, rising=False), last)):
        assert np.array_equal(to_array(seen), places == np.expand_dims(heights, axis))
        assert seen.cube == tree.cube


@settings(deadline=None, max_examples=80)
@given(arrays(), st.data())
def test_branches(array, data):
    tree = from_array(array)
    level = data.draw(st.integers(0, tree.bits))
    cell = [data.draw(st.integers(0, 2**level - 1)) for _ in array.shape]
    edge = array.shape[0] >> level
    place = tuple(slice(x * edge, (x + 1) * edge) for x in cell)
    part = branch(tree, level, cell)
    assert np.array_equal(to_array(part), array[place])
    assert part.cube == Cube(tuple(x / 2**level for x in cell), 2.0**-level)
    assert not (part - tree)
    assert insert(tree, part, level, cell) == tree
    new = blocky(data.draw(st.integers(0, 2**32)), array.ndim, part.bits)
    changed = array.copy()
    changed[place] = new
    assert np.array_equal(to_array(insert(tree, from_array(new), level, cell)), changed)
    finer = insert(tree, from_array(new).at(part.bits + 1), level, cell)
    assert finer == from_array(changed).at(tree.bits + 1)
    bits = data.draw(st.integers(0, tree.bits))
    corner = [data.draw(st.integers(-3, array.shape[0] + 1)) for _ in array.shape]
    shown = window(tree, corner, bits)
    expected = moved(array, [-x for x in corner])[(slice(2**bits),) * array.ndim]
    assert np.array_equal(to_array(shown), expected)
    assert shown.origin == tuple(x / 2**tree.bits for x in corner)


def test_large_trees_stay_small():
    half = from_points(np.array([[0, 0, 0]]), 1).at(21)
    moved_by_one = translate(from_points([[0, 0, 0]], 1).at(8), np.array([1, 0, 0]))
    assert moved_by_one.count == (2**7) ** 3
    assert reflect(half, [0, 1, 2]).count == 2**60
    assert list(reflect(half, [0, 1, 2]).at(1)) == [(1, 1, 1)]
    assert section(half, 1, 2**20 - 1).count == 2**40
    assert section(half, 1, 2**20).count == 0
    assert project(half, 0).count == 2**40
    assert branch(half, 1, [0, 0, 0]) == ~empty(Cube((0.0,) * 3, 0.5), 20)
    assert branch(half, 0, [0, 0, 0]) == half
    line = ~empty(unit_cube(1), 64)
    assert branch(line, 0, [0]) == line
    assert insert(line, empty(unit_cube(1), 63), 1, [1]).count == 2**63
    assert insert(line, ~line, 0, [0]) == ~line
    assert translate(half, [2**20, 0, 0]).count == 2**60
    assert list(translate(half, [2**20, 0, 0]).at(1)) == [(1, 0, 0)]


def test_six_dimensions():
    rng = np.random.default_rng(2)
    array = rng.random((4,) * 6) < 0.2
    tree = from_array(array)
    assert np.array_equal(to_array(translate(tree, [1, -1, 0, 2, 0, -3])), moved(array, [1, -1, 0, 2, 0, -3]))
    assert np.array_equal(to_array(permute(tree, [5, 0, 3, 1, 4, 2])), array.transpose(5, 0, 3, 1, 4, 2))
    assert np.array_equal(to_array(project(tree, 3)), array.any(3))
    assert np.array_equal(to_array(section(tree, 5, 2)), array[..., 2])


def test_wrong_input_is_named():
    tree = from_points([[1, 2]], 2)
    for call, message in [
        (lambda: translate(tree, [1]), "2 of them"),
        (lambda: reflect(tree, [2]), "axis 2: 0 to 1"),
        (lambda: reflect(tree, [0, 0]), "once"),
        (lambda: permute(tree, [0, 0]), "each of 0 to 1"),
        (lambda: quarter_turn(tree, 1, 1), "two axes"),
        (lambda: section(tree, 0, 4), "cell 4 on axis 0"),
        (lambda: section(tree, 2, 0), "axis 2"),
        (lambda: project(from_points([[1]], 1), 0), "dimension 1"),
        (lambda: branch(tree, 3, [0, 0]), "level 3: 0 to 2"),
        (lambda: branch(tree, 1, [0, 2]), r"node \(0, 2\) of level 1"),
        (lambda: insert(tree, from_points([[1]], 1), 0, [0, 0]), "part of dimension 1"),
        (lambda: window(tree, [0, 0], 3), "window of 3 bits"),
    ]:
        with pytest.raises(TreeError, match=message):
            call()
    with pytest.raises(KeyTooWide):
        scale(tree, -31)
    with pytest.raises(KeyTooWide):
        translate(tree, [2**40, 0], grow=True)


def test_the_products_of_quarter_turns():
    tree = from_array(blocky(3, 3, 3))
    turns = list(itertools.permutations(range(3), 2))
    for a, b in turns:
        four = tree
        for _ in range(4):
            four = quarter_turn(four, a, b)
        assert four == tree


def test_the_examples_of_the_docstrings():
    tried = 0
    for module in pkgutil.iter_modules(trees.geometry.__path__):
        result = doctest.testmod(importlib.import_module(f"trees.geometry.{module.name}"))
        assert result.failed == 0
        tried += result.attempted
    assert tried > 40
