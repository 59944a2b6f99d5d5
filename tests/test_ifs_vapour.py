"""Measures on grids, median sets and clouds between sets, against fractions and brute force."""

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest
from scipy.spatial import KDTree
from scipy.spatial.distance import directed_hausdorff

import ifs
from ifs.measures.density import density, sampled
from ifs.measures.grid import Grid, TooManyCells, WrongGrid, grid_around
from ifs.measures.moments import WrongProbabilities, moments
from ifs.medians.condensation import coverage, median_cells
from ifs.medians.median_sets import (
    EmptySet,
    hausdorff_distance,
    left_median,
    median,
    right_median,
    turned_median,
)
from ifs.medians.nearest_cells import nearest_cells
from ifs.medians.perturbed import largest_move, perturbed


def corners(tmp_path, scale):
    """Four maps of that scale to the corners of the unit square, at (0,0), (1,0), (0,1), (1,1) in order."""
    maps = [
        f'[[maps]]\nscale = "{scale}"\ntranslation = ["{x * (1 - scale)}", "{y * (1 - scale)}"]\n'
        for y in (0, 1)
        for x in (0, 1)
    ]
    path = tmp_path / "corners.toml"
    path.write_text('format = "bcifs/1"\nname = "Corners"\n' + "\n".join(maps))
    return ifs.shape(path)


def products(table, level):
    """The masses of all words of a length, in place: the Kronecker power of the masses of one letter."""
    result = np.array([[Fraction(1)]], dtype=object)
    for _ in range(level):
        result = np.kron(result, table)
    return result


def test_unequal_quarters_of_a_square_have_products_of_probabilities(tmp_path):
    # The source's figure 5.20.
    chances = [Fraction(3, 10), Fraction(1, 5), Fraction(1, 4), Fraction(1, 4)]
    shape = corners(tmp_path, Fraction(1, 2))
    labels = shape.system.states[shape.system.shape].labels
    grid = Grid(np.zeros(2), 1 / 16, (16, 16))
    found = density(shape, grid=grid, probabilities=dict(zip(labels, chances, strict=True)))
    table = np.array([[chances[0], chances[2]], [chances[1], chances[3]]], dtype=object)
    assert found.error == 0
    assert np.allclose(found.amounts, products(table, 4).astype(float), rtol=1e-13, atol=0)
    assert found.total == pytest.approx(1, abs=1e-14)


def test_cantor_dust_has_its_masses_on_the_grid_of_thirds(tmp_path):
    chances = [Fraction(1, 2), Fraction(1, 4), Fraction(1, 8), Fraction(1, 8)]
    shape = corners(tmp_path, Fraction(1, 3))
    labels = shape.system.states[shape.system.shape].labels
    found = density(
        shape,
        grid=Grid(np.zeros(2), 1 / 27, (27, 27)),
        probabilities=dict(zip(labels, chances, strict=True)),
    )
    none = Fraction(0)
    rows = [[chances[0], none, chances[2]], [none] * 3, [chances[1], none, chances[3]]]
    expected = products(np.array(rows, dtype=object), 3)
    assert found.error == 0
    assert np.array_equal(found.amounts, expected.astype(float))  # powers of 1/2: no rounding at all


def test_the_sponge_has_8000_equal_cells():
    found = density(ifs.shape("menger-sponge"), 27)
    digits = np.array([[n // 9, n // 3 % 3, n % 3] for n in range(27)]) == 1
    inner = digits[:, None, None].astype(int) + digits[None, :, None] + digits[None, None, :]
    assert found.error == 0
    assert np.allclose(found.amounts, (inner < 2).all(axis=-1) / 8000, rtol=1e-12, atol=0)


def test_pieces_that_straddle_are_accounted_for():
    # x = 27 passes through the sponge's middle plane: by symmetry half of the mass lies on either side.
    found = density(ifs.shape("menger-sponge"), grid=Grid(np.zeros(3), 27.0, (2, 2, 2)), part=1 / 9)
    assert 0 < found.error < 1
    assert np.allclose(found.amounts, 1 / 8, atol=1e-12)
    coarse, fine = (density(ifs.shape("koch-curve"), 60, part=part) for part in (1, 1 / 64))
    assert fine.error < coarse.error / 8
    distance = np.abs(coarse.amounts - fine.amounts).sum() / 2
    assert 0 < distance <= coarse.error + fine.error


@pytest.mark.parametrize("name", ["koch-curve", "sierpinski-triangle", "nonuniform-quadratic-spline"])
def test_pushing_and_sampling_agree(name):
    shape = ifs.shape(name)
    exact = density(shape, 40, part=1 / 32)
    drawn = sampled(shape, 200_000, 5, 40)
    assert exact.total == pytest.approx(1, abs=1e-12)
    assert drawn.total == pytest.approx(1, abs=1e-12)
    assert np.abs(exact.amounts - drawn.amounts).sum() / 2 <= exact.error + 2 * drawn.error


def test_the_sampling_error_is_that_of_many_runs():
    shape = ifs.shape("menger-sponge")
    exact = density(shape, 9)
    runs = [sampled(shape, 20_000, seed, 9) for seed in range(8)]
    found = np.mean([np.abs(run.amounts - exact.amounts).sum() / 2 for run in runs])
    assert np.mean([run.error for run in runs]) == pytest.approx(found, rel=0.2)
    again = sampled(shape, 20_000, 3, 9)
    assert np.array_equal(again.amounts, runs[3].amounts)


def test_the_centroid_is_the_first_moment():
    shape = ifs.shape("sierpinski-triangle")
    cell = shape.system.shape
    labels = shape.system.states[cell].labels
    chances = dict(zip(labels, [Fraction(1, 2), Fraction(1, 3), Fraction(1, 6)], strict=True))
    mean = [float(x) for x in moments(shape, 1, {cell: chances}).mean]
    for resolution in (16, 512):
        found = density(shape, resolution, probabilities=chances)
        assert np.abs(found.centroid - mean).max() <= found.grid.pitch / 2
    assert np.abs(found.centroid - mean).max() < 0.02


def test_wrong_measures_are_refused():
    shape = ifs.shape("sierpinski-triangle")
    labels = shape.system.states[shape.system.shape].labels
    with pytest.raises(WrongProbabilities, match=r"sum to 1\.25"):
        density(shape, probabilities=dict(zip(labels, [0.5, 0.5, 0.25], strict=True)))
    with pytest.raises(WrongGrid, match="the shape reaches from"):
        density(shape, grid=Grid(np.zeros(2), 1.0, (9, 9)))
    with pytest.raises(WrongGrid, match="2 coordinates, the grid 3 axes"):
        density(shape, grid=Grid(np.zeros(3), 100.0, (9, 9, 9)))
    with pytest.raises(WrongGrid, match="part"):
        density(shape, part=0)
    with pytest.raises(ValueError, match="32 points or more; found 31"):
        sampled(shape, 31, 0)
    with pytest.raises(TooManyCells) as caught:
        Grid(np.zeros(3), 1.0, (1000, 1000, 1000))
    assert caught.value.cells == 10**9
    for wrong in ((np.zeros(2), 0.0, (2, 2)), (np.zeros(2), 1.0, (2, 0)), (np.zeros(1), 1.0, (2,))):
        with pytest.raises(WrongGrid):
            Grid(*wrong)
    with pytest.raises(WrongGrid, match="sides above 0"):
        grid_around(np.ones(2), np.ones(2), 4)


def hausdorff(a, b):
    return max(directed_hausdorff(a, b)[0], directed_hausdorff(b, a)[0])


@pytest.mark.parametrize("dim", [2, 3])
def test_the_median_set_lies_exactly_between(dim):
    random = np.random.default_rng(dim)
    for _ in range(10):
        a = random.normal(size=(30, dim))
        b = random.normal(size=(20, dim)) * 2 + random.normal(size=dim)
        whole = hausdorff(a, b)
        assert hausdorff_distance(a, b) == pytest.approx(whole, rel=1e-12)
        for share in (0.5, 0.2):
            between = median(a, b, share)
            assert hausdorff(a, between) == pytest.approx(share * whole, rel=1e-12)
            assert hausdorff(between, b) == pytest.approx((1 - share) * whole, rel=1e-12)
        left = left_median(a, b)
        pairs = ((a[:, None] - b) ** 2).sum(axis=-1)
        assert np.allclose(left, (a + b[pairs.argmin(axis=1)]) / 2)
        assert np.allclose(right_median(a, b), (b + a[pairs.argmin(axis=0)]) / 2)
        assert hausdorff(a, left) <= whole / 2 + 1e-12
        assert np.array_equal(median(b, b), np.unique(b, axis=0))


def test_the_left_median_alone_may_stay_far_from_the_other_set():
    a, b = np.zeros((1, 2)), np.array([[0.0, 0], [10, 0]])
    assert hausdorff_distance(left_median(a, b), b) == 10
    assert hausdorff_distance(median(a, b), b) == 5


def test_the_map_to_the_median_set_does_not_contract():
    # The middle point of B is as near to both points of X; a small move of one decides.
    b = np.array([[-1.1, 0], [0, 0], [1.1, 0]])
    one, other = (np.array([[-1.0 - move, 0], [1, 0]]) for move in (1e-6, -1e-6))
    assert hausdorff_distance(one, other) < 3e-6
    assert hausdorff_distance(median(one, b), median(other, b)) == pytest.approx(0.55, abs=1e-5)


def test_a_turned_median_set_keeps_its_fixed_point_and_its_bound():
    random = np.random.default_rng(0)
    for rate in (5.0, -20.0):
        a, b = random.normal(size=(2, 25, 2))
        whole = hausdorff(a, b)
        found, plain = turned_median(a, b, rate), median(a, b)
        radius = np.linalg.norm(plain - (plain.min(axis=0) + plain.max(axis=0)) / 2, axis=1).max()
        assert hausdorff(found, b) <= (0.5 + abs(np.deg2rad(rate)) * radius) * whole
        assert hausdorff(found, plain) > 0.01
        assert np.allclose(turned_median(b, b, rate), median(b, b))


def test_wrong_sets_are_refused():
    with pytest.raises(EmptySet, match="set B has no points"):
        median(np.zeros((1, 2)), np.zeros((0, 2)))
    with pytest.raises(ValueError, match="2 coordinates, set B 3"):
        median(np.zeros((1, 2)), np.zeros((1, 3)))
    with pytest.raises(ValueError, match="finite"):
        hausdorff_distance(np.array([[np.nan]]), np.zeros((1, 1)))
    with pytest.raises(ValueError, match="share"):
        left_median(np.zeros((1, 2)), np.zeros((1, 2)), 1.5)


@pytest.mark.parametrize("part", [0.5, 0.05, 0.003])
def test_nearest_cells_are_nearest(part):
    random = np.random.default_rng(1)
    for size in ((7, 9, 30), (20, 1, 13), (1, 25, 31)):
        cells = random.random(size) < part
        cells[size[0] // 2, 0, 0] = True
        found = nearest_cells(cells)
        assert cells.ravel()[found.ravel()].all()
        everywhere = np.argwhere(np.ones(size, dtype=bool))
        there = np.stack(np.unravel_index(found.ravel(), size), axis=1)
        distances = KDTree(np.argwhere(cells)).query(everywhere)[0]
        assert np.array_equal(((there - everywhere) ** 2).sum(axis=1), np.rint(distances**2))


def blobs(random, size):
    """Cells inside a few random balls."""
    places = np.indices(size)
    result = np.zeros(size, dtype=bool)
    for _ in range(3):
        centre = [random.uniform(0, side) for side in size]
        away = sum((place - at) ** 2 for place, at in zip(places, centre, strict=True))
        result |= np.asarray(away) < random.uniform(4, 40)
    result[0, 0] = True
    return result


@pytest.mark.parametrize("size", [(40, 30), (18, 16, 20)])
def test_median_cells_halve_the_distance(size):
    random = np.random.default_rng(len(size))
    for _ in range(5):
        a, b = blobs(random, size), blobs(random, size)
        whole = hausdorff(np.argwhere(a), np.argwhere(b))
        found = median_cells(a, b)
        assert hausdorff(np.argwhere(found), np.argwhere(b)) <= whole / 2
        assert hausdorff(np.argwhere(found), np.argwhere(a)) <= whole / 2 + math.sqrt(len(size)) / 2
        assert not (a & b & ~found).any()
        steps = 0
        while not np.array_equal(a, b):
            a, steps = median_cells(a, b), steps + 1
            assert steps <= math.log2(whole) + 1


def test_the_cloud_between_two_points_is_a_sum_over_words():
    # f_0 halves, f_1 halves and adds 32: with 64 cells between them all positions of five maps are whole.
    a, b = np.zeros((2, 65, 1), dtype=bool)
    a[0], b[64] = True, True
    p = (Fraction(2, 3), Fraction(1, 3))
    expected = [Fraction(0)] * 65
    for word in itertools.product((0, 1), repeat=6):
        place = 64 * word[0]
        for letter in word[1:]:
            place = Fraction(place, 2) + 32 * letter
        expected[int(place)] += math.prod(p[letter] for letter in word)
    found = coverage([a, b], [float(x) for x in p], 5)
    assert np.allclose(found.chance[:, 0], np.array(expected, dtype=float), atol=1e-15)
    assert found.sets == 64


def test_the_cloud_is_the_mean_of_its_sets():
    random = np.random.default_rng(7)
    models = [blobs(random, (24, 20)) for _ in range(3)]
    chances = [0.5, 0.3, 0.2]
    told = []
    found = coverage(models, chances, 2, progress=lambda message, share: told.append(share))
    expected = np.zeros((24, 20))
    for first, *rest in itertools.product(range(3), repeat=3):
        cells, weight = models[first], chances[first]
        for letter in rest:
            cells, weight = median_cells(cells, models[letter]), weight * chances[letter]
        expected += weight * cells
    assert np.allclose(found.chance, expected, atol=1e-14)
    everywhere = np.logical_and.reduce(models)
    assert everywhere.any()
    assert np.allclose(found.chance[everywhere], 1, atol=1e-14)
    assert told == sorted(told)
    assert told[-1] == pytest.approx(1)


def test_a_bar_half_way_is_turned_by_a_right_angle():
    a, b = np.zeros((2, 21, 21), dtype=bool)
    a[5:16, 6], b[5:16, 14] = True, True
    found = coverage([a, b], [1.0, 0.0], 0).chance + coverage([b, a], [1.0, 0.0], 1, 90 / 8).chance
    upright = np.zeros((21, 21))
    upright[5:16, 6] = 1  # model a, chance 1
    upright[5:16, 14] += 1  # b stays b under its own map, unturned
    assert np.array_equal(found, upright)
    mixed = coverage([a, b], [0.5, 0.5], 1, 90 / 8).chance
    bar = np.zeros((21, 21))
    bar[10, 5:16] = 0.5
    assert np.array_equal(mixed, bar + 0.25 * a + 0.25 * b)


def test_wrong_models_are_refused():
    full, empty = np.ones((4, 4), dtype=bool), np.zeros((4, 4), dtype=bool)
    with pytest.raises(EmptySet, match="model 1 fills no cell"):
        coverage([full, empty], [0.5, 0.5])
    with pytest.raises(EmptySet, match="no model"):
        coverage([], [])
    with pytest.raises(ValueError, match="model 1 has the grid"):
        coverage([full, np.ones((4, 5), dtype=bool)], [0.5, 0.5])
    with pytest.raises(WrongProbabilities, match=r"they sum to 1\.5"):
        coverage([full, full], [0.5, 1.0])
    with pytest.raises(WrongProbabilities, match="model 0 must lie"):
        coverage([full, full], [1.5, -0.5])
    with pytest.raises(WrongProbabilities, match="2 models need as many"):
        coverage([full, full], [1.0])
    with pytest.raises(ValueError, match=r"2\^21 words"):
        coverage([full, full], [0.5, 0.5], 20)


def test_a_perturbed_set_moves_no_further_than_its_bound():
    block = np.zeros((40, 40, 40), dtype=bool)
    block[12:28, 12:28, 12:28] = True
    found = perturbed(block, 4, 2.0, 16.0)
    bound = largest_move(4, 2.0, 16.0) + math.sqrt(3) / 2
    distances = KDTree(np.argwhere(block)).query(np.argwhere(found))[0]
    assert 1 < distances.max() <= bound
    assert np.array_equal(found, perturbed(block, 4, 2.0, 16.0))
    assert not np.array_equal(found, perturbed(block, 5, 2.0, 16.0))
    assert np.array_equal(block, perturbed(block, 4, 0.0, 16.0))
    with pytest.raises(ValueError, match="amount"):
        perturbed(block, 4, -1.0, 16.0)
