"""Hulls, balls, Hausdorff distances and open sets against chaos games, known shapes and deep evaluations."""

from fractions import Fraction

import numpy as np
import pytest
from scipy.spatial import cKDTree

import ifs
from automata import parse_text
from ifs.certificates.balls import ball, smallest_ball
from ifs.certificates.hausdorff import control_figures, hausdorff_error
from ifs.certificates.supports import grid_directions, hull
from ifs.dimensions.gluing import gluing, vertex_address
from ifs.dimensions.openset import content, open_set
from ifs.dimensions.parametrisation import Parametrisation, WrongRatios, parametrisation
from ifs.shape import Shape
from ifs.system import State, System
from subdivision.schemes import b_spline, de_rham, hilbert, koch, menger_wall


def plain(maps, control):
    """The shape of a plain system: `maps` are (linear, shift) in coordinates on the unit axes."""
    rows = ["format = 'bcifs/1'", "name = 'plain'"]
    for linear, shift in maps:
        rows += ["[[maps]]", f"linear = {np.array(linear, float).tolist()}", f"translation = {list(shift)}"]
    return ifs.shape(parse_text("\n".join([*rows, "[control]", f"points = {control}"])))


def random_plane(seed):
    rng = np.random.default_rng(seed)
    maps = []
    for _ in range(4):
        matrix = rng.normal(size=(2, 2))
        maps.append((matrix * rng.uniform(0.3, 0.7) / np.linalg.norm(matrix, 2), rng.normal(size=2)))
    return maps, plain([(m, s.tolist()) for m, s in maps], [[0, 0], [1, 0], [0, 1]])


def chaos(maps, count, seed):
    rng = np.random.default_rng(seed)
    linear, shift = np.array([m for m, _ in maps]), np.array([s for _, s in maps])
    # From the fixed point of a map every point stays on the attractor.
    points = np.repeat(np.linalg.solve(np.eye(2) - linear[0], shift[0])[None], count, axis=0)
    for _ in range(25):
        choice = rng.integers(len(maps), size=count)
        points = np.einsum("nij,nj->ni", linear[choice], points) + shift[choice]
    return points


def deep_points(shape, depth):
    columns = ifs.sample(shape.system)
    return np.concatenate(
        [
            np.einsum("p,npd->nd", columns[g.cell], g.control)
            for g in ifs.pieces(shape.system, shape.control, depth=depth)
        ]
    )


@pytest.mark.parametrize("seed", range(2))
def test_a_million_points_of_the_chaos_game_stay_inside(seed):
    maps, shape = random_plane(seed)
    points = chaos(maps, 1_000_000, seed)
    found, around = hull(shape, tolerance=1e-4), ball(shape, tolerance=1e-4)
    slack = 1e-9 * np.abs(points).max()
    heights = points @ found.directions.T
    assert (heights <= found.outer + slack).all()
    assert (np.linalg.norm(points - around.centre, axis=1) <= around.radius + slack).all()
    # Tight: what is claimed, and what the points themselves reach.
    size = float(np.ptp(points, axis=0).max())
    assert found.looseness <= 1.1e-4 + slack
    assert (found.outer - heights.max(axis=0) <= 0.02 * size).all()
    assert around.radius <= around.least + 2e-4 * size
    assert around.least >= 0.98 * smallest_ball(points[:3000])[1]
    for k, point in enumerate(found.touching):
        assert found.directions[k] @ point == pytest.approx(found.inner[k], abs=1e-9)


def test_supports_of_known_hulls():
    koch_hull = hull(ifs.shape("koch-curve"), np.array([[0, 3], [0, -1], [1, 1]]))
    h = 90 / np.sqrt(12)
    expected = np.array([h, 0, 90 / np.sqrt(2)])
    assert (koch_hull.outer >= expected).all()
    np.testing.assert_allclose(koch_hull.outer, expected, atol=0.1)
    sponge = hull(ifs.shape("menger-sponge"), tolerance=1e-6)
    corners = sponge.vertices()
    np.testing.assert_allclose(corners.min(axis=0), 0, atol=1e-3)
    np.testing.assert_allclose(corners.max(axis=0), 54, atol=1e-3)
    assert sponge.contains(np.array([[0.0, 0, 0], [27, 54, 54]])).all()
    assert not sponge.contains(np.array([[27, 27, 54.1]])).any()
    assert len(grid_directions(2)) == 8


def test_a_flat_shape_in_space_has_a_hull():
    flat = ifs.shape("koch-curve", control=np.array([[0, 0, 1], [3, 2, 1], [6, 0, 1]]))
    corners = hull(flat, tolerance=1e-6).vertices()
    np.testing.assert_allclose(corners[:, 2], 1, atol=1e-4)


@pytest.mark.parametrize("name", ["sierpinski-triangle", "koch-curve", "takagi-curve", "corner-cutting"])
def test_hausdorff_errors_hold_against_a_deeper_evaluation(name):
    shape = ifs.shape(name)
    fine = {2: 12, 3: 9, 4: 7}[len(shape.system.states[shape.system.shape].labels)]
    deep = deep_points(shape, fine)
    rest = hausdorff_error(shape, fine)
    for depth in (1, 4):
        coarse = deep_points(shape, depth)
        there = cKDTree(coarse).query(deep)[0].max()
        back = cKDTree(deep).query(coarse)[0].max()
        error = hausdorff_error(shape, depth)
        assert max(there, back - rest) <= error
        assert error <= 4 * max(there, back)
        drawn = control_figures(shape.system)
        control = np.concatenate(
            [g.control.reshape(-1, 2) for g in ifs.pieces(shape.system, shape.control, depth=depth)]
        )
        bound = hausdorff_error(shape, depth, drawn)
        assert cKDTree(deep).query(control)[0].max() - rest <= bound
        assert cKDTree(control).query(deep)[0].max() <= bound


def test_hausdorff_errors_beyond_the_pieces_that_can_be_counted():
    shape = ifs.shape("sierpinski-triangle")
    errors = [hausdorff_error(shape, depth) for depth in (9, 10, 20, 60)]
    assert errors[0] / errors[1] == pytest.approx(2)
    # Each letter halves, and the bound of the letters left is loose by a constant.
    assert errors[1] / 2**10 <= errors[2] <= 2 * errors[1] / 2**10
    assert errors[2] / errors[3] == pytest.approx(2.0**40)
    with pytest.raises(ValueError, match="0 or more"):
        hausdorff_error(shape, -1)


def test_open_sets_of_known_shapes():
    for shape in (
        ifs.shape(koch()),
        ifs.shape(hilbert()),
        ifs.shape(menger_wall()),
        ifs.shape("menger-sponge"),
    ):
        assert open_set(shape).verdict == "holds"
    third = np.eye(1) / 3
    cantor = plain([(third, [0]), (third, [2 / 3])], [[0], [9]])
    found = open_set(cantor)
    np.testing.assert_allclose(np.sort(found.sets[cantor.system.shape].ravel()), [0, 9], atol=1e-9)
    large = plain([(np.eye(1) * 0.6, [0]), (np.eye(1) * 0.6, [0.4])], [[0], [1]])
    assert open_set(large).verdict == "fails"
    twice = plain([(np.eye(1) / 4, s) for s in ([0], [0], [0.75])], [[0], [1]])
    assert open_set(twice).verdict == "fails"
    assert open_set(twice).words == (("0",), ("1",))
    quarter = np.eye(1) / 4
    same = plain([(quarter, [0]), (quarter, [0.25]), (quarter, [1.0])], [[0], [1]])
    found = open_set(same)  # x/16 + 1/4: 1 after 0, and 0 after the third
    assert found.verdict == "fails"
    assert {len(word) for word in found.words} == {2}
    assert open_set(ifs.shape(b_spline(3))).verdict == "undecided"


def test_content_is_zero_or_that_of_the_tile():
    assert content(ifs.shape(hilbert())).value == pytest.approx(90**2)
    assert content(ifs.shape("koch-curve")).value == 0
    unit = plain(
        [(np.eye(2) / 2, s) for s in ([0, 0], [0.5, 0], [0, 0.5], [0.5, 0.5])], [[0, 0], [3, 0], [1, 2]]
    )
    assert content(unit).value == pytest.approx(6)


def test_systems_without_attractor_are_refused():
    shape = ifs.shape("koch-curve")
    grown = State("edge", 2, ("0",), ("edge",), (np.array([[1.5, -0.5], [-0.5, 1.5]]),))
    broken = Shape(shape.name, shape.topology, System("edge", {"edge": grown}), np.array([[0.0, 0], [1, 0]]))
    for ask in (hull, ball, open_set, lambda s: hausdorff_error(s, 2)):
        with pytest.raises(ifs.NotContracting):
            ask(broken)
    with pytest.raises(ValueError, match="direction 1"):
        hull(shape, np.array([[1, 0], [0, 0]]))
    with pytest.raises(ValueError, match="unbounded"):
        hull(shape, np.array([[1, 0], [0, 1]])).vertices()


def test_the_koch_curve_by_its_parameters():
    shape = ifs.shape(koch(), control=np.array([[0, 0], [45, 45 / 3**0.5], [90, 0]]))
    found = parametrisation(shape)
    np.testing.assert_allclose(found.ratios, 0.25)
    # The parameter in base 4 leads along the pieces; -1/2 of the third piece mirrored is the fourth.
    t = np.array([0, 1 / 16, 0.25, 0.5, 1])
    expected = [[0, 0], [10, 0], [30, 0], [45, 45 / 3**0.5], [90, 0]]
    np.testing.assert_allclose(found.at(shape, t), expected, atol=1e-9)
    # A curve of order log 3 / log 4: |H(t) - H(s)| <= c |t - s|^alpha.
    rng = np.random.default_rng(0)
    start = rng.random(2000)
    step = rng.random(2000) * np.minimum(1e-3, 1 - start)
    moved = np.linalg.norm(found.at(shape, start + step) - found.at(shape, start), axis=1)
    assert (moved <= 90 * 4 * step ** (np.log(3) / np.log(4))).all()


def test_addresses_and_parameters_are_inverse():
    parts = Parametrisation(("a", "b", "c"), (Fraction(1, 2), Fraction(1, 3), Fraction(1, 6)))
    rng = np.random.default_rng(1)
    for _ in range(50):
        word = tuple(rng.choice(["a", "b", "c"], size=12).tolist())
        t = parts.parameter(word)
        assert parts.address(t, 12) == word
        assert parts.parameter(word, ("c",)) >= t
    assert parts.parameter(("a",), ("c",)) == parts.parameter(("b",)) == Fraction(1, 2)
    with pytest.raises(ValueError, match="'d'"):
        parts.parameter(("d",))


def test_given_ratios_move_the_parameters_only():
    shape = ifs.shape("takagi-curve")
    thirds = parametrisation(shape, {"0": Fraction(1, 3), "1": Fraction(2, 3)})
    halves = parametrisation(shape)
    word = ("1", "0", "0", "1")
    one = thirds.at(shape, np.array([float(thirds.parameter(word))]))
    np.testing.assert_allclose(one, halves.at(shape, np.array([float(halves.parameter(word))])), atol=1e-6)
    for wrong, message in [
        ({"0": 0.5}, "wrong: 1"),
        ({"0": 1.5, "1": -0.5}, "'1' must be above 0"),
        ({"0": 0.5, "1": 0.4}, "sum to 1"),
    ]:
        with pytest.raises(WrongRatios, match=message):
            parametrisation(shape, wrong)


def test_gluing_tells_strong_from_weak_from_none():
    takagi, curve = ifs.shape("takagi-curve"), ifs.shape(de_rham(Fraction(1, 3)))
    assert gluing(takagi, curve).kind == "strong"
    assert vertex_address(takagi, "edge", "right") == ((), ("1",))
    half = [[0.5]]
    loose = plain([(half, [0]), (half, [0.5])], [[0], [8]])
    found = gluing(takagi, loose)
    assert (found.kind, len(found.numeric)) == ("weak", 1)
    third = [[1 / 3]]
    apart = gluing(takagi, plain([(third, [0]), (third, [2 / 3])], [[0], [9]]))
    assert apart.kind == "none"
    assert apart.broken[0][1] == pytest.approx(3)
    assert gluing(takagi, ifs.shape("koch-curve")).kind == "none"
