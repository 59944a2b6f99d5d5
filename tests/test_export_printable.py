"""Islands, voids, hollows, bases, least walls and gaps: dense references, closed forms, known solids."""

import itertools
import math
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy import ndimage
from scipy.sparse.csgraph import minimum_spanning_tree
from scipy.spatial.distance import cdist
from scipy.spatial.transform import Rotation

from export.meshing.skin import EmptySolid
from export.printable import (
    WrongLength,
    drained,
    filled,
    fits,
    gaps_at_least,
    hollowed,
    islands,
    thin_walls,
    tight_gaps,
    turned,
    turns,
    voids,
    walls_at_least,
    with_base,
)
from trees import Cube, Tree, TreeError, empty, from_array, from_points, to_array, to_points, unit_cube
from trees.topology import components

struts = sys.modules["export.printable.struts"]
PITCH = 0.3
FACES = ndimage.generate_binary_structure(3, 1)
small = hnp.arrays(bool, (8, 8, 8), elements=st.booleans()).filter(np.any)
sparse = st.lists(st.tuples(*[st.integers(0, 7)] * 3), min_size=1, max_size=14)


def solid(array: np.ndarray, origin=(-1.0, 0.5, 2.0), pitch: float = PITCH) -> Tree:
    """The set cells of an array of any shape, in the smallest cube."""
    bits = (max(array.shape) - 1).bit_length()
    return from_points(np.argwhere(array), bits, Cube(tuple(origin), pitch * 2**bits))


def block(shape=(16, 16, 16), *slabs: tuple[slice, slice, slice]) -> np.ndarray:
    array = np.zeros(shape, dtype=bool)
    for where in slabs:
        array[where] = True
    return array


def box(low, high) -> tuple[slice, slice, slice]:
    x, y, z = (slice(a, b) for a, b in zip(low, high, strict=True))
    return x, y, z


def same_set(a: Tree, b: Tree) -> bool:
    """Whether the cells stand at the same places in mm, whatever the cubes."""
    one, other = (
        np.unique(np.rint((np.array(t.origin) - a.origin) / a.cell_size + to_points(t)), axis=0)
        for t in (a, b)
    )
    return math.isclose(a.cell_size, b.cell_size) and np.array_equal(one, other)


def holds(outer: Tree, inner: Tree) -> bool:
    """Whether all cells of one set are in another, by their centres."""
    places = np.array(inner.origin) + (to_points(inner) + 0.5) * inner.cell_size
    return bool(outer.holds(places).all())


def labelled(array: np.ndarray) -> tuple[np.ndarray, int]:
    """The components by scipy, for cells that touch across faces."""
    labels = np.zeros(array.shape, dtype=np.int32)
    count = ndimage.label(array, FACES, output=labels)
    return labels, int(np.asarray(count))


def brute_components(cells: np.ndarray) -> np.ndarray:
    array = np.zeros((8, 8, 8), dtype=bool)
    array[tuple(cells.T)] = True
    return labelled(array)[0]


# Islands


@settings(max_examples=20, deadline=None)
@given(small, st.integers(0, 4))
def test_islands_kept_and_dropped(array, least):
    tree = solid(array)
    labels, count = labelled(array)
    sizes = np.bincount(labels.ravel())[1:]
    smallest = (least - 0.5) * PITCH**3 if least else 0.0
    if sizes.max() < least:
        with pytest.raises(EmptySolid, match="dropped"):
            islands(tree, smallest_mm3=smallest)
        return
    found, report = islands(tree, smallest_mm3=smallest)
    stays = np.isin(labels, np.flatnonzero(sizes >= least) + 1)
    assert found == solid(array & stays)
    assert len(report.kept) + len(report.dropped) == count
    volumes = np.sort(sizes[sizes >= least])[::-1] * PITCH**3
    np.testing.assert_allclose([region.volume for region in report.kept], volumes)
    assert islands(tree, "largest")[0].count == sizes.max()


@settings(max_examples=20, deadline=None)
@given(small)
def test_regions_are_those_of_scipy(array):
    tree = solid(array)
    labels, count = labelled(array)
    rows = set()
    for number in range(1, count + 1):
        cells = np.argwhere(labels == number)
        low, high = cells.min(axis=0), cells.max(axis=0) + 1
        ends = np.concatenate([cells.mean(axis=0) + 0.5, low, high]).reshape(3, 3) * PITCH + tree.origin
        rows.add(tuple(np.round(ends, 6).ravel().tolist()))
    report = islands(tree)[1]
    assert {tuple(np.round([*r.centre, *r.low, *r.high], 6).tolist()) for r in report.kept} == rows


@settings(max_examples=25, deadline=None)
@given(sparse, st.floats(0.1, 3.0))
def test_links_form_a_minimum_spanning_tree(cells, diameter):
    cells = np.unique(np.array(cells), axis=0)
    tree = from_points(cells, 3, Cube((1.0, 2.0, 3.0), 8 * PITCH))
    labels = brute_components(cells)[tuple(cells.T)]
    parts = [cells[labels == n] for n in np.unique(labels)]
    lengths = np.array([[cdist(a, b).min() if a is not b else 0.0 for b in parts] for a in parts])
    total = minimum_spanning_tree(lengths).sum()
    found, report = islands(tree, "link", diameter_mm=diameter * PITCH)
    assert len(report.struts) == len(parts) - 1
    assert sum(s.length for s in report.struts) == pytest.approx(total * PITCH)
    assert len(components(found)) == 1
    assert holds(found, tree)
    for strut in report.struts:
        assert math.dist(strut.start, strut.end) == pytest.approx(strut.length)
        assert tree.holds([strut.start, strut.end]).all()


def test_two_cubes_are_linked_by_a_round_bar():
    array = block((32, 16, 16), box((1, 2, 2), (9, 14, 14)), box((21, 2, 2), (29, 14, 14)))
    found, report = islands(solid(array), "link", diameter_mm=6 * PITCH)
    assert [s.length for s in report.struts] == pytest.approx([13 * PITCH])
    added = (found.count - array.sum()) / 12
    disc = sum(x * x + y * y <= 9 for x, y in itertools.product(range(-3, 4), repeat=2))
    assert added == disc


def test_lines_step_across_faces():
    rng = np.random.default_rng(1)
    for start, end in rng.integers(-20, 20, (50, 2, 3)):
        cells = struts.line(start, end)
        assert (np.abs(np.diff(cells, axis=0)).sum(axis=1) == 1).all()
        assert np.array_equal(cells[0], start)
        assert np.array_equal(cells[-1], end)
        along = (end - start) / max(np.linalg.norm(end - start), 1)
        off = (cells - start) - np.outer((cells - start) @ along, along)
        assert np.linalg.norm(off, axis=1).max() < math.sqrt(3)


# Voids and drains


@settings(max_examples=25, deadline=None)
@given(hnp.arrays(np.uint8, (8, 8, 8), elements=st.integers(0, 3)), st.floats(0.1, 3))
def test_voids_are_those_of_scipy_and_drains_open_all(numbers, diameter):
    array = numbers > 0
    if not array.any():
        return
    tree = solid(array)
    whole = np.asarray(ndimage.binary_fill_holes(array, FACES), dtype=bool)
    labels, count = labelled(whole & ~array)
    found = voids(tree)
    assert sorted(np.rint([v.volume / PITCH**3 for v in found])) == sorted(np.bincount(labels.ravel())[1:])
    assert filled(tree)[0] == solid(whole)
    assert filled(tree)[1] == found
    opened, drains = drained(tree, diameter * PITCH)
    assert len(drains) == count
    assert holds(tree, opened)
    assert not opened or voids(opened) == ()
    outside = np.pad(~whole, 1, constant_values=True)
    for drain in drains:
        shortest = min(
            _ways_out(outside, np.argwhere(labels == n) + 1) for n in _same(labels, drain.void, tree)
        )
        assert drain.length == pytest.approx(shortest * PITCH)
        assert np.count_nonzero(~np.isclose(drain.start, drain.end)) == 1


def _same(labels: np.ndarray, region, tree: Tree) -> list[int]:
    """The labels whose box and volume are those of a region."""
    low = np.rint((np.array(region.low) - tree.origin) / PITCH).astype(int)
    high = np.rint((np.array(region.high) - tree.origin) / PITCH).astype(int)
    inside = labels[box(low, high)]
    volume = round(region.volume / PITCH**3)
    return [n for n in np.unique(inside[inside > 0]) if (labels == n).sum() == volume]


def _ways_out(outside: np.ndarray, cells: np.ndarray) -> int:
    best = 99
    for cell, axis, step in itertools.product(cells, range(3), (-1, 1)):
        place, n = cell.copy(), 0
        while not outside[tuple(place)]:
            place[axis] += step
            n += 1
        best = min(best, n)
    return best


def test_nested_cubes_have_two_voids_and_drains():
    array = block((32, 32, 32), box((1, 1, 1), (29, 29, 29)))
    array[box((4, 5, 6), (25, 25, 25))] = False
    array[box((8, 9, 10), (22, 22, 22))] = True
    array[box((11, 12, 13), (19, 19, 19))] = False
    found = voids(solid(array))
    expected = [21 * 20 * 19 - 14 * 13 * 12, 8 * 7 * 6]
    assert [v.volume for v in found] == pytest.approx(np.array(expected) * PITCH**3)
    opened, drains = drained(solid(array), 4 * PITCH)
    assert [d.length / PITCH for d in drains] == pytest.approx([4, 11])
    assert [d.axis for d in drains] == [0, 0]
    assert voids(opened) == ()
    disc = 13
    assert array.sum() - opened.count == disc * (3 + 3 + 4)


def test_a_void_behind_an_edge_contact_is_trapped():
    array = np.ones((4, 4, 4), dtype=bool)
    array[1, 1, 1:3] = array[0, 0, 1:3] = False
    assert [v.volume for v in voids(solid(array))] == pytest.approx([2 * PITCH**3])


# Hollows


@pytest.mark.parametrize(("wall", "cells"), [(0.6, 2), (0.61, 3), (0.3, 1), (1.5, 5), (0.01, 1)])
def test_a_hollow_box_has_the_asked_wall(wall, cells):
    array = block((32, 32, 32), box((0, 3, 4), (32, 27, 20)))
    found, report = hollowed(solid(array), wall)
    sides = np.array([32, 24, 16]) - 2 * cells
    assert report.wall == pytest.approx(cells * PITCH)
    assert [c.volume for c in report.cavities] == pytest.approx([sides.prod() * PITCH**3])
    assert array.sum() - found.count == sides.prod()
    assert len(voids(found)) == 1


@settings(max_examples=15, deadline=None)
@given(hnp.arrays(np.uint8, (8, 8, 8), elements=st.integers(0, 9)), st.integers(1, 3))
def test_a_hollow_keeps_what_is_near_white(numbers, cells):
    array = numbers > 0
    if not array.any():
        return
    far = np.asarray(ndimage.distance_transform_edt(np.pad(array, 4)))[4:-4, 4:-4, 4:-4] > cells
    found, report = hollowed(solid(array), cells * PITCH)
    assert same_set(found, solid(array & ~far))
    assert sum(c.volume for c in report.cavities) == pytest.approx(far.sum() * PITCH**3)


def test_a_part_too_thin_to_hollow_stays():
    tree = solid(block((8, 8, 8), box((0, 0, 0), (8, 8, 3))))
    assert hollowed(tree, 2 * PITCH)[0] == tree
    assert hollowed(tree, 1e9)[1].cavities == ()


# Bases


@settings(max_examples=15, deadline=None)
@given(sparse, st.integers(1, 5), st.integers(0, 3))
def test_a_rectangular_base(cells, layers, margin):
    cells = np.unique(np.array(cells), axis=0)
    tree = from_points(cells, 3, Cube((1.0, 2.0, 3.0), 8 * PITCH))
    found, base = with_base(tree, layers * PITCH, margin * PITCH, footprint="rectangle")
    low, high = cells.min(axis=0), cells.max(axis=0) + 1
    grid = np.zeros((16, 16), dtype=bool)
    grid[low[0] + 4 : high[0] + 4, low[1] + 4 : high[1] + 4] = True
    near = np.asarray(ndimage.distance_transform_edt(~grid)) <= margin
    assert base.area == pytest.approx(near.sum() * PITCH**2)
    assert found.count == len(cells) + near.sum() * layers
    assert base.contact == pytest.approx((cells[:, 2] == low[2]).sum() * PITCH**2)
    assert base.low[2] == pytest.approx(3.0 + (low[2] - layers) * PITCH)
    assert base.high[2] == pytest.approx(3.0 + low[2] * PITCH)
    assert base.low[0] == pytest.approx(1.0 + (low[0] - margin) * PITCH)
    lowest = from_points(cells[cells[:, 2] == low[2]], 3, tree.cube)
    assert len(components(with_base(lowest, PITCH)[0])) == 1


def test_a_hull_base_is_the_convex_shadow():
    array = block(
        (16, 16, 16), box((2, 2, 5), (3, 3, 9)), box((10, 2, 5), (11, 3, 6)), box((2, 10, 7), (3, 11, 8))
    )
    found, base = with_base(solid(array), 1.9 * PITCH)
    assert base.area == pytest.approx(53 * PITCH**2)  # 45 with x + y <= 8, and 8 that the slanted side meets
    assert found.count == array.sum() + 2 * 53


# Least walls and gaps


@pytest.mark.parametrize("cells", range(1, 9))
@pytest.mark.parametrize("limit", [1, 2, 3, 4, 5, 6.5])
def test_slabs_of_known_walls(cells, limit):
    tree = solid(block((32, 32, 32), box((0, 0, 3), (32, 32, 3 + cells))))
    found, report = thin_walls(tree, limit * PITCH)
    thin = cells < 2 * math.floor(limit / 2) + 1
    assert found.count == thin * tree.count
    assert len(report.places) == thin
    assert abs(2 * math.floor(limit / 2) + 1 - limit) <= 1
    thick, _ = walls_at_least(tree, limit * PITCH)
    assert holds(thick, tree)
    assert not thin_walls(thick, limit * PITCH)[0]
    middle = to_points(thick)[:, 2]
    assert middle.max() - middle.min() + 1 >= limit - 1


def test_the_corners_of_cubes_and_balls_are_no_thin_walls():
    grid = np.stack(np.meshgrid(*[np.arange(64)] * 3, indexing="ij"), -1) - 31.7
    for seed in range(4):
        matrix = Rotation.random(rng=np.random.default_rng(seed)).as_matrix() if seed else np.eye(3)
        places = grid @ matrix.T
        for size in (np.abs(places).max(axis=-1) / 17, np.linalg.norm(places, axis=-1) / 20):
            array = np.asarray(size < 1)
            for limit in (2, 3, 5, 8, 14):
                assert thin_walls(solid(array), limit * PITCH)[1].places == ()


def test_a_fin_on_a_block_is_thin_and_made_thick():
    array = block((32, 32, 32), box((4, 4, 4), (28, 28, 14)), box((4, 15, 14), (28, 17, 26)))
    tree = solid(array)
    found, report = thin_walls(tree, 5 * PITCH)
    fin = np.zeros_like(array)
    fin[4:28, 15:17, 14:26] = True
    assert len(report.places) == 1
    assert holds(found, solid(fin))
    assert found.count <= fin.sum() + 2 * 24
    thick, _ = walls_at_least(tree, 5 * PITCH)
    row = [
        y for x, y, z in (to_points(thick).astype(int) - _shift(tree, thick)).tolist() if x == 15 and z == 20
    ]
    assert 5 <= len(row) <= 6
    assert thin_walls(thick, 5 * PITCH)[1].places == ()


def _shift(old: Tree, new: Tree) -> np.ndarray:
    return np.rint((np.array(old.origin) - new.origin) / old.cell_size).astype(int)


@settings(max_examples=12, deadline=None)
@given(hnp.arrays(np.uint8, (8, 8, 8), elements=st.integers(0, 2)), st.sampled_from([1.5, 2, 3, 4, 5]))
def test_enforced_walls_and_gaps_are_found_no_more(numbers, limit):
    array = numbers > 1
    if not array.any():
        return
    tree = solid(array)
    ball = np.linalg.norm(np.indices((7, 7, 7)) - 3, axis=0) <= limit / 2 + 1e-9
    wide = np.pad(array, 12)
    thin, _ = thin_walls(tree, limit * PITCH)
    assert same_set(solid(array), thin | tree)
    residue = array & ~np.asarray(ndimage.binary_opening(wide, ball), dtype=bool)[12:-12, 12:-12, 12:-12]
    assert holds(solid(residue), thin) if residue.any() else not thin
    gaps, _ = tight_gaps(tree, limit * PITCH)
    origin = np.array(tree.origin) - 12 * PITCH
    closing = np.asarray(ndimage.binary_closing(wide, ball), dtype=bool) & ~wide
    assert not gaps or holds(solid(closing, origin), gaps)
    thick, closed = walls_at_least(tree, limit * PITCH)[0], gaps_at_least(tree, limit * PITCH)[0]
    assert holds(thick, tree)
    assert not thin_walls(thick, limit * PITCH)[0]
    assert holds(closed, tree)
    assert not tight_gaps(closed, limit * PITCH)[0]


@pytest.mark.parametrize("cells", range(1, 7))
@pytest.mark.parametrize("limit", [2, 3, 5])
def test_plates_with_a_known_gap(cells, limit):
    array = block((32, 32, 32), box((4, 4, 2), (28, 28, 10)), box((4, 4, 10 + cells), (28, 28, 18 + cells)))
    found, report = tight_gaps(solid(array), limit * PITCH)
    tight = cells < 2 * math.floor(limit / 2) + 1
    assert len(report.places) == tight
    if tight:
        np.testing.assert_allclose(
            report.places[0].centre, np.array([-1, 0.5, 2]) + PITCH * np.array([16, 16, 10 + cells / 2])
        )
        assert found.count >= 0.8 * 24 * 24 * cells
    closed, _ = gaps_at_least(solid(array), limit * PITCH)
    assert len(components(closed)) == (1 if tight else 2)


# Build volumes


def test_turns_are_the_rotations_of_the_cube():
    matrices = np.array(turns())
    assert len({m.tobytes() for m in matrices}) == 24
    assert all(round(np.linalg.det(m)) == 1 for m in matrices)
    assert all(np.array_equal(m @ m.T, np.eye(3)) for m in matrices)


@settings(max_examples=20, deadline=None)
@given(sparse, st.lists(st.integers(1, 8), min_size=3, max_size=3))
def test_fits_against_all_orientations(cells, room):
    cells = np.array(cells)
    tree = from_points(cells, 3, Cube((1.0, 2.0, 3.0), 8 * PITCH))
    sides = np.ptp(cells, axis=0) + 1
    found = fits(tree, [side * PITCH for side in room])
    scales = [min(np.array(room) / sides[list(p)]) for p in itertools.permutations(range(3))]
    assert found.fits == (max(scales) >= 1)
    assert found.scale == pytest.approx(max(scales)) if not found.fits else found.scale >= 1 - 1e-9
    moved = turned(tree, found.turn)
    assert (np.ptp(to_points(moved).astype(int), axis=0) + 1 == np.abs(found.turn) @ sides).all()
    scaled = fits(tree, [side * PITCH / found.scale for side in room])
    assert scaled.fits


def test_turned_is_the_rotation_about_the_middle():
    rng = np.random.default_rng(0)
    array = rng.random((8, 8, 8)) < 0.2
    for turn in turns():
        moved = (np.argwhere(array) * 2 - 7) @ np.array(turn).T
        expected = np.zeros_like(array)
        expected[tuple((moved.T + 7) // 2)] = True
        assert np.array_equal(to_array(turned(from_array(array), turn)), expected)


# Doors


CALLS = [
    lambda tree: islands(tree),
    voids,
    filled,
    lambda tree: drained(tree, 1.0),
    lambda tree: hollowed(tree, 1.0),
    lambda tree: with_base(tree, 1.0),
    lambda tree: walls_at_least(tree, 1.0),
    lambda tree: gaps_at_least(tree, 1.0),
    lambda tree: fits(tree, (1, 1, 1)),
]


@pytest.mark.parametrize("call", CALLS)
def test_empty_and_flat_trees_are_refused(call):
    with pytest.raises(EmptySolid):
        call(empty(unit_cube(3), 3))
    with pytest.raises(TreeError, match="dimension 2"):
        call(from_points([[0, 1]], bits=2))


@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_lengths_out_of_range_are_refused(value):
    tree = solid(np.ones((4, 4, 4), dtype=bool))
    for call in (drained, hollowed, with_base, walls_at_least, gaps_at_least, thin_walls, tight_gaps):
        with pytest.raises(WrongLength, match="above 0"):
            call(tree, value)
    with pytest.raises(WrongLength, match="side 1"):
        fits(tree, (1, value, 1))
    with pytest.raises(WrongLength):
        islands(tree, "link", diameter_mm=value)
    if value:
        with pytest.raises(WrongLength):
            islands(tree, smallest_mm3=value)
        with pytest.raises(WrongLength):
            with_base(tree, 1.0, value)


def test_choices_are_checked():
    tree = solid(np.ones((4, 4, 4), dtype=bool))
    with pytest.raises(ValueError, match="link"):
        islands(tree, "join")
    with pytest.raises(ValueError, match="diameter_mm"):
        islands(tree, "link")
    with pytest.raises(ValueError, match="rectangle"):
        with_base(tree, 1.0, footprint="round")
    with pytest.raises(ValueError, match="3 are needed"):
        fits(tree, (1, 1))
    with pytest.raises(ValueError, match="24"):
        turned(tree, ((1, 0, 0), (0, 1, 0), (0, 0, -1)))
